"""The robot in motion by fixed steps in a chart; a step that jumps is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.errors import SingularityError
from ..models.charts import StateChart
from ..models.compiled import Buffered
from ..models.kinematics import Rates
from ..models.loaded_robot import JointTorques, refuse_numbers
from ..models.loads import lost_power, potential
from ..models.physics import loads_of, physics_of
from ..models.robots import Robot, nearest_equivalent_angle
from .plant import check_start, fast
from .steps import (
    COLUMNS,
    ENERGY,
    MARGIN_RATES,
    MARGINS,
    Q_DOT,
    XI,
    Q,
    block_function,
    motion_of,
    observe_function,
)

# Of the energy that a fixed step turns over: to lose more is a jump, not an integration error.
LOST_ENERGY = 1e-3
ROUNDING = 1e-14  # rad, m: rounding of a joint step, where next to nothing moves
NEAR = 0.3  # a sine: farther from a singularity, a step that loses energy is just too long
AHEAD = 1.5  # steps: a chart ends where its margin would vanish within them
BLOCK = 50  # fixed steps in one compiled call


class FixedPlant:
    """The robot moving by fixed steps of `step` s in a chart, by a method of `steps`."""

    def __init__(
        self,
        robot: Robot,
        start: Rates,
        chart: StateChart,
        method: str,
        step: float,
        jit: bool | str = False,
        torques: JointTorques | None = None,
    ) -> None:
        check_start(robot, start)
        refuse_sticking(robot)
        refuse_numbers(torques, "a fixed step")
        self.robot = robot
        self.torques = torques
        self.chart = chart
        self.method = method
        self.step = step
        self.jit = jit
        self.k = 0
        c, c_dot, modes = chart.coordinates(start)
        self.state = np.array([*c, *c_dot])
        self.modes = np.array(modes, dtype=float)
        self._blocks: dict[int, Callable] = {}
        self._rows: list[np.ndarray] = []
        self._torques: list[np.ndarray] = []
        observe = observe_function(robot, chart)
        self._last = observe(self.state, self.modes).full().ravel()

    @property
    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """q and q' now."""
        return self._last[Q].copy(), self._last[Q_DOT].copy()

    def advance(self, until: float, tau: np.ndarray) -> None:
        """Move on to the time `until`, s, under the torques tau."""
        steps = round(until / self.step) - self.k
        while steps:
            count = min(steps, BLOCK)
            now = self.k * self.step
            states, rows, last = self._block(count)(self.state, tau, self.modes, now)
            self._rows.append(rows.reshape(-1, COLUMNS).copy())
            self._torques += [tau] * count
            if self.chart.wraps:
                last[Q] = nearest_equivalent_angle(self.robot, last[Q], self._last[Q])
            self.state = states.reshape(count, -1)[-1].copy()
            self._last = last.copy()
            self.k = self.k + count
            steps = steps - count

    def _block(self, count):
        if count not in self._blocks:
            options = self.chart, self.method, self.step, count, self.torques
            function = block_function(self.robot, *options)
            self._blocks[count] = Buffered(fast(function, self.jit))
        return self._blocks[count]

    def rows(self, t: np.ndarray) -> np.ndarray:
        """Return the observations (n, columns) before each step, and now."""
        rows = np.vstack([*self._rows, self._last])
        tau = np.array(self._torques)
        refuse_losses(self.robot, rows, tau, self.chart, self.step, self.torques)
        return rows


def refuse_sticking(robot: Robot) -> None:
    """Refuse dry friction, which fixed steps would jump."""
    if loads_of(robot).sticks:
        names = " and ".join(name for name in ("fs1", "fs2") if name in robot.parameters)
        raise ValueError(
            f"{names}: dry friction sticks and lets go between fixed steps, as simulate_many has;"
            " simulate(...) without integrator= chooses its steps so that they end there"
        )


def refuse_losses(
    robot: Robot,
    rows: np.ndarray,
    tau: np.ndarray,
    chart: StateChart,
    step: float,
    torques: JointTorques | None = None,
) -> None:
    """Raise at the first fixed step that jumped.

    A step has jumped where its energy does not balance, or where the chart's margin would vanish
    within it.

    Parameters
    ----------
    robot : FiveBar or Biglide
    rows : (n + 1, columns)
        Observations.
    tau : (n, 2), N m
        Torques held between them.
    chart : a chart of models.charts
    step : float, s
    torques : JointTorques, optional
        Of a LoadedRobot.
    """
    work = np.sum(np.diff(robot.continuous(rows[:, Q]), axis=0) * tau, axis=1)
    energy = rows[:, ENERGY]
    before = energy[:-1]
    after = energy[1:]
    gained = after - before
    turned_over = after + before + np.abs(work)
    if physics_of(robot) is not None:
        motion = motion_of(robot, rows)
        raised = np.diff(potential(motion.pose) + 0.0 * energy)
        power = lost_power(motion) + 0.0 * energy
        whole = np.hstack([robot.continuous(rows[:, Q]), rows[:, Q_DOT.start :]])
        # Rates change evenly within a step that is short enough.
        in_middle = lost_power(motion_of(robot, (whole[1:] + whole[:-1]) / 2))
        lost = step / 6 * (power[1:] + 4 * in_middle + power[:-1])
        gained = gained + raised + lost
        turned_over = turned_over + np.abs(raised) + lost
    allowed = LOST_ENERGY * turned_over + ROUNDING * np.abs(tau).sum(axis=1)
    if torques is not None:
        lost, uncertain = lost_in_steps(robot, torques, rows, tau, step)
        gained = gained + lost
        rounding = LOST_ENERGY * np.abs(lost)
        allowed = allowed + rounding + uncertain
    columns = list(chart.margins)
    margins = rows[:-1, MARGINS][:, columns]
    rates = rows[:-1, MARGIN_RATES][:, columns]
    ahead = margins + AHEAD * step * rates
    ends = (margins * ahead <= 0).any(axis=1)
    jumps = ~(np.abs(gained - work) <= allowed) | ends
    if jumps.any():
        k = int(np.argmax(jumps))
        raise _jump(robot, rows[k], tau[k], chart, step, k)


def lost_in_steps(
    robot: Robot, torques: JointTorques, rows: np.ndarray, tau: np.ndarray, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the energy (n,), J, that torques of a LoadedRobot take in each step.

    And by how much that may err: by the difference of Simpson's rule, on cubics through the steps'
    ends, from the trapezoidal one, and by the rounding of q.
    """
    t = step * np.arange(len(rows) - 1)
    whole = robot.continuous(rows[:, Q])
    q0, v0 = whole[:-1], rows[:-1, Q_DOT]
    q1, v1 = whole[1:], rows[1:, Q_DOT]
    bend = step / 8 * (v0 - v1)
    q = (q0 + q1) / 2 + bend
    chord = (q1 - q0) / step
    v = 1.5 * chord - (v0 + v1) / 4
    taken = torques.taken(t, q0, v0, tau)
    in_middle = torques.taken(t + step / 2, q, v, tau)
    at_end = torques.taken(t + step, q1, v1, tau)
    before = (taken * v0).sum(axis=1)
    middle = (in_middle * v).sum(axis=1)
    after = (at_end * v1).sum(axis=1)
    lost = step / 6 * (before + 4 * middle + after)
    trapezoidal = step / 2 * (before + after)
    rounding = ROUNDING * np.abs(taken).sum(axis=1)
    return lost, np.abs(lost - trapezoidal) + rounding


def _jump(robot, row, tau, chart, step, k):
    """Return the error that says where step k jumped."""
    sines = row[MARGINS]
    x, y = row[XI]
    words = robot.words
    where = f"t = {k * step:g} s, xi = ({x:.9g}, {y:.9g}) m"
    nearest = min(chart.margins, key=lambda column: abs(sines[column]), default=None)
    if nearest is None or abs(sines[nearest]) > NEAR:
        return ArithmeticError(
            f"the motion at {where} is too fast for steps of {step:g} s (joint rates"
            f" {row[2]:.3g}, {row[3]:.3g} {words.unit}/s, {words.effort}s {tau[0]:.3g},"
            f" {tau[1]:.3g} {words.effort_unit}): simulate(...) without integrator= chooses its"
            " steps, and says where gains are unstable"
        )
    margin = float(sines[nearest])
    return SingularityError(
        f"the step from {where} jumps the singularity of the {chart.name} chart"
        f' ({words.sines[nearest]} = {margin:.3g}): chart="auto" has none',
        margin,
    )
