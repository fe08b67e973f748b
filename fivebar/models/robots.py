"""Parameter sets of robots: frozen, self-validating, named by their source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ..base.backend import EPS, is_symbolic, wrap
from ..base.checks import not_negative, two_numbers
from .dyads import Crank, Slider
from .links import Link, grouped, knowing_links, links_by_name
from .physics import Physics
from .values import Named, check_values


def must_close(what: str, lengths: dict[str, float]) -> None:
    """Refuse sides (name -> m) of a closed chain of which one is longer than all others
    together.
    """
    if not any(map(is_symbolic, lengths.values())):
        must_span(what, max(lengths, key=lengths.__getitem__), lengths)


def must_span(what: str, longest: str, lengths: dict[str, float]) -> None:
    """Refuse a side that is longer than all others together, by more than rounding."""
    others = [name for name in lengths if name != longest]
    total = sum(lengths[name] for name in others)
    if lengths[longest] > total * (1 + 8 * EPS):
        raise ValueError(
            f"this {what} can never close: {longest} = {lengths[longest]:g} m is longer than "
            f"{' + '.join(others)} = {total:g} m, by {lengths[longest] - total:.6g} m"
        )


class Words(NamedTuple):
    """What the parts and quantities of a kind of robot are called, in messages, tables, files and
    pictures.
    """

    title: str
    joints: tuple  # active
    passive: tuple
    base: str  # where a drive is mounted
    pivots: str  # that the drives move
    unit: str  # of a joint coordinate
    effort: str  # of a drive
    effort_unit: str
    inertias: tuple

    @property
    def sines(self) -> tuple:
        """The margins of both legs' Type 1, and of Type 2."""
        return *(f"sin {angle}" for angle in self.passive), "det A"


FIVE_BAR = Words(
    "five-bar robot",
    ("q11", "q21"),
    ("q12", "q22"),
    "base joint",
    "elbows",
    "rad",
    "torque",
    "N m",
    ("zz1", "zz2"),
)
BIGLIDE = Words(
    "biglide robot",
    ("q1", "q2"),
    ("phi1", "phi2"),
    "guide",
    "feet",
    "m",
    "force",
    "N",
    ("mf1", "mf2"),
)


# What turns an active joint coordinate q into a pivot P(q). Where a text says rad of joint
# coordinates, m is meant of a drive that slides, and N of its torque in N m.
Drive = Crank | Slider


class Robot(Protocol):
    """What every function here asks of a robot: two drives, and two distal bars that meet in the
    end-effector.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def m(self) -> float: ...  # grouped mass of the end-effector, kg
    @property
    def turns(self) -> bool: ...  # whether joint coordinates are angles
    @property
    def words(self) -> Words: ...
    @property
    def drives(self) -> tuple[Drive, Drive]: ...
    @property
    def distal(self) -> tuple[float, float]: ...
    @property
    def inertias(self) -> tuple[float, float]: ...
    @property
    def physics(self) -> Physics | None: ...
    @property
    def parameters(self) -> dict[str, Any]: ...
    def __hash__(self) -> int: ...
    def joint_difference(self, difference: Any) -> Any: ...
    def continuous(self, q: np.ndarray) -> np.ndarray: ...


def nearest_equivalent_angle(robot: Robot, q, before):
    """Return joint coordinates q, which may jump by a turn, in the turn that is nearest to
    `before`.
    """
    difference = q - before
    return q - (difference - robot.joint_difference(difference))


@dataclass(frozen=True, repr=False)
class FiveBar(Named):
    """Planar five-bar robot 2-RRR, motors at (-d/2, 0) and (d/2, 0); by default the AMORO lab's.

    What is 0 is not computed. CasADi symbols may stand for numbers: what is made of such a robot is
    a function of them. `from_links` groups these parameters from bars as they are built.

    Parameters
    ----------
    l11, l12, l21, l22 : float
        Proximal and distal bar of the left and of the right leg, m.
    d : float
        Distance of the base joints, m.
    zz1, zz2 : float
        Grouped inertias of the proximal bars, kg m^2.
    m : float
        Grouped mass of the end-effector, kg.
    mx11, my11, mx21, my21 : float
        First moments of the proximal bars about their motor, along and across the bar, with what
        the distal bars put on the elbows, kg m.
    zz12, zz22 : float
        Grouped inertias that turn with the distal bars, kg m^2; of a uniform bar -m l^2 / 6.
    my12, my22 : float
        First moments of the distal bars across, kg m.
    gravity : (2,)
        m/s^2.
    fv1, fv2, fs1, fs2 : float
        Viscous (N m s/rad) and Coulomb friction (N m) of the motors.
    fv12, fv22 : float
        Viscous friction of the elbows, N m s/rad.

    Raises
    ------
    ValueError
        A value that no such robot can have; lengths outside 1e-9 to 1e9 m or in a ratio above 1e6,
        masses and inertias outside 1e-30 to 1e30, whose products lose their digits.

    References
    ----------
    Khalil and Dombre, Modeling, Identification and Control of Robots, ch. 9 (grouped parameters).

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.FiveBar(m=0.6).d
    0.118
    """

    l11: float = 0.09
    l12: float = 0.09
    l21: float = 0.09
    l22: float = 0.09
    d: float = 0.118
    zz1: float = 0.002
    zz2: float = 0.002
    m: float = 0.5
    mx11: float = 0.0
    my11: float = 0.0
    mx21: float = 0.0
    my21: float = 0.0
    zz12: float = 0.0
    zz22: float = 0.0
    my12: float = 0.0
    my22: float = 0.0
    gravity: tuple[float, float] = (0.0, 0.0)
    fv1: float = 0.0
    fv2: float = 0.0
    fs1: float = 0.0
    fs2: float = 0.0
    fv12: float = 0.0
    fv22: float = 0.0

    lab = 8
    turns = True  # joint coordinates are angles
    words = FIVE_BAR
    turning_names = "zz12", "zz22", "my12", "my22"

    @classmethod
    def from_links(
        cls,
        l11: float,
        l12: float,
        l21: float,
        l22: float,
        d: float,
        links: Mapping[str, Link | float],
        payload: float = 0.0,
        gravity: tuple[float, float] = (0.0, 0.0),
        rotor: Sequence = (0.0, 0.0),
        viscous: Sequence[float] = (0.0, 0.0),
        coulomb: Sequence[float] = (0.0, 0.0),
        elbows: Sequence[float] = (0.0, 0.0),
    ) -> FiveBar:
        """Return a robot of bars as they are built, in base parameters (`links.grouped`).

        It knows its links: `sweep` and `design` group them anew at other lengths.

        Parameters
        ----------
        l11, l12, l21, l22, d : float
            As of FiveBar, m.
        links : mapping of "11", "12", "21", "22" to Link or float
            A number is the mass of a uniform bar, kg; a bar that is not named has no mass.
        payload : float
            Mass at the end-effector, kg.
        gravity : (2,)
            (x, y), m/s^2: (0, -9.81) of an upright robot.
        rotor : (2,)
            Per motor the inertia at the joint, kg m^2, or (inertia of the rotor, gear ratio): it
            counts ratio^2.
        viscous, coulomb : (2,)
            Friction per motor, N m s/rad and N m.
        elbows : (2,)
            Viscous friction per elbow, N m s/rad.

        Raises
        ------
        ValueError
            A mass or an inertia that no body can have, by its name.
        """
        lengths = dict(l11=l11, l12=l12, l21=l21, l22=l22)
        links = links_by_name(links)
        found = grouped(lengths, links, payload, rotor)
        friction = {"viscous": (viscous, "fv1", "fv2"), "coulomb": (coulomb, "fs1", "fs2")}
        friction["elbows"] = elbows, "fv12", "fv22"
        for name, (given, left, right) in friction.items():
            found[left], found[right] = (
                not_negative(each, name) for each in two_numbers(given, name)
            )
        return knowing_links(cls(**lengths, d=d, **found, gravity=gravity), links)

    def __post_init__(self):
        check_values(self)
        must_close(
            "robot", {name: getattr(self, name) for name in ("l11", "l12", "l21", "l22", "d")}
        )

    @property
    def drives(self) -> tuple[Crank, Crank]:
        """The left and right drive."""
        return Crank(-self.d / 2, 0.0, self.l11), Crank(self.d / 2, 0.0, self.l21)

    @property
    def distal(self) -> tuple[float, float]:
        """Lengths of the two bars that meet in the end-effector, m."""
        return self.l12, self.l22

    @property
    def inertias(self) -> tuple[float, float]:
        """Grouped inertias of the two drives."""
        return self.zz1, self.zz2

    @cached_property
    def physics(self) -> Physics | None:
        """What is named beyond the lab's parameters and changes a motion; None: nothing."""
        found = Physics(
            self.gravity,
            (self.mx11, self.mx21),
            (self.my11, self.my21),
            (self.zz12, self.zz22),
            (self.my12, self.my22),
            (self.fv1, self.fv2),
            (self.fs1, self.fs2),
            (self.fv12, self.fv22),
        )
        return found if found.asked else None

    def joint_difference(self, difference: Any) -> Any:
        """Return the difference of two joint coordinates: of angles the one within half a turn."""
        return wrap(difference)

    def continuous(self, q: np.ndarray) -> np.ndarray:
        """Return joint coordinates (n, 2) along a motion, without the jumps of angles."""
        return np.unwrap(q, axis=0)


@dataclass(frozen=True, repr=False)
class Biglide(Named):
    """Planar biglide robot 2-PRR; the AMORO lab's by default.

    Two feet slide along y on guides at x = -d/2 and x = d/2, which have no ends, and carry two
    bars. Their coordinates q1, q2 are in m, the drives' forces in N.

    Parameters
    ----------
    l1, l2 : float
        Left and right bar, m.
    d : float
        Distance of the guides, m.
    mf1, mf2 : float
        Masses of the feet, kg.
    m : float
        Grouped mass of the end-effector, kg.
    zz1, zz2 : float
        Grouped inertias that turn with the bars, kg m^2; they may be below 0.
    my1, my2 : float
        First moments of the bars across, kg m.
    gravity : (2,)
        m/s^2, of the feet too.
    fv1, fv2, fs1, fs2 : float
        Viscous (N s/m) and Coulomb friction (N) of the drives.

    Raises
    ------
    ValueError
        A value that no such robot can have, and as of `FiveBar`.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.dgm(fb.Biglide(), (0.0, 0.0)).xi.round(6).tolist()
    [0.0, 0.2]
    """

    l1: float = 0.2828427
    l2: float = 0.2828427
    d: float = 0.4
    mf1: float = 1.0
    mf2: float = 1.0
    m: float = 3.0
    zz1: float = 0.0
    zz2: float = 0.0
    my1: float = 0.0
    my2: float = 0.0
    gravity: tuple[float, float] = (0.0, 0.0)
    fv1: float = 0.0
    fv2: float = 0.0
    fs1: float = 0.0
    fs2: float = 0.0

    lab = 6
    turns = False
    words = BIGLIDE
    turning_names = "zz1", "zz2", "my1", "my2"

    def __post_init__(self):
        check_values(self)
        lengths = {"l1": self.l1, "l2": self.l2, "d": self.d}
        if not any(map(is_symbolic, lengths.values())):
            must_span("robot", "d", lengths)

    @property
    def drives(self) -> tuple[Slider, Slider]:
        """The left and right drive."""
        return Slider(-self.d / 2, 0.0), Slider(self.d / 2, 0.0)

    @property
    def distal(self) -> tuple[float, float]:
        """Lengths of the two bars that meet in the end-effector, m."""
        return self.l1, self.l2

    @property
    def inertias(self) -> tuple[float, float]:
        """Masses of the two feet, the inertias of the drives."""
        return self.mf1, self.mf2

    @cached_property
    def physics(self) -> Physics | None:
        """What is named beyond the lab's parameters and changes a motion; None: nothing."""
        found = Physics(
            gravity=self.gravity,
            levers=self.inertias,
            turning=(self.zz1, self.zz2),
            across=(self.my1, self.my2),
            viscous=(self.fv1, self.fv2),
            coulomb=(self.fs1, self.fs2),
        )
        return found if found.asked else None

    def joint_difference(self, difference: Any) -> Any:
        """Return the difference of two joint coordinates: lengths do not wrap."""
        return difference

    def continuous(self, q: np.ndarray) -> np.ndarray:
        """Return joint coordinates (n, 2) along a motion: lengths do not jump."""
        return q


KINDS = FiveBar, Biglide
