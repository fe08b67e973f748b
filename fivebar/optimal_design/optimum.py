"""`design`: the best robot for one goal, or the Pareto front of several, within bounds and limits
by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..base.checks import instance, number, optional, positive, takes, whole
from ..base.progress import progress
from ..base.workers import WorkersDied, check_executor, compute_chunks
from ..models.robots import Biglide, FiveBar
from .batch import at_once, check_variables, robot_of_design
from .designs import limits_of
from .evolution import evolve, refine, thinned
from .figures import evaluate, figures_of
from .goals import SENSE_OF, SENSES, goals_of, limits_by_figure
from .results import AT_LIMIT, Design, Front
from .sweeping import compute_chunk
from .task import Task, task_of

POPULATION, MEMBERS = 20, 20  # per parameter, at least 60; of each small population
MOST_EFFORT = 100.0
TOGETHER = 5  # designs in a piece of work for an executor
FAR = 1e30  # what keeps the limits is below, what does not is above, by how much it is off


def _effort(value, name):
    return number(value, name, 0.01, MOST_EFFORT)


@takes(
    robot=optional(instance(FiveBar, Biglide)),
    step=optional(positive),
    points=whole(2, 200),
    seed=whole(0, 2**63),
    effort=_effort,
)
def design(
    goals: Any,
    bounds: Mapping[str, Any],
    *,
    limits: Mapping[Any, Any] | None = None,
    robot: FiveBar | Biglide | None = None,
    step: float | None = None,
    points: int = 20,
    seed: int = 0,
    effort: float = 1.0,
    executor: Executor | None = None,
    **choices: Any,
) -> Design | Front:
    """The best robot within bounds: a Design for one goal, a Front of them for two or three.

    goals: a figure of merit by name or as a function of a robot, a list of up to three, or {figure:
        "min" or "max"}; a name knows its own sense, a function is to be large.
    bounds: {parameter: (low, high)}, a number where it is fixed; parameters as in `sweep`: l1 and
        l2 make the robot symmetric, task_y moves its table.
    limits: {figure or parameter-free function: (low, high)}, None for no limit; a number is a limit
        on the worse side. A table must be reached, without a singularity, whether named or not.
    robot: what the bounds do not name, FiveBar() if None. step: lengths are whole multiples of it,
        m, as 0.001.
    points: on the front. effort: of the search, 2 for twice as many generations.
    executor: who computes figures that are not in closed form, as in `sweep`; None: this process.
    choices: what the figures are about, as in `sweep`: table=(0.2, 0.15), motor="xh430-w350",
        det_A=0.3, ...

    One goal: SciPy's differential evolution. Several: differential evolution of all goals at once
    (GDE3), then each point by itself. A search finds no proof: each result says which bounds and
    limits hold it, and how far it is from what no robot within the bounds can pass, where that is
    known. ValueError where nothing keeps the limits.
    """
    robot = FiveBar() if robot is None else robot
    check_executor(executor)
    problem = Problem(goals, bounds, limits, robot, step, task_of(choices), executor)
    rng = np.random.default_rng(seed)
    with progress(unit=" generations") as bar:
        if len(problem.goals) == 1:
            rows = _one(problem, rng, effort, bar)
        else:
            rows = _several(problem, rng, points, effort, bar)
    found = [problem.design_of(row) for row in rows]
    if len(problem.goals) == 1:
        return found[0]
    return Front(tuple(sorted(found, key=lambda each: each.values[problem.goals[0].name])))


class Problem:
    """What is searched, as numbers: columns of what varies in, goals to be small and how far off
    the limits out.
    """

    def __init__(self, goals, bounds, limits, robot, step, task: Task, executor: Executor | None):
        self.robot, self.step, self.task, self.executor = robot, step, task, executor
        pairs = limits_of(bounds)
        check_variables(tuple(pairs), robot, "bounds")
        self.names = tuple(pairs)
        self.low, self.high = (np.array(each) for each in zip(*pairs.values()))
        self.goals, self.signs = goals_of(goals, task, robot)
        self.limits = limits_by_figure({} if limits is None else limits, task, robot)
        reach = figures_of(["reach", "det_A"], task, robot) if self.on_table else ()
        asked = [*self.goals, *(limit.figure for limit in self.limits), *reach]
        self.figures = tuple({each.name: each for each in asked}.values())
        self.place = {each.name: k for k, each in enumerate(self.figures)}
        self.free = self.high > self.low
        self._round_bounds()

    @property
    def on_table(self) -> bool:
        return bool(self.task.table or self.task.disc) and isinstance(self.robot, FiveBar)

    def _round_bounds(self):
        """Steps need a multiple within the bounds."""
        self.stepped = np.array([self.step is not None and name[0] in "lrd" for name in self.names])
        if self.step is None:
            return
        for k in np.flatnonzero(self.stepped):
            low, high = (
                np.ceil(self.low[k] / self.step - 1e-9),
                np.floor(self.high[k] / self.step + 1e-9),
            )
            if low > high:
                raise ValueError(
                    f"bounds: no multiple of step = {self.step:g} lies in {self.names[k]} ="
                    f" ({self.low[k]:g}, {self.high[k]:g})"
                )
            self.low[k], self.high[k] = low * self.step, high * self.step

    def rows(self, x: np.ndarray) -> np.ndarray:
        """Designs (n, k), in steps where these are asked for."""
        near = 1e-9 * (self.high - self.low)  # a search ends beside a bound, not on it
        x = np.where(x <= self.low + near, self.low, np.where(x >= self.high - near, self.high, x))
        if self.step is None:
            return x
        return (
            np.where(self.stepped, np.round(np.rint(x / self.step) * self.step, 12), x) + 0.0
        )  # no -0

    def values(self, x: np.ndarray) -> np.ndarray:
        rows = self.rows(x)
        if self.executor is None or all(each.kind in ("closed", "poses") for each in self.figures):
            return evaluate(self.figures, self.names, rows, self.robot, self.task)[0]
        compute = partial(compute_chunk, self.figures, self.names, self.robot, self.task)
        parts = enumerate(np.array_split(rows, max(1, len(rows) // TOGETHER)))
        try:
            done = dict(compute_chunks(compute, parts, self.executor))
        except WorkersDied as error:
            raise RuntimeError(f"{error}; a search keeps nothing: begin it anew") from None
        return np.concatenate([done[k].values for k in range(len(done))])

    def __call__(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(goals to be small (n, goals), off (n,)) of designs."""
        values = self.values(x)
        f = values[:, : len(self.goals)] * self.signs
        off = np.zeros(len(x))
        for limit in self.limits:
            value = values[:, self.place[limit.figure.name]]
            size = max(abs(each) for each in (limit.low, limit.high) if np.isfinite(each)) or 1.0
            off += np.maximum(np.maximum(limit.low - value, value - limit.high), 0) / size
        if self.on_table:  # how far the table is out of reach tells the way to it
            off += np.maximum(-values[:, self.place["reach"]], 0) / self.task_size
            off += np.where(values[:, self.place["det_A"]] > 0, 0.0, 1.0)
        lost = ~np.isfinite(f).all(axis=1) | np.isnan(off)
        off = np.where(lost, 10.0 + np.where(np.isfinite(off), off, 10.0), off)
        return np.where(np.isfinite(f), f, 0.0), off

    @cached_property
    def task_size(self):
        return float(np.ptp(self.task.nodes[0], axis=0).max())

    def design_of(self, x: np.ndarray) -> Design:
        row = self.rows(x[None])[0]
        values = dict(zip((each.name for each in self.figures), self.values(x[None])[0].tolist()))
        goals = {each.name: SENSE_OF[sign] for each, sign in zip(self.goals, self.signs)}
        units = {each.name: each.unit for each in self.figures}
        return Design(
            dict(zip(self.names, row.tolist())),
            robot_of_design(self.names, row, self.robot),
            values,
            goals,
            units,
            self._binding(row, values),
            self._passed_by_none(values),
            self.task,
        )

    def _binding(self, row, values):
        """Sentences on what is at its limit; of lengths in steps, on what is nearer than a step."""
        found = []
        steps = np.where(self.stepped, 1.001 * (self.step or 0.0), 0.0)
        for k in np.flatnonzero(self.free):
            near = max(AT_LIMIT * (self.high[k] - self.low[k]), steps[k])
            for which, limit in (("lower", self.low[k]), ("upper", self.high[k])):
                if abs(row[k] - limit) <= near:
                    found.append(
                        f"{self.names[k]} = {row[k]:.6g} is {self._how(row[k], limit)} {which}"
                        f" bound {limit:.6g}"
                    )
        others = [row + sign * step for step in np.diag(steps)[steps > 0] for sign in (1, -1)]
        around = self.values(np.array([row, *others]))
        if self.on_table:
            within = around[:, self.place["reach"]] >= 0
            if values["reach"] <= AT_LIMIT * self.task_size or not within.all():
                found.append(
                    f"reach = {values['reach']:.6g} is near its limit, at least 0: a corner of the"
                    " table"
                )
            around = around[within & (around[:, self.place["det_A"]] > 0)]
        for limit in self.limits:
            name = limit.figure.name
            column = around[:, self.place[name]]
            for which, value, passed in (
                ("at least", limit.low, column < limit.low),
                ("at most", limit.high, column > limit.high),
            ):
                near = np.isfinite(value) and abs(values[name] - value) <= AT_LIMIT * max(
                    abs(value), 1e-12
                )
                if near or passed.any():
                    how = "at" if near else "less than a step from"
                    found.append(
                        f"{name} = {values[name]:.6g} is {how} its limit, {which} {value:.6g}"
                    )
        return tuple(found)

    def _how(self, value, limit):
        return (
            "at its"
            if self.step is None or abs(value - limit) < 0.5 * self.step
            else "a step from its"
        )

    def _passed_by_none(self, values):
        """{goal: what no robot within the bounds passes}: figures' own bounds at the longest, or
        the shortest, bars.
        """
        found = {}
        for figure, sign in zip(self.goals, self.signs):
            if figure.bound is None or SENSES[SENSE_OF[sign]] != figure.better:
                continue
            corner = (self.high if figure.better == "large" else self.low)[None]
            found[figure.name] = float(
                figure.bound(at_once(self.names, corner, self.robot), self.task)[0]
            )
        return found


def _one(problem, rng, effort, bar):
    """SciPy's differential evolution on what varies; designs that do not keep the limits count by
    how far they are.
    """
    from scipy.optimize import differential_evolution

    free = problem.free
    if not free.any():
        return _kept(problem, problem.low[None])

    def all_of(x):
        rows = np.repeat(problem.low[None], len(x), axis=0)
        rows[:, free] = x
        f, off = problem(rows)
        return np.where(off > 0, FAR * (1 + off), f[:, 0])

    found = differential_evolution(
        lambda x: all_of(x.T),
        list(zip(problem.low[free], problem.high[free])),
        vectorized=True,
        polish=False,
        updating="deferred",
        maxiter=int(np.ceil(300 * effort)),
        popsize=POPULATION,
        tol=1e-10,
        atol=0.0,
        rng=rng,
        init="halton",
        callback=lambda *_, **__: bar.update() and None,
    )
    row = problem.low.copy()
    row[free] = found.x
    return _kept(problem, row[None])


def _several(problem, rng, points, effort, bar):
    generations = int(np.ceil(100 * effort))
    size = max(60, POPULATION * int(problem.free.sum()), points)
    x, f, off = evolve(
        problem,
        problem.low,
        problem.high,
        len(problem.goals),
        size,
        generations,
        rng,
        told=bar.update,
    )
    kept = off == 0
    if not kept.any():
        return _kept(problem, x[np.argsort(off)[:1]])
    x, f = x[kept], f[kept]
    chosen = np.array(thinned(f, np.arange(len(f)), min(points, len(f))))
    x, f, off = refine(
        problem, problem.low, problem.high, x, f, chosen, MEMBERS, generations, rng, told=bar.update
    )
    rows = problem.rows(x[off == 0])
    f, off = problem(rows)
    better = (f[:, None] <= f[None]).all(axis=2) & (f[:, None] < f[None]).any(axis=2)
    rows, f = rows[~better.any(axis=0)], f[~better.any(axis=0)]
    return rows[np.unique(f.round(15), axis=0, return_index=True)[1]]


def _kept(problem, rows):
    """The rows; ValueError where even the best found does not keep the limits, with what it
    lacks.
    """
    off = problem(rows)[1]
    if off[0] == 0:
        return rows
    values = dict(zip((each.name for each in problem.figures), problem.values(rows)[0]))
    lacks = [
        f"{limit.figure.name} = {values[limit.figure.name]:.6g}, not from {limit.low:g} to"
        f" {limit.high:g}"
        for limit in problem.limits
        if not limit.low <= values[limit.figure.name] <= limit.high
    ]
    if problem.on_table and values["reach"] < 0:
        lacks.append(f"the table is out of reach by {-values['reach']:.6g} m")
    elif problem.on_table and not values["det_A"] > 0:
        lacks.append("a Type-2 singularity crosses the table")
    at = ", ".join(
        f"{name} = {value:.6g}" for name, value in zip(problem.names, problem.rows(rows)[0])
    )
    what = "; ".join(lacks) or "no robot closes, or a goal is not finite"
    raise ValueError(
        f"nothing within the bounds was found that keeps the limits; the nearest, {at}: {what}"
    )
