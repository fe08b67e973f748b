"""The robot in motion: fixed steps in a chart that is regular, each of them checked."""

import numpy as np

from ..errors import SingularityError
from ..models.compiled import Buffered
from .steps import COLUMNS, ENERGY, MARGIN_RATES, MARGINS, XI, Q, block_function, model_functions

STUCK = 1e-7  # no chart is integrated through a margin smaller than this
SWITCH = 0.75  # "auto" leaves a chart when its margin is below this part of the best one: measured, 0.5 loses a digit
LOST_ENERGY = 1e-3  # of the energy that a step turns over: to lose more is a jump, not an integration error
ROUNDING = 1e-14  # rad, m: rounding of a joint step, where next to nothing moves
NEAR = 0.3  # a sine: farther from a singularity, a step that loses energy is just too long
AHEAD = 1.5  # steps: a single chart is held to end where its margin would vanish within them


class Plant:
    """The robot in motion: chart, state and modes now, and what was observed so far, a row at each step."""

    def __init__(self, robot, charts, method, step, block, start):
        if start.pose.robot != robot:
            raise ValueError(f"start is of another robot: {start.pose.robot}, not {robot}")
        if start.q_dot.shape != (2,) or start.xi_dot.shape != (2,):
            raise ValueError("start must be the Rates of a single pose")
        if not (np.isfinite(start.xi_dot).all() and np.isfinite(start.q_dot).all()):
            raise ValueError("start must be finite: its pose is unreachable")
        self.robot, self.charts, self.method, self.step, self.block = robot, charts, method, step, block
        self.rows, self.torques, self.calls = [], [], {}
        self._enter(start, 0)
        self.observation = self._look()

    def advance(self, k, count, tau):
        """`count` steps from step k under the torque tau, changing charts on the way."""
        done = 0
        while done < count:
            states, rows, last = self._call(tau)
            good = self._first_weak(rows)
            if good == 0:
                self._enter(self._rates(), k + done)
                states, rows, last = self._call(tau)
                good = max(self._first_weak(rows), 1)
            good = min(good, count - done)
            self.rows.append(rows[:good].copy())
            self.torques += [tau] * good
            self.state = states[good - 1].copy()
            done += good
        self.observation = last.copy() if good == self.block else self._look()

    def _call(self, tau):
        """A block of steps in the present chart: states after each, observations before each, observation after all."""
        if self.chart not in self.calls:
            block = block_function(self.robot, self.chart, self.method, self.step, self.block)
            self.calls[self.chart] = Buffered(block)
        states, rows, last = self.calls[self.chart](self.state, tau, self.modes)
        return states.reshape(-1, 4), rows.reshape(-1, COLUMNS), last

    def _look(self):
        return model_functions(self.robot, self.chart)[1](self.state, self.modes).full().ravel()

    def _enter(self, rates, k):
        """Take the chart of largest margin, at step k."""
        sines = np.array([*rates.pose.sines, rates.pose.det_A])
        margins = [np.abs(sines[list(chart.margins)]).min() for chart in self.charts]
        self.chart = self.charts[int(np.argmax(margins))]
        if not max(margins) > STUCK:
            x, y = rates.pose.xi
            raise SingularityError(
                f"no chart is regular at t = {k * self.step:g} s, xi = ({x:.9g}, {y:.9g}) m: "
                f"{', '.join(self.robot.words.sines)} = {sines[0]:.2g}, {sines[1]:.2g}, {sines[2]:.2g}",
                max(margins),
            )
        c, c_dot, modes = self.chart.coordinates(rates)
        self.state, self.modes = np.array([*c, *c_dot]), np.array(modes, dtype=float)

    def _rates(self):
        c, c_dot = tuple(self.state[:2].tolist()), tuple(self.state[2:].tolist())
        return self.chart.rates(self.robot, c, c_dot, tuple(int(mode) for mode in self.modes))

    def _first_weak(self, rows):
        """The first row where this chart's margin is below that part of the best one's (the number of rows if none)."""
        if len(self.charts) == 1:
            return len(rows)
        sines = np.abs(rows[:, MARGINS])
        own = sines[:, self.chart.margins[0]]
        weak = np.flatnonzero(own < SWITCH * sines.max(axis=1))
        return int(weak[0]) if len(weak) else len(rows)

    def refuse_jumps(self):
        refuse_jumps(self.robot, *self.history(), self.charts, self.chart, self.step)

    def history(self):
        """Observations (n + 1, columns) at every step, torques (n, 2) held between them."""
        return np.vstack([*self.rows, self.observation]), np.array(self.torques).reshape(-1, 2)


def refuse_jumps(robot, rows, tau, charts, chart, step, start=0.0):
    """Raise at the first step that left its chart, lost energy, or in which a chart held fast ends; start: time, s."""
    work = np.sum(np.diff(robot.continuous(rows[:, Q]), axis=0) * tau, axis=1)
    gained, turned = np.diff(rows[:, ENERGY]), rows[1:, ENERGY] + rows[:-1, ENERGY] + np.abs(work)
    bad = ~(np.abs(gained - work) <= LOST_ENERGY * turned + ROUNDING * np.abs(tau).sum(axis=1))
    if len(charts) == 1:
        columns = list(chart.margins)
        margins = rows[:-1, MARGINS][:, columns]
        ahead = margins + AHEAD * step * rows[:-1, MARGIN_RATES][:, columns]
        bad |= (margins * ahead <= 0).any(axis=1)
    if not bad.any():
        return
    k = int(np.argmax(bad))
    sines, (x, y), when, words = rows[k, MARGINS], rows[k, XI], start + k * step, robot.words
    nearest = min(chart.margins, key=lambda column: abs(sines[column]))
    if abs(sines[nearest]) > NEAR:
        raise ArithmeticError(
            f"the motion at t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m is too fast for steps of {step:g} s "
            f"(joint rates {rows[k, 2]:.3g}, {rows[k, 3]:.3g} {words.unit}/s, {words.effort}s {tau[k, 0]:.3g}, "
            f"{tau[k, 1]:.3g} {words.effort_unit})"
        )
    raise SingularityError(
        f"the step from t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m jumps the singularity of the {chart.name} "
        f"chart ({words.sines[nearest]} = {sines[nearest]:.3g}): take a smaller step"
        + (' or chart="auto"' if len(charts) == 1 else ""), float(sines[nearest]))  # fmt: skip
