"""What a simulation leaves: a Run, with its errors and events, saved to CSV and read back."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..models.geometry import igm
from ..models.robots import Biglide, FiveBar, robot_of
from ..pictures.skeleton import elbows, joints
from ..singularities.margins import Singularity
from ..tables import read_columns


class Event(NamedTuple):
    """A crossing of a singularity: time (s), type, vanished sine, modes (left, right, assembly) before, after."""

    t: float
    type: Singularity
    margin: str
    before: tuple
    after: tuple


class Control(NamedTuple):
    """The controller's side, k samples: t (k,) s; what it measured, q, q_dot (k, 2); its torque before (commanded) and
    after delay and limit (applied), (k, 2) N m."""

    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    commanded: np.ndarray
    applied: np.ndarray


def columns(robot, has_reference):
    """Names of the columns of a run's CSV file."""
    left, right = robot.words.joints
    names = "t", left, right, f"{left}_dot", f"{right}_dot", "x", "y", "tau1", "tau2", "energy"
    return (*names, "x_ref", "y_ref") if has_reference else names


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated motion on the grid of its steps.

    t (n,) s; q, q_dot (n, 2) rad, rad/s, q continuous; xi (n, 2) m; tau (n, 2) N m, held from each t to the next;
    energy (n,) J, kinetic; xi_ref (n, 2) m or None; torque_limit N m or None; control: the controller's own grid, or
    None; events: crossings; step_error: rad, of q by the steps' length, where `simulate` was given a tolerance;
    log: what the controller has in its own `log`, as a Tracker, or None. Of a biglide, q is in m and tau in N.
    """

    robot: FiveBar | Biglide
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    xi: np.ndarray
    tau: np.ndarray
    energy: np.ndarray
    xi_ref: np.ndarray | None = None
    torque_limit: float | None = None
    control: Control | None = None
    events: tuple = ()
    step_error: float | None = None
    log: object | None = None

    @cached_property
    def error(self):
        """xi - xi_ref (n, 2), m."""
        self._needs_reference()
        return self.xi - self.xi_ref

    @cached_property
    def q_error(self):
        """q - q_ref (n, 2), rad (m), in the working modes in which the run begins; nan where xi_ref is out of reach."""
        self._needs_reference()
        return self.robot.differ(self.q - igm(self.robot, self.xi_ref, self._working_at_start(), unreachable="nan").q)

    def _working_at_start(self):
        modes = [(left, right) for left in (-1, 1) for right in (-1, 1)]
        poses = igm(self.robot, np.broadcast_to(self.xi[0], (4, 2)), modes, unreachable="nan")
        away = np.abs(self.robot.differ(poses.q - self.q[0]))
        return modes[int(np.argmin(np.nan_to_num(away, nan=0.0).sum(axis=1)))]

    def _needs_reference(self):
        if self.xi_ref is None:
            raise ValueError("this run has no reference, so no error")

    @property
    def saturated(self):
        """Where each torque is at its limit: (n, 2) bool; nowhere without a limit."""
        limit = np.inf if self.torque_limit is None else self.torque_limit
        return np.abs(self.tau) >= limit * (1 - 1e-12)

    @property
    def points(self) -> np.ndarray:
        """Base joint, elbow, end-effector, elbow, base joint: (n, 5, 2) m; of a biglide foot, end-effector, foot."""
        return joints(self.robot, elbows(self.robot, self.q), self.xi)

    def plot(self, path=None):
        """Matplotlib figure of path, errors and torques; written to `path` (PNG, SVG, PDF) if given."""
        from ..pictures.plot.runs import tracking

        figure = tracking(self)
        if path is not None:
            figure.savefig(path)
        return figure

    def animate(self, path, show=None):
        """The motion as a page in meshcat's viewer (.html; needs no server and no network) or as an animation (.gif).

        show: names out of view.SHOWS; None: the path, and the reference where there is one.
        """
        from ..pictures.view import scene

        scene(self.robot, self, show).save(path)

    def page(self, path, show=None, title=None):
        """One HTML file with the robot beside plots of `show`, linked by the time pointed at: `fb.page`."""
        from ..pictures.pages import page

        page(self, path, show, title)

    def to_csv(self, path):
        """Write the run on its step grid; robot, torque limit and events go into comment lines. SI units."""
        import csv
        import json

        about = {
            "robot": asdict(self.robot),
            "torque_limit": self.torque_limit,
            "events": [list(e) for e in self.events],
        }
        table = [self.t, *self.q.T, *self.q_dot.T, *self.xi.T, *self.tau.T, self.energy]
        if self.xi_ref is not None:
            table += [*self.xi_ref.T]
        with open(path, "w", newline="", encoding="utf-8") as file:
            file.write(f"# fivebar run, SI units: {json.dumps(about)}\n")
            writer = csv.writer(file)
            writer.writerow(columns(self.robot, self.xi_ref is not None))
            writer.writerows(map(repr, row) for row in np.column_stack(table).tolist())

    @classmethod
    def from_csv(cls, path):
        """Read what `to_csv` wrote; the control grid is not in it."""
        import json

        with open(path, encoding="utf-8") as file:
            first, header = file.readline(), file.readline()
        try:
            about = json.loads(first.removeprefix("# fivebar run, SI units: "))
            events = tuple(
                Event(t, Singularity(kind), margin, tuple(before), tuple(after))
                for t, kind, margin, before, after in about["events"]
            )
            robot = robot_of(about["robot"])
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ValueError(f"{path}, line 1: not a file written by Run.to_csv") from None
        table = read_columns(path, columns(robot, "x_ref" in header))
        t, q, q_dot, xi, tau, energy, xi_ref = np.split(table, (1, 3, 5, 7, 9, 10), axis=1)
        return cls(
            robot, t[:, 0], q, q_dot, xi, tau, energy[:, 0], xi_ref if xi_ref.size else None, about["torque_limit"],
            events=events,
        )  # fmt: skip
