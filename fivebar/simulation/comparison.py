"""Several runs side by side: the figures of each, as a table and as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..base.checks import instance, shown
from ..base.presentation import Plotted
from ..base.representation import aligned
from ..models.robots import Robot
from .run import Run

COLUMNS = (
    ("rms_error_m", "RMS error (µm)", 1e6),
    ("max_error_m", "largest (µm)", 1e6),
    ("final_error_m", "at the end (µm)", 1e6),
    ("peak_torque_Nm", "peak torque (mN m)", 1e3),
    ("peak_force_N", "peak force (N)", 1.0),
    ("saturated_s", "saturated (s)", 1.0),
    ("median_solve_s", "solve, median (ms)", 1e3),
    ("p99_solve_s", "99 % (ms)", 1e3),
    ("fallbacks", "fallbacks", 1),
)


def compare(runs: Mapping[str, Run]) -> Comparison:
    """Return the figures of several runs, {name: Run}, side by side: `fb.compare`."""
    if not isinstance(runs, Mapping):
        raise TypeError(f"compare: runs must be a dict {{name: Run}}, not {shown(runs)}")
    runs = dict(runs)
    if not runs:
        raise ValueError("compare needs at least one run in runs")
    for name, run in runs.items():
        instance(Run)(run, f"compare: runs[{name!r}]")
        if run.xi_ref is None:
            raise ValueError(f"compare: the run {name!r} has no reference, so no error")
    if len({type(run.robot) for run in runs.values()}) > 1:
        raise ValueError(
            "compare: these runs are of different kinds of robots, whose torques and forces do not"
            " compare"
        )
    return Comparison(runs)


@dataclass(frozen=True, eq=False)
class Comparison(Plotted):
    """runs {name: Run}; figures {name: {figure: value}} in SI units; printed, it is a table."""

    runs: dict[str, Run]

    @cached_property
    def figures(self) -> dict[str, dict]:
        """Errors of the end-effector; peak torques [left, right]; time with a torque at its limit
        (nan without one); of
        controllers that keep a log: solve times, and steps in which they fell back to another law
            (nan else).
        """
        return {name: _figures(run) for name, run in self.runs.items()}

    def _has(self, name):
        """Return whether a figure is a number for at least one run."""
        largest = [np.max(row.get(name, np.nan)) for row in self.figures.values()]
        return not np.isnan(largest).all()

    def __str__(self) -> str:
        used = [column for column in COLUMNS if self._has(column[0])]
        lines = [["", *(title for _, title, _ in used)]]
        for name, row in self.figures.items():
            lines.append([name, *(_number(scale * np.max(row[key])) for key, _, scale in used)])
        return "\n".join(aligned(lines, 1))


def peak_name(robot: Robot) -> str:
    """Return what the figure of the motors' largest torques or forces, a list, is called."""
    words = robot.words
    return f"peak_{words.effort}_{words.effort_unit.replace(' ', '')}"


def _figures(run):
    size = np.linalg.norm(run.error, axis=1)
    log = run.log
    size = size[np.isfinite(size)] if run.measured is not None else size  # not in the gaps of a log
    nan = float("nan")
    figures = {
        "rms_error_m": float(np.sqrt(np.mean(size**2))),
        "max_error_m": float(size.max()),
        "final_error_m": float(size[-1]),
        peak_name(run.robot): _peaks(run),
        "saturated_s": nan,
        "median_solve_s": nan,
        "p99_solve_s": nan,
        "fallbacks": nan,
    }
    if run.torque_limit is not None:
        saturated = run.saturated[:-1].any(axis=1)
        figures["saturated_s"] = float(np.diff(run.t)[saturated].sum())
    if log is not None:
        figures["median_solve_s"] = float(np.median(log.solve_time))
        figures["p99_solve_s"] = float(np.percentile(log.solve_time, 99))
        figures["fallbacks"] = int(np.count_nonzero(log.status))
    return figures


def _peaks(run):
    known = [tau[np.isfinite(tau)] for tau in run.tau.T]
    return [float(np.abs(tau).max(initial=0.0)) for tau in known]


def _number(value):
    if np.isnan(value):
        return "-"
    if value >= 1e3 or value == round(value):
        return f"{value:.0f}"
    return f"{value:.3g}"
