"""Maps: a margin on a grid of the task space for each working mode, or of the joint space for each
assembly mode.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import HUGE
from ..base.checks import instance, one_of, optional
from ..base.presentation import Paged
from ..base.representation import one_line
from ..base.robot_uses import takes_robot
from ..base.tables import (
    STRANGE,
    BinaryFile,
    FilePath,
    TextFile,
    arrays_in,
    file_or_path,
    write,
    written,
)
from ..models.geometry import joint_pose, task_pose
from ..models.parameters import robot_of
from ..models.robots import Robot
from .loci import singularity_loci
from .locus import MODES
from .margins import Singularity, singularity_margins

BLOCK = 8192  # nodes computed together: what they need stays in the processor's cache
SHARE = 0.5  # of the machine's memory that a map may fill
MOST_TURNS = (
    100  # squares of a turn in a window of joint space: in each a picture draws the loci again
)

FIELDS = {
    "parallel": ("sin(φ2 − φ1), signed, 0 at Type 2", lambda m: m.parallel),
    "serial_left": (
        "sin {passive[0]}, signed, 0 at Type 1 of the left leg",
        lambda m: m.pose.sines[0],
    ),
    "serial_right": (
        "sin {passive[1]}, signed, 0 at Type 1 of the right leg",
        lambda m: m.pose.sines[1],
    ),
    "transmission_angle": (
        "acute angle between the distal bars, rad",
        lambda m: m.transmission_angle,
    ),
    "manipulability": ("|det J|, scaled, inf at Type 2", lambda m: m.manipulability),
    "sigma_min_A": ("smallest singular value of A", lambda m: m.sigma_min.A),
    "sigma_min_B": ("smallest singular value of B, scaled", lambda m: m.sigma_min.B),
    "sigma_min_J": ("smallest singular value of J = A⁻¹B, scaled", lambda m: m.sigma_min.J),
    "condition_A": ("condition number of A", lambda m: m.condition.A),
    "condition_B": ("condition number of B", lambda m: m.condition.B),
    "condition_J": ("condition number of J = A⁻¹B", lambda m: m.condition.J),
}
SIGNED = ("parallel", "serial_left", "serial_right")


@dataclass(frozen=True, eq=False)
class Map(Paged):
    """A margin on a grid, from `singularity_map`.

    space "task": x (nx,), y (ny,) m are the end-effector's; modes: pairs of working modes, one for
    each layer; space "joint": x (nx,), y (ny,) rad (m of a biglide) are q11, q21; modes: assembly
    modes. values (modes, ny, nx): nan where the robot cannot close. tool: the Tool there, or None.
    """

    robot: Robot
    field: str
    space: str
    x: np.ndarray
    y: np.ndarray
    modes: tuple[tuple[int, int], ...] | tuple[int, ...]
    values: np.ndarray
    tool: Any = None

    def __repr__(self) -> str:
        nodes = f"{len(self.x)} x {len(self.y)} nodes"
        return one_line(
            "Map",
            self.description,
            f"{self.space} space",
            nodes,
            f"{len(self.modes)} modes",
            self.robot.words.title,
        )

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns that `to_csv` writes; the last ones are the field in each mode."""
        if self.space == "task":
            own = ("x", "y")
        else:
            own = self.robot.words.joints
        for mode in self.modes:
            signs = ",".join(f"{m:+d}" for m in np.atleast_1d(mode))
            own += (f"{self.field}({signs})",)
        return own

    @property
    def description(self) -> str:
        """The field in words."""
        return FIELDS[self.field][0].format(passive=self.robot.words.passive)

    def _about(self):
        return {
            "robot": self.robot.parameters,
            "field": self.field,
            "space": self.space,
            "modes": self.modes,
            "tool": None if self.tool is None else asdict(self.tool),
        }

    def to_csv(self, path: TextFile) -> None:
        """Write one line per node of the grid that closes in any mode, SI units, nan where a mode
        does not.
        """
        x, y = np.meshgrid(self.x, self.y)
        table = np.column_stack([x.ravel(), y.ravel(), self.values.reshape(len(self.modes), -1).T])
        table = table[~np.isnan(table[:, 2:]).all(axis=1)]
        write(path, "map", self._about(), self.columns, table.tolist(), end="\n")

    def to_npz(self, path: BinaryFile) -> None:
        """Write the whole map, compressed."""
        with written(path, binary=True) as file:
            np.savez_compressed(
                file, x=self.x, y=self.y, values=self.values, about=json.dumps(self._about())
            )

    @classmethod
    def from_npz(cls, path: FilePath) -> Map:
        """Read what `to_npz` wrote; ValueError for any other file."""
        file_or_path(path, "read")
        try:
            data = arrays_in(path)
            about = json.loads(str(data["about"]))
            x = data["x"]
            y = data["y"]
            values = data["values"]
            modes = tuple(
                tuple(mode) if isinstance(mode, list) else mode for mode in about["modes"]
            )
            if about["tool"]:
                raise ValueError("the map of a tool is not read back")
            if about["field"] not in FIELDS or values.shape != (len(modes), *y.shape, *x.shape):
                raise ValueError(
                    f"{about['field']} {values.shape} on a grid of {x.shape} x {y.shape} nodes"
                )
            return cls(
                robot_of(about["robot"]), about["field"], about["space"], x, y, modes, values
            )
        except (*STRANGE, SystemError) as error:  # of letters beyond Unicode's
            raise ValueError(f"{path} is not a map written by to_npz: {error}") from None


@takes_robot(field=one_of(*FIELDS), space=one_of("task", "joint"), tool=optional(instance("Tool")))
def singularity_map(
    robot: Robot,
    field: str = "parallel",
    space: str = "task",
    window: ArrayLike | None = None,
    shape: tuple[int, int] = (401, 401),
    tool: Any = None,
) -> Map:
    """Return a margin on a grid.

    Over the task space there is a layer for each of the four working modes, over the joint space
    one for each of both assembly modes.

    Parameters
    ----------
    robot : FiveBar or Biglide
    field : str
        One of FIELDS.
    space : "task" or "joint"
    window : (4,), optional
        (x_min, x_max, y_min, y_max), m; or of q11 and q21, rad (biglide: m). None: what the robot
        reaches, or a turn of each; of a biglide, whose map has no ends along its guides, as much
        along as across them. Of angles at most 100 turns times turns.
    shape : (2,)
        (nx, ny) nodes, the window's borders among them.
    tool : Tool, optional
        Then the map is over its places.

    Returns
    -------
    Map

    Raises
    ------
    ValueError
        An unknown field, a window that misses the workspace, a grid that memory cannot hold.

    Examples
    --------
    >>> import fivebar as fb
    >>> data = fb.singularity_map(fb.FiveBar(), shape=(21, 21))
    >>> data.values.shape
    (4, 21, 21)
    """
    modes: Any = MODES if space == "task" else (1, -1)
    nx, ny = _checked_shape(shape, len(modes))
    close: Callable = task_pose if space == "task" else joint_pose
    if tool is not None:
        if space != "task":
            raise ValueError("singularity_map: a tool has places in task space, not in joint space")

        def close(robot, at, mode):
            return tool.pose(robot, np.stack(at, axis=-1), mode, unreachable="nan")

    if window is None:
        if tool is not None:
            window = _tool_window(robot, tool, close)
        elif space == "task":
            window = workspace_window(robot)
        else:
            window = 2 * _joint_range(robot)
    x_min, x_max, y_min, y_max = checked_window(window, turns=space == "joint" and robot.turns)
    x = np.linspace(x_min, x_max, nx)
    y = np.linspace(y_min, y_max, ny)
    pick = FIELDS[field][1]
    values = np.empty((len(modes), ny, nx))
    rows = max(1, BLOCK // nx)
    for first in range(0, ny, rows):
        block = slice(first, first + rows)
        at = np.broadcast_arrays(x, y[block, None])
        for layer, mode in zip(values, modes):
            layer[block] = pick(singularity_margins(close(robot, at, mode)))
    if np.isnan(values).all():
        extent = ", ".join(f"{end:.6g}" for end in workspace_window(robot, border=0.0))
        raise ValueError(
            f"no pose closes at the {nx} x {ny} nodes of this window of the {space} space;"
            f" the end-effector reaches ({extent}) m: x_min, x_max, y_min, y_max"
        )
    return Map(robot, field, space, x, y, modes, values, tool)


def turned_into(data: Map, points: np.ndarray) -> Iterator[np.ndarray]:
    """Yield points (n, 2) of joint space, shifted by those full turns that bring some into the
    window of the Map.
    """
    turn = 2 * np.pi
    low = np.array([data.x[0], data.y[0]])
    high = np.array([data.x[-1], data.y[-1]])
    first = np.ceil((low - points.max(axis=0)) / turn).astype(int)
    last = np.floor((high - points.min(axis=0)) / turn).astype(int)
    for i in range(first[0], last[0] + 1):
        for j in range(first[1], last[1] + 1):
            yield points + turn * np.array([i, j])


def _joint_range(robot):
    end = np.pi if robot.turns else max(robot.distal)
    return -end, end


def workspace_window(robot: Any, border: float = 0.04) -> tuple[float, float, float, float]:
    """Return (x_min, x_max, y_min, y_max), m, of all that the end-effector reaches, with a border
    of that share around it.

    Of a biglide, what it reaches and its guides across, and as much along these, about 0.
    """
    if not robot.turns:
        low, high = _strip(robot)
        low = min(low, -robot.d / 2)
        high = max(high, robot.d / 2)
        half = (0.5 + border) * (high - low)
        return (low + high) / 2 - half, (low + high) / 2 + half, -half, half
    loci = singularity_loci(robot).task
    points = np.concatenate([piece.points for piece in loci if piece.type & Singularity.SERIAL])
    low = points.min(axis=0)
    high = points.max(axis=0)
    pad = border * max((high - low).max(), 1e-6 * (robot.l11 + robot.l12))
    return low[0] - pad, high[0] + pad, low[1] - pad, high[1] + pad


def _tool_window(robot, tool, close):
    """Return the window of all that a tool reaches, to a hundredth of the robot's reach."""
    drive = robot.drives[tool.leg - 1]
    reach = drive.length + robot.distal[tool.leg - 1] + abs(complex(tool.along, tool.across))
    steps = reach * np.linspace(-1.02, 1.02, 205)
    at = np.meshgrid(drive.x + steps, drive.y + steps)
    reached = np.zeros(at[0].shape, bool)
    for mode in MODES:
        reached |= np.isfinite(close(robot, at, mode).det_A)
    ends = [axis[reached] for axis in at] if reached.any() else at
    pad = 2 * (steps[1] - steps[0])
    return [end for axis in ends for end in (axis.min() - pad, axis.max() + pad)]


def _strip(robot):
    """Return (x_min, x_max), m, of what a biglide reaches, at any y."""
    sides = [(drive.x - bar, drive.x + bar) for drive, bar in zip(robot.drives, robot.distal)]
    return max(low for low, _ in sides), min(high for _, high in sides)


def _checked_shape(shape, layers):
    try:
        nx, ny = map(int, shape)
        if (nx, ny) != tuple(shape) or min(nx, ny) < 2:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f"shape must be two whole numbers (nx, ny) of at least 2, not {shape!r}"
        ) from None
    needed = 8 * layers * nx * ny
    if needed > SHARE * _memory():
        raise ValueError(
            f"shape: a map of {nx} x {ny} nodes in {layers} modes needs {needed / 2**30:.3g} GiB; "
            f"{SHARE:.0%} of this machine's memory are {SHARE * _memory() / 2**30:.3g} GiB"
        )
    return nx, ny


def _memory():
    """Bytes of memory of this machine; 8 GiB where it does not tell."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return 8 * 2**30


def checked_window(window: Any, turns: bool = False) -> tuple[float, float, float, float]:
    """Return a window's four borders as floats; ValueError unless they are finite and in order.

    turns: of joints that turn, of which only a few whole turns can be drawn.
    """
    try:
        x_min, x_max, y_min, y_max = map(float, window)
        if not (-HUGE < x_min < x_max < HUGE and -HUGE < y_min < y_max < HUGE):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            "window must be four numbers (x_min, x_max, y_min, y_max) with finite min < max,"
            f" not {window!r}"
        ) from None
    wide = (x_max - x_min) / (2 * np.pi)
    high = (y_max - y_min) / (2 * np.pi)
    if turns and wide * high > MOST_TURNS * (1 + 1e-6):
        raise ValueError(
            f"window is {wide:.6g} x {high:.6g} turns, and its picture would draw the loci"
            f" {wide * high:.3g} times: at most {MOST_TURNS}"
        )
    return x_min, x_max, y_min, y_max
