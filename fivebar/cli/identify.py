"""`fivebar identify`: masses and friction of the robot on the table, from logs of its motion and
torques.
"""

from __future__ import annotations

import json
from argparse import _SubParsersAction
from pathlib import Path

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `identify` to the program's commands."""
    parser = commands.add_parser("identify")
    parser.add_argument(
        "logs",
        nargs="+",
        metavar="LOG.csv",
        help="columns t, q1, q2, tau1, tau2, perhaps q1_dot, ...",
    )
    parser.add_argument(
        "--validate",
        metavar="LOG.csv",
        help="a second run, of which the torques are only predicted",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write robot.toml, identification.json and torques.png there",
    )
    parser.add_argument(
        "--json", action="store_true", help="values, deviations and sentences as JSON on stdout"
    )
    parser.add_argument(
        "--unknown", nargs="+", metavar="NAME", help="of these parameters only (default: all)"
    )
    parser.add_argument(
        "--assembly",
        type=int,
        choices=(-1, 1),
        default=-1,
        help="of the logs, throughout (default: %(default)s)",
    )
    parser.add_argument(
        "--cutoff",
        type=float,
        metavar="HZ",
        help="of the filters (default: where the motion ends in noise)",
    )
    parser.add_argument("--consistent", action="store_true", help="only what bodies can have")
    gauges = parser.add_argument_group("what was logged", "one number for both motors, or two")
    gauges.add_argument(
        "--units",
        nargs="+",
        default=[],
        metavar="NAME=UNIT",
        help="of columns without one, as q1=deg",
    )
    gauges.add_argument(
        "--counts-per-turn",
        nargs="+",
        type=float,
        metavar="N",
        help="of an encoder, where q is in counts",
    )
    gauges.add_argument(
        "--gear-ratio",
        nargs="+",
        type=float,
        metavar="R",
        help="turns of the motor for one of the joint",
    )
    gauges.add_argument(
        "--offset",
        nargs="+",
        type=float,
        metavar="RAD",
        help="of the joint beyond the encoder's zero",
    )
    gauges.add_argument(
        "--torque-constant",
        nargs="+",
        type=float,
        metavar="NM",
        help="of the motor for a unit of tau",
    )
    add_robot_options(parser)
    parser.set_defaults(run=_identify)


def _identify(arguments):
    from ..estimation.identification.identify import identify

    robot = chosen_robot(arguments)
    gauges = {
        name: _both(getattr(arguments, name), name)
        for name in ("counts_per_turn", "gear_ratio", "offset", "torque_constant")
    }
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
        **{name: value for name, value in gauges.items() if value is not None},
    )
    files = []
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        files = [
            arguments.out / name for name in ("robot.toml", "identification.json", "torques.png")
        ]
        for write, file in zip((found.to_toml, found.to_json, found.plot), files):
            write(file)
    if arguments.json:
        print(json.dumps({**found.table, "files": list(map(str, files))}, indent=2))
        return
    print(found)
    print(*files, sep="\n", end="\n" if files else "")


def _both(given, name):
    if given is None:
        return None
    if len(given) > 2:
        raise UsageError(f"--{name.replace('_', '-')} takes one number or two, not {len(given)}")
    return given[0] if len(given) == 1 else tuple(given)


def _units(given):
    pairs = [word.partition("=") for word in given]
    if wrong := [name for name, _, unit in pairs if not unit]:
        raise UsageError(f"--units: {wrong[0]!r} must be NAME=UNIT, as q1=deg")
    return {name: unit for name, _, unit in pairs}
