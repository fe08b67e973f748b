"""The robot in motion: fixed-step RK4 in a chart that is regular, checked step by step.

The step is a CasADi function made from the same equations as everything else. It also returns what the state says of
itself (angles, end-effector, singular margins and their rates, energy), by which charts are chosen and a step that
jumped over its chart's singularity is refused.
"""

from functools import lru_cache

import numpy as np

from .charts import MARGIN_NAMES
from .dyads import dot
from .dynamics import energy, forward_dynamics
from .errors import SingularityError

# Columns of an observation.
Q, Q_DOT, XI, XI_DOT, MARGINS, MARGIN_RATES, ENERGY = (
    slice(0, 2), slice(2, 4), slice(4, 6), slice(6, 8), slice(8, 11), slice(11, 14), 14,
)  # fmt: skip
COLUMNS = 15
STUCK = 1e-7  # no chart is integrated through a margin smaller than this
SWITCH = 0.75  # "auto" leaves a chart when its margin is below this part of the best one: measured, 0.5 loses a digit
LOST_ENERGY = 1e-3  # of the energy that a step turns over: to lose more is a jump, not an integration error
ROUNDING = 1e-14  # rad: rounding of a joint step, where next to nothing moves
NEAR = 0.3  # a sine: farther from a singularity, a step that loses energy is just too long
AHEAD = 1.5  # steps: a single chart is held to end where its margin would vanish within them


class Plant:
    """The robot in motion: chart, state and modes now, and what was observed so far, a row at each step."""

    def __init__(self, robot, charts, step, block, start):
        if start.q_dot.shape != (2,) or start.xi_dot.shape != (2,):
            raise ValueError("start must be the Rates of a single pose")
        if not (np.isfinite(start.xi_dot).all() and np.isfinite(start.q_dot).all()):
            raise ValueError("start must be finite: its pose is unreachable")
        self.robot, self.charts, self.step, self.block = robot, charts, step, block
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
            buffer, run = _block(self.robot, self.chart, self.step, self.block).buffer()
            inputs = [np.empty(4), np.empty(2), np.empty(2)]
            outputs = [np.empty((self.block, 4)), np.empty((self.block, COLUMNS)), np.empty(COLUMNS)]
            for k in range(3):
                buffer.set_arg(k, memoryview(inputs[k]))
                buffer.set_res(k, memoryview(outputs[k]))
            self.calls[self.chart] = inputs, outputs, run, buffer
        inputs, outputs, run, _ = self.calls[self.chart]
        for slot, value in zip(inputs, (self.state, tau, self.modes)):
            slot[:] = value
        run()
        return outputs

    def _look(self):
        return _model(self.robot, self.chart)[1](self.state, self.modes).full().ravel()

    def _enter(self, rates, k):
        """Take the chart of largest margin, at step k."""
        sines = np.array([*rates.pose._serial, rates.pose._parallel])
        margins = [np.abs(sines[list(chart.margins)]).min() for chart in self.charts]
        self.chart = self.charts[int(np.argmax(margins))]
        if not max(margins) > STUCK:
            x, y = rates.pose.xi
            raise SingularityError(
                f"no chart is regular at t = {k * self.step:g} s, xi = ({x:.9g}, {y:.9g}) m: sin q12, sin q22, det A = "
                f"{sines[0]:.2g}, {sines[1]:.2g}, {sines[2]:.2g}", max(margins))  # fmt: skip
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
        """Raise at the first step that left its chart, lost energy, or in which a chart held fast ends."""
        rows, tau = self.all_rows(), np.array(self.torques).reshape(-1, 2)
        work = np.sum(np.diff(np.unwrap(rows[:, Q], axis=0), axis=0) * tau, axis=1)
        gained, turned = np.diff(rows[:, ENERGY]), rows[1:, ENERGY] + rows[:-1, ENERGY] + np.abs(work)
        bad = ~(np.abs(gained - work) <= LOST_ENERGY * turned + ROUNDING * np.abs(tau).sum(axis=1))
        if len(self.charts) == 1:
            columns = list(self.chart.margins)
            margins = rows[:-1, MARGINS][:, columns]
            ahead = margins + AHEAD * self.step * rows[:-1, MARGIN_RATES][:, columns]
            bad |= (margins * ahead <= 0).any(axis=1)
        if not bad.any():
            return
        k = int(np.argmax(bad))
        sines, (x, y), when = rows[k, MARGINS], rows[k, XI], k * self.step
        nearest = min(self.chart.margins, key=lambda column: abs(sines[column]))
        if abs(sines[nearest]) > NEAR:
            raise ArithmeticError(
                f"the motion at t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m is too fast for steps of {self.step:g} s "
                f"(joint rates {rows[k, 2]:.3g}, {rows[k, 3]:.3g} rad/s, torques {tau[k, 0]:.3g}, {tau[k, 1]:.3g} N m)"
            )
        raise SingularityError(
            f"the step from t = {when:g} s, xi = ({x:.9g}, {y:.9g}) m jumps the singularity of the {self.chart.name} "
            f"chart ({MARGIN_NAMES[nearest]} = {sines[nearest]:.3g}): take a smaller step"
            + (' or chart="auto"' if len(self.charts) == 1 else ""), float(sines[nearest]))  # fmt: skip

    def all_rows(self):
        return np.vstack([*self.rows, self.observation])


@lru_cache(maxsize=64)
def _model(robot, chart):
    """(state, tau, modes) -> (slope, observation), and (state, modes) -> observation."""
    import casadi

    state, tau, modes = casadi.SX.sym("state", 4), casadi.SX.sym("tau", 2), casadi.SX.sym("modes", 2)
    rates = chart.rates(robot, (state[0], state[1]), (state[2], state[3]), (modes[0], modes[1]))
    slope = casadi.vertcat(state[2], state[3], *chart.accelerations(forward_dynamics(rates, tau)))
    slope, seen = casadi.cse([slope, _observation(rates)])
    return casadi.Function("model", [state, tau, modes], [slope, seen]), casadi.Function("look", [state, modes], [seen])


@lru_cache(maxsize=64)
def _block(robot, chart, step, count):
    """(state, tau, modes) -> (states after each of `count` RK4 steps, what is seen before each, and after the last)."""
    import casadi

    model, look = _model(robot, chart)
    state, tau, modes = casadi.SX.sym("state", 4), casadi.SX.sym("tau", 2), casadi.SX.sym("modes", 2)
    k1, seen = model(state, tau, modes)
    k2, _ = model(state + step / 2 * k1, tau, modes)
    k3, _ = model(state + step / 2 * k2, tau, modes)
    k4, _ = model(state + step * k3, tau, modes)
    after = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    steps = casadi.Function("step", [state, tau, modes], [after, seen]).mapaccum(count)
    state, tau, modes = casadi.MX.sym("state", 4), casadi.MX.sym("tau", 2), casadi.MX.sym("modes", 2)
    states, rows = steps(state, casadi.repmat(tau, 1, count), casadi.repmat(modes, 1, count))
    return casadi.Function("block", [state, tau, modes], [states, rows, look(states[:, -1], modes)])


def _observation(rates):
    """q, q', xi, xi', the sines (q12, q22, det A), their rates, kinetic energy: in the order of the columns above."""
    import casadi

    pose = rates.pose
    swing = [s / bar for s, bar in zip(rates._swing, pose.robot.distal)]
    cosines = [dot(u1, u2) for u1, u2 in zip(pose._proximal, pose._distal)]
    serial_rates = [c * (w - q_dot) for c, w, q_dot in zip(cosines, swing, rates._q_dot)]
    parallel_rate = dot(*pose._distal) * (swing[1] - swing[0])
    return casadi.vertcat(
        pose.q, rates.q_dot, pose.xi, rates.xi_dot, *pose._serial, pose._parallel, *serial_rates, parallel_rate,
        energy(rates),
    )  # fmt: skip
