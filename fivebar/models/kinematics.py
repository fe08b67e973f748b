"""First- and second-order kinematic models, A xi' = B q' and A xi'' = B q'' + d, and the passive
joints'.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..base.backend import first_index, is_symbolic, pack, unpack_for
from ..base.checks import instance
from ..base.errors import SingularityError
from ..base.representation import one_line, vector
from .dyads import SINGULAR, cross, dot
from .pose import Pose, ReachedLeg

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Rates:
    """Velocities at a pose, from `dkm` or `ikm`. What is derived is computed when first read.

    Attributes
    ----------
    pose : Pose
    q_dot : (*batch, 2)
        rad/s (biglide: m/s).
    xi_dot : (*batch, 2)
        m/s.
    q_passive_dot : (*batch, 2)
        rad/s.
    d : (*batch, 2)
        Bias of the second-order model A xi'' = B q'' + d (AMORO eq. 18), m/s^2.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(), (0.0, 0.0)), (0.0, 0.0))
    >>> rates.d.tolist() == [0.0, 0.0]
    True
    """

    pose: Pose
    _q_dot: tuple
    _xi_dot: tuple
    _from_task: bool = field(default=False, kw_only=True)  # xi' was given

    def __repr__(self) -> str:
        return one_line("Rates", *self._words())

    def _words(self):
        pose = self.pose
        own = (
            vector("xi'", self._xi_dot, "m/s"),
            vector("q'", self._q_dot, f"{pose.robot.words.unit}/s"),
        )
        return (*own, *pose._words())

    @cached_property
    def _transverse_velocity(self):
        """Per leg l_i2 phi_i' = v_i2 . (xi' - P_i' q_i'): regular at every singularity (AMORO eq.
        15).
        """
        if self._from_task and not self.pose.robot.turns:
            # Across its guide, whose direction is P_i', a foot stands still. Without q_i' a fast
            # motion along the guides turns no bar.
            legs = zip(self.pose.tangents, self.pose.b)
            return tuple(cross(tangent, self._xi_dot) / along for tangent, along in legs)
        legs = zip(self.pose.u2, self.pose._velocity_coefficients, self._q_dot)
        return tuple(cross(u2, self._xi_dot) - across * q_dot for u2, (_, across), q_dot in legs)

    @cached_property
    def _centripetal(self):
        """Per leg P_i'' q_i'^2 along and across the distal bar."""
        terms = []
        for drive, leg, q_dot in zip(self.pose.robot.drives, self.pose.legs, self._q_dot):
            square = q_dot * q_dot
            coefficients = drive.acceleration_coefficients(leg.sine, leg.cosine)
            terms.append(tuple(part * square for part in coefficients))
        return tuple(terms)

    @cached_property
    def _bias(self):
        if self._from_task and _reached(self.pose):
            # The same in q_i2': with l_i1 cos q_i2 + l_i2 = c . u_i2 two large squares cancel where
            # the leg is folded.
            bias = []
            for leg, bar, q_dot, passive in zip(
                self.pose.legs, self.pose.robot.distal, self._q_dot, self._passive
            ):
                l1 = leg.drive.length
                reach = 0.5 / bar * (leg.dyad.span_squared + (bar - l1) * (bar + l1))
                bias.append(-(reach * q_dot * q_dot + bar * passive * (2 * q_dot + passive)))
            return tuple(bias)
        legs = zip(self._centripetal, self._transverse_velocity, self.pose.robot.distal)
        # AMORO eq. 18: d_i = u_i2 . P_i'' q_i'^2 - l_i2 phi_i'^2.
        return tuple(along - velocity * velocity * (1 / bar) for (along, _), velocity, bar in legs)

    @property
    def phi_dot(self) -> tuple:
        """Per leg the distal bar's own rate phi_i', rad/s, on components."""
        return tuple(
            transverse * (1 / bar)
            for transverse, bar in zip(self._transverse_velocity, self.pose.robot.distal)
        )

    @property
    def margin_rates(self) -> tuple:
        """Rates of both sines and of det A, 1/s, on components."""
        pose = self.pose
        turns = self.phi_dot
        legs = zip(pose.robot.drives, pose.legs, turns, self._q_dot)
        sines = tuple(leg.cosine * drive.relative(turn, q_dot) for drive, leg, turn, q_dot in legs)
        return *sines, dot(*pose.u2) * (turns[1] - turns[0])

    @property
    def components(self) -> tuple[tuple, tuple]:
        """(q1', q2'), (x', y')."""
        return self._q_dot, self._xi_dot

    @cached_property
    def q_dot(self) -> np.ndarray:
        return pack(*self._q_dot)

    @cached_property
    def xi_dot(self) -> np.ndarray:
        return pack(*self._xi_dot)

    @cached_property
    def q_passive_dot(self) -> np.ndarray:
        return pack(*self._passive)

    @cached_property
    def _passive(self):
        if not (self._from_task and _reached(self.pose)):
            return self._relative(self._transverse_velocity, self._q_dot)
        # From the law of cosines, c . xi' = -l_i1 l_i2 sin(q_i2) q_i2' on the span c = xi - A_i1.
        legs = zip(self.pose.legs, self.pose.robot.distal, self.pose.b)
        return tuple(-dot(leg.dyad.span, self._xi_dot) / (bar * b) for leg, bar, b in legs)

    def _relative(self, transverse, own):
        """Return the passive joints' rates or accelerations, from l_i2 times the distal bars' and
        the drives' own.
        """
        robot = self.pose.robot
        legs = zip(robot.drives, robot.distal, transverse, own)
        return tuple(drive.relative(part * (1 / bar), o) for drive, bar, part, o in legs)

    @cached_property
    def d(self) -> np.ndarray:
        return pack(*self._bias)


@dataclass(frozen=True, eq=False)
class Accelerations:
    """Accelerations at given velocities, from `dkm2`, `ikm2` or `forward_dynamics`.

    Attributes
    ----------
    rates : Rates
    q_ddot : (*batch, 2)
        rad/s^2 (biglide: m/s^2).
    xi_ddot : (*batch, 2)
        m/s^2.
    q_passive_ddot : (*batch, 2)
        rad/s^2.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(), (0.0, 0.0)), (0.0, 0.0))
    >>> fb.dkm2(rates, (0.0, 0.0)).xi_ddot.tolist()
    [0.0, 0.0]
    """

    rates: Rates
    _q_ddot: tuple
    _xi_ddot: tuple
    _from_task: bool = field(default=False, kw_only=True)  # xi'' was given

    def __repr__(self) -> str:
        unit = f"{self.rates.pose.robot.words.unit}/s²"
        own = vector("xi''", self._xi_ddot, "m/s²"), vector("q''", self._q_ddot, unit)
        return one_line("Accelerations", *own, *self.rates._words())

    @cached_property
    def q_ddot(self) -> np.ndarray:
        return pack(*self._q_ddot)

    @property
    def phi_ddot(self) -> tuple:
        """Per leg the distal bar's own acceleration phi_i'', rad/s^2, on components."""
        return tuple(
            transverse * (1 / bar)
            for transverse, bar in zip(self._transverse_velocity, self.rates.pose.robot.distal)
        )

    @cached_property
    def xi_ddot(self) -> np.ndarray:
        return pack(*self._xi_ddot)

    @cached_property
    def _transverse_velocity(self):
        """Per leg l_i2 phi_i'' = v_i2 . (xi'' - P_i' q_i'' - P_i'' q_i'^2) (AMORO eq. 20)."""
        pose = self.rates.pose
        if self._from_task and not pose.robot.turns:
            coefficients = zip(pose.tangents, pose._velocity_coefficients)
            velocities = zip(self.rates._transverse_velocity, pose.robot.distal)
            return tuple(
                (cross(tangent, self._xi_ddot) - across * velocity * velocity * (1 / bar)) / along
                for (tangent, (along, across)), (velocity, bar) in zip(coefficients, velocities)
            )
        legs = zip(pose.u2, pose._velocity_coefficients, self._q_ddot, self.rates._centripetal)
        return tuple(
            cross(u2, self._xi_ddot) - across * q_ddot - bend
            for u2, (_, across), q_ddot, (_, bend) in legs
        )

    @cached_property
    def q_passive_ddot(self) -> np.ndarray:
        rates, pose = self.rates, self.rates.pose
        if not (self._from_task and _reached(pose)):
            return pack(*rates._relative(self._transverse_velocity, self._q_ddot))
        # The law of cosines differentiated twice, |xi'|^2 split along and across c, the part along
        # joined with q_i2'^2.
        passive = []
        for leg, bar, b, q_dot in zip(pose.legs, pose.robot.distal, pose.b, rates._passive):
            c = leg.dyad.span
            square = leg.dyad.span_squared
            l1 = leg.drive.length
            difference = (l1 + bar) * (l1 - bar)
            across = cross(c, rates._xi_dot)
            bend = 0.25 * (square + difference) * (square - difference) * q_dot * q_dot
            passive.append(-((across * across + bend) / square + dot(c, self._xi_ddot)) / (bar * b))
        return pack(*passive)


a_pose = instance(Pose, what="a Pose, as dgm and igm give")
some_rates = instance(Rates, what="Rates, as dkm and ikm give")


def dkm(pose: Pose, q_dot: ArrayLike) -> Rates:
    """Return the velocities for joint rates: the direct first-order model, xi' = A^-1 B q'.

    Parameters
    ----------
    pose : Pose
    q_dot : (*batch, 2)
        Rates of the active joints, rad/s (biglide: m/s).

    Returns
    -------
    Rates

    Raises
    ------
    SingularityError
        A is singular (Type 2).

    References
    ----------
    AMORO lab handout, eq. 13.

    Examples
    --------
    >>> import fivebar as fb
    >>> pose = fb.dgm(fb.FiveBar(), (0.0, 0.0))
    >>> fb.dkm(pose, (1.0, 0.0)).xi_dot.round(6).tolist()
    [0.051836, 0.045]
    """
    if not isinstance(pose, Pose):
        a_pose(pose, "pose")
    q_dot = unpack_for(pose.point[0], q_dot, "q_dot")
    return Rates(
        pose, q_dot, solve_a(pose, tuple(b * rate for b, rate in zip(pose.b, q_dot)), "dkm")
    )


def ikm(pose: Pose, xi_dot: ArrayLike) -> Rates:
    """Return the joint rates for a velocity: the inverse first-order model, q' = B^-1 A xi'.

    Parameters
    ----------
    pose : Pose
    xi_dot : (*batch, 2)
        Velocity of the end-effector, m/s.

    Returns
    -------
    Rates

    Raises
    ------
    SingularityError
        B is singular (Type 1).

    References
    ----------
    AMORO lab handout, eq. 13.

    Examples
    --------
    >>> import fivebar as fb
    >>> pose = fb.igm(fb.FiveBar(), (0.05, 0.09))
    >>> fb.ikm(pose, (0.1, 0.0)).q_dot.round(4).tolist()
    [0.2415, -1.164]
    """
    if not isinstance(pose, Pose):
        a_pose(pose, "pose")
    xi_dot = unpack_for(pose.point[0], xi_dot, "xi_dot")
    return Rates(
        pose,
        solve_b(pose, tuple(dot(u2, xi_dot) for u2 in pose.u2), "ikm"),
        xi_dot,
        _from_task=True,
    )


def dkm2(rates: Rates, q_ddot: ArrayLike) -> Accelerations:
    """Return the accelerations for joint accelerations: xi'' = A^-1 (B q'' + d).

    The direct second-order model.

    Parameters
    ----------
    rates : Rates
    q_ddot : (*batch, 2)
        Accelerations of the active joints, rad/s^2 (biglide: m/s^2).

    Returns
    -------
    Accelerations

    Raises
    ------
    SingularityError
        A is singular (Type 2).

    References
    ----------
    AMORO lab handout, eq. 18.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.dkm(fb.dgm(fb.FiveBar(), (0.0, 0.0)), (1.0, 0.0))
    >>> fb.dkm2(rates, (0.0, 0.0)).xi_ddot.shape
    (2,)
    """
    if not isinstance(rates, Rates):
        some_rates(rates, "rates")
    q_ddot = unpack_for(rates._xi_dot[0], q_ddot, "q_ddot")
    along = tuple(b * q + d for b, q, d in zip(rates.pose.b, q_ddot, rates._bias))
    return Accelerations(rates, q_ddot, solve_a(rates.pose, along, "dkm2"))


def ikm2(rates: Rates, xi_ddot: ArrayLike) -> Accelerations:
    """Return the joint accelerations for an acceleration: q'' = B^-1 (A xi'' - d).

    The inverse second-order model.

    Parameters
    ----------
    rates : Rates
    xi_ddot : (*batch, 2)
        Acceleration of the end-effector, m/s^2.

    Returns
    -------
    Accelerations

    Raises
    ------
    SingularityError
        B is singular (Type 1).

    References
    ----------
    AMORO lab handout, eq. 18.

    Examples
    --------
    >>> import fivebar as fb
    >>> rates = fb.ikm(fb.igm(fb.FiveBar(), (0.05, 0.09)), (0.0, 0.0))
    >>> fb.ikm2(rates, (0.1, 0.0)).q_ddot.round(4).tolist()
    [0.2415, -1.164]
    """
    if not isinstance(rates, Rates):
        some_rates(rates, "rates")
    xi_ddot = unpack_for(rates._xi_dot[0], xi_ddot, "xi_ddot")
    along = tuple(dot(u2, xi_ddot) - d for u2, d in zip(rates.pose.u2, rates._bias))
    return Accelerations(rates, solve_b(rates.pose, along, "ikm2"), xi_ddot, _from_task=True)


def solve_a(pose: Pose, along: tuple, model: str) -> tuple:
    """Return A^-1 times `along`: the vector with these components along the two distal bars.

    With det A = x1 y2 - x2 y1, A^-1 = [[y2, -y1], [-x2, x1]] / det A. Refused where A is singular.
    """
    refuse_parallel(pose, model)
    (x1, y1), (x2, y2) = pose.u2
    r1, r2 = along
    inverse = 1.0 / pose.det_A
    return (y2 * r1 - y1 * r2) * inverse, (x1 * r2 - x2 * r1) * inverse


def solve_b(pose: Pose, along: tuple, model: str) -> tuple:
    """Return B^-1 times `along`; B is diagonal (AMORO eq. 13). Refused where B is singular."""
    for joint, sine in zip(pose.robot.words.passive, pose.sines):
        _refuse(pose, sine, f"{model}: B is singular (Type 1)", f"sin {joint}")
    return tuple(r / b for r, b in zip(along, pose.b))


def refuse_parallel(pose: Pose, model: str) -> None:
    """Raise where A is singular."""
    _refuse(pose, pose.det_A, f"{model}: A is singular (Type 2)", "det A")


def _refuse(pose, margin, problem, name):
    if is_symbolic(margin) or (isinstance(margin, float) and abs(margin) > SINGULAR):
        return
    singular = np.abs(margin) <= SINGULAR
    if not singular.any():
        return
    count, index = first_index(singular)
    if index:
        where = f" in {count} of {singular.size} poses, the first at index {index}"
    else:
        where = ""
    value = float(np.asarray(margin)[index])
    at = place_of(pose, np.shape(margin), index)
    raise SingularityError(f"{problem}{where}: {name} = {value:.3g} {at}", value, index or None)


def place_of(pose: Pose, shape: tuple, index: tuple) -> str:
    """Return where one pose of a batch of this shape is, in words."""
    q, xi = (np.broadcast_to(v, (*shape, 2))[index] for v in (pose.q, pose.xi))
    return (
        f"at q = ({q[0]:.9g}, {q[1]:.9g}) {pose.robot.words.unit}, xi = ({xi[0]:.9g},"
        f" {xi[1]:.9g}) m"
    )


def _reached(pose):
    """Return whether the legs are cranks with bars, closed on a given end-effector."""
    return pose.robot.turns and all(isinstance(leg, ReachedLeg) for leg in pose.legs)
