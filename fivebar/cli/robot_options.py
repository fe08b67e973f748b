"""The robot on the command line: a named set, a TOML or JSON file, single values."""

import sys
from argparse import SUPPRESS
from dataclasses import fields, replace
from pathlib import Path
from warnings import catch_warnings, simplefilter

from ..base.errors import UsageError
from ..models.named_robots import ROBOTS
from ..models.parameter_units import parameter_in_si
from ..models.robot_files import READERS
from ..models.robots import KINDS
from .options import add_options, usage_errors, used_options

DEFAULT = "amoro"
PARAMETERS = tuple(dict.fromkeys(field.name for kind in KINDS for field in fields(kind)))


def add_robot_options(parser):
    """Add --robot, --gravity and an option for each parameter."""
    single = [name for name in PARAMETERS if name != "gravity"]
    group = parser.add_argument_group(
        "robot",
        "a set or a file; over it go single values, each by its name, as --l11 0.1 or --l11 80mm"
        " (m, kg, kg m², kg m, friction in N m s/rad and N m): " + ", ".join(single),
    )
    known = ", ".join(ROBOTS)
    options = {
        "--robot ROBOT": (DEFAULT, f"one of {known}, or a .toml or .json file of parameters"),
        "--gravity M/S2 M/S2": "along x and y; 0 -9.81: upright",
    }
    add_options(group, options)
    for name in single:  # 40 lines of names without a word would bury all others
        group.add_argument(f"--{name}", help=SUPPRESS)


def robot_is_chosen(arguments):
    """Return whether any of the options was used."""
    return arguments.robot != DEFAULT or bool(used_options(arguments, *PARAMETERS))


def chosen_robot(arguments):
    """Return the robot of these arguments, of which a command without a tool moves joint C."""
    return machine_without_tool(arguments).robot


def machine_without_tool(arguments):
    """Return the Machine of these arguments; say that a tool of it is left out."""
    machine = chosen_machine(arguments)
    if machine.tool is not None:
        words = "this command leaves out its tool: points are those of joint C"
        print(f"{arguments.robot}: {words}", file=sys.stderr)
    return machine


def chosen_machine(arguments):
    """Return the Machine of these arguments: its robot, and what its file says beside it."""
    from ..paths.machine import machine_of

    values = used_options(arguments, *PARAMETERS)
    with usage_errors(ValueError):
        if arguments.robot in ROBOTS:
            named = ROBOTS[arguments.robot]
            machine = machine_of(named.robot, named.tables)
        else:
            machine = machine_from(arguments.robot)
        robot = machine.robot
        known = [field.name for field in fields(robot)]
        for name in values:
            if name not in known:
                title, names = robot.words.title, ", ".join(known)
                raise UsageError(f"--{name}: {arguments.robot} is a {title}, with {names}")
            if name != "gravity":
                values[name] = parameter_in_si(values[name], name, robot.turns)
        with catch_warnings():
            simplefilter("ignore")  # of unusual lengths, whose unit was written
            return replace(machine, robot=replace(robot, **values))


def machine_from(path):
    """Return the Machine in a TOML or JSON file."""
    from ..paths.machine import machine_and_defaults

    if Path(path).suffix.lower() not in READERS:
        known = ", ".join(ROBOTS)
        raise UsageError(f"no robot {path!r}: the known ones are {known}; or a .toml or .json file")
    with usage_errors(OSError, ValueError):
        machine, defaults = machine_and_defaults(path)
    if defaults:
        title, values = machine.robot.words.title, ", ".join(defaults)
        print(f"{path}: not in it, so as usual of a {title}: {values}", file=sys.stderr)
    return machine
