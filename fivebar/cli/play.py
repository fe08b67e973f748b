"""`fivebar play`: the live page of a five-bar as a file."""

from __future__ import annotations

import sys
from argparse import _SubParsersAction
from pathlib import Path

from ..base.errors import SingularityError, UnreachableError, UsageError
from .robot_options import add_robot_options, chosen_robot


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `play` to the program's commands."""
    parser = commands.add_parser("play")
    parser.add_argument(
        "--out", type=Path, default=Path("play.html"), metavar="FILE", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--xi", nargs=2, type=float, metavar=("X", "Y"), help="where the end-effector begins, m"
    )
    parser.add_argument(
        "--working",
        nargs=2,
        type=int,
        choices=(-1, 1),
        default=(-1, -1),
        help="modes there (default: -1 -1)",
    )
    parser.add_argument(
        "--link", action="store_true", help='print what follows the address, "#...", on stdout'
    )
    add_robot_options(parser)
    parser.set_defaults(run=_play)


def _play(arguments):
    from ..models.geometry import igm
    from ..visualization.play import play

    robot = chosen_robot(arguments)
    if not robot.turns:
        raise UsageError(
            "play shows five-bars; of a biglide: fivebar map --robot biglide --page map.html"
        )
    if arguments.out.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"--out must end in .html, not {arguments.out.name!r}")
    try:
        pose = igm(robot, arguments.xi, tuple(arguments.working)) if arguments.xi else None
        live = play(robot, pose)
    except (ValueError, UnreachableError, SingularityError) as error:
        raise UsageError(f"--xi: {error}") from None
    live.save(arguments.out)
    if robot.fs1 or robot.fs2:
        print("fivebar: dry friction (fs1, fs2) is left out on the page", file=sys.stderr)
    print(arguments.out)
    if arguments.link:
        print(live.fragment)
