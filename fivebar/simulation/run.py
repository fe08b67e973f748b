"""What a simulation leaves: a Run, with its errors and events, saved to CSV and read back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..checks import modes
from ..checks import robot as must_be_robot
from ..described import Pictured, one_line
from ..models.four_joints import seen_rates
from ..models.geometry import igm
from ..models.loads import potential
from ..models.parameters import robot_of
from ..models.physics import loads_of
from ..models.robots import FiveBar, Robot
from ..pictures.pages import page
from ..pictures.skeleton import elbows, joints
from ..pictures.view import scene
from ..singularities.margins import Singularity
from ..tables import BinaryFile, FilePath, TextFile, opened, saved, write
from .logs import Gauges, read_log
from .measured_runs import run_fields

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from ..measured.replays import Replay
    from ..pictures.pages import Page
    from ..pictures.view import Scene


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


class Measured(NamedTuple):
    """What is known of a run from a log: gaps, (from, to, why) s; said: what was done to its rows; rates: whether q_dot
    was logged, and not differentiated. At each gap there is a row of nan."""

    gaps: tuple = ()
    said: tuple = ()
    rates: bool = False


def has_friction(robot: Robot) -> bool:
    return loads_of(robot).rubs


def columns(robot: Robot, has_reference: bool) -> tuple[str, ...]:
    """Names of the columns of a run's CSV file."""
    left, right = robot.words.joints
    names = ["t", left, right, f"{left}_dot", f"{right}_dot", "x", "y", "tau1", "tau2", "energy"]
    names += ["x_ref", "y_ref"] * has_reference + ["friction_loss"] * has_friction(robot)
    return tuple(names)


@dataclass(frozen=True, eq=False)
class Run(Pictured):
    """A simulated motion on the grid of its steps.

    t (n,) s; q, q_dot (n, 2) rad, rad/s, q continuous; xi (n, 2) m; tau (n, 2) N m, held from each t to the next;
    energy (n,) J, kinetic (`potential` is the other); xi_ref (n, 2) m or None; torque_limit N m or None; control: the
    controller's own grid, or None; events: crossings; step_error: rad, of q by the steps' length, where `simulate` was
    given a tolerance; log: what the controller has in its own `log`, as a Tracker, or None; friction_loss (n,) J, what
    friction has taken (after fixed steps by Simpson's rule), or None without; measured: of a run `from_log`, or None.
    Of a biglide, q is in m and tau in N.
    """

    robot: Robot
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
    friction_loss: np.ndarray | None = None
    measured: Measured | None = None

    def __repr__(self) -> str:
        tracked = self.xi_ref is not None
        error = f"error at most {1e6 * np.nanmax(np.linalg.norm(self.error, axis=1)):.4g} um" if tracked else ""
        crossings = f"{len(self.events)} crossings" if self.events else ""
        return one_line("Run", self.robot.words.title, f"{self.t[-1]:g} s in {len(self.t)} rows", error, crossings)

    @cached_property
    def error(self) -> np.ndarray:
        """xi - xi_ref (n, 2), m."""
        self._needs_reference()
        return self.xi - self.xi_ref

    @cached_property
    def q_error(self) -> np.ndarray:
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
    def saturated(self) -> np.ndarray:
        """Where each torque is at its limit: (n, 2) bool; nowhere without a limit."""
        limit = np.inf if self.torque_limit is None else self.torque_limit
        return np.abs(self.tau) >= limit * (1 - 1e-12)

    @cached_property
    def energy_error(self) -> np.ndarray:
        """Energy less what the drives put in since the start, (n,) J, which no motion has: by what the steps err.

        Potential energy counts too, and what friction took.
        """
        work = np.sum(np.diff(self.q, axis=0) * self.tau[:-1], axis=1)
        whole = self.energy + self.potential
        if self.friction_loss is not None:
            whole = whole + self.friction_loss
        return whole - whole[0] - np.concatenate([[0.0], np.cumsum(work)])

    @cached_property
    def potential(self) -> np.ndarray:
        """Potential energy (n,) J, 0 without gravity."""
        rest = (0.0, 0.0)
        return potential(seen_rates(self.robot, self.q.T, self.xi.T, rest, rest).pose) + np.zeros(len(self.t))

    @cached_property
    def loop_gap(self) -> np.ndarray:
        """By how much the distal bars' ends, the elbows by q and xi, are apart from their lengths, (n, 2) m."""
        away = self.xi[:, None] - elbows(self.robot, self.q)
        return np.hypot(*np.moveaxis(away, -1, 0)) - self.robot.distal

    @property
    def points(self) -> np.ndarray:
        """Base joint, elbow, end-effector, elbow, base joint: (n, 5, 2) m; of a biglide foot, end-effector, foot."""
        return joints(self.robot, elbows(self.robot, self.q), self.xi)

    def plot(self, path: BinaryFile | None = None) -> Figure:
        """Matplotlib figure of path, errors and torques; written to `path` (PNG, SVG, PDF) if given."""
        from ..pictures.plot.runs import tracking  # Matplotlib, which no simulation and no page needs

        return saved(tracking(self), path)

    def animate(self, path: FilePath | None = None, show: str | Sequence[str] | None = None) -> Scene:
        """The motion as a page in meshcat's viewer (.html; needs no server and no network), as an animation (.gif, and
        with ffmpeg .mp4, .webm) or a strip of poses (.png).

        show: names out of view.SHOWS; None: the path, and the reference where there is one.
        """
        return scene(self.robot, self, show).saved(path)

    def page(
        self, path: FilePath | None = None, show: str | Sequence[str] | None = None, title: str | None = None
    ) -> Page:
        """One HTML file with the robot beside plots of `show`, linked by the time pointed at: `fb.page`."""
        return page(self, path, show, title)

    def to_csv(self, path: TextFile) -> None:
        """Write the run on its step grid; what else it holds, but the log, goes into a comment line. SI units."""
        about = {
            "robot": self.robot.parameters,
            "torque_limit": self.torque_limit,
            "events": [list(e) for e in self.events],
        }
        if self.step_error is not None:
            about["step_error"] = self.step_error
        if self.measured is not None:
            about["measured"] = self.measured._asdict()
        if self.control is not None:
            about["control"] = self.control._asdict()
        table = [self.t, *self.q.T, *self.q_dot.T, *self.xi.T, *self.tau.T, self.energy]
        if self.xi_ref is not None:
            table += [*self.xi_ref.T]
        if has_friction(self.robot):
            table.append(np.full(len(self.t), np.nan) if self.friction_loss is None else self.friction_loss)
        write(path, "run", about, columns(self.robot, self.xi_ref is not None), np.column_stack(table).tolist())

    @classmethod
    def from_log(
        cls, t: object, q1: ArrayLike | None = None, q2: ArrayLike | None = None, tau1: ArrayLike | None = None,
        tau2: ArrayLike | None = None, *, robot: Robot | None = None, assembly: int | None = None,
        units: Mapping[str, str] | None = None, counts_per_turn: object = None, gear_ratio: object = 1.0,
        offset: object = (0.0, 0.0), torque_constant: object = None, **more: ArrayLike,
    ) -> Run:  # fmt: skip
        """The Run of a log of a robot on a table: its rows as they are, differentiated, its gaps marked by rows of nan.

        t: (n,) s, with q1, q2 and perhaps tau1, tau2 (n,), and `more` of q1_dot, q2_dot, x, y, x_ref, y_ref; or instead
        of all a mapping of these, or a CSV file with these columns in any units that its header names.
        robot: of which it is, the lab's by default; assembly: its mode, None: the one that fits x and y, or -1.
        units: {"q1": "deg"} of columns without one. counts_per_turn: of an encoder, where q is in counts; gear_ratio:
        turns of it for a turn of the joint, < 0 where it turns the other way; offset: rad, of the joint beyond the
        encoder's 0; torque_constant: N m of the motor for a unit of tau (N m/A), gear_ratio times as much at the joint.
        Each of these a number, or two. Rows without a time or a position, gaps, restarts and jumps of whole turns are
        named in Run.measured.said. ValueError for what is no motion.
        """
        source = t
        if q1 is not None or q2 is not None or not (isinstance(t, (Mapping, str, PathLike)) or hasattr(t, "read")):
            source = {"t": t, "q1": q1, "q2": q2, "tau1": tau1, "tau2": tau2, **more}
        elif more or tau1 is not None or tau2 is not None:
            raise ValueError(f"from_log: columns beside a file or a mapping: {', '.join([*more, 'tau1', 'tau2'])}")
        robot = FiveBar() if robot is None else must_be_robot(robot, "robot")
        log = read_log(source, robot, units, Gauges(counts_per_turn, gear_ratio, offset, torque_constant))
        found = run_fields(log, robot, None if assembly is None else modes(1)(assembly, "assembly"))
        events = tuple(Event(*each) for each in found.pop("events"))
        measured = Measured(found.pop("gaps"), found.pop("said"), log.q_dot is not None)
        return cls(robot=robot, **found, events=events, measured=measured)

    def replay(
        self, robot: Robot | None = None, by: str = "torques", controller: Callable | None = None,
        restart: float | None = None,
    ) -> Replay:  # fmt: skip
        """This run beside a simulation of the same torques, or of the same reference: a Replay.

        robot: that is simulated, None: the run's own. by: "torques", from the state at the start and after each gap,
        and again every `restart` s, as nothing holds an open loop to what was measured; or "reference", the run's
        xi_ref, or where it went, under a controller (None: computed torque).
        """
        from ..measured.replays import replay  # simulates: from a floor above

        return replay(self, self.robot if robot is None else robot, by, controller, restart)

    @classmethod
    def from_csv(cls, path: TextFile) -> Run:
        """Read what `to_csv` wrote; ValueError with file and line for what is not such a file."""
        with opened(path) as table:
            about = table.about("run", "a file written by Run.to_csv", _known)
            has_reference = "x_ref" in table.header
            values = table.numbers(columns(about["robot"], has_reference), finite=False)
        t, q, q_dot, xi, tau, energy, rest = np.split(values, (1, 3, 5, 7, 9, 10), axis=1)
        return cls(
            t=t[:, 0], q=q, q_dot=q_dot, xi=xi, tau=tau, energy=energy[:, 0],
            xi_ref=rest[:, :2] if has_reference else None,
            friction_loss=rest[:, -1] if has_friction(about["robot"]) else None, **about,
        )  # fmt: skip


def _known(about):
    """The fields of a Run that are in the comment line of its file."""
    limit, error, control = about["torque_limit"], about.get("step_error"), about.get("control")
    measured = about.get("measured")
    return {
        "robot": robot_of(about["robot"]),
        "torque_limit": limit if limit is None else float(limit),
        "step_error": error if error is None else float(error),
        "events": tuple(
            Event(float(t), Singularity(kind), str(margin), tuple(before), tuple(after))
            for t, kind, margin, before, after in about["events"]
        ),
        "control": control if control is None else _control(**control),
        "measured": measured if measured is None else _measured(**measured),
    }


def _measured(gaps, said, rates):
    gaps = tuple((float(low), float(high), str(why)) for low, high, why in gaps)
    return Measured(gaps, tuple(map(str, said)), bool(rates))


def _control(t, **pairs):
    t = np.array(t, dtype=float).reshape(-1)
    return Control(t, **{name: np.array(pair, dtype=float).reshape(len(t), 2) for name, pair in pairs.items()})
