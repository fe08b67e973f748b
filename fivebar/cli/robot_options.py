"""The robot on the command line: a named set, a TOML or JSON file, single values."""

import sys
from argparse import SUPPRESS
from dataclasses import fields, replace

from ..base.errors import UsageError
from ..models.named_robots import ROBOTS
from ..models.parameters import robot_of
from ..models.robots import KINDS

DEFAULT = "amoro"
LAB = tuple(dict.fromkeys(f.name for kind in KINDS for f in fields(kind)[: kind.lab]))
BEYOND = tuple(f.name for kind in KINDS for f in fields(kind)[kind.lab :])
PARAMETERS = tuple(dict.fromkeys((*LAB, *BEYOND)))
LONG = 20.0  # m: hardly a robot's or a linkage's, but likely in mm


def add_robot_options(parser):
    group = parser.add_argument_group(
        "robot",
        "a set or a file; over it go single values, each by its name, as --l11 0.1, in m, kg m² and"
        " kg: " + ", ".join(LAB),
    )
    group.add_argument(
        "--robot",
        default=DEFAULT,
        metavar="NAME|FILE",
        help=(
            f"one of {', '.join(ROBOTS)}, or a .toml or .json file: parameters by name, or lengths"
            " and links"
        ),
    )
    for name in LAB:  # 24 lines of names without a word would bury all others
        group.add_argument(f"--{name}", type=float, help=SUPPRESS)
    group = parser.add_argument_group(
        "a robot of more than the lab's parameters",
        "likewise, first moments in kg m, friction in N m s/rad (fv) and N m (fs): "
        + ", ".join(name for name in PARAMETERS[len(LAB) :] if name != "gravity"),
    )
    for name in PARAMETERS[len(LAB) :]:
        if name == "gravity":
            group.add_argument(
                "--gravity", type=float, nargs=2, metavar=("X", "Y"), help="m/s²; 0 -9.81: upright"
            )
        else:
            group.add_argument(f"--{name}", type=float, help=SUPPRESS)


def robot_is_chosen(arguments):
    """Whether any of the options was used."""
    return arguments.robot != DEFAULT or any(
        getattr(arguments, name) is not None for name in PARAMETERS
    )


def chosen_robot(arguments):
    given = {
        name: getattr(arguments, name)
        for name in PARAMETERS
        if getattr(arguments, name) is not None
    }
    try:
        robot = (
            ROBOTS[arguments.robot].robot
            if arguments.robot in ROBOTS
            else robot_from(arguments.robot)
        )
        own = [f.name for f in fields(robot)]
        if foreign := [f"--{name}" for name in given if name not in own]:
            raise UsageError(
                f"{', '.join(foreign)}: --robot {arguments.robot} is a {robot.words.title}, with"
                f" {', '.join(own)}"
            )
        robot = replace(robot, **given)
        ask_for_mm(max(getattr(robot, name) for name in own if name[0] in "ld"))
        return robot
    except ValueError as error:
        raise UsageError(error) from None


def robot_from(path):
    import json
    import tomllib

    readers = {".toml": tomllib.load, ".json": json.load}
    read = next((reader for end, reader in readers.items() if path.endswith(end)), None)
    if read is None:
        raise UsageError(
            f"no robot {path!r}: the known ones are {', '.join(ROBOTS)}; or name a file that ends"
            " in .toml or .json"
        )
    try:
        with open(path, "rb") as file:
            table = read(file)
    except OSError as error:
        raise UsageError(error) from None
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: {error}") from None
    try:
        robot = robot_of(table)
    except (ValueError, TypeError) as error:
        raise UsageError(f"{path}: {error}") from None
    own = () if "links" in table else fields(robot)[: robot.lab]
    if taken := [f"{f.name} = {f.default:g}" for f in own if f.name not in table]:
        print(
            f"{path}: not in it, so as usual of a {robot.words.title}: {', '.join(taken)}",
            file=sys.stderr,
        )
    return robot


def ask_for_mm(longest):
    """Say it where the longest length looks as if it were in mm."""
    if longest > LONG:
        print(
            f"fivebar: lengths are in m, the longest {longest:g} m: were they meant in mm?",
            file=sys.stderr,
        )
