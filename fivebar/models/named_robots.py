"""Robots by name, with the place their numbers come from."""

from dataclasses import dataclass

from .links import Link
from .robots import Biglide, FiveBar


@dataclass(frozen=True)
class NamedRobot:
    """A robot with the place its numbers come from; inertias are 0 where the source gives none."""

    robot: FiveBar | Biglide
    source: str


def _symmetric(proximal, distal, half_base):
    return FiveBar(
        proximal,
        distal,
        proximal,
        distal,
        2 * half_base,
        0,
        0,
        0,
    )


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
    "haply": NamedRobot(
        _symmetric(0.07, 0.09, 0.0),
        "Haply hAPI, defaults of Pantograph: a haptic device, coaxial; no inertias given",
    ),
}
