"""`fivebar export`: the robot as a file of a simulator, or as C for a chip."""

from __future__ import annotations

import sys
from argparse import _SubParsersAction
from pathlib import Path

from ..base.errors import SingularityError, UnreachableError, UsageError
from .robot_options import add_robot_options, chosen_robot

FORMATS = "mjcf", "urdf", "sdf", "c"


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `export` to the program's commands."""
    parser = commands.add_parser("export")
    parser.add_argument(
        "--format", choices=FORMATS, required=True, help="c is one header: models and a controller"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="(default: stdout)")
    parser.add_argument(
        "--name", help="of the model; in C what all names begin with (default: fivebar or biglide)"
    )
    parser.add_argument(
        "--start", nargs=2, type=float, metavar=("Q1", "Q2"), help="the pose that is shown"
    )
    parser.add_argument(
        "--assembly",
        type=int,
        choices=(-1, 1),
        default=-1,
        help="of that pose (default: %(default)s)",
    )
    parser.add_argument("--step", type=float, metavar="S", help="the simulator's (default: 0.001)")
    parser.add_argument(
        "--closure",
        choices=("constraint", "joint"),
        help="of SDF: for Drake (default) or for Gazebo",
    )
    parser.add_argument(
        "--functions",
        nargs="+",
        metavar="NAME",
        help="of C (default: all); a wrong name lists them",
    )
    add_robot_options(parser)
    parser.set_defaults(run=_export)


def _export(arguments):
    from ..exporters.export import export
    from ..models.geometry import dgm

    robot = chosen_robot(arguments)
    try:
        start = dgm(robot, arguments.start, arguments.assembly) if arguments.start else None
    except (ValueError, UnreachableError, SingularityError) as error:
        raise UsageError(f"--start: {error}") from None
    options = {name: getattr(arguments, name) for name in ("step", "closure", "functions", "name")}
    try:
        found = export(robot, arguments.format, arguments.out, start=start, **options)
    except ValueError as error:
        raise UsageError(error) from None
    sys.stdout.write(f"{arguments.out}\n" if arguments.out else found)
