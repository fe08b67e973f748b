"""What a run was: its figures, its files, and the words for both."""

import json
import sys

import numpy as np

from . import outputs
from .plot_tools import scopes

PEN = "#0072B2", "#D55E00"
MOST_COLUMNS = 4
WRITERS = {"record": "to_csv", "bag": "to_bag", "plot": "plot", "animate": "animate"}


def figures(world, run, wall):
    """Return numbers of a finished run, as JSON has them."""
    simulated = world.steps / 100
    about = {
        "robot": world.kind,
        "simulated_s": simulated,
        "wall_s": wall,
        "real_time_factor": simulated / wall,
        "interrupted": world.interrupted,
        "resets_at_s": world.resets,
        "recorded_after_reset": bool(world.resets and world.since_reset),
    }
    if run is not None:
        about |= {
            "start_xi_m": run.xi[0].tolist(),
            "end_xi_m": run.xi[-1].tolist(),
            "end_q": run.q[-1].tolist(),
            "peak_effort": np.abs(run.tau).max(axis=0).tolist(),
            "singularity_crossings": [
                [event.t, int(event.type), event.margin] for event in run.events
            ],
        }
    about["scopes"] = [_difference(scope) for scope in drawn()]
    about["files"] = outputs.written
    return about


def drawn():
    """Return the scopes that were given points."""
    return [scope for scope in scopes if scope.points]


def _difference(scope):
    """Return how far apart the two curves of a scope are: tracking errors, where one of them is the
    reference.
    """
    _, first, second = np.transpose(scope.points)
    apart = np.abs(first - second)
    largest, rms = float(apart.max()), float(np.sqrt(np.mean(apart**2)))
    return {"title": scope.title, "largest_difference": largest, "rms_difference": rms}


def write_files(run, options):
    """The files asked for; the script's own windows are written as they close."""
    for option, write in WRITERS.items():
        path = options[option]
        if path is None:
            continue
        if run is None:
            raise ValueError(f"--{option} {path}: nothing to write, as nothing was stepped")
        try:
            getattr(run, write)(path)
        except ValueError as error:
            raise ValueError(f"--{option} {path}: {error}") from None
        outputs.written.append(str(path))


def draw_scopes(figure_of):
    """Return a figure of this kind with all scopes."""
    shown = drawn()
    columns = min(len(shown), 2 if len(shown) <= 4 else MOST_COLUMNS)
    rows = -(-len(shown) // columns)
    figure = figure_of(figsize=(3.9 * columns + 0.2, 2.2 * rows + 0.5), layout="constrained")
    for scope, axes in zip(shown, figure.subplots(rows, columns, squeeze=False).flat):
        t, *curves = np.transpose(scope.points)
        for curve, name, colour, style in zip(curves, ("y1", "y2"), PEN, ("-", "--")):
            axes.plot(t, curve, style, color=colour, lw=1.4, label=name)
        limits = [limit for limit in scope.limits if np.isfinite(limit)]
        axes.update_datalim([(t[0], limit) for limit in limits])
        difference = _difference(scope)["largest_difference"]
        title = f"{scope.title} (at most {difference:.3g} apart)"
        axes.set_title(title, parse_math=False)
        axes.grid(alpha=0.25)
        axes.margins(x=0)
    for axes in figure.axes[len(shown) :]:
        axes.remove()
    for axes in figure.axes[-columns:]:
        axes.set_xlabel("time (s)")
    figure.axes[0].legend(fontsize=8)
    return figure


def print_words(about):
    """The same for reading, on stderr."""
    lines = []
    if about["robot"] is None:
        lines.append("the script made no Robot")
    elif "end_xi_m" not in about:
        lines.append(f"{about['robot']}: nothing moved, as apply_efforts was not called")
    else:
        (x0, y0), (x1, y1) = about["start_xi_m"], about["end_xi_m"]
        lines.append(f"{about['robot']}: from ({x0:.6f}, {y0:.6f}) m to ({x1:.6f}, {y1:.6f}) m")
        side = "after" if about["recorded_after_reset"] else "before"
        lines += [
            f"reset at {t:g} s: said and recorded is what was {side} it"
            for t in about["resets_at_s"][-1:]
        ]
        lines += [
            f"singularity: Type {kind} ({margin} = 0) crossed at {t:.6f} s"
            for t, kind, margin in about["singularity_crossings"]
        ]
    for scope in about["scopes"]:
        largest, rms = scope["largest_difference"], scope["rms_difference"]
        lines.append(f"scope {scope['title']!r}: curves at most {largest:.6g} apart, RMS {rms:.6g}")
    if about["simulated_s"]:
        wall, factor = about["wall_s"], about["real_time_factor"]
        until = " (then its KeyboardInterrupt, --until)" if about["interrupted"] else ""
        lines.append(
            f"{about['simulated_s']:g} s simulated{until} in {wall:.2f} s, {factor:.3g} x real time"
        )
    lines += [f"wrote {path}" for path in about["files"]]
    say(*lines)


def print_json(about, stream):
    """Print the same as data; null for what is no number."""
    known = []
    for scope in about["scopes"]:
        values = [scope["largest_difference"], scope["rms_difference"]]
        largest, rms = (value if np.isfinite(value) else None for value in values)
        known.append(scope | {"largest_difference": largest, "rms_difference": rms})
    print(json.dumps(about | {"scopes": known}, indent=2), file=stream)


def say(*lines):
    """Messages of the runtime, on stderr, apart from the script's own."""
    sys.stdout.flush()
    for line in lines:
        print(f"fivebar run: {line}", file=sys.stderr)
