"""A test drawing whose distances, measured with a ruler, calibrate the robot that drew it.

Distances between crosses know no frame, so that the sheet may lie anywhere. The joint angles of
each cross are those that the uncalibrated robot was told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from ...base.checks import instance, modes, one_of
from ...base.representation import one_line
from ...base.tables import TextFile, written
from ...constraints.constraints import ON_POSES, Constraints
from ...models.geometry import igm
from ...models.robots import FiveBar
from ...paths.curve import Path
from ...paths.machine import Machine
from ...paths.pieces import Line
from ...paths.placing.fitting_in import fitted_in
from .measured_robot import PLACE, seen, values_of

PAPERS = {"A4": (0.297, 0.21), "A5": (0.21, 0.148)}  # m, lying
BORDER = 0.012  # m, of the paper that stays free
GRID = 4, 3  # crosses
ARM = 0.003  # m, of a cross
MARK = 0.011  # m, side of the square around A1
CLEARANCE = 0.005  # m, of the drawing from singularities
PAIRS = 24  # distances that are measured
UNKNOWN = "l11", "l12", "l21", "l22", "d", "offset1", "offset2"


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
        """Of the crosses: a letter for the row from below, a number from the left."""
        columns, _ = GRID
        return [f"{'ABC'[k // columns]}{k % columns + 1}" for k in range(len(self.crosses))]

    @property
    def readings(self) -> np.ndarray:
        """What the drives read (n, 2) at the crosses."""
        xi = self.machine.frame.inverse(self.crosses)
        return self.machine.readings(igm(self.machine.robot, xi, self.working).q)

    def points_to_csv(self, file: TextFile, points: np.ndarray) -> None:
        """Write measured places of the crosses (n, 2), m, for `calibrate`; nan is left out."""
        signs = ",".join(map(str, self.working))
        with written(file) as out:
            out.write("q1,q2,working1,working2,x,y\n")
            for (q1, q2), (x, y) in zip(self.readings.tolist(), points.tolist()):
                if x == x:
                    out.write(f"{q1!r},{q2!r},{signs},{x!r},{y!r}\n")

    def drawing_to_csv(self, file: TextFile) -> None:
        """Write the drawing as x, y in mm and pen, for `fivebar draw`."""
        points = [(*(1e3 * np.array(self.path.pieces[0].start)), 0)]
        for piece, down in zip(self.path.pieces, self.path.pen):
            points.append((*(1e3 * np.array(piece.end)), int(down)))
        with written(file) as out:
            out.write("x (mm),y (mm),pen\n")
            out.writelines(f"{x:.6f},{y:.6f},{pen}\n" for x, y, pen in points)

    def distances_to_csv(self, file: TextFile) -> None:
        """Write the table for the ruler, whose column distance is to be filled in."""
        q = self.readings
        names = self.names
        with written(file) as out:
            out.write("cross,to_cross,q1,q2,working1,working2,to,distance (mm)\n")
            for one, other in self.pairs.tolist():
                q1, q2 = q[one].tolist()
                signs = ",".join(map(str, self.working))
                ends = f"{names[one]},{names[other]}"
                out.write(f"{ends},{q1!r},{q2!r},{signs},{other + 1},\n")


def sheet(
    machine: Machine | FiveBar,
    paper: str = "A5",
    working: tuple[int, int] | None = None,
) -> Sheet:
    """Return the test drawing for a machine, on paper, or as large as it fits.

    Raises
    ------
    ValueError
        The machine has a tool beside joint C, or nothing fits.
    """
    machine = Machine(machine) if isinstance(machine, FiveBar) else machine
    instance(Machine)(machine, "sheet: machine")
    if machine.tool is not None or not machine.robot.turns:
        raise ValueError(
            "sheet: the drawing is of the joint of a five-bar's distal bars: put the pen there and"
            " take the table tool out of the robot's file"
        )
    size = np.array(PAPERS[one_of(*PAPERS)(paper, "sheet: paper")]) - 2 * BORDER
    outline = [(0.0, 0.0), (size[0], 0.0), tuple(size), (0.0, size[1]), (0.0, 0.0)]
    frame = Path(tuple(Line(a, b) for a, b in zip(outline, outline[1:])))
    kept = {name: getattr(machine.constraints, name) for name in ON_POSES}
    limits = replace(Constraints(**kept), clearance=CLEARANCE)
    if working is not None:
        working = modes(2)(working, "sheet: working")
    robot: Any = machine.robot
    fit = fitted_in(robot, frame, 0.0, None, working, limits)
    scale = min(1.0, fit.scale)
    box = fit.rectangle
    middle = np.array([box.x_min + box.x_max, box.y_min + box.y_max]) / 2
    half = scale * size / 2
    columns, rows = GRID
    inner = half - MARK
    x, y = (np.linspace(-h, h, n) for h, n in zip(inner, (columns, rows)))
    crosses = middle + np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    outlines = (
        machine.frame(middle + half * corners),
        machine.frame(crosses[0] + MARK / 2 * corners),
    )
    in_frame = machine.frame(crosses)
    path = _strokes([*outlines, *_arms(in_frame)])
    pairs = _telling(machine.robot, igm(machine.robot, crosses, fit.aspect.working))
    return Sheet(machine, fit.aspect.working, in_frame, path, pairs)


def _arms(crosses):
    found = []
    for arm in ((ARM, 0.0), (0.0, ARM)):
        found.append(np.stack([crosses - arm, crosses + np.array(arm)], axis=1))
    return [stroke for both in zip(*found) for stroke in both]


def _strokes(strokes):
    pieces = []
    pen = []
    last = None
    for stroke in strokes:
        points = [tuple(point) for point in stroke.tolist()]
        if last is not None and last != points[0]:
            pieces.append(Line(last, points[0]))
            pen.append(False)
        pieces += [Line(a, b) for a, b in zip(points, points[1:])]
        pen += [True] * (len(points) - 1)
        last = points[-1]
    return Path(pieces, pen)


def _telling(robot, pose):
    """Return pairs (k, 2) of crosses whose distances tell most of the unknowns: each cross with its
    best one, and then those by which the determinant of the information grows most.
    """
    points, slopes = seen(values_of(robot), pose.q, pose.assembly)
    slopes = slopes[..., [PLACE[name] for name in UNKNOWN]]
    size = np.array([robot.l11] * 5 + [1.0, 1.0])
    pairs = [*combinations(range(len(points)), 2)]
    pairs += [(b, a) for a, b in pairs]
    ends = np.array(pairs)
    gap = points[ends[:, 0]] - points[ends[:, 1]]
    along = gap / np.linalg.norm(gap, axis=1)[:, None]
    change = slopes[ends[:, 0]] - slopes[ends[:, 1]]
    rows = np.einsum("ni,nik->nk", along, change) * size
    information = 1e-6 * np.eye(len(size)) * np.sum(rows**2) / len(rows)
    chosen: list[int] = []
    taken = np.zeros(len(pairs), dtype=bool)
    while len(chosen) < PAIRS:
        gain = np.einsum("nk,kl,nl->n", rows, np.linalg.inv(information), rows)
        gain[taken] = -1.0
        if len(chosen) < len(points):
            gain[ends[:, 0] != len(chosen)] = -1.0
        best = int(gain.argmax())
        chosen.append(best)
        taken |= (ends == ends[best]).all(axis=1) | (ends == ends[best, ::-1]).all(axis=1)
        information = information + np.outer(rows[best], rows[best])
    return ends[chosen]
