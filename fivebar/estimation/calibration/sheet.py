"""A test drawing whose distances, measured with a ruler, calibrate the robot that drew it.

Distances between crosses know no frame, so that the sheet may lie anywhere. The joint angles of
each cross are those that the uncalibrated robot was told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base.checks import instance, modes, one_of
from ...base.representation import one_line
from ...base.tables import TextFile, written
from ...models.geometry import igm
from ...models.robots import FiveBar
from ...paths.curve import Path
from ...paths.machine import Machine
from ...paths.pieces import Line
from ...paths.placing.fitting_in import fitted_in

PAPERS = {"A4": (0.297, 0.21), "A5": (0.21, 0.148)}  # m, lying
BORDER = 0.012  # m, of the paper that stays free
GRID = 4, 3  # crosses
ARM = 0.003  # m, of a cross
MARK = 0.011  # m, side of the square around A1
CLEARANCE = 0.005  # m, of the drawing from singularities
# Crosses between which distances are measured, two hexadecimal digits each. By exchanges, the mean
# over seven robots of the tip's expected error is least: 2 % less than by the pairs of the greatest
# determinant of each robot's own information, at most 2 % more.
PAIRS = "0a 13 27 3b 49 50 60 71 81 93 a4 b2 02 34 03 09 08 23 14 8b 38 1b 01 3a"


@dataclass(frozen=True, eq=False)
class Sheet:
    """A test drawing: a grid of crosses in a frame, the first of them in a square.

    Attributes
    ----------
    machine : Machine
    working : (2,)
    crosses : (n, 2)
        In the machine's frame, m.
    path : Path
        The drawing, in that frame.
    pairs : (k, 2)
        Crosses between which distances are measured; each cross begins one.
    """

    machine: Machine
    working: tuple[int, int]
    crosses: np.ndarray
    path: Path
    pairs: np.ndarray

    def __repr__(self) -> str:
        words = f"{len(self.crosses)} crosses, {len(self.pairs)} distances"
        return one_line("Sheet", words, f"working {self.working}")

    @property
    def names(self) -> list[str]:
        """Return the crosses' names: a letter for the row from below, a number from the left."""
        columns, _ = GRID
        names = []
        for k in range(len(self.crosses)):
            row, column = divmod(k, columns)
            names.append(f"{'ABC'[row]}{column + 1}")
        return names

    @property
    def readings(self) -> np.ndarray:
        """Return what the drives read (n, 2) at the crosses."""
        machine = self.machine
        xi = machine.frame.inverse(self.crosses)
        return machine.readings(_pose(machine, xi, self.working).q)

    @property
    def _signs(self) -> str:
        """Return the working modes as two columns of a table."""
        return ",".join(map(str, self.working))

    def points_to_csv(self, file: TextFile, points: np.ndarray) -> None:
        """Write measured places of the crosses (n, 2), m, for `calibrate`; nan is left out."""
        missing = np.isnan(points[:, 0])
        numbers = np.hstack([self.readings, points])[~missing]
        with written(file) as out:
            out.write("q1,q2,working1,working2,x,y\n")
            for q1, q2, x, y in numbers.tolist():
                out.write(f"{q1!r},{q2!r},{self._signs},{x!r},{y!r}\n")

    def drawing_to_csv(self, file: TextFile) -> None:
        """Write the drawing as x, y in mm and pen, for `fivebar draw`."""
        pieces = self.path.pieces
        points = [pieces[0].start]
        points += [piece.end for piece in pieces]
        in_mm = 1e3 * np.array(points)
        pen = [False, *self.path.pen]
        with written(file) as out:
            out.write("x (mm),y (mm),pen\n")
            for (x, y), down in zip(in_mm, pen):
                out.write(f"{x:.6f},{y:.6f},{int(down)}\n")

    def distances_to_csv(self, file: TextFile) -> None:
        """Write the table for the ruler, whose column distance is to be filled in."""
        q = self.readings
        names = self.names
        with written(file) as out:
            out.write("cross,to_cross,q1,q2,working1,working2,to,distance (mm)\n")
            for one, other in self.pairs.tolist():
                q1, q2 = q[one].tolist()
                ends = f"{names[one]},{names[other]}"
                out.write(f"{ends},{q1!r},{q2!r},{self._signs},{other + 1},\n")


def sheet(
    machine: Machine | FiveBar, paper: str = "A5", working: tuple[int, int] | None = None
) -> Sheet:
    """Return the test drawing for a machine, on paper, or as large as it fits.

    Raises
    ------
    ValueError
        The machine is no five-bar, or nothing fits.
    """
    if isinstance(machine, FiveBar):
        machine = Machine(machine)
    instance(Machine)(machine, "sheet: machine")
    if not machine.robot.turns:
        raise ValueError("sheet: the drawing is of a five-bar, and the machine is a biglide")
    paper = one_of(*PAPERS)(paper, "sheet: paper")
    size = np.array(PAPERS[paper]) - 2 * BORDER
    width, height = size
    outline = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)]
    frame = Path(_lines(outline))
    limits = replace(machine.on_poses, clearance=CLEARANCE)
    if working is not None:
        working = modes(2)(working, "sheet: working")
    robot: Any = machine.robot
    fit = fitted_in(robot, frame, 0.0, None, working, limits, machine.tool)
    working = fit.aspect.working
    scale = min(1.0, fit.scale)
    box = fit.rectangle
    twice_middle = [box.x_min + box.x_max, box.y_min + box.y_max]
    middle = np.array(twice_middle) / 2
    half = scale * size / 2
    x, y = half - MARK
    columns, rows = GRID
    grid = np.meshgrid(np.linspace(-x, x, columns), np.linspace(-y, y, rows))
    crosses = middle + np.stack(grid, axis=-1).reshape(-1, 2)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    border = middle + half * corners
    mark = crosses[0] + MARK / 2 * corners
    in_frame = machine.frame(crosses)
    strokes = [machine.frame(border), machine.frame(mark), *_arms(in_frame)]
    pairs = np.array([divmod(int(pair, 16), 16) for pair in PAIRS.split()])
    return Sheet(machine, working, in_frame, path=_drawn(strokes), pairs=pairs)


def _pose(machine, points, working):
    """Return the Pose with the pen at points of the robot's frame."""
    if machine.tool is None:
        return igm(machine.robot, points, working)
    return machine.tool.pose(machine.robot, points, working)


def _lines(points):
    """Return the lines from each point to the next."""
    return [Line(start, end) for start, end in zip(points, points[1:])]


def _arms(crosses):
    """Return the two strokes (2, 2) of each cross in turn: along x, and along y."""
    arms = ARM * np.eye(2)
    centres = crosses[:, None]
    ends = [centres - arms, centres + arms]
    return np.stack(ends, axis=2).reshape(-1, 2, 2)


def _drawn(strokes):
    """Return the path along strokes, the pen up between them."""
    pieces = []
    pen = []
    last = None
    for stroke in strokes:
        points = [tuple(point) for point in stroke.tolist()]
        first = points[0]
        if last is not None and last != first:
            pieces.append(Line(last, first))
            pen.append(False)
        lines = _lines(points)
        pieces += lines
        pen += [True] * len(lines)
        last = points[-1]
    return Path(pieces, pen)
