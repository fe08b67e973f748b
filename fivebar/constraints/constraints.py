"""What a motion must keep, named once: joint limits, a region, least margins, and bars that must
not meet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.backend import finite_numbers
from ..base.checks import share, shown
from ..base.representation import one_line
from ..models.geometry import Pose
from .link_collisions import LinkCollisions, apart, off


@dataclass(frozen=True)
class Keep:
    """What a motion must keep; what is not named is free. `check_path`, `plan`, `largest_disc` and
    `place` take it.

    joints: ((q11 low, high), (q21 low, high)) rad, None for a free one; an angle and its full turns
    are one, so that a range is at most a full turn (of a biglide: m).
    half_planes: (a, b, c) each, for a x + b y >= c, m: y > 0 is (0, 1, 0). region: corners (n, 2) m
    of a polygon whose sides do not cross, inside of which the end-effector stays.
    det_A, sin: least |det A| and |sin q_i2| (of a biglide |sin phi_i|). bars: a `Bars`, whose bars
        must not meet.
    """

    joints: Sequence[Sequence[float] | None] | None = None
    half_planes: Sequence[Sequence[float]] = ()
    region: Sequence[Sequence[float]] | None = None
    det_A: float = 0.0
    sin: float = 0.0
    bars: LinkCollisions | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "joints", _joints(self.joints))
        put(self, "half_planes", _half_planes(self.half_planes))
        put(self, "region", None if self.region is None else _polygon(self.region))
        for name in ("det_A", "sin"):
            put(self, name, share(getattr(self, name), f"Keep: {name}"))
        if not (self.bars is None or isinstance(self.bars, LinkCollisions)):
            raise TypeError(f"Keep: bars must be Bars, not {shown(self.bars)}")

    def __repr__(self) -> str:
        words = []
        for name, limits in zip(("q11", "q21"), self.joints or ()):
            words += [f"{name} from {limits[0]:g} to {limits[1]:g}"] if limits else []
        words += [f"{a:g} x + {b:g} y >= {c:g} m" for a, b, c in self.half_planes]
        words += [f"in a polygon of {len(self.region)} corners"] if self.region else []
        words += [f"|det A| >= {self.det_A:g}"] if self.det_A else []
        words += [f"|sin q_i2| >= {self.sin:g}"] if self.sin else []
        return one_line(
            "Keep", *words, *([repr(self.bars)] if self.bars else []) or ["bars may meet"]
        )

    def rooms(self, pose: Pose) -> dict[str, np.ndarray]:
        """What is left of all that is kept, (*batch,) by words: < 0 where it is broken, nan where
        the pose is.
        """
        found, (x, y) = {}, pose.point
        for leg, limits in enumerate(self.joints or ()):
            if limits:
                low, high = limits
                q = pose.legs[leg].q
                if pose.robot.turns:
                    middle, half = (low + high) / 2, (high - low) / 2
                    found[f"joint limits of q{leg + 1}1"] = half - np.abs(
                        np.mod(q - middle + np.pi, 2 * np.pi) - np.pi
                    )
                else:
                    found[f"joint limits of q{leg + 1}1"] = np.minimum(q - low, high - q)
        for a, b, c in self.half_planes:
            found[f"{a:g} x + {b:g} y >= {c:g} m"] = a * np.asarray(x) + b * np.asarray(y) - c
        if self.region:
            found["region"] = off_sides(
                np.array(self.region) @ (1, 1j), np.asarray(x) + 1j * np.asarray(y)
            )
        for name, least, sines in (
            ("det A", self.det_A, [pose.det_A]),
            ("sin q_i2", self.sin, pose.sines),
        ):
            if least:
                found[f"|{name}| >= {least:g}"] = np.abs(sines).min(axis=0) - least
        if self.bars:
            found |= self.bars.rooms(pose)
        return found

    def smooth(self, pose: Pose, length: float) -> list:
        """Rooms with slopes, >= 0 where it is kept, of symbols: of joints, half-planes, a convex
        region and bars.

        length: m, what distances are divided by.
        """
        found, (x, y) = [], pose.point
        for leg, limits in enumerate(self.joints or ()):
            if limits and pose.robot.turns:
                middle, half = sum(limits) / 2, (limits[1] - limits[0]) / 2
                ux, uy = pose.legs[leg].direction
                found.append(ux * math.cos(middle) + uy * math.sin(middle) - math.cos(half))
            elif limits:
                q = pose.legs[leg].q
                found += [(q - limits[0]) / length, (limits[1] - q) / length]
        planes = list(self.half_planes)
        if self.region:
            z = np.array(self.region) @ (1, 1j)
            side = np.roll(z, -1) - z
            turns = (side.conj() * np.roll(side, -1)).imag
            if (turns >= 0).all() or (turns <= 0).all():
                inward = 1j * side / np.abs(side) * (1 if turns.sum() > 0 else -1)
                planes += [
                    (n.real, n.imag, (n.conjugate() * a).real)
                    for n, a in zip(inward.tolist(), z.tolist())
                ]
        bars = [room / length for room in self.bars.smooth(pose)] if self.bars else []
        return [*found, *((a * x + b * y - c) / length for a, b, c in planes), *bars]

    def kept(self, pose: Pose) -> np.ndarray:
        """Whether all is kept: bool (*batch,), False where the pose is nan."""
        rooms = list(self.rooms(pose).values())
        closes = np.isfinite(pose.det_A)
        return closes & (np.min(rooms, axis=0) >= 0) if rooms else closes


def off_sides(corners: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Distance of points (*batch,) from the sides of a polygon, corners (n,) complex; less than 0
    outside.
    """
    a, b, p = corners, np.roll(corners, -1), np.asarray(z)[..., None]
    distance = off(p, a, b).min(axis=-1)
    spans = (a.imag > p.imag) != (b.imag > p.imag)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = a.real + (p.imag - a.imag) / (b.imag - a.imag) * (b.real - a.real)
    return np.where((spans & (x > p.real)).sum(axis=-1) % 2 == 1, distance, -distance)


def _joints(joints):
    if joints is None:
        return None
    if not isinstance(joints, tuple | list) or len(joints) != 2:
        raise ValueError(
            f"Keep: joints must be two ranges (low, high) or None, not {shown(joints)}"
        )
    found = []
    for name, limits in zip(("q11", "q21"), joints):
        if limits is not None:
            values = finite_numbers(limits, f"Keep: joints of {name}")
            if values.shape != (2,) or not 0 < values[1] - values[0] <= 2 * math.pi:
                raise ValueError(
                    f"Keep: joints of {name} must be (low, high), low < high and at most a full"
                    f" turn apart, not {shown(limits)}"
                )
            limits = tuple(values.tolist())
        found.append(limits)
    return tuple(found)


def _half_planes(planes):
    if not isinstance(planes, tuple | list | np.ndarray):
        raise ValueError(f"Keep: half_planes must be a list of (a, b, c), not {shown(planes)}")
    values = finite_numbers(planes, "Keep: half_planes")
    values = values if values.size else np.empty((0, 3))
    if values.ndim != 2 or values.shape[1] != 3 or not np.hypot(values[:, 0], values[:, 1]).all():
        raise ValueError(
            "Keep: half_planes must be (a, b, c) each, a x + b y >= c, a or b not 0, not"
            f" {shown(planes)}"
        )
    values = (
        values / np.hypot(values[:, 0], values[:, 1])[:, None]
    )  # so that what is left of one is a distance
    return tuple(map(tuple, values.tolist()))


def _polygon(region):
    corners = finite_numbers(region, "Keep: region")
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise ValueError(
            f"Keep: region must be the corners (n, 2) of a polygon, n >= 3, not {shown(region)}"
        )
    z = corners @ (1, 1j)
    if np.abs(np.roll(z, -1) - z).min() == 0:
        raise ValueError("Keep: region has the same corner twice in a row")
    for k in range(len(z)):
        for m in range(k + 2, len(z) - (k == 0)):
            if apart(z[k], z[k + 1], z[m], z[(m + 1) % len(z)]) <= 0:
                raise ValueError(f"Keep: sides {k + 1} and {m + 1} of the region meet")
    return tuple(map(tuple, corners.tolist()))
