"""A scene: one mechanism in motion, or two side by side, and what is shown of them; it shows and
saves itself.
"""

from __future__ import annotations

import html
from base64 import b64encode
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...base.tables import replaced, saved, written
from ..document import framed
from .machine import Machine
from .page import page
from .shows import alike, shown, usual
from .sources import source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from matplotlib.figure import Figure

    from ...linkages import Study
    from ...models.robots import Robot
    from ...simulation.run import Run

WRITERS = {
    ".html": "a page",
    ".gif": "an animation",
    ".mp4": "a film",
    ".webm": "a film",
    ".png": "a strip of poses",
}
HEIGHT = 480  # px, of the frame in a notebook


@dataclass(frozen=True, eq=False)
class Scene:
    """One or two machines in motion on one clock, from `scene`; in a notebook it shows itself.

    machines: tuple of Machine; title: text over the picture; names: one for each machine, or empty.
    """

    machines: tuple[Machine, ...]
    title: str
    names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Scene({self.title!r}, {self.duration:.6g} s)"

    @cached_property
    def html(self) -> str:
        """The page, complete."""
        return page(self)

    @cached_property
    def offsets(self) -> tuple[float, ...]:
        """By how much each machine is moved to the right, m, so that they stand side by side."""
        gap = 0.12 * max(
            float(high[0] - low[0]) for low, high in (machine.box for machine in self.machines)
        )
        offsets, end = [], None
        for machine in self.machines:
            low, high = machine.box
            offsets.append(0.0 if end is None else end + gap - float(low[0]))
            end = offsets[-1] + float(high[0])
        return tuple(offsets)

    @cached_property
    def window(self) -> tuple[list[float], list[float]]:
        """((x, y) low, (x, y) high) of all machines, moved side by side, m: floats."""
        low = np.min(
            [m.box[0] + (offset, 0) for m, offset in zip(self.machines, self.offsets)], axis=0
        )
        high = np.max(
            [m.box[1] + (offset, 0) for m, offset in zip(self.machines, self.offsets)], axis=0
        )
        return low.tolist(), high.tolist()

    @property
    def duration(self) -> float:
        """Of the longer motion, s."""
        return max(machine.frames.duration for machine in self.machines)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out, as sentences."""
        return tuple(
            dict.fromkeys(note for machine in self.machines for note in machine.frames.notes)
        )

    def save(self, path: str | Path) -> None:
        """Write it to a file: .html the page, .gif an animation, .mp4 or .webm a film, .png a strip
        of six poses.

        ValueError for another suffix, OSError where the file cannot be written, or a film without
        ffmpeg.
        """
        path = Path(path)
        kind = path.suffix.lower()
        if kind not in WRITERS:
            known = ", ".join(f"{suffix} ({words})" for suffix, words in WRITERS.items())
            raise ValueError(f"a scene is saved as {known}, not as {path.name!r}")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"cannot write {path}: there is no folder {path.parent}")
        if kind == ".html":
            with written(path) as file:
                file.write(self.html)
        else:
            from ..plot import poses

            with replaced(path, path.suffix) as part:
                {".gif": poses.gif, ".png": poses.save_strip}.get(kind, poses.film)(self, part)

    def saved(self, path: str | Path | None) -> Scene:
        """Itself, saved if a path is given."""
        if path is not None:
            self.save(path)
        return self

    @cached_property
    def png(self) -> bytes:
        """Five poses in a row, as a PNG file: bytes."""
        from ..plot.poses import strip_png

        return strip_png(self, 5)

    def _repr_html_(self):
        """The page in a frame that covers the picture of poses: where frames are stripped, the
        picture is seen.
        """
        title, picture = html.escape(self.title), b64encode(self.png).decode()
        return (
            f'<div style="position:relative;height:{HEIGHT}px;overflow:hidden">'
            f'<img style="max-width:100%;max-height:100%" alt="{title}"'
            f' src="data:image/png;base64,{picture}">'
            f"{framed(self.html, self.title, HEIGHT, 'position:absolute;left:0;top:0')}</div>"
        )

    def _repr_mimebundle_(self, include=None, exclude=None):
        makers = {
            "text/html": self._repr_html_,
            "image/png": lambda: b64encode(self.png).decode(),
            "text/plain": lambda: repr(self),
        }
        wanted = set(include or makers) - set(exclude or ())
        return {kind: make() for kind, make in makers.items() if kind in wanted}


def scene(
    robot: Robot | object,
    motion: Run | Study | Callable,
    show: str | Iterable[str] | None = None,
    *,
    beside: Run | Study | Callable | None = None,
    title: str | None = None,
    names: Iterable[str] | None = None,
) -> Scene:
    """A Scene of a motion.

    robot   FiveBar or any robot with two drives, or a linkage
    motion  a Run, a Plan or any reference, or a Study of the linkage
    show    names out of SHOWS; None: the path, and the reference where there is one
    beside  a second motion of the same kind, drawn to the right on the same clock
    title   text over the picture, None: the mechanism's own
    names   texts for both motions

    ValueError for unknown names, motions of another robot and motions of which nothing can be
    drawn; ImportError without meshcat, once it is saved.
    """
    sources = [source(robot, motion)]
    if beside is not None:
        sources.append(
            source(getattr(beside, "robot", None) or getattr(beside, "linkage", robot), beside)
        )
    names = () if names is None else tuple(map(str, names))
    if names and len(names) != len(sources):
        raise ValueError(f"names has {len(names)} texts for {len(sources)} motions")
    if not names and len(sources) == 2:
        names = "first", "second"
    groups = alike([shown(own, usual(own) if show is None else show) for own in sources])
    machines = tuple(
        Machine(own.frames, own.body, tuple(own.events), layers)
        for own, layers in zip(sources, groups)
    )
    return Scene(machines, sources[0].heading if title is None else str(title), names)


def strip(
    motion: Run | Study | Callable,
    path: str | Path | None = None,
    poses: int = 6,
    *,
    robot: Robot | None = None,
    show: str | Iterable[str] | None = None,
    title: str | None = None,
) -> Figure:
    """Matplotlib figure of a motion in poses evenly spaced in time; written to `path` (PNG, SVG,
    PDF) if given.

    robot: needed for a reference only; the rest as in `scene`.
    """
    from ..plot.poses import strip_figure

    own = getattr(motion, "robot", None) or getattr(motion, "linkage", robot)
    figure = strip_figure(scene(own, motion, show, title=title), poses)
    return saved(figure, path)
