"""A robot as it is built: its angles as its drives read them, and the frame it is measured in."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, one_of, positive, robot, shown, two_numbers
from ..base.columns import Origin
from ..base.representation import one_line, vector, working_words
from ..base.robot_uses import freed, left_out
from ..base.tables import TextFile
from ..base.units import METRES, RADIANS
from ..constraints.constraints import CHECKS, ON_POSES, Constraints
from ..constraints.link_collisions import LinkCollisions
from ..models.parameters import refuse_missing, refuse_unknown
from ..models.robot_files import RobotFile, read_robot
from ..models.robot_writing import write_robot
from ..models.robots import Biglide, FiveBar
from .curve import AtUnitSpeed
from .placement import Placement
from .tool import MountedTool, Tool

# How many are 1 rad; None: it depends on the motor.
UNITS = {
    "rad": 1.0,
    "deg": 1 / RADIANS["deg"],
    "turns": 1 / RADIANS["rev"],
    "counts": None,
    "steps": None,
    "mm": None,
}
# Of a machine's ratio: below, its drives read degrees, mm, inches or counts.
IN_RADIANS = 0.02
IN_METRES = 0.5
FASTEST = 10.0  # rad of a joint for one that its drive reads


def _names(kind):
    return [field.name for field in fields(kind)]


KNOWN = {  # tables of a robot file
    "readings": ["offset", "ratio"],
    "frame": _names(Placement),
    "constraints": [name for name in CHECKS if name != "functions"],
    "tool": _names(Tool),
    "measured": ["modes"],
}


@dataclass(frozen=True)
class Machine:
    """A robot as it is built, with all that its file says.

        true angle = ratio * reading + offset        measured point = frame(xi)

    Parameters
    ----------
    robot : FiveBar or Biglide
    offset : (2,)
        True angles where the drives read 0, rad (of a biglide m).
    ratio : (2,)
        True angle for one of the drive's, not 0; negative where it turns the other way.
    frame : Placement
        From the robot's frame to the one in which points are measured, that of the table.
    constraints : Constraints
        What all motions keep; half planes and region are in the robot's own frame.
    tool : Tool, optional
        What draws, where that is not the joint of the distal bars.
    measured : (n, 3)
        Modes in which it was calibrated, each (left working, right working, assembly), +1 or -1;
        () where that is not known. In other modes it goes less exactly where it should.

    Raises
    ------
    ValueError, TypeError
        A value is none of these; the message names it.

    Examples
    --------
    >>> import fivebar as fb
    >>> machine = fb.Machine(fb.FiveBar(), offset=(0.01, 0.0), frame=fb.Placement((0.1, 0.2)))
    >>> pose = fb.igm(machine.robot, machine.frame.inverse((0.19, 0.268)))
    >>> bool(abs(machine.angles(machine.readings(pose.q)) - pose.q).max() < 1e-15)
    True
    """

    robot: FiveBar | Biglide
    offset: tuple[float, float] = (0.0, 0.0)
    ratio: tuple[float, float] = (1.0, 1.0)
    frame: Placement = Placement()
    constraints: Constraints = field(default_factory=Constraints)
    tool: Tool | None = None
    measured: tuple[tuple[int, int, int], ...] = ()

    def __post_init__(self) -> None:
        robot(self.robot, "Machine: robot")
        offset = two_numbers(self.offset, "Machine: offset")
        object.__setattr__(self, "offset", offset)
        ratio = two_numbers(self.ratio, "Machine: ratio")
        if 0 in ratio:
            raise ValueError(f"Machine: ratio must not be 0, not {ratio}")
        if self.robot.turns and (fastest := max(map(abs, ratio))) > FASTEST:
            raise ValueError(
                f"Machine: ratio {fastest:g} says that the joint turns {fastest:g} times as far as"
                f" its drive: of a gear of {fastest:g} it is {1 / fastest:.9g}"
            )
        object.__setattr__(self, "ratio", ratio)
        instance(Placement)(self.frame, "Machine: frame")
        limits = instance(Constraints)(self.constraints, "Machine: constraints")
        object.__setattr__(self, "constraints", limits.of_robot)
        if self.tool is not None:
            tool = instance(Tool)(self.tool, "Machine: tool")
            robot_: Any = self.robot
            MountedTool(tool, robot_, (-1, -1))
        measured = instance(tuple, list)(self.measured, "Machine: measured")
        object.__setattr__(self, "measured", tuple(map(_signs, measured)))

    def __repr__(self) -> str:
        words = [self.robot.words.title]
        if self.reads_otherwise:
            unit = self.robot.words.unit
            words.append(vector("offset", self.offset, unit))
            words.append(vector("ratio", self.ratio, ""))
        if self.frame != Placement():
            words.append(str(self.frame))
        if self.constraints != Constraints():
            words.append(str(self.constraints))
        if self.tool is not None:
            words.append(str(self.tool))
        if self.measured:
            words.append(f"calibrated in {self.measured_words}")
        return one_line("Machine", *words)

    @property
    def measured_words(self) -> str:
        """The modes in which it was calibrated, in words."""
        modes = []
        for *working, assembly in self.measured:
            modes.append(f"{working_words(working)} with assembly mode {assembly:+d}")
        return ", ".join(modes)

    @property
    def measured_constraints(self) -> Constraints:
        """Its constraints with half planes and region in the measuring frame, as in a file."""
        return _moved(self.constraints, self.frame)

    @property
    def on_poses(self) -> Constraints:
        """Its constraints on poses."""
        return Constraints(**{name: getattr(self.constraints, name) for name in ON_POSES})

    def is_measured(self, working: tuple[int, int], assembly: int) -> bool:
        """Return whether it was calibrated in these modes; True where that is not known."""
        return not self.measured or (*working, assembly) in self.measured

    @property
    def reads_otherwise(self) -> bool:
        """Whether its drives read other angles than the model has."""
        return (self.offset, self.ratio) != ((0.0, 0.0), (1.0, 1.0))

    @property
    def reads_si(self) -> bool:
        """Whether its drives read rad, of the joint or before a gear; of a biglide, m."""
        least = IN_RADIANS if self.robot.turns else IN_METRES
        return max(map(abs, self.ratio)) >= least

    @property
    def moves_points(self) -> bool:
        """Whether its points are measured in another frame than the robot's own."""
        return self.frame != Placement()

    def used_by(self, user: str) -> tuple[Machine, str]:
        """Return the machine without what a command or function leaves out, and in words: this,
        and what bounds joint C where a tool leads.

        Raises
        ------
        ValueError
            What it says is refused there; the message names it.
        """
        said = {
            "biglide": not self.robot.turns,
            "readings": self.reads_otherwise,
            "frame": self.moves_points,
            "tool": self.tool is not None,
            "measured": bool(self.measured),
        }
        rows, note = left_out(user, [*filter(said.get, said), *self.constraints.named])
        of_joint = {"half_planes", "region"}.intersection(self.constraints.named).difference(rows)
        if said["tool"] and "tool" not in rows and of_joint:
            words = f"{user}: {', '.join(sorted(of_joint))} bound joint C, not the tool"
            note = f"{note}; {words}" if note else words
        names = [*rows, "offset", "ratio"] if "readings" in rows else rows
        return replace(freed(self, names), constraints=freed(self.constraints, rows)), note

    def led(self, path: Any, working: ArrayLike) -> Any:
        """Return the Path or Trajectory of joint C, in the robot's own frame, that leads what draws
        along one in the measuring frame: `Tool.path`, or without a tool joint C itself. Of a file
        that fivebar wrote, the first line says whether its points are so: `for_points_of`.
        """
        if isinstance(path, AtUnitSpeed):
            return self.led(path.path, working).at_unit_speed
        if getattr(path, "tool", None) is not None:
            raise ValueError(
                "this path leads a tool already, in the robot's own frame: give machine.robot"
            )
        machine = self.for_points_of(path)
        if machine.moves_points:
            path = machine.frame.inverse(path)
        robot: Any = self.robot
        if machine.tool is None:
            return path
        return MountedTool(machine.tool, robot, working, machine.frame).led(path)

    def for_points_of(self, path: Any) -> Machine:
        """Return the machine without tool or frame where a path's file says so of its points.

        Raises
        ------
        ValueError
            They are a tool's, or in a measuring frame, and this machine has none.
        """
        origin = getattr(path, "origin", None) or Origin(self.tool is not None, self.moves_points)
        for needed, has, words in (
            (origin.of_tool, self.tool is not None, "of a tool, and this robot has no tool"),
            (origin.measured, self.moves_points, "in a measuring frame, and this robot has none"),
        ):
            if needed and not has:
                raise ValueError(
                    f"the first line of the path's file says that its points are {words}: give a"
                    " robot's file that has it (without --frame robot), or take that line out"
                )
        return replace(
            self,
            tool=self.tool if origin.of_tool else None,
            frame=self.frame if origin.measured else Placement(),
        )

    def joint(self, point: ArrayLike, working: ArrayLike = (-1, -1)) -> np.ndarray:
        """Return where joint C is (2,), m, in the robot's own frame, with what draws at a point of
        the measuring frame.
        """
        xi = self.frame.inverse(point)
        robot: Any = self.robot
        if self.tool is None:
            return xi
        return MountedTool(self.tool, robot, working, self.frame).pose(xi).xi

    def angles(self, readings: ArrayLike) -> np.ndarray:
        """Return the true angles (*batch, 2), rad, at the drives' readings (*batch, 2)."""
        return np.asarray(readings, float) * self.ratio + self.offset

    def readings(self, angles: ArrayLike) -> np.ndarray:
        """Return what the drives read (*batch, 2) at true angles, rad: what to command."""
        return (np.asarray(angles, float) - self.offset) / self.ratio

    def scale(self, unit: str, per_turn: float | None = None) -> float:
        """Return how many of a unit are 1 rad of its drives; of a biglide, how many are 1 m.

        Parameters
        ----------
        unit : "rad", "deg", "turns", "counts", "steps" or "mm"
            Of what a drive, motor or firmware takes; "rad" leaves the readings as they are.
        per_turn : float, optional
            Counts, steps or mm of a turn; the mm of a biglide need none.

        Raises
        ------
        ValueError
            The unit could be two things, or is none of these joints.
        """
        one_of(*UNITS)(unit, "unit")
        slides = unit == "mm" and not self.robot.turns
        known = 1 / METRES["mm"] if slides else UNITS[unit]
        if (per_turn is None) != (known is not None):
            have = "needs per_turn" if per_turn is None else "has no per_turn"
            why = "the joints slide" if slides else "how many are a turn of the motor"
            raise ValueError(f"unit={unit!r} {have}: {why}")
        if unit == "rad":
            return 1.0
        if not (self.robot.turns or slides):
            raise ValueError(
                f"the joints of a biglide slide, they have no angles, of which {unit} is a unit"
            )
        if not self.reads_si:
            way = "m" if slides else "turn"
            count = (1.0 if slides else 2 * math.pi) / self.ratio[0]
            raise ValueError(
                f"the drives read {count:.6g} a {way}, by the ratio of the"
                f" machine: {unit} could be theirs or the motor's; unit rad leaves the readings as"
                f" they are, or give the machine a ratio in {self.robot.words.unit}"
            )
        if known:
            return known
        return positive(per_turn, f"{unit} per turn") / (2 * math.pi)

    def save(
        self, path: TextFile, sd: Mapping[str, float] = {}, comments: tuple[str, ...] = ()
    ) -> None:
        """Write it as TOML, which `load_machine`, `load_robot` and `--robot` read.

        Parameters
        ----------
        path : path or open file
            A .toml file.
        sd : mapping
            Standard deviations of the robot's parameters, for comments beside them.
        comments : tuple of str
            Lines at the top.
        """
        tables: dict[str, Any] = {}
        if self.reads_otherwise:
            tables["readings"] = {"offset": self.offset, "ratio": self.ratio}
        if self.moves_points:
            tables["frame"] = asdict(self.frame)
        kept = self.measured_constraints
        limits: dict[str, Any] = {name: getattr(kept, name) for name in kept.named}
        if "joints" in limits:
            limits["joints"] = [range_ or () for range_ in limits["joints"]]
        if "motors" in limits:
            limits["motors"] = [_given(motor) for motor in limits["motors"]]
        if "collisions" in limits:
            limits["collisions"] = asdict(limits["collisions"])
        if limits:
            tables["constraints"] = limits
        if self.tool is not None:
            tables["tool"] = asdict(self.tool)
        if self.measured:
            tables["measured"] = {"modes": self.measured}
        write_robot(path, self.robot, sd, comments, tables)


def _moved(constraints, placement):
    """Return constraints with half planes and region in another frame; a file has them in the
    measuring frame.
    """
    if placement == Placement():
        return constraints
    planes = []
    for a, b, c in constraints.half_planes:
        on, beyond = placement([(c * a, c * b), (c * a + a, c * b + b)])
        planes.append((*(beyond - on), (beyond - on) @ on))
    region = constraints.region and placement(constraints.region)
    return replace(constraints, half_planes=planes, region=region)


def _signs(modes):
    """Return the working modes and the assembly mode of a measurement, as plain ints."""
    signs = tuple(modes) if isinstance(modes, tuple | list) else ()
    if len(signs) != 3 or not set(signs) <= {-1, 1}:
        raise ValueError(
            "Machine: measured modes must be three signs, +1 or -1: left working, right working,"
            f" assembly, not {shown(modes)}"
        )
    return tuple(map(int, signs))


def _given(motor):
    """Return the values of a motor by name, without those that are 0 or None."""
    return {name: value for name, value in asdict(motor).items() if value}


def load_machine(path: TextFile) -> Machine:
    """Return the machine in a file, or of a name, which `--robot` reads.

    Parameters
    ----------
    path : name, path or open file
        A name in `fivebar.ROBOTS`; or a .toml or .json file: a robot, as `load_robot` reads it, and
        perhaps the tables readings (offset, ratio), frame (shift, turn, scale), constraints (those
        of `Constraints`; a joint without a range has [], half planes and region are in the
        measuring frame), tool (leg, along, across) and measured (modes). Or RepRapFirmware's
        config.g, whose only working mode counts as measured.

    Returns
    -------
    Machine

    Raises
    ------
    ValueError
        For a file that holds no robot, or a table with something else.

    Examples
    --------
    >>> import fivebar as fb
    >>> from pathlib import Path
    >>> from tempfile import mkdtemp
    >>> path = Path(mkdtemp()) / "robot.toml"
    >>> fb.Machine(fb.FiveBar(), offset=(0.01, 0.0)).save(path)
    >>> fb.load_machine(path).offset
    (0.01, 0.0)
    """
    return machine_of(read_robot(path))


def machine_of(read: RobotFile) -> Machine:
    """Return the machine of what a robot's file says; ValueError names the file."""
    try:
        return _machine(read.robot, read.sections)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{read.name}: {error}") from None


def _machine(robot, sections):
    for name, known in KNOWN.items():
        refuse_unknown(f"the table {name}", sections.get(name, {}), known)
    constraints: dict[str, Any] = dict(sections.get("constraints", {}))
    joints = constraints.get("joints")
    if isinstance(joints, list):
        constraints["joints"] = [range_ or None for range_ in joints]
    if "collisions" in constraints:
        links = constraints["collisions"]
        refuse_unknown("the table constraints.collisions", links, _names(LinkCollisions))
        constraints["collisions"] = LinkCollisions(**links)
    frame = Placement(**sections.get("frame", {}))
    limits = _moved(Constraints(**constraints), frame.inverse)
    tool = None
    if "tool" in sections:
        refuse_missing("the table tool", sections["tool"], ["leg"])
        tool = Tool(**sections["tool"])
    readings = sections.get("readings", {})
    return Machine(
        robot,
        frame=frame,
        constraints=limits,
        tool=tool,
        measured=sections.get("measured", {}).get("modes", ()),
        **readings,
    )
