"""Robots by name, with the place their numbers come from."""

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .links import Link
from .robots import Biglide, FiveBar


@dataclass(frozen=True)
class NamedRobot:
    """A robot with the place its numbers come from; inertias are 0 where the source gives none.

    tables: what its robot file would say beside the robot: readings, frame, constraints, tool.
    """

    robot: FiveBar | Biglide
    source: str
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def _symmetric(proximal, distal, half_base):
    return FiveBar(proximal, distal, proximal, distal, 2 * half_base, 0, 0, 0)


_LIU = (
    "Liu, Wang, Pritschow 2006, Mech. Mach. Theory 41, lengths without unit: r1, r2, r3 = {},"
    " {}, {}"
)
_LIU_SETS = (
    (1.2, 1.0, 0.8), (0.8125, 0.9375, 1.25), (0.7, 1.7, 0.6), (1.17, 1.45, 0.38), (1.5, 1.5, 0),
    (0.4, 2.33, 0.27),
)  # fmt: skip

# Taken as about the centres of mass; friction of the motors as published, their inertia not.
_IRI_BAR = Link.about_centre(1.2093, 0.11, 0.0, 7e-3)
_IRI_FOREARM = Link.about_centre(0.8925, 0.0746, 0.0, 2.3e-3)
_IRI = FiveBar.from_links(
    0.2,
    0.15,
    0.2,
    0.15,
    0.12,
    {"11": _IRI_BAR, "12": _IRI_FOREARM, "21": _IRI_BAR, "22": _IRI_FOREARM},
    payload=0.5,
    gravity=(0.0, -9.81),
    viscous=(0.0176, 0.0176),
)

# PlotClock: set_XY of its firmware turns a pen at (x, y) into angles by L1 = 35 (servo arms), L2 =
# 55.1 (left elbow to pen), L3 = 13.2 (pen to the joint of the distal bars), L4 = 45 (right distal
# bar), all mm, and 0.621 rad from the line elbow-pen to the line joint-pen; its motors are at
# (22, -25) and (47, -25) of the board.
_PEN = complex(0.0551)
_JOINT = _PEN - 0.0132 * cmath.exp(0.621j)
_PEN_FROM_ELBOW = _PEN * abs(_JOINT) / _JOINT  # as if the bar were along x
_PLOTCLOCK = FiveBar(0.035, abs(_JOINT), 0.035, 0.045, 0.025, 0, 0, 0)
_PLOTCLOCK_TOOL = {
    "leg": 1,
    "along": _PEN_FROM_ELBOW.real - abs(_JOINT),
    "across": _PEN_FROM_ELBOW.imag,
}

# M669 K9 X-54:54 Y-170:-170 L2 P129.5:127.5 D182:181 B251.9:144.3 A5:185:-90:360:-90:360
# C34:251:-71:146 of RepRapFirmware, all left:right, lengths in mm, angles in degrees from the
# x axis to the left:
# K9 five-bar parallel SCARA; X, Y the actuators' axes; L2 working mode: left elbow on the left,
#   right elbow on the right of the line from motor to hotend, here (+1, -1);
# P proximal and D distal arms (D's third and fourth numbers would be cantL and cantR, a hotend
#   beyond the joint along the left or right distal arm: a Tool with along = cant);
# B angles of the proximal arms at the homing switches;
# A least and largest angle between the distal arms, between proximal and distal arm on the left,
#   and on the right: -90:360 of angles from 0 to 360 allows all. A5:185 allows Type 2 at 180, so
#   it is not taken as a bound of |det A|;
# C least and largest angle of each actuator.
_DEGREE = math.pi / 180
_RRF = FiveBar(0.1295, 0.182, 0.1275, 0.181, 0.108, 0, 0, 0)
_RRF_TABLES: dict[str, dict[str, Any]] = {
    "readings": {"offset": (0.0, 0.0), "ratio": (_DEGREE, _DEGREE)},
    "frame": {"shift": (0.0, -0.17)},
    "constraints": {"joints": [(34 * _DEGREE, 251 * _DEGREE), (-71 * _DEGREE, 146 * _DEGREE)]},
}

ROBOTS = {
    "amoro": NamedRobot(FiveBar(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "amoro-files": NamedRobot(
        FiveBar(zz1=0.002025, zz2=0.002025), "the AMORO lab's own files, zz = 1.0 * 0.045^2"
    ),
    "biglide": NamedRobot(Biglide(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "hoang-2015": NamedRobot(
        _symmetric(0.07, 0.2, 0.125), "Hoang, Vuong, Pham 2015: no Type-2 singularity anywhere"
    ),
    **{
        f"liu-2006-{letter}": NamedRobot(_symmetric(*r), _LIU.format(*r))
        for letter, r in zip("abcdef", _LIU_SETS)
    },
    "iri-vertical": NamedRobot(
        _IRI,
        "IRI five-bar in the vertical plane, published masses, centres of mass, inertias, friction,"
        " payload 0.5 kg",
    ),
    "motkin": NamedRobot(
        _symmetric(0.06, 0.1, 0.05),
        "MOTKIN desktop testbed: 60, 100, base 100 mm; no inertias given",
    ),
    "minitaur-leg": NamedRobot(
        _symmetric(0.1, 0.2, 0.0),
        "Ghost Robotics SDK, defaults of MinitaurLeg: two coaxial motors; no inertias given",
    ),
    "plotclock": NamedRobot(
        _PLOTCLOCK,
        "PlotClock by J. Heberlein, 2014, thingiverse.com/thing:248009: a pen beside the joint; no"
        " inertias given; servos' zeros are each builder's own",
        {"tool": _PLOTCLOCK_TOOL, "frame": {"shift": (0.0345, -0.025)}},
    ),
    "reprapfirmware": NamedRobot(
        _RRF,
        "a published line M669 K9 of RepRapFirmware, kinematics type five-bar parallel SCARA,"
        " docs.duet3d.com; axes in degrees; no inertias given",
        _RRF_TABLES,
    ),
    "haply": NamedRobot(
        _symmetric(0.07, 0.09, 0.0),
        "Haply hAPI, defaults of Pantograph: a haptic device, coaxial; no inertias given",
    ),
}
