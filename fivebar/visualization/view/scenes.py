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

from ...base.tables import FilePath, replaced, saved
from ..document import WebPage, frame_html
from .machine import Machine
from .page import page
from .shows import shown, with_common_scale
from .sources import source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from matplotlib.figure import Figure

    from ...linkages import Study
    from ...models.robots import Robot
    from ...simulation.run import Run

HEIGHT = 480  # px, of the frame in a notebook


@dataclass(frozen=True, eq=False)
class Scene(WebPage):
    """One or two machines in motion on one clock, from `scene`; in a notebook it shows itself.

    Attributes
    ----------
    machines : tuple of Machine
    title : str
        Text over the picture.
    names : tuple of str
        One for each machine, or empty.
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
        boxes = [np.array(machine.box)[:, 0] for machine in self.machines]
        gap = 0.12 * max(high - low for low, high in boxes)
        offsets = [0.0]
        end = boxes[0][1]
        for low, high in boxes[1:]:
            offsets.append(float(end + gap - low))
            end = offsets[-1] + high
        return tuple(offsets)

    @cached_property
    def window(self) -> tuple[list[float], list[float]]:
        """((x, y) low, (x, y) high) of all machines, moved side by side, m: floats."""
        boxes = [np.add(m.box, (offset, 0)) for m, offset in zip(self.machines, self.offsets)]
        return np.min(boxes, axis=0)[0].tolist(), np.max(boxes, axis=0)[1].tolist()

    @property
    def duration(self) -> float:
        """Of the longer motion, s."""
        return max(machine.frames.duration for machine in self.machines)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out, as sentences."""
        return tuple(dict.fromkeys(sum((machine.frames.notes for machine in self.machines), ())))

    # Pictures and films are files of their own: no open text file will do.
    def save(self, path: FilePath) -> None:  # type: ignore[override]
        """Write a page (.html), an animation (.gif, .mp4, .webm) or a strip of six poses (.png).

        Raises ValueError for another suffix, OSError where the file cannot be written, or a film
        without ffmpeg.
        """
        path = Path(path)
        kind = path.suffix.lower()
        if kind not in (".html", ".gif", ".mp4", ".webm", ".png"):
            known = ".html (a page), .gif (an animation), .mp4, .webm (films) or .png (poses)"
            raise ValueError(f"a scene is saved as {known}, not as {path.name!r}")
        if not path.parent.is_dir():
            raise FileNotFoundError(f"cannot write {path}: there is no folder {path.parent}")
        if kind == ".html":
            return super().save(path)
        from ..plot.poses import film, save_strip

        with replaced(path, path.suffix) as part:
            (save_strip if kind == ".png" else film)(self, part)

    def saved(self, path: FilePath | None) -> Scene:
        """Return itself, saved if a path is given."""
        if path is not None:
            self.save(path)
        return self

    @cached_property
    def png(self) -> bytes:
        """Five poses in a row, as a PNG file."""
        from ..plot.poses import strip_png

        return strip_png(self)

    def _repr_png_(self):
        return self.png

    def _repr_html_(self):
        """Return the page in a frame that covers the picture of poses: where frames are stripped,
        the picture is seen.
        """
        title = html.escape(self.title)
        picture = b64encode(self.png).decode()
        return (
            f'<div style="position:relative;height:{HEIGHT}px;overflow:hidden">'
            f'<img style="max-width:100%;max-height:100%" alt="{title}"'
            f' src="data:image/png;base64,{picture}">'
            f"{frame_html(self.html, self.title, HEIGHT, 'position:absolute;left:0;top:0')}</div>"
        )


def scene(
    robot: Robot | object,
    motion: Run | Study | Callable,
    show: str | Iterable[str] | None = None,
    *,
    second: Run | Study | Callable | None = None,
    title: str | None = None,
    names: Iterable[str] | None = None,
) -> Scene:
    """Return the scene of a motion.

    Parameters
    ----------
    robot : FiveBar, Biglide or linkage
        What moves.
    motion : Run, Plan, reference or Study
        How it moves.
    show : str or sequence of str, optional
        Names out of `SHOWS`; the path, and the reference where there is one, by default.
    second : Run, Plan, reference or Study, optional
        A second motion of the same kind, drawn to the right on the same clock.
    title : str, optional
        Text over the picture; the mechanism's own by default.
    names : sequence of str, optional
        A text for each motion.

    Returns
    -------
    Scene
        It shows itself in a notebook; `save` writes it.

    Raises
    ------
    ValueError
        For unknown names, motions of another robot and motions of which nothing can be drawn.
    ImportError
        Without meshcat, once it is saved.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.view.scene(fb.FiveBar(), fb.line((0.05, 0.1), (0.0, 0.1), 1.0), ["trace", "loci"])
    Scene('five-bar robot, all bars 90 mm, base 118 mm', 1 s)
    """
    sources = [source(robot, motion)]
    if second is not None:
        mechanism = getattr(second, "robot", None) or getattr(second, "linkage", robot)
        sources.append(source(mechanism, second))
    if names is None:
        names = ("first", "second") if len(sources) == 2 else ()
    names = tuple(map(str, names))
    if names and len(names) != len(sources):
        raise ValueError(f"names has {len(names)} texts for {len(sources)} motions")
    groups = with_common_scale([shown(one, show) for one in sources])
    machines = tuple(
        Machine(one.frames, one.body, tuple(one.events), layers)
        for one, layers in zip(sources, groups)
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
    """Return the Matplotlib figure of a motion in poses evenly spaced in time.

    Parameters
    ----------
    motion : Run, Plan, reference or Study
        What is drawn.
    path : str, path or binary file, optional
        Where to write the figure: PNG, SVG or PDF.
    poses : int
        From 1 to 48.
    robot : FiveBar or Biglide, optional
        Needed for a reference only.
    show, title
        As in `scene`.

    Returns
    -------
    Figure
        One panel a pose.

    Raises
    ------
    ValueError
        As `scene`, and for a number of poses out of range.

    Examples
    --------
    >>> import fivebar as fb
    >>> line = fb.line((0.05, 0.1), (0.0, 0.1), 1.0)
    >>> figure = fb.view.strip(line, poses=3, robot=fb.FiveBar())
    >>> [axes.get_title() for axes in figure.axes]
    ['0 s', '0.5 s', '1 s']
    """
    from ..plot.poses import strip_figure

    subject = getattr(motion, "robot", None) or getattr(motion, "linkage", robot)
    return saved(strip_figure(scene(subject, motion, show, title=title), poses), path)
