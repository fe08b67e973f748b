"""The plant with dry friction in its drives: each slips one way or sticks.

A drive that slips stops where its rate passes 0; one that sticks lets go where more than its
friction is needed to hold it. Both are found on the step's polynomial, and the step ends at the
first of them. Nothing is smoothed: what sticks is held at its angle to the last bit, so that it
neither creeps nor chatters.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from ..models.dynamics import held_by
from ..models.four_joints import closed
from ..models.kinematics import Rates
from ..models.loaded_robot import JointTorques
from ..models.physics import loads_of
from ..models.robots import Robot
from ..models.sticking import slip_of
from .plant import Plant
from .steps import JOINT_RATES, between, holding

PLACES = np.linspace(0.0, 1.0, 17)[1:]  # of a step, at which it is looked what holds a drive
FAR = 0.2  # of a rate's largest value in a step: where it stays above, it has no zero
OVER = 1e-12  # of the friction: where this much more is needed, a drive lets go
AT_REST = 1e-13  # of the rates, 1 + |rate|: a drive as slow as this, where it stops, stands


def plant_of(
    robot: Robot,
    start: Rates,
    tolerance: float,
    jit: bool | str = False,
    torques: JointTorques | None = None,
) -> Plant:
    """Return the robot's plant: with dry friction the one that sticks."""
    kind = StickSlip if loads_of(robot).sticks else Plant
    return kind(robot, start, tolerance, jit, torques)


def _powers() -> np.ndarray:
    """Return each coefficient of a step's polynomial (`steps.between`) in powers of the place."""
    rows = []
    basis = Polynomial([1.0])
    for k in range(7):
        factor = [1.0, -1.0] if k % 2 else [0.0, 1.0]
        basis = basis * Polynomial(factor)
        missing = 8 - len(basis.coef)
        rows.append(np.pad(basis.coef, (0, missing)))
    return np.array(rows)


POWERS = _powers()  # (7, 8)


class StickSlip(Plant):
    """Plant of a robot with Coulomb friction; slip: per drive +1, -1, or 0 where it sticks."""

    def __init__(
        self,
        robot: Robot,
        start: Rates,
        tolerance: float,
        jit: bool | str = False,
        torques: JointTorques | None = None,
    ) -> None:
        super().__init__(robot, start, tolerance, jit, torques)
        self.friction = np.array(loads_of(robot).coulomb)
        self.slip = np.ones(2)
        self._holding = self._function(holding, jit)
        for drive in (0, 1):
            # A start that stands may have rates of rounding, whose sign says nothing.
            if self.friction[drive] and self._stands(drive, self.state):
                self._stop(drive)

    @property
    def moves(self) -> bool:
        return bool(self.slip.any())

    @property
    def _known(self):
        return self.parameters, self.slip

    def _advance(self, until, tau):
        self._settle(tau)
        super()._advance(until, tau)
        if not self.moves and until > self.t:
            self._pieces.append((self.t, until - self.t, self.state, np.zeros((7, 8)), tau))
            self.t = until

    def _held_by(self, tau):
        """Return the friction that keeps what sticks where it is, (2,) N m."""
        return self._holding_at(self.t, self.state, tau)

    def _holding_at(self, t, state, tau):
        joint = self._at_joints(t, state, tau)
        return self._holding(state, joint, self.parameters, self.slip)[0]

    def _settle(self, tau):
        """Find which drives stick now."""
        rates = self.state[JOINT_RATES]
        standing = (rates == 0) & (self.friction > 0)
        if not standing.any():
            self.slip = np.where(rates < 0, -1.0, 1.0)
            return
        if (self.slip[standing] == 0).all():
            held = np.abs(self._held_by(tau)[standing])
            if (held <= self.friction[standing]).all():
                return
        joint = self._at_joints(self.t, self.state, tau)
        self.slip = np.array(slip_of(self.rates, tuple(joint.tolist()), held_by))
        if not self.moves:
            if np.abs(self.state[4:]).max() > 1e-9:
                why = "both drives stick while the distal bars, in one line, still move"
                self._refuse(tau, why)
            self.state = np.concatenate([self.state[:4], np.zeros(4)])

    def _keep_step(self, tau, length, after, polynomial):
        place, drive = self._first_event(tau, length, polynomial)
        if place is None:
            return super()._keep_step(tau, length, after, polynomial)
        stops = self.slip[drive] != 0
        cut = place * length
        if stops:
            cut = self._until_it_stops(tau, cut, length, drive, polynomial)
        after, _, polynomial = self._try_step(tau, cut)
        super()._keep_step(tau, cut, after, polynomial.copy())
        if stops:
            self._stop(drive)
            self._settle(tau)
        else:
            self.slip = self.slip.copy()
            self.slip[drive] = np.sign(self._held_by(tau)[drive])
        return cut

    def _until_it_stops(self, tau, cut, length, drive, polynomial):
        """Return after how many seconds, near `cut`, a step brings the drive's rate to 0."""
        column = 4 + 2 * drive
        slope = Polynomial(polynomial[:, column] @ POWERS).deriv()
        for _ in range(4):
            after = self._try_step(tau, cut)[0]
            if self._stands(drive, after):
                break
            acceleration = slope(cut / length) / length
            better = cut - after[column] / acceleration if acceleration else cut
            if not 0 < better <= length:
                break
            cut = better
        return cut

    def _stands(self, drive, state):
        fastest = np.abs(state[4:]).max()
        return abs(state[4 + 2 * drive]) <= AT_REST * (1 + fastest)

    def _stop(self, drive):
        """Make the drive's rate 0 and close the loop by the others."""
        state = self.state.copy()
        state[4 + 2 * drive] = 0.0
        free = tuple((state[JOINT_RATES] != 0).astype(float).tolist())
        if any(free):
            a = tuple(state[:4].tolist())
            a_dot = tuple(state[4:].tolist())
            c, c_dot, _ = closed(self.robot, a, a_dot, free)
            state = np.array([*c, *c_dot])
        self.state = state

    def _first_event(self, tau, length, polynomial):
        """Return (place in (0, 1], drive) where a drive first stops or lets go; (None, None)."""
        events = []
        for k in np.flatnonzero(self.friction):
            if self.slip[k]:
                place = self._stops_at(k, polynomial)
            else:
                place = self._lets_go_at(k, tau, length, polynomial)
            if place is not None:
                events.append((place, k))
        return min(events, default=(None, None))

    def _stops_at(self, k, polynomial):
        begin = self.state[4 + 2 * k]
        coefficients = polynomial[:, 4 + 2 * k] @ POWERS
        coefficients[0] += begin
        if begin == 0:  # it has just begun to slip
            coefficients = coefficients[1:]
        rate = Polynomial(coefficients)
        values = rate(PLACES) * self.slip[k]
        if values.min() > FAR * values.max():
            return None
        roots = rate.trim().roots()
        within = (roots.real > 0) & (roots.real <= 1)
        places = roots.real[within & (np.abs(roots.imag) < 1e-9)]
        slope = rate.deriv()
        for place in np.sort(places):
            if slope(place) * self.slip[k] <= 0:
                return place
        return None

    def _lets_go_at(self, k, tau, length, polynomial):
        def excess(place):
            state = between(self.state[None], polynomial[None], np.array([place]))[0]
            now = self.t + place * length
            needed = self._holding_at(now, state, tau)[k]
            return abs(needed) - self.friction[k] * (1 + OVER)

        low = 0.0
        for place in PLACES:
            if excess(place) > 0:
                break
            low = place
        else:
            return None
        high = place
        while high - low >= 1e-12:
            middle = (low + high) / 2
            low, high = (low, middle) if excess(middle) > 0 else (middle, high)
        return high

    def _free(self, states, polynomials):
        changes = (polynomials[:, :, JOINT_RATES] != 0).any(axis=1)
        moving = (states[:, JOINT_RATES] != 0) | changes
        # Where both drives stand, so does what is between them.
        moving |= ~moving.any(axis=1, keepdims=True)
        return tuple(moving.T.astype(float))
