"""Runs on a page: one with its left and right side together, or several with a plot for each
side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...base.tables import must_increase
from ...models.dynamics import energy
from ...simulation.run import Run
from ...singularities.margins import singularity_margins
from ..loci import crossings
from ..skeleton import measured_pose, run_body
from ..style import largest_of, names_of, robot_title
from .document import packed
from .samples import TIME, gap_notes, panel, samples_to_keep, subject

if TYPE_CHECKING:
    from ...paths.timing.timed_path import TimedPath
    from ...planning.plans import Plan

LEGS = ("left", "right")
AXES = ("x", "y")


def is_planned(subject: object) -> bool:
    """Return whether it is a motion of a robot that knows its torques: a Plan, a TimedPath."""
    return all(hasattr(subject, name) for name in ("robot", "accelerations", "torques", "duration"))


def sampled(plan: Plan | TimedPath) -> Run:
    """Return a Plan or a TimedPath at 2001 times, with the singularities that it crosses."""
    robot = plan.robot
    t = np.linspace(0.0, plan.duration, 2001)
    rates = plan.accelerations(t).rates
    pose = rates.pose
    constraints = plan.limits if hasattr(plan, "limits") else plan.problem.constraints
    torque: Any = constraints.torque or ()
    limits = set(torque)
    return Run(
        robot,
        t,
        robot.continuous(pose.q),
        rates.q_dot,
        pose.xi,
        plan.torques(t),
        energy(rates),
        torque_limit=limits.pop() if len(limits) == 1 else None,
        events=tuple(Mark(time, kind) for time, kind, *_ in crossings(t, pose)),
        tool=getattr(plan, "tool", None),
    )


class Mark(NamedTuple):
    """A singularity that is crossed: when, s, and of which type."""

    t: float
    type: int


class RunQuantity(NamedTuple):
    """title; unit, by those of a joint and a drive; parts: names of the columns; of: Run -> (n,
    parts).
    """

    title: str
    unit: str
    parts: tuple
    of: Callable
    needs_reference: bool = False


def _error(run):
    return np.column_stack([run.error, np.linalg.norm(run.error, axis=1)])


def _margins(run):
    margins = singularity_margins(measured_pose(run.robot, run.q, run.xi))
    return np.column_stack([margins.serial, margins.parallel])


def _column(name):
    return lambda run: getattr(run, name).reshape(len(run.t), -1)


SINES = "left leg", "right leg", "distal bars"
QUANTITIES = {
    "q": RunQuantity("active joints", "{joint}", LEGS, _column("q")),
    "q_dot": RunQuantity("active joints' rates", "{joint}/s", LEGS, _column("q_dot")),
    "xi": RunQuantity("{point}", "m", AXES, _column("drawn")),
    "error": RunQuantity("tracking error", "m", (*AXES, "distance"), _error, True),
    "q_error": RunQuantity("active joints' error", "{joint}", LEGS, _column("q_error"), True),
    "tau": RunQuantity("motor {effort}s", "{effort}", LEGS, _column("tau")),
    "margins": RunQuantity("singularity margins (sines)", "", SINES, _margins),
    "energy": RunQuantity("kinetic energy", "J", ("energy",), _column("energy")),
    "potential": RunQuantity("potential energy", "J", ("energy",), _column("potential")),
}


def runs_content(runs: Mapping[str, Run], show: str | Iterable[str] | None = None) -> dict:
    """Return what the page of runs {name: Run} holds; a single run has the name ""."""
    runs = {str(name): run for name, run in runs.items()}
    show = _checked(runs, show)
    several = list(runs) != [""]
    # Of several runs' errors the distance alone.
    parts = {key: list(enumerate(QUANTITIES[key].parts)) for key in show}
    if several and "error" in parts:
        parts["error"] = parts["error"][-1:]
    width = sum(map(len, parts.values())) + 9  # time, three moving points, reference
    subjects = []
    columns = []
    notes = _differences(runs) if several else []
    for name, run in runs.items():
        source = f"Run.to_csv of {name}" if several else "Run.to_csv"
        keep, words = samples_to_keep(len(run.t), width * len(runs), source)
        run, broken = _thinned(name, run, keep)
        computed = {key: QUANTITIES[key].of(run) for key in show}
        notes += (
            words + (broken or gap_notes(name, computed)) + list(getattr(run.measured, "notes", ()))
        )
        column: dict = {}
        for key in show:
            column |= {f"{key} {part}": computed[key][:, k] for k, part in parts[key]}
        columns.append(column)
        reference = None if run.xi_ref is None else [packed(x) for x in run.drawn_ref.T]
        marks = [[event.t, f"Type {int(event.type)}"] for event in run.events]
        body = run_body(run)
        subjects.append(subject(name, run.t, body, column, reference=reference, marks=marks))
    words = run.robot.words
    size = max(largest_of(run_body(run).points) for run in runs.values())
    panels, table = [], []
    for key in show:
        unit = QUANTITIES[key].unit.format(joint=words.unit, effort=words.effort_unit)
        names = [part for _, part in parts[key]]
        panels += _panels(key, runs, columns, names, unit, size)
        header = f" ({unit})" if unit else ""
        table += [[f"{key} {part}", f"{key} {part}{header}"] for part in names]
    return {
        "title": f"{words.title}: {', '.join(runs)}" if several else robot_title(run.robot),
        "notes": notes,
        "axis": TIME,
        "subjects": subjects,
        "panels": panels,
        "table": table,
        "source": "Run.to_csv",
    }


def _panels(key, runs, columns, names, unit, size):
    """Return the plots of a quantity: one with all its parts, or with several runs one for each
    part.
    """
    first = next(iter(runs.values()))
    point = "end-effector" if first.tool is None else "tool"
    title = QUANTITIES[key].title.format(effort=first.robot.words.effort, point=point)
    step = key == "tau"
    known = {run.largest_torque for run in runs.values() if step} - {None}
    limits = [sign * limit for limit in sorted(known) for sign in (1, -1)]
    several = list(runs) != [""]
    panels = []
    for group in ([name] for name in names) if several else (names,):
        curves = [
            (run or part, k, f"{key} {part}", columns[k][f"{key} {part}"])
            for part in group
            for k, run in enumerate(runs)
        ]
        words = title
        if several and len(QUANTITIES[key].parts) > 1:
            words = f"{title}, {group[0]}"
        panels.append(panel(words, unit, curves, limits, step, size))
    return panels


def _checked(runs, show):
    """Return the names of what is shown; refuses names and references that are not there."""
    if not runs:
        raise ValueError("a page needs at least one run")
    for name, run in runs.items():
        if not isinstance(run, Run):
            raise TypeError(f"a page compares Runs, but {name!r} is a {type(run).__name__}")
        must_increase(run.t, f"the run {name!r}" if name else "the run")
    if len({run.robot.turns for run in runs.values()}) > 1:
        raise ValueError("runs of cranks and of sliders cannot be compared: their units differ")
    referenced = all(run.xi_ref is not None for run in runs.values())
    if show is None:
        return ("error" if referenced else "xi"), "tau", "q", "margins"
    show = tuple(dict.fromkeys(names_of(show)))
    known = ", ".join(QUANTITIES)
    for name in show:
        if name not in QUANTITIES:
            raise ValueError(f"no quantity {name!r}; the known ones are {known}")
        if QUANTITIES[name].needs_reference and not referenced:
            raise ValueError(f"{name} cannot be shown: there is a run without a reference")
    if not show:
        raise ValueError(f"show is empty; the known quantities are {known}")
    return show


def _differences(runs):
    """Notes on what is to be kept in mind where runs are compared."""
    notes = []
    first = next(iter(runs.values()))
    if any(run.robot != first.robot for run in runs.values()):
        notes.append("The robots differ.")
    if len({(run.t[0], run.t[-1]) for run in runs.values()}) > 1:
        notes.append(
            "The runs differ in time: before its start a run stays at its first sample, and after"
            " its end at its last."
        )
    return notes


def _thinned(name, run, keep):
    """These samples of the run, with nan for inf, of which no cosine can be taken, and a note on
    both.
    """
    values = {field.name: getattr(run, field.name) for field in fields(run)}
    arrays = {key: array for key, array in values.items() if isinstance(array, np.ndarray)}
    for key, values in arrays.items():
        if len(values) != len(run.t):
            raise ValueError(f"the run has {len(run.t)} samples of t, but {len(values)} of {key}")
    arrays = {key: values[keep] for key, values in arrays.items()}
    finite = {key: np.where(np.isfinite(values), values, np.nan) for key, values in arrays.items()}
    return replace(run, **finite), gap_notes(name, arrays)
