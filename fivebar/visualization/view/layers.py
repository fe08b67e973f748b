"""What is shown of a mechanism besides itself: lines, areas, arrows, turning arrows and ghosts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..style import PALE
from .solids import arc, dashed, link, polygon, ribbon, triangles
from .tracks import Part, angles_of, placed

if TYPE_CHECKING:
    from .machine import Machine

ARROW = 0.3  # the longest arrow's share of the mechanism's size
SWEEP = np.radians(300)  # of the turning arrow of the largest value
PIECES = 120  # of its band


def flags(times: np.ndarray, good: np.ndarray) -> tuple | None:
    """When a part is shown (times, flags), of flags (m,) at the frames; None where it always is."""
    if good.all():
        return None
    change = np.concatenate([[0], np.flatnonzero(np.diff(good.astype(int))) + 1])
    return times[change], good[change]


class Layer:
    """Has a name and a colour; `parts` are its nodes in the scene, the number-th layer of a
    machine.
    """

    still = False  # whether it belongs to the base
    glyph = "line"  # how a legend shows it
    words = sign = ""  # more of what it is; what is written at an arrow's tip

    @property
    def key(self) -> str:
        """What a legend calls it."""
        return self.words or self.name

    def reach(self, machine: Machine) -> np.ndarray:
        """Points (n, 2) m for which the picture must have room."""
        return np.empty((0, 2))

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Line(Layer):
    """Paths, each (n, 2) m; width, and dash (on, off) in widths of a bar; over or under the
    bars.
    """

    name: str
    paths: list
    colour: str
    width: float = 0.12
    dash: tuple | None = None
    over: bool = False
    opacity: float = 1.0
    lift: float = 0.0
    good: np.ndarray | None = None  # (m,) at which frames it is shown
    words: str = ""
    still = True

    def reach(self, machine: Machine) -> np.ndarray:
        return np.concatenate([np.empty((0, 2)), *self.paths])

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        w = machine.pen
        paths = self.paths
        if self.dash:
            paths = [
                piece
                for path in paths
                for piece in dashed(path, *(w * share for share in self.dash))
            ]
        height = machine.top + self.lift * w if self.over else (self.lift - 0.5) * machine.layer
        see_through = {"transparent": True, "opacity": self.opacity} if self.opacity < 1 else {}
        band = ribbon(paths, self.width * w, height, self.colour, **see_through)
        shown = None if self.good is None else flags(machine.frames.t, self.good)
        # A path that stays in one point has no band, and the viewer complains of an empty one.
        yield Part(f"{self.name}/{number}", [] if band is None else [band], shown=shown)


@dataclass(frozen=True, eq=False)
class Area(Layer):
    """An area of strips, each rows (n, 2, 2) of a left and a right point, m; its outline (paths) is
    drawn too.
    """

    name: str
    strips: list
    outline: list
    colour: str
    still = True
    glyph = "area"

    def reach(self, machine: Machine) -> np.ndarray:
        return np.concatenate(self.outline)

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        points = np.concatenate(self.strips).reshape(-1, 2)
        flat = np.pad(points, [(0, 0), (0, 1)], constant_values=-4.6 * machine.layer)
        row = np.concatenate(
            [np.arange(len(rows)) < len(rows) - 1 for rows in self.strips]
        )  # that has one above
        faces = 2 * np.flatnonzero(row)[:, None] + (0, 1, 2, 2, 1, 3)
        glass = {
            "type": "MeshBasicMaterial",
            "side": 2,
            "transparent": True,
            "opacity": 0.12,
            "depthWrite": False,
        }
        edge = ribbon(self.outline, 0.1 * machine.pen, -0.6 * machine.layer, self.colour)
        yield Part(f"{self.name}/{number}", [triangles(flat, faces, self.colour, **glass), edge])


@dataclass(frozen=True, eq=False)
class Arrows(Layer):
    """Arrows (m, 2) from places (m, 2) m, in `unit`; nan where there is none. `largest` is drawn
    `ARROW` long.
    """

    name: str
    places: np.ndarray
    vectors: np.ndarray
    colour: str
    unit: str
    largest: float
    words: str = ""
    sign: str = ""
    glyph = "arrow"

    @property
    def key(self) -> str:
        return f"{super().key} (longest {self.largest:.3g} {self.unit})"

    def reach(self, machine: Machine) -> np.ndarray:
        tips = self.places + self.drawn(machine)
        return tips[np.isfinite(tips).all(axis=1)]

    def place_of_sign(self, machine: Machine) -> dict:
        """Where it is in the tip's own frame, and the tip's least size for it to be seen."""
        return {"at": (1.8, 0.0), "least": 0.9 * machine.pen}

    def drawn(self, machine: Machine) -> np.ndarray:
        """The arrows as they are drawn, (m, 2) m; nan where there is none."""
        return self.vectors * (ARROW * machine.size / (self.largest or 1.0))

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        arrows, w = self.drawn(machine), machine.pen
        good = np.isfinite(arrows).all(axis=1)
        arrows = np.where(good[:, None], arrows, 0.0)
        length, height = np.hypot(*arrows.T), machine.top + (0.25 + 0.02 * number) * w
        head = np.minimum(1.3 * w, 0.7 * length)
        path = f"{self.name}/{number}"
        yield Part(path, [], placed(self.places, angles_of(arrows)), flags(machine.frames.t, good))
        # Both have unit length along x; a scale of 0 has no inverse, which the viewer's shading
        # asks for.
        shaft = polygon(
            np.array([(0, -0.14 * w), (1, -0.14 * w), (1, 0.14 * w), (0, 0.14 * w)]),
            height,
            self.colour,
        )
        tip = polygon(np.array([(0, -0.45), (1, 0), (0, 0.45)]), height, self.colour)
        yield Part(
            f"{path}/shaft", [shaft], {"scale[x]": ("number", np.maximum(length - head, 1e-6 * w))}
        )
        at = np.column_stack([length - head, np.zeros((len(head), 2))])
        size = np.maximum(head, 1e-6 * w)
        scale = np.column_stack([size, size, np.ones(len(size))])
        yield Part(f"{path}/tip", [tip], {"position": ("vector3", at), "scale": ("vector3", scale)})


@dataclass(frozen=True, eq=False)
class Turning(Layer):
    """Turning arrows about places (m, 2) m: values (m,), counter-clockwise > 0; `largest` is drawn
    `SWEEP` wide.
    """

    name: str
    places: np.ndarray
    values: np.ndarray
    colour: str
    unit: str
    largest: float
    words: str = ""
    sign: str = ""
    glyph = "turn"
    radius = 2.4  # widths of a bar

    @property
    def key(self) -> str:
        return f"{super().key} (largest {self.largest:.3g} {self.unit})"

    def place_of_sign(self, machine: Machine) -> dict:
        """Where it is in the tip's own frame, and the tip's least size for it to be seen."""
        return {"at": (self.radius * machine.pen, 2.2 * machine.pen), "least": 0.3}

    def sweeps(self) -> np.ndarray:
        """Angles (m,) through which they turn, rad."""
        return self.values * (SWEEP / (self.largest or 1.0))

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        good = np.isfinite(self.values)
        sweep, w = np.where(good, self.sweeps(), 0.0), machine.pen
        path, height = f"{self.name}/{number}", machine.top + 0.2 * w
        # The page draws as many pieces of the band as the tip has passed: no track can change a
        # geometry.
        side = np.column_stack(
            [np.ones(len(sweep)), np.where(sweep < 0, -1.0, 1.0), np.ones(len(sweep))]
        )
        moved = placed(self.places) | {"scale": ("vector3", side)}
        yield Part(path, [], moved, flags(machine.frames.t, good))
        size = np.abs(sweep)
        yield Part(
            f"{path}/band", [arc(self.radius * w, 0.34 * w, SWEEP, PIECES, height, self.colour)]
        )
        tip = polygon(
            (self.radius * w, 0) + w * np.array([(-0.55, 0), (0.55, 0), (0, 1.1)]),
            height,
            self.colour,
        )
        full = np.clip(size / 0.3, 0.02, 1.0)
        scale = np.column_stack([np.ones(len(size)), full, np.ones(len(size))])
        yield Part(
            f"{path}/tip", [tip], {"rotation[z]": ("number", size), "scale": ("vector3", scale)}
        )


@dataclass(frozen=True, eq=False)
class Ghost(Layer):
    """The mechanism in other positions, points (m, k, 2) m, pale; nan where there is none."""

    name: str
    mechanism: np.ndarray
    colour: str = PALE
    words = "ghost: the reference"
    glyph = "bar"

    def reach(self, machine: Machine) -> np.ndarray:
        points = self.mechanism.reshape(-1, 2)
        return points[np.isfinite(points).all(axis=1)]

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        good = np.isfinite(self.mechanism).all(axis=(1, 2))
        if not good.any():
            return
        shown = flags(machine.frames.t, good)
        where = np.maximum.accumulate(np.where(good, np.arange(len(good)), np.argmax(good)))
        points, low = self.mechanism[where], -0.3 * machine.layer
        glass = {"transparent": True, "opacity": 0.4, "depthWrite": False}
        for b, (i, j) in enumerate(machine.body.bars):
            span = points[:, j] - points[:, i]
            solid = link(
                machine.lengths[b],
                0.8 * machine.width,
                low,
                low + 0.1 * machine.layer,
                self.colour,
                **glass,
            )
            path = f"{self.name}/{number}-{b}"
            yield Part(path, [solid], placed(points[:, i], angles_of(span)), shown)
