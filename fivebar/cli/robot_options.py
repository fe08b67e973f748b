"""The robot on the command line: a named set, a TOML or JSON file, single values."""

from argparse import SUPPRESS
from dataclasses import fields, replace
from warnings import catch_warnings, simplefilter

from ..base.errors import UsageError
from ..base.robot_uses import uses
from ..models.named_robots import ROBOTS
from ..models.parameter_units import parameter_in_si
from ..models.parameters import refuse_unknown, with_values
from ..models.robot_files import read_robot
from ..models.robots import KINDS
from .options import add_options, print_notes, print_table, usage_errors, used_options

DEFAULT = "amoro"
FRAMES = {
    "measuring": "in the measuring frame of the robot's file; --frame robot: in the robot's own",
    "robot": "in the robot's own frame",
}
LIMITS = {  # option: constraint
    "motor": "motors",
    "torque_limit": "torque",
    "speed_limit": "speed",
    "joint_speed_limit": "joint_speed",
    "acceleration_limit": "acceleration",
    "serial_margin": "sin",
    "parallel_margin": "det_A",
}
PARAMETERS = tuple(dict.fromkeys(field.name for kind in KINDS for field in fields(kind)))


def add_robot_options(parser):
    """Add --robot, --gravity, an option for each parameter, and --frame where points are used; say
    in the help what of a robot's file is used.
    """
    single = [name for name in PARAMETERS if name != "gravity"]
    group = parser.add_argument_group(
        "robot",
        "a set or a file; over it go single values, each by its name, as --l11 0.1 or --l11 80mm"
        " (m, kg, kg m², kg m, friction in N m s/rad and N m): " + ", ".join(single),
    )
    known = ", ".join(ROBOTS)
    options = {
        "--robot ROBOT": (
            DEFAULT,
            f"one of {known}, or a .toml, .json or config.g file of parameters",
        ),
        "--gravity M/S2 M/S2": "along x and y; 0 -9.81: upright",
    }
    command = parser.prog.split()[-1]
    of_command = {user: use for user, use in uses()[1].items() if user.split()[0] == command}
    if any("frame" in use.used for use in of_command.values()):
        words = "of points: that of the file's [frame], or the robot's own"
        options["--frame measuring|robot"] = ("measuring", words)
    add_options(group, options)
    parser.epilog = "\n".join(use.words(user) for user, use in of_command.items())
    for name in single:  # 40 lines of names without a word would bury all others
        group.add_argument(f"--{name}", help=SUPPRESS)


def print_frames(arguments, machine, *files):
    """Print in which frame points are, and which files are in another one."""
    print_table([*arguments.frame_row, *in_robot_frame(machine, *files)])


def peak_row(robot, figures):
    """Return the row of output of both motors' largest torques or forces."""
    from ..simulation.comparison import peak_name

    peaks = ", ".join(f"{1e3 * peak:.3f}" for peak in figures[peak_name(robot)])
    return f"peak {robot.words.effort}", f"{peaks} m{robot.words.effort_unit}"


def in_robot_frame(machine, *files):
    """Return the row of output that names files in the robot's own frame, where its file has
    another one.
    """
    names = ", ".join(map(str, files))
    return [("robot's own frame", names)] if machine.moves_points and names else []


def machine_for(arguments, machine, file, path):
    """Return the machine for the points of a path's file; say where that file's first line names
    other points than the machine's own.
    """
    with usage_errors(ValueError):
        found = machine.for_points_of(path)
    if found != machine:
        arguments.frame = "measuring" if found.moves_points else "robot"
        where, _, _ = FRAMES[arguments.frame].partition(";")
        whose = f"of {'joint C' if found.tool is None else 'the tool'}, {where}"
        arguments.frame_row = [("points", whose)]
        print_notes(file, [f"its points are {whose}, as its first line says"])
    return found


def refuse_angles(arguments, machine, counts_per_turn=None):
    """Raise UsageError where setpoints of this machine cannot have the unit of --angles."""
    try:
        machine.scale(arguments.angles, counts_per_turn)
    except ValueError as error:
        raise UsageError(f"leave out --angles {arguments.angles}: {error}") from None


def chosen_limits(arguments):
    """Return {constraint: value} of the options of LIMITS that were used."""
    return {LIMITS[option]: value for option, value in used_options(arguments, *LIMITS).items()}


def chosen_machine(arguments, user=""):
    """Return the Machine of these arguments, without what the command leaves out, which is said.

    user: the name in the table of uses, where it is not the command's alone. `arguments.frame_row`
    gets the row of output that says in which frame points are, where the file has one.
    """
    from ..paths.machine import machine_of
    from ..paths.placement import Placement

    values = used_options(arguments, *PARAMETERS)
    with usage_errors(ValueError, OSError):
        read = read_robot(arguments.robot)
        machine = machine_of(read)
        robot = machine.robot
        title = robot.words.title
        refuse_unknown(f"a {title}", values, [field.name for field in fields(robot)])
        for name in values:
            if name != "gravity":
                values[name] = parameter_in_si(values[name], name, robot.turns)
        with catch_warnings():
            simplefilter("ignore")  # of unusual lengths, whose unit was written
            machine = replace(machine, robot=with_values(robot, values))
        user = user or arguments.command
        built, note = machine.used_by(user)
    frame = getattr(arguments, "frame", None)
    arguments.frame_row = [("points", FRAMES[frame])] if built.moves_points and frame else []
    if frame == "robot":
        built = replace(built, frame=Placement())
    has_masses = "masses" in uses()[1][user].used
    usual = ", ".join(each for each in read.defaults if has_masses or each[0] in "ld")
    notes = [note, usual and f"not in it, so as usual of a {title}: {usual}"]
    print_notes(arguments.robot, filter(None, notes))
    return built
