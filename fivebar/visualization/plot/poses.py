"""A scene drawn by Matplotlib: strips of poses, GIFs and films, for where no page can be shown."""

from __future__ import annotations

import io
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

from ...base.progress import progress
from ..style import PATH
from ..view.layers import Area, Arrows, Ghost, Line, Turning
from ..view.machine import EVENT, MOTOR, PIN, PLATE, RAIL, STEEL

if TYPE_CHECKING:
    from ..view.scenes import Scene

# Pictures a second, which browsers slow down where a GIF has more; how many at most, beyond which a
# motion is shown faster; and pixels to an inch.
GIF, FILM = (20, 400, 80), (30, 1200, 160)
TURN = np.linspace(0.5 * np.pi, 1.5 * np.pi, 13)
ROUND = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)


def strip_figure(scene: Scene, poses: int = 6) -> Figure:
    """Figure of a view.Scene in so many poses, evenly spaced in time, in rows of at most six."""
    if isinstance(poses, bool) or not (isinstance(poses, (int, np.integer)) and 1 <= poses <= 48):
        raise ValueError(f"poses must be a whole number from 1 to 48, not {poses!r}")
    columns = min(poses, 6)
    rows = -(-poses // columns)
    side = 12.0 / max(columns, 3)
    figure = Figure(
        figsize=(side * columns, rows * (side * _shape(scene) + 0.3) + 0.8), layout="constrained"
    )
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, time in zip(panels, np.linspace(0.0, scene.duration, poses)):
        _stage(axes, scene)
        _draw(axes, scene, time)
        axes.set_title(f"{scene.machines[0].frames.start + time:.4g} s", fontsize=9)
    for axes in panels[poses:]:
        axes.remove()
    figure.suptitle(_heading(scene), fontsize=11)
    entries = {layer.key: layer.colour for machine in scene.machines for layer in machine.layers}
    bars = {
        name: colours[0] for machine in scene.machines for name, colours in machine.body.key.items()
    }
    handles = [
        Line2D([], [], color=colour, lw=3, label=key) for key, colour in (bars | entries).items()
    ]
    if handles:
        figure.legend(
            handles=handles, loc="outside lower center", ncols=4, fontsize=8, frameon=False
        )
    return figure


def save_strip(scene: Scene, path: str | Path) -> None:
    """Write a strip of six poses as PNG."""
    strip_figure(scene).savefig(path, dpi=120)


def strip_png(scene: Scene, poses: int) -> bytes:
    """The PNG file of a strip."""
    file = io.BytesIO()
    strip_figure(scene, poses).savefig(file, format="png", dpi=80)
    return file.getvalue()


def gif(scene: Scene, path: str | Path) -> None:
    """Write a GIF of 20 pictures a second; a motion of more than 20 s is shown faster, which its
    heading says.
    """
    _filmed(scene, path, PillowWriter(fps=GIF[0]), *GIF)


def film(scene: Scene, path: str | Path) -> None:
    """Write an MP4 or a WebM by its suffix, of 30 pictures a second; more than 40 s are shown
    faster.

    FileNotFoundError without ffmpeg, OSError where it fails.
    """
    kind = Path(path).suffix.lower()
    if not FFMpegWriter.isAvailable():
        raise FileNotFoundError(
            f"{kind} is written by the program ffmpeg, which is not here: install it (apt-get"
            " install ffmpeg, brew install ffmpeg), or take .html or .gif"
        )
    arguments = (
        ["-movflags", "+faststart"]
        if kind == ".mp4"
        else ["-deadline", "realtime", "-cpu-used", "5"]
    )
    try:
        codec = "h264" if kind == ".mp4" else "vp9"
        writer = FFMpegWriter(FILM[0], codec, extra_args=["-pix_fmt", "yuv420p", *arguments])
        _filmed(scene, path, writer, *FILM)
    except CalledProcessError as error:
        raise OSError(
            f"ffmpeg could not write a {kind}: {' '.join(error.stderr.split()[-40:])}"
        ) from None


def _filmed(scene, path, writer, per_second, most, dpi):
    count = max(2, round(scene.duration * per_second))
    times = np.linspace(0.0, scene.duration, min(count, most))
    faster = f", {count / len(times):.3g} times as fast" if count > len(times) else ""
    shape = _shape(scene)
    width, height = 6.0 / max(1.0, shape), 6.0 * min(1.0, shape)
    figure = Figure(figsize=(width, height + 0.35), dpi=dpi)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, height / (height + 0.35)))
    _stage(axes, scene)
    heading = figure.text(0.5, 0.99, "", ha="center", va="top", fontsize=9)
    moving = []
    with writer.saving(figure, path, dpi=dpi):
        for time in progress(times, unit=" pictures", delay=2, leave=False):
            for artist in moving:
                artist.remove()
            moving = _draw(axes, scene, time)
            heading.set_text(
                f"{_heading(scene)}  {scene.machines[0].frames.start + time:.2f} s{faster}"
            )
            writer.grab_frame()


def _heading(scene):
    """The title and the machines' names, without Matplotlib's mathematics and short enough for a
    heading.
    """
    text = scene.title + (f": {' | '.join(scene.names)}" if scene.names else "")
    text = " ".join(text.split()).replace("$", r"\$")
    return text if len(text) < 90 else text[:89] + "…"


def _shape(scene):
    (left, low), (right, high) = scene.window
    return float(np.clip((high - low) / (right - left), 0.3, 3.0))


def _stage(axes, scene):
    """What does not move: base, rails, lines and areas."""
    (left, low), (right, high) = scene.window
    axes.set(xlim=(left, right), ylim=(low, high), xticks=[], yticks=[])
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_color("#d5dade")
    for machine, offset in zip(scene.machines, scene.offsets):
        w, at, body = machine.width, np.array([offset, 0.0]), machine.body
        fixed = body.points[0] + at
        feet = fixed[body.feet]
        for a, b in zip(feet, feet[1:]):
            axes.add_patch(_capsule(a, b, 2.2 * w, PLATE, zorder=1))
        for foot in feet:
            corners = foot + 1.7 * w * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
            axes.add_patch(Polygon(corners, fc=PLATE, ec="none", zorder=1))
        for joint, foot in zip(body.feet, feet):
            radius, colour = (1.25 * w, MOTOR) if joint in body.actuated else (0.75 * w, RAIL)
            axes.add_patch(Circle(foot, radius, fc=colour, zorder=2))
        for i, j in body.fixed_rails:
            axes.add_patch(_capsule(fixed[i], fixed[j], 1.5 * w, PLATE, zorder=1))
            axes.add_patch(_capsule(fixed[i], fixed[j], 0.5 * w, RAIL, zorder=1.5))
        for layer in machine.layers:
            if isinstance(layer, Area):
                for rows in layer.strips:
                    edge = np.concatenate([rows[:, 0], rows[::-1, 1]]) + at
                    axes.add_patch(Polygon(edge, fc=layer.colour, alpha=0.12, lw=0, zorder=0))
            if isinstance(layer, Line) and layer.good is None:
                _line(axes, layer, at)


def _line(axes, layer, at):
    style = dict(
        color=layer.colour,
        lw=8 * layer.width,
        alpha=layer.opacity,
        zorder=7 + layer.lift if layer.over else 2.5,
    )
    style["ls"] = (0, (4, 2)) if layer.dash else "-"
    return [line for path in layer.paths for line in axes.plot(*(path + at).T, **style)]


def _draw(axes, scene, time):
    """What moves, at a time; gives the artists."""
    artists = []
    for machine, offset in zip(scene.machines, scene.offsets):
        frames, at = machine.frames, np.array([offset, 0.0])
        k = max(0, int(np.searchsorted(frames.t, time, side="right")) - 1)
        for layer in machine.layers:
            if isinstance(layer, Line) and layer.good is not None and layer.good[k]:
                artists += _line(axes, layer, at)
        if any(low < time < high for low, high in frames.gaps):
            continue
        artists += _machine(axes, machine, _between(frames.t, machine.body.points, time) + at)
        for layer in machine.layers:
            if isinstance(layer, (Arrows, Turning, Ghost)):
                artists += _layer(axes, machine, layer, time, at)
        for event in machine.events:
            if abs(event.t - time) <= 0.2:
                ring = Circle(
                    np.add(event.place, at),
                    1.8 * machine.width,
                    fc="none",
                    ec=EVENT,
                    lw=3,
                    zorder=9,
                )
                artists.append(axes.add_patch(ring))
    return artists


def _between(t, values, time):
    """Values at a time, linearly between the frames."""
    if time <= t[0] or len(t) == 1:
        return values[0]
    k = min(int(np.searchsorted(t, time)), len(t) - 1)
    share = min(1.0, (time - t[k - 1]) / (t[k] - t[k - 1]))
    return (1 - share) * values[k - 1] + share * values[k]


def _machine(axes, machine, points):
    w, body = machine.width, machine.body
    patches = [
        _capsule(points[i], points[j], 0.6 * w, RAIL, zorder=2.7) for i, j in body.moving_rails
    ]
    for i, j, joint in body.blocks:
        half = (points[j] - points[i]) / 2
        half = half * max(1.0, 1.3 * w / (np.hypot(*half) or 1.0))
        across, middle = w * half[::-1] * (-1, 1) / np.hypot(*half), (points[i] + points[j]) / 2
        corners = middle + np.array([-half - across, half - across, half + across, across - half])
        patches.append(
            Polygon(
                corners,
                fc=MOTOR if joint in body.actuated else RAIL,
                ec="white",
                lw=0.5,
                zorder=2.8,
            )
        )
    for (i, j), height, colour in zip(body.bars, machine.heights, machine.body.colours):
        patches.append(
            _capsule(
                points[i], points[j], w, colour, zorder=3 + height / machine.top, ec="white", lw=0.5
            )
        )
    for joint in body.joints:
        radius, colour = (0.62 * w, MOTOR) if joint in body.travelling else (0.36 * w, STEEL)
        patches.append(Circle(points[joint], radius, fc=colour, zorder=5))
        patches.append(
            Circle(points[joint], 0.22 * w, fc=PATH if joint == body.traced else PIN, zorder=6)
        )
    return [axes.add_patch(patch) for patch in patches]


def _layer(axes, machine, layer, time, at):
    t, w, colour = machine.frames.t, machine.pen, layer.colour
    if isinstance(layer, Ghost):
        points = _between(t, layer.mechanism, time) + at
        pairs = [
            (points[i], points[j])
            for i, j in machine.body.bars
            if np.isfinite(points[[i, j]]).all()
        ]
        return [
            axes.add_patch(_capsule(a, b, 0.8 * machine.width, layer.colour, zorder=2.6, alpha=0.4))
            for a, b in pairs
        ]
    place = _between(t, layer.places, time) + at
    if isinstance(layer, Arrows):
        arrow = _between(t, layer.drawn(machine), time)
        path = np.array([place, place + arrow])
    else:
        sweep = float(_between(t, layer.sweeps(), time))
        if not np.isfinite(sweep):
            return []
        turn = np.linspace(0.0, sweep, 40)
        path = place + layer.radius * w * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    length = np.hypot(*np.diff(path, axis=0).T).sum()
    if not length > 1e-3 * w:
        return []
    along = (path[-1] - path[-2]) / np.hypot(*(path[-1] - path[-2]))
    head, across = min(1.3 * w, 0.7 * length), along[::-1] * (-1, 1)
    tip = path[-1] + (head * along if isinstance(layer, Turning) else 0)
    corners = [
        tip,
        tip - head * along + 0.45 * head * across,
        tip - head * along - 0.45 * head * across,
    ]
    if isinstance(layer, Arrows):
        path = np.array([place, tip - head * along])
    words = dict(ha="center", va="center", fontsize=8, clip_on=True, zorder=8.5)
    sign = axes.text(*(tip + 0.8 * w * along), layer.sign if head > 0.9 * w else "", **words)
    return [
        sign,
        *axes.plot(*path.T, color=colour, lw=2, zorder=8),
        axes.add_patch(Polygon(corners, fc=colour, zorder=8)),
    ]


def _capsule(a, b, width, colour, **style):
    """A bar with round ends from a to b."""
    span = b - a
    along = span / (np.hypot(*span) or 1.0)
    turned = width / 2 * (ROUND[:, :1] * along + ROUND[:, 1:] * (along[::-1] * (-1, 1)))
    return Polygon(
        np.concatenate([a + turned, b - turned]), **{"fc": colour, "ec": "none", **style}
    )
