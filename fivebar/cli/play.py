"""`fivebar play`: the live page of a five-bar as a file, a folder for the web, or served here."""

from __future__ import annotations

from pathlib import Path

from ..base.errors import SingularityError, UsageError
from .options import WORKING, add_command, print_message, print_table, usage_errors
from .robot_options import add_robot_options, chosen_machine, in_robot_frame

OPTIONS = {
    "--out PAGE.html": (Path("play.html"), "the page"),
    "--xi X Y": "where joint C begins, or the tool of the robot's file, m",
    WORKING: "modes there (default: -1 -1)",
    "--site DIR": "write a folder for any web host instead: the page, its preview, social tags",
    "--address URL": "where the folder of --site will be, for the preview of its links",
    "--serve": "serve the page on this computer instead, until Ctrl C",
    "--link": 'print what follows the address, "#...", on stdout',
}


def add_parsers(commands):
    """Add `play` to the program's commands."""
    add_robot_options(add_command(commands, "play", _play, (OPTIONS,)))


def _play(arguments):
    from ..models.geometry import igm
    from ..visualization.play import play

    if arguments.working and not arguments.xi:
        raise UsageError("--working goes with --xi X Y")
    machine = chosen_machine(arguments)
    robot = machine.robot
    with usage_errors(ValueError, SingularityError):
        working = tuple(arguments.working or (-1, -1))
        xi = arguments.xi and machine.joint(arguments.xi, working)
        pose = None if xi is None else igm(robot, xi, working)
        live = play(robot, pose, tool=machine.tool)
    if robot.fs1 or robot.fs2:
        print_message("fivebar: dry friction (fs1, fs2) is left out on the page")
    print_table(in_robot_frame(machine, "the page"))
    if machine.tool is not None:
        print_table([("loci of the page", "those of joint C, not of the tool")])
    for path in _written(live, arguments):
        print(path)
    if arguments.link:
        print(live.fragment)
    if arguments.serve:
        _serve(live)


def _written(live, arguments):
    from ..visualization.play.site import save_site

    if arguments.address and not arguments.site:
        raise UsageError("--address is the address of a folder: give --site DIR, too")
    if arguments.site:
        return save_site(live, arguments.site, arguments.address or "")
    if arguments.serve:
        return []
    live.save(arguments.out)
    return [arguments.out]


def _serve(live):
    from ..visualization.play.site import server

    with server(live) as served:
        print(f"http://127.0.0.1:{served.server_port}/", flush=True)
        print_message("fivebar: serving the page until Ctrl C")
        try:
            served.serve_forever()
        except KeyboardInterrupt:
            pass
