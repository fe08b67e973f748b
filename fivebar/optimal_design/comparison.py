"""Runs or designs side by side: figures of each, as a table and as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.presentation import Plotted
from ..base.representation import aligned
from ..base.robot_uses import AnyRobot, robot_for
from ..models.robots import Biglide, FiveBar
from ..simulation.comparison import compare as compare_runs
from .batch import PLACE
from .figures import Figure, evaluate, figures_of
from .results import Design
from .task import Task, task_of

if TYPE_CHECKING:
    from ..simulation.comparison import Comparison
    from ..simulation.run import Run

USUAL = ("bars", "workspace_area", "largest_disc", "largest_rectangle")  # which need no table


def compare(
    runs: Mapping[str, Run] | Mapping[str, AnyRobot | Design], figures: Any = None, **choices: Any
) -> Comparison | DesignComparison:
    """Return figures of several runs, or of several designs, side by side.

    Parameters
    ----------
    runs : dict
        {name: Run}, each with a reference, all of one kind of robot; or {name: robot or Design},
        also the name or the file of a robot.
    figures : str, callable, list or mapping, optional
        Of designs: figures of merit, as `sweep` takes them. None: those of the first Design, else
        bars, workspace_area, largest_disc and largest_rectangle.
    **choices
        Of designs: what the figures are about, the fields of `optimal_design.Task`; without any,
        the task of the first Design.

    Returns
    -------
    Comparison or DesignComparison
        `figures` {name: {figure: value}} in SI units; printed, it is a table; `plot` draws it.

    Raises
    ------
    ValueError
        A run has no reference, robots of two kinds are compared, or figures and choices do not fit.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot, line = fb.FiveBar(), fb.line((0.09, 0.068), (0.08, 0.075), 0.5)
    >>> runs = {"PD": fb.simulate(robot, fb.PD(robot, 2, 0.2), line)}
    >>> fb.compare(runs).figures["PD"]["peak_torque_Nm"][0] > 0
    True

    >>> robots = {"lab": robot, "narrow": fb.FiveBar(d=0.1)}
    >>> print(fb.compare(robots, ["det_A", "transmission_angle"], table=(-0.01, 0.01, 0.1, 0.12)))
                                 lab  narrow
    det_A                     0.3298  0.4014
    transmission_angle (rad)  0.3361  0.4131
    """
    given: Mapping[str, Any] = runs
    if not isinstance(given, Mapping) or all(hasattr(each, "xi_ref") for each in given.values()):
        compared = compare_runs(given)
        if named := [*choices, *["figures"] * (figures is not None)]:
            raise ValueError(f"compare: {', '.join(named)}: of designs only, these are runs")
        return compared
    robots: dict[str, FiveBar | Biglide] = {}
    places: dict[str, Any] = {}
    for name, each in given.items():
        if isinstance(each, Design):
            robots[name], places[name] = each.robot, each.place
        else:
            robots[name] = robot_for("fb.compare")(each, f"compare: runs[{name!r}]")
            places[name] = 0.0, 0.0
    designs = [each for each in given.values() if isinstance(each, Design)]
    task = designs[0].task if designs and not choices else task_of(choices)
    if figures is None:
        figures = list(designs[0].values) if designs else list(USUAL)
    values, notes = {}, []
    for name, robot in robots.items():
        chosen = figures_of(figures, task, robot, "figures")
        row = np.array([places[name]])
        found, errors = evaluate(chosen, PLACE, row, robot, task)
        values[name] = {one.name: float(value) for one, value in zip(chosen, found[0])}
        notes += [f"{name}: {words}" for _, words in errors]
    return DesignComparison(robots, values, chosen, task, tuple(notes))


@dataclass(frozen=True, eq=False)
class DesignComparison(Plotted):
    """robots {name: robot}; figures {name: {figure: value}}; of: these Figures; task: of them;
    notes: why a figure is nan.
    """

    robots: dict[str, FiveBar | Biglide]
    figures: dict[str, dict[str, float]]
    of: tuple[Figure, ...]
    task: Task
    notes: tuple[str, ...]

    def words(self, name: str, figure: Figure) -> str:
        """Return a design's figure as the table and the picture show it, "-" where it is nan."""
        value = self.figures[name][figure.name]
        return "-" if np.isnan(value) else f"{value:.4g}"

    def __str__(self) -> str:
        lines = [["", *self.robots]]
        for figure in self.of:
            lines.append([figure.label, *(self.words(name, figure) for name in self.robots)])
        return "\n".join([*aligned(lines, 1), *self.notes])
