"""Robots by name, with the place their numbers come from."""

from dataclasses import dataclass

from .robots import Biglide, FiveBar


@dataclass(frozen=True)
class NamedRobot:
    """A robot with the place its numbers come from; inertias are 0 where the source gives none."""

    robot: FiveBar | Biglide
    source: str


def _symmetric(proximal, distal, half_base):
    return FiveBar(proximal, distal, proximal, distal, 2 * half_base, 0, 0, 0)


_LIU = "Liu, Wang, Pritschow 2006, Mech. Mach. Theory 41, lengths without unit: r1, r2, r3 = {}, {}, {}"
_LIU_SETS = [
    (1.2, 1.0, 0.8),
    (0.8125, 0.9375, 1.25),
    (0.7, 1.7, 0.6),
    (1.17, 1.45, 0.38),
    (1.5, 1.5, 0),
    (0.4, 2.33, 0.27),
]

ROBOTS = {
    "amoro": NamedRobot(FiveBar(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "amoro-files": NamedRobot(FiveBar(zz1=0.002025, zz2=0.002025), "the AMORO lab's own files, zz = 1.0 * 0.045^2"),
    "biglide": NamedRobot(Biglide(), "AMORO lab handout, Ecole Centrale de Nantes, 2021"),
    "hoang-2015": NamedRobot(_symmetric(0.07, 0.2, 0.125), "Hoang, Vuong, Pham 2015: no Type-2 singularity anywhere"),
    **{f"liu-2006-{letter}": NamedRobot(_symmetric(*r), _LIU.format(*r)) for letter, r in zip("abcdef", _LIU_SETS)},
}
