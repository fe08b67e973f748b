"""`fivebar export`: the robot as a file of a simulator, or as C for a chip."""

from __future__ import annotations

import sys
from argparse import _SubParsersAction

from ..base.errors import SingularityError
from .options import add_options, usage_errors, used_options
from .robot_options import add_robot_options, chosen_robot

OPTIONS = {
    "--out FILE": "(default: stdout)",
    "--name NAME": "of the model; in C what all names begin with (default: fivebar or biglide)",
    "--start Q1 Q2": "the pose that is shown",
    "--assembly -1|1": (-1, "of that pose"),
    "--step S": "the simulator's (default: 0.001)",
    "--closure constraint|joint": "of SDF: for Drake (default) or for Gazebo",
    "--functions NAME ...": "of C (default: all); a wrong name lists them",
}


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `export` to the program's commands."""
    parser = commands.add_parser("export")
    formats = "mjcf", "urdf", "sdf", "c"
    words = "c is one header: models and a controller"
    parser.add_argument("--format", choices=formats, required=True, help=words)
    add_options(parser, OPTIONS)
    add_robot_options(parser)
    parser.set_defaults(run=_export)


def _export(arguments):
    from ..exporters.export import export
    from ..models.geometry import dgm

    robot = chosen_robot(arguments)
    options = used_options(arguments, "step", "closure", "functions", "name")
    with usage_errors(ValueError, SingularityError):
        if arguments.start:
            options["start"] = dgm(robot, arguments.start, arguments.assembly)
        text = export(robot, arguments.format, arguments.out, **options)
    sys.stdout.write(f"{arguments.out}\n" if arguments.out else text)
