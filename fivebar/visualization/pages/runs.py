"""Runs on a page: one with its left and right side together, or several with a plot for each
side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...base.tables import must_increase
from ...models.dynamics import energy
from ...models.loads import potential
from ...singularities.margins import singularity_margins
from ..crossings import crossings
from ..names import names_of
from ..skeleton import measured_pose, run_body
from ..style import robot_title
from .document import packed
from .samples import gaps, kept, panel, subject

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ...paths.timing.timed_path import TimedPath
    from ...planning.plans import Plan
    from ...simulation.run import Run

LEGS, AXES = ("left", "right"), ("x", "y")


def is_run(subject: object) -> bool:
    """Whether it is what `simulate` gives."""
    return hasattr(subject, "xi_ref") and hasattr(subject, "q_dot")


def is_planned(subject: object) -> bool:
    """Whether it is a motion of a robot that knows its torques: a Plan, a TimedPath."""
    return all(hasattr(subject, name) for name in ("robot", "accelerations", "tau", "duration"))


@dataclass(frozen=True, eq=False)
class Sampled:
    """A planned motion as a page takes it: `motions.Run` without a reference."""

    robot: Robot
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    xi: np.ndarray
    tau: np.ndarray
    energy: np.ndarray
    potential: np.ndarray
    torque_limit: float | None
    events: tuple
    xi_ref = measured = None


def sampled(plan: Plan | TimedPath) -> Sampled:
    """A Plan or a TimedPath at 2001 times, with the singularities that it crosses."""
    robot, t = plan.robot, np.linspace(0.0, plan.duration, 2001)
    rates = plan.accelerations(t).rates
    pose, limit = (
        rates.pose,
        (plan.limits if hasattr(plan, "limits") else plan.problem.constraints).torque,
    )
    limits = np.ravel([] if limit is None else limit)
    return Sampled(
        robot,
        t,
        robot.continuous(pose.q),
        rates.q_dot,
        pose.xi,
        plan.tau(t),
        energy(rates),
        potential(pose) + np.zeros(len(t)),
        float(limits[0]) if len(limits) and np.ptp(limits) == 0 else None,
        tuple(Mark(time, kind) for time, kind, *_ in crossings(t, pose)),
    )


class Mark(NamedTuple):
    """A singularity that is crossed: when, s, and of which type."""

    t: float
    type: int


class Quantity(NamedTuple):
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


QUANTITIES = {
    "q": Quantity("active joints", "{joint}", LEGS, lambda run: run.q),
    "q_dot": Quantity("active joints' rates", "{joint}/s", LEGS, lambda run: run.q_dot),
    "xi": Quantity("end-effector", "m", AXES, lambda run: run.xi),
    "error": Quantity("tracking error", "m", (*AXES, "distance"), _error, True),
    "q_error": Quantity("active joints' error", "{joint}", LEGS, lambda run: run.q_error, True),
    "tau": Quantity("motors", "{effort}", LEGS, lambda run: run.tau),
    "margins": Quantity(
        "sines, 0 at a singularity", "", ("left leg", "right leg", "distal bars"), _margins
    ),
    "energy": Quantity("kinetic energy", "J", ("energy",), lambda run: run.energy[:, None]),
    "potential": Quantity("potential energy", "J", ("energy",), lambda run: run.potential[:, None]),
}


def runs_content(runs: Mapping[str, Run], show: str | Iterable[str] | None = None) -> dict:
    """What the page of runs {name: Run} holds; a single run has the name ""."""
    runs = {str(name): run for name, run in runs.items()}
    show = _checked(runs, show)
    several = list(runs) != [""]
    parts = {key: _parts(key, several) for key in show}
    width = sum(map(len, parts.values())) + 9  # time, three moving points, reference
    subjects, columns, notes = [], [], _differences(runs) if several else []
    for name, run in runs.items():
        keep, words = kept(
            len(run.t), width * len(runs), f"Run.to_csv of {name}" if several else "Run.to_csv"
        )
        run, broken = _sampled(name, run, keep)
        computed = {key: QUANTITIES[key].of(run) for key in show}
        notes += words + (broken or gaps(name, computed)) + list(getattr(run.measured, "notes", ()))
        columns.append(
            {f"{key} {part}": computed[key][:, k] for key in show for part, k in parts[key]}
        )
        reference = None if run.xi_ref is None else [packed(x) for x in run.xi_ref.T]
        marks = [[event.t, f"Type {int(event.type)}"] for event in run.events]
        own = subject(name, run.t, run_body(run), columns[-1], reference=reference, marks=marks)
        subjects.append(own)
    words = next(iter(runs.values())).robot.words
    units = {
        key: QUANTITIES[key].unit.format(joint=words.unit, effort=words.effort_unit) for key in show
    }
    titles = [(f"{key} {part}", units[key]) for key in show for part, _ in parts[key]]
    return {
        "title": f"{words.title}: {', '.join(runs)}" if several else robot_title(run.robot),
        "notes": notes,
        "axis": {"name": "time", "unit": "s", "scale": 1.0},
        "subjects": subjects,
        "panels": [
            own
            for key in show
            for own in _panels(key, runs, columns, parts[key], units[key], several)
        ],
        "table": [[key, f"{key} ({unit})" if unit else key] for key, unit in titles],
        "source": "Run.to_csv",
    }


def _panels(key, runs, columns, parts, unit, several):
    """The plots of a quantity: one with all its parts, or with several runs one for each part."""
    quantity, names, step = QUANTITIES[key], [part for part, _ in parts], key == "tau"
    limits = sorted(
        {run.torque_limit for run in runs.values() if step and run.torque_limit is not None}
    )
    for group in [[part] for part in names] if several else [names]:
        curves = [
            (name if several else part, k, f"{key} {part}", columns[k][f"{key} {part}"])
            for k, name in enumerate(runs)
            for part in group
        ]
        title = (
            f"{quantity.title}, {group[0]}"
            if several and len(quantity.parts) > 1
            else quantity.title
        )
        yield panel(title, unit, curves, [sign * x for x in limits for sign in (1, -1)], step)


def _checked(runs, show):
    """The names of what is shown; refuses runs without samples, and names and references that are
    not there.
    """
    if not runs:
        raise ValueError("a page needs at least one run")
    for name, run in runs.items():
        if not is_run(run):
            raise TypeError(f"a page compares Runs, but {name!r} is a {type(run).__name__}")
        must_increase(run.t, f"the run {name!r}" if name else "the run")
    if len({run.robot.turns for run in runs.values()}) > 1:
        raise ValueError(
            "runs of robots with cranks and with sliders cannot be compared: they have no units in"
            " common"
        )
    referenced = all(run.xi_ref is not None for run in runs.values())
    if show is None:
        return ("error", "tau", "q", "margins") if referenced else ("xi", "tau", "q", "margins")
    show = tuple(dict.fromkeys(names_of(show)))
    for name in show:
        if name not in QUANTITIES:
            raise ValueError(f"no quantity {name!r}; the known ones are {', '.join(QUANTITIES)}")
        if QUANTITIES[name].needs_reference and not referenced:
            raise ValueError(f"{name} cannot be shown: there is a run without a reference")
    if not show:
        raise ValueError(f"show is empty; the known quantities are {', '.join(QUANTITIES)}")
    return show


def _parts(key, several):
    """(name, column) of what is shown of a quantity: of several runs' errors the distance alone."""
    parts = list(zip(QUANTITIES[key].parts, range(3)))
    return parts[-1:] if several and key == "error" else parts


def _differences(runs):
    """Notes on what is to be kept in mind where runs are compared."""
    notes, several = [], list(runs.values())
    if any(run.robot != several[0].robot for run in several):
        notes.append("The robots differ.")
    if len({(run.t[0], run.t[-1]) for run in several}) > 1:
        notes.append(
            "The runs differ in time; outside its own each one stays at its first or last sample."
        )
    return notes


def _sampled(name, run, keep):
    """These samples of the run, with nan for inf, of which no cosine can be taken, and a note on
    both.
    """
    arrays = {
        f.name: getattr(run, f.name)
        for f in fields(run)
        if isinstance(getattr(run, f.name), np.ndarray)
    }
    for key, values in arrays.items():
        if len(values) != len(run.t):
            raise ValueError(f"the run has {len(run.t)} samples of t, but {len(values)} of {key}")
    arrays = {key: values[keep] for key, values in arrays.items()}
    finite = {key: np.where(np.isfinite(values), values, np.nan) for key, values in arrays.items()}
    return replace(run, **finite), gaps(name, arrays)
