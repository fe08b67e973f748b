"""A scene drawn by Matplotlib: strips of poses, GIFs and films, for where no page can be shown.

Each part of the scene is drawn flat as the areas of its outlines, the highest last, as the page
does in a browser without WebGL.
"""

from __future__ import annotations

import io
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...base.progress import progress
from ..view.machine import SHADOW_OFFSET
from .panels import figure_legend
from .sheets import new_figure

if TYPE_CHECKING:
    from ..view.scenes import Scene

# Pictures a second, which browsers slow down where a GIF has more; how many at most, beyond which a
# motion is shown faster; and pixels to an inch.
GIF = (20, 400, 80)
FILM = (30, 1200, 160)
CODECS = {
    ".mp4": ("h264", "-movflags", "+faststart"),
    ".webm": ("vp9", "-deadline", "realtime", "-cpu-used", "5"),
}


def strip_figure(scene: Scene, poses: int = 6) -> Figure:
    """Return the figure of a scene in so many poses, in rows of at most six."""
    if poses not in range(1, 49) or isinstance(poses, bool):
        raise ValueError(f"poses must be a whole number from 1 to 48, not {poses!r}")
    columns = min(poses, 6)
    rows = -(-poses // columns)
    side = 12.0 / max(columns, 3)
    figure = new_figure(side * columns, rows * (side * _shape(scene) + 0.3) + 0.8)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, time in zip(panels, np.linspace(0.0, scene.duration, poses)):
        _stage(axes, scene)
        _draw(axes, scene, time)
        axes.set_title(f"{scene.machines[0].frames.start + time:.4g} s", fontsize=9)
    for axes in panels[poses:]:
        axes.remove()
    figure.suptitle(_heading(scene), fontsize=11)
    entries: dict = {}
    for machine in scene.machines:
        entries |= {name: colours[0] for name, colours in machine.body.key.items()}
        entries |= {layer.key: layer.colour for layer in machine.layers}
    handles = [Line2D([], [], color=colour, lw=3, label=key) for key, colour in entries.items()]
    if handles:
        figure_legend(figure, handles, 4)
    return figure


def save_strip(scene: Scene, path: str | Path) -> None:
    """Write a strip of six poses as PNG."""
    strip_figure(scene).savefig(path, dpi=120)


def strip_png(scene: Scene) -> bytes:
    """Return the PNG file of a strip of five poses."""
    file = io.BytesIO()
    strip_figure(scene, 5).savefig(file, format="png", dpi=80)
    return file.getvalue()


def film(scene: Scene, path: str | Path) -> None:
    """Write a GIF, an MP4 or a WebM by its suffix; long motions are shown faster, says the heading.

    Raises FileNotFoundError without ffmpeg, OSError where it fails.
    """
    kind = Path(path).suffix.lower()
    if kind == ".gif":
        return _film(scene, path, PillowWriter(fps=GIF[0]), *GIF)
    if not FFMpegWriter.isAvailable():
        raise FileNotFoundError(
            f"{kind} is written by the program ffmpeg, which is not installed: install it, or take"
            " .html or .gif"
        )
    codec, *options = CODECS[kind]
    writer = FFMpegWriter(FILM[0], codec, extra_args=["-pix_fmt", "yuv420p", *options])
    try:
        _film(scene, path, writer, *FILM)
    except CalledProcessError as error:
        words = " ".join(error.stderr.split()[-40:])
        raise OSError(f"ffmpeg could not write a {kind}: {words}") from None


def _film(scene, path, writer, per_second, most, dpi):
    count = max(2, round(scene.duration * per_second))
    times = np.linspace(0.0, scene.duration, min(count, most))
    if count > len(times):
        faster = f", {count / len(times):.3g} times as fast"
    else:
        faster = ""
    shape = _shape(scene)
    width = 6.0 / max(1.0, shape)
    height = 6.0 * min(1.0, shape)
    figure = Figure(figsize=(width, height + 0.35), dpi=dpi)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, height / (height + 0.35)))
    _stage(axes, scene)
    heading = figure.text(0.5, 0.99, "", ha="center", va="top", fontsize=9)
    drawn = []
    with writer.saving(figure, path, dpi=dpi):
        for time in progress(times, unit=" pictures", delay=2, leave=False):
            for artist in drawn:
                artist.remove()
            drawn = _draw(axes, scene, time)
            clock = f"{scene.machines[0].frames.start + time:.2f} s"
            heading.set_text(f"{_heading(scene)}  {clock}{faster}")
            writer.grab_frame()


def _heading(scene):
    """Return the title and the machines' names, without Matplotlib's mathematics and short enough
    for a heading.
    """
    text = scene.title + (f": {' | '.join(scene.names)}" if scene.names else "")
    text = " ".join(text.split()).replace("$", r"\$")
    return text if len(text) < 90 else text[:89] + "…"


def _shape(scene):
    (left, low), (right, high) = scene.window
    return float(np.clip((high - low) / (right - left), 0.3, 3.0))


def _stage(axes, scene):
    (left, low), (right, high) = scene.window
    axes.set(xlim=(left, right), ylim=(low, high), xticks=[], yticks=[], aspect="equal")
    axes.spines[:].set_color("#d5dade")


def _draw(axes, scene, time):
    """Draw the scene at a time; return the artists."""
    areas, texts = [], []
    for machine, offset in zip(scene.machines, scene.offsets):
        places = {"still": _place(x=offset), "moving": _place(x=offset)}
        places["moving/shadows"] = _place(*SHADOW_OFFSET * machine.width + (offset, 0))
        t = machine.frames.t
        gone = any(low < time < high for low, high in machine.frames.gaps)
        for group, part in machine.groups:
            path = f"{group}/{part.path}"
            parent = places.get(path.rpartition("/")[0], places[group])
            hidden = parent is None or (gone and group == "moving") or not _is_shown(part, time)
            places[path] = None if hidden else parent @ _place_at(part, t, time)
            if not hidden:
                share = 1.0 if part.drawn is None else _between(t, part.drawn, time)
                areas += _areas(part.meshes, places[path], share)
        for event in machine.events:
            if abs(event.t - time) <= 0.2:
                x, y = event.place
                areas += _areas(machine.flash, _place(x + offset, y), 1.0)
        for number, layer in enumerate(machine.layers):
            tip = places.get(f"moving/{layer.name}/{number}/tip") if layer.sign else None
            if tip is not None:
                sign = layer.place_of_sign(machine)
                if np.hypot(*tip[:2, 1]) > sign["least"]:
                    texts.append((tip @ (*sign["at"], 1.0), layer.sign))
    areas.sort(key=lambda area: area[0])
    _, polygons, colours = zip(*areas)
    edges = dict(edgecolors="face", linewidths=0.6, zorder=2)
    style = dict(ha="center", va="center", fontsize=8, clip_on=True, zorder=3)
    return [
        axes.add_collection(PolyCollection(polygons, facecolors=colours, **edges)),
        *(axes.text(x, y, text, **style) for (x, y, _), text in texts),
    ]


def _place(x=0.0, y=0.0, angle=0.0, scale=(1.0, 1.0)):
    """Return the matrix of a place, a turn and a scale in the plane."""
    c = np.cos(angle)
    s = np.sin(angle)
    return np.array([(c * scale[0], -s * scale[1], x), (s * scale[0], c * scale[1], y), (0, 0, 1)])


def _place_at(part, t, time):
    values = {name: _between(t, track, time) for name, (_, track) in part.tracks.items()}
    x, y, _ = values.get("position", (0.0, 0.0, 0.0))
    return _place(x, y, values.get("rotation[z]", 0.0), values.get("scale", (1.0, 1.0)))


def _is_shown(part, time):
    if part.shown is None:
        return True
    since, flags = part.shown
    return flags[max(0, int(np.searchsorted(since, time, side="right")) - 1)]


def _areas(meshes, place, share):
    """Yield (height, corners, colour) of each outline; of a band the first share."""
    for mesh in meshes:
        material = mesh["material"]
        opacity = material["opacity"] if material.get("transparent") else 1.0
        colour = to_rgba(f"#{material['color']:06x}", opacity)
        for outline in mesh["outlines"]:
            if share < 1:
                rows = round(share * (len(outline) / 2 - 1)) + 1
                outline = np.concatenate([outline[:rows], outline[-rows:]])
            yield (mesh["top"], outline @ place[:2, :2].T + place[:2, 2], colour)


def _between(t, values, time):
    """Return values at a time, linearly between the frames; one value holds."""
    if time <= t[0] or len(values) == 1:
        return values[0]
    k = min(int(np.searchsorted(t, time)), len(t) - 1)
    share = min(1.0, (time - t[k - 1]) / (t[k] - t[k - 1]))
    return (1 - share) * values[k - 1] + share * values[k]
