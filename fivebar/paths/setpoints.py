"""Joint angles at a steady rate, for a drive that takes a table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import a_callable, bounded, modes, one_of, optional, positive, takes
from ..base.checks import robot as must_be_robot
from ..base.representation import one_line
from ..base.tables import TextFile, write
from ..models.geometry import igm
from ..models.kinematics import ikm
from ..models.robots import Robot
from .strokes import pen_down

MOST_ROWS = 10**7


@dataclass(frozen=True, eq=False)
class Setpoints:
    """t (n,) s, even steps from the first instant to the last or the first row after it; q, q_dot
    (n, 2) rad, rad/s (m, m/s where a foot slides), continuous; pen (n,), True where it is down, or
    None.
    """

    robot: Robot
    t: np.ndarray
    q: np.ndarray
    q_dot: np.ndarray
    pen: np.ndarray | None = None

    def __repr__(self) -> str:
        rows = f"{len(self.t)} rows, {self.t[1] - self.t[0]:g} s apart"
        return one_line("Setpoints", self.robot.words.title, rows)

    def to_csv(self, path: TextFile, angles: str = "rad") -> None:
        """Write them: t, q1, q2, their rates, and pen where there is one. angles: "rad" or
        "deg".
        """
        one_of("rad", "deg")(angles, "angles")
        if angles == "deg" and not self.robot.turns:
            raise ValueError("to_csv: the joints of a biglide slide, they have no angles")
        factor, unit = (180 / math.pi, "_deg") if angles == "deg" else (1.0, "")
        header = [
            "t",
            f"q1{unit}",
            f"q2{unit}",
            f"q1_dot{unit}",
            f"q2_dot{unit}",
            *["pen"] * (self.pen is not None),
        ]
        table = [
            self.t,
            self.q * factor,
            self.q_dot * factor,
            *([self.pen.astype(int)] if self.pen is not None else []),
        ]
        rows = np.column_stack(table).tolist()
        if self.pen is not None:
            rows = [[*row[:-1], int(row[-1])] for row in rows]
        about = {"robot": self.robot.parameters, **({"angles": "deg"} if angles == "deg" else {})}
        write(path, "setpoints", about, header, rows)


@takes(robot=must_be_robot, reference=a_callable, rate=positive, working=optional(modes(2)))
def setpoints(
    robot: Robot,
    reference: Any,
    rate: float = 1000.0,
    working: tuple[int, int] | None = None,
) -> Setpoints:
    """Return the joint coordinates of a motion at a steady rate.

    If the duration is no multiple of the step, the last row is the first after the end, at the
    motion's last point.

    Parameters
    ----------
    robot : FiveBar or Biglide
    reference : callable
        A motion with a duration: t -> (xi, xi_dot, xi_ddot).
    rate : float
        Rows a second, Hz.
    working : (2,), optional
        Working modes; by default those of the reference, or (-1, -1).

    Returns
    -------
    Setpoints

    Raises
    ------
    UnreachableError, SingularityError
        The motion is out of reach or crosses Type 1.

    Examples
    --------
    >>> import fivebar as fb
    >>> from fivebar.paths.setpoints import setpoints
    >>> motion = fb.line((0.05, 0.09), (0.04, 0.09), 1.0)
    >>> setpoints(fb.FiveBar(), motion, rate=100.0).q.shape
    (101, 2)
    """
    steps = math.ceil(reference.duration * rate * (1 - 1e-12))
    bounded(
        steps,
        MOST_ROWS,
        f"setpoints: {reference.duration:g} s at {rate:g} Hz",
        40,
    )
    t = np.arange(steps + 1) / rate
    times = getattr(reference, "start", 0.0) + t
    modes_own = getattr(reference, "working", None)
    if (
        working is None and modes_own is None and hasattr(reference, "joints")
    ):  # a plan that is free of modes
        q, q_dot = reference.joints(times)
    else:
        xi, xi_dot, _ = reference(times)
        rates = ikm(
            igm(robot, xi, working or modes_own or (-1, -1)),
            xi_dot,
        )
        q = rates.pose.q
        q_dot = rates.q_dot
    pen = pen_down(reference, times) if hasattr(reference, "path") else None
    return Setpoints(
        robot,
        t,
        np.unwrap(q, axis=0) if robot.turns else q,
        q_dot,
        pen,
    )
