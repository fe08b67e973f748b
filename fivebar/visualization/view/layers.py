"""What is shown of a mechanism besides itself: lines, arrows and turning arrows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

import numpy as np

from .solids import arc, dash_pieces, polygon, ribbon
from .tracks import Part, place_tracks, scale_track

if TYPE_CHECKING:
    from .machine import Machine

ARROW = 0.3  # the longest arrow's share of the mechanism's size
SWEEP = np.radians(300)  # of the turning arrow of the largest value
PIECES = 120  # of its band


def visibility(times: np.ndarray, good: np.ndarray) -> tuple | None:
    """Return when a part is shown (times, flags), of flags (m,) at the frames; None for always."""
    if good.all():
        return None
    change = np.append(0, np.flatnonzero(np.diff(good)) + 1)
    return times[change], good[change]


@dataclass(frozen=True, eq=False)
class Layer:
    """Something shown, with a name and a colour; words: what a legend calls it."""

    name: str
    colour: str
    _: KW_ONLY
    words: str = ""
    sign: str = ""  # what is written at an arrow's tip
    still = False  # whether it belongs to the base
    glyph = "line"  # how a legend shows it

    @property
    def key(self) -> str:
        """What a legend calls it."""
        return self.words or self.name

    def reach(self, machine: Machine) -> np.ndarray:
        """Return points (n, 2) m for which the picture must have room."""
        raise NotImplementedError

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        """Yield its nodes in the scene, of a machine's layer of this number."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class LineLayer(Layer):
    """Paths, each (n, 2) m; width, and dash (on, off), in widths of a bar."""

    paths: list
    width: float = 0.12
    dash: tuple | None = None
    over: bool = False  # the bars, or under them
    opacity: float = 1.0
    lift: float = 0.0
    good: np.ndarray | None = None  # (m,) at which frames it is shown
    still = True

    def reach(self, machine: Machine) -> np.ndarray:
        return np.concatenate([np.empty((0, 2)), *self.paths])

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        w = machine.pen
        paths = self.paths
        path = f"{self.name}/{number}"
        if self.dash:
            on, off = w * np.array(self.dash)
            paths = sum((dash_pieces(line, on, off) for line in paths), [])
        if self.over:
            height = machine.top + self.lift * w
        else:
            height = (self.lift - 0.5) * machine.layer
        glass = {"transparent": self.opacity < 1, "opacity": self.opacity}
        band = ribbon(paths, self.width * w, height, self.colour, **glass)
        times = machine.frames.t
        shown = None if self.good is None else visibility(times, self.good)
        # A path that stays in one point has no band, and the viewer complains of an empty one.
        yield Part(path, [band] if band else [], shown=shown)


@dataclass(frozen=True, eq=False)
class Arrows(Layer):
    """Arrows (m, 2) from places (m, 2) m, in `unit`; nan where there is none.

    One of the length `largest` is drawn `ARROW` times as long as the mechanism is large.
    """

    places: np.ndarray
    vectors: np.ndarray
    unit: str
    largest: float
    glyph = "arrow"

    @property
    def key(self) -> str:
        return f"{self.words} (longest {self.largest:.3g} {self.unit})"

    def reach(self, machine: Machine) -> np.ndarray:
        tips = self.places + self.drawn(machine)
        return tips[np.isfinite(tips).all(axis=1)]

    def place_of_sign(self, machine: Machine) -> dict:
        """Return where it is in the tip's frame, and the tip's least size for it to be seen."""
        return {"at": (1.8, 0.0), "least": 0.9 * machine.pen}

    def drawn(self, machine: Machine) -> np.ndarray:
        """Return the arrows as they are drawn, (m, 2) m."""
        return self.vectors * (ARROW * machine.size / (self.largest or 1.0))

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        arrows = self.drawn(machine)
        w = machine.pen
        path = f"{self.name}/{number}"
        good = np.isfinite(arrows).all(axis=1)
        arrows = np.where(good[:, None], arrows, 0.0)
        yield Part(path, [], place_tracks(self.places, arrows), visibility(machine.frames.t, good))
        # Both have unit length along x; a scale of 0 has no inverse, which the viewer's shading
        # asks for.
        length = np.hypot(*arrows.T)
        height = machine.top + (0.25 + 0.02 * number) * w
        head = np.maximum(np.minimum(1.3 * w, 0.7 * length), 1e-6 * w)
        neck = np.maximum(length - head, 1e-6 * w)
        half = 0.14 * w
        shaft = polygon([(0, -half), (1, -half), (1, half), (0, half)], height, self.colour)
        yield Part(f"{path}/shaft", [shaft], scale_track(neck, 1.0))
        tip = polygon([(0, -0.45), (1, 0), (0, 0.45)], height, self.colour)
        tracks = place_tracks(np.stack([neck, 0 * neck], axis=1)) | scale_track(head, head)
        yield Part(f"{path}/tip", [tip], tracks)


@dataclass(frozen=True, eq=False)
class TurningArrows(Layer):
    """Turning arrows about places (m, 2) m: values (m,), counter-clockwise > 0.

    One of the size `largest` is drawn `SWEEP` wide.
    """

    places: np.ndarray
    values: np.ndarray
    unit: str
    largest: float
    glyph = "turn"
    radius = 2.4  # widths of a bar

    @property
    def key(self) -> str:
        return f"{self.words} (largest {self.largest:.3g} {self.unit})"

    def reach(self, machine: Machine) -> np.ndarray:
        return np.empty((0, 2))

    def place_of_sign(self, machine: Machine) -> dict:
        """Return where it is in the tip's frame, and the tip's least size for it to be seen."""
        return {"at": (self.radius * machine.pen, 2.2 * machine.pen), "least": 0.3}

    def sweeps(self) -> np.ndarray:
        """Return the angles (m,) through which they turn, rad."""
        return self.values * (SWEEP / (self.largest or 1.0))

    def parts(self, machine: Machine, number: int) -> Iterator[Part]:
        good = np.isfinite(self.values)
        sweep = np.where(good, self.sweeps(), 0.0)
        w = machine.pen
        path = f"{self.name}/{number}"
        radius = self.radius * w
        height = machine.top + 0.2 * w
        tracks = place_tracks(self.places) | scale_track(1.0, np.where(sweep < 0, -1.0, 1.0))
        yield Part(path, [], tracks, visibility(machine.frames.t, good))
        # The page draws as many pieces of the band as the tip has passed: no track can change a
        # geometry.
        size = np.abs(sweep)
        band = arc(radius, 0.34 * w, SWEEP, PIECES, height, self.colour)
        yield Part(f"{path}/band", [band], drawn=size / SWEEP)
        corners = [(radius - 0.55 * w, 0), (radius + 0.55 * w, 0), (radius, 1.1 * w)]
        tip = polygon(corners, height, self.colour)
        tracks = {"rotation[z]": ("number", size)} | scale_track(
            1.0, np.clip(size / 0.3, 0.02, 1.0)
        )
        yield Part(f"{path}/tip", [tip], tracks)
