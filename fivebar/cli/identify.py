"""`fivebar identify`: masses and friction of a robot, from logs of its motion and torques."""

from __future__ import annotations

import json
from argparse import _SubParsersAction
from pathlib import Path

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot

GAUGES = {
    "counts-per-turn": ("N", "of an encoder, where q is in counts"),
    "gear-ratio": ("R", "turns of the motor for one of the joint"),
    "offset": ("RAD", "of the joint beyond the encoder's zero"),
    "torque-constant": ("NM", "of the motor for a unit of tau"),
}


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `identify` to the program's commands."""
    parser = commands.add_parser("identify")
    add = parser.add_argument
    add(
        "logs",
        nargs="+",
        metavar="LOG.csv",
        help="columns t, q1, q2, tau1, tau2, perhaps q1_dot, ...",
    )
    add("--validate", metavar="LOG.csv", help="a second run, whose torques are only predicted")
    add(
        "--out",
        type=Path,
        metavar="DIR",
        help="write robot.toml, identification.json and torques.png there",
    )
    add("--json", action="store_true", help="values, deviations and sentences as JSON on stdout")
    add("--unknown", nargs="+", metavar="NAME", help="identify only these (default: all)")
    add(
        "--assembly",
        type=int,
        choices=(-1, 1),
        default=-1,
        help="of the logs, throughout (default: %(default)s)",
    )
    add(
        "--cutoff",
        type=float,
        metavar="HZ",
        help="of the filters (default: where the motion ends in noise)",
    )
    add("--consistent", action="store_true", help="only what bodies can have")
    group = parser.add_argument_group("what was logged", "one number for both motors, or two")
    group.add_argument(
        "--units",
        nargs="+",
        default=[],
        metavar="NAME=UNIT",
        help="of columns without one, as q1=deg",
    )
    for name, (metavar, text) in GAUGES.items():
        group.add_argument(f"--{name}", nargs="+", type=float, metavar=metavar, help=text)
    add_robot_options(parser)
    parser.set_defaults(run=_identify)


def _identify(arguments):
    from ..estimation.identification.identify import identify

    robot = chosen_robot(arguments)
    for path in [*arguments.logs, arguments.validate]:
        if path is not None and not Path(path).exists():
            raise UsageError(f"no file {path!r}")
    found = identify(
        robot,
        arguments.logs,
        validate=arguments.validate,
        unknown=arguments.unknown,
        assembly=arguments.assembly,
        cutoff=arguments.cutoff,
        consistent=arguments.consistent,
        units=_units(arguments.units),
        **_gauges(arguments),
    )
    files = []
    if folder := arguments.out:
        folder.mkdir(parents=True, exist_ok=True)
        names = "robot.toml", "identification.json", "torques.png"
        files = [folder / name for name in names]
        for write, file in zip((found.to_toml, found.to_json, found.plot), files):
            write(file)
    if arguments.json:
        print(json.dumps({**found.table, "files": [str(file) for file in files]}, indent=2))
    else:
        print(found, *files, sep="\n")


def _gauges(arguments):
    options = {}
    for option in GAUGES:
        name = option.replace("-", "_")
        numbers = getattr(arguments, name)
        if numbers is None:
            continue
        if len(numbers) > 2:
            raise UsageError(f"--{option} takes one number or two, not {len(numbers)}")
        options[name] = numbers[0] if len(numbers) == 1 else tuple(numbers)
    return options


def _units(words):
    for word in words:
        if not word.partition("=")[2]:
            raise UsageError(f"--units: {word!r} must be NAME=UNIT, as q1=deg")
    return dict(word.split("=", 1) for word in words)
