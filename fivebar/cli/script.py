"""`fivebar run`: a script of the AMORO lab on the simulated robot, in a process of its own."""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

from ..base.errors import UsageError

# The package's own folder may not be on the child's path; it is put last, where it shadows nothing.
CHILD = "import sys; sys.path.append({!r}); from fivebar.amoro.ros_free.child import main; main()"
BACKEND = "module://fivebar.amoro.ros_free.figures"
ENDINGS = {"plot": (".png", ".svg", ".pdf"), "animate": (".html", ".gif", ".mp4", ".webm", ".png")}
MOST_SEED = 2**32 - 1
MOST_TIME = 10_000.0  # s: more than a GB of rows


def add_parsers(commands):
    """Add `run` to the program's commands."""
    options = _options()
    run = commands.add_parser(
        "run",
        parents=[options],
        allow_abbrev=False,
        description=(
            "Run a script written for the AMORO lab's ROS class as `python3 SCRIPT ARGS` would, on"
            " the simulated five-bar or biglide. Options may stand before or after the script; what"
            " follows -- is the script's."
        ),
    )
    run.add_argument("script", metavar="SCRIPT")
    run.add_argument("rest", nargs=argparse.REMAINDER, metavar="ARGS", help="of the script")
    run.set_defaults(run=lambda arguments: _run(arguments, options))


def _options():
    options = argparse.ArgumentParser(prog="fivebar run", add_help=False, allow_abbrev=False)
    add = options.add_argument
    add(
        "--until",
        type=float,
        default=5.0,
        metavar="S",
        help="simulated time at which the script gets its KeyboardInterrupt (default: %(default)g)",
    )
    add("--record", metavar="RUN.csv", help="write the motion, a row each millisecond")
    add("--plot", metavar="OUT.png", help="draw the motion")
    add(
        "--animate", metavar="OUT.html", help="write the motion as a 3-D page, or .gif, .mp4, .webm"
    )
    add(
        "--plots",
        default=".",
        metavar="DIR",
        help="folder for the script's own windows and scopes (default: here)",
    )
    add("--show", action="store_true", help="open windows in place of writing them to files")
    add(
        "--real-time",
        action="store_true",
        help="not faster than real time; the script's clock is the computer's",
    )
    add("--seed", type=int, default=0, help="of random and numpy.random (default: %(default)s)")
    add(
        "--exact-acceleration",
        dest="exact",
        action="store_true",
        help=(
            "joint accelerations of the dynamics, not velocity differences over 10 ms as in the lab"
        ),
    )
    add(
        "--mark",
        choices=("1", "2"),
        help="the tracking error in the lab's control task of this number, as points",
    )
    add(
        "--lenient",
        action="store_true",
        help="let arrays of one element pass for numbers, as older NumPy did",
    )
    add(
        "--timeout",
        type=float,
        default=60.0,
        metavar="S",
        help="wall time that the script may take without a step (default: %(default)g)",
    )
    add(
        "--json",
        action="store_true",
        help="the figures as JSON on stdout; what the script prints goes to stderr",
    )
    return options


def _run(arguments, options):
    own, rest = _split(arguments.rest)
    arguments, unknown = options.parse_known_args(own, namespace=arguments)
    _check(arguments)
    names = [action.dest for action in options._actions]
    settings = json.dumps({name: getattr(arguments, name) for name in names})
    environment = {**os.environ, "PYTHONHASHSEED": str(arguments.seed)}
    if not arguments.show:
        environment["MPLBACKEND"] = BACKEND
    start = CHILD.format(str(Path(__file__).parents[2]))
    command = [sys.executable, "-P", "-c", start, settings, arguments.script, *unknown, *rest]
    child = subprocess.Popen(command, env=environment)
    while True:
        try:
            code = child.wait()
            break
        except KeyboardInterrupt:  # the child got it too, and it is the script's
            continue
    if code < 0:
        raise RuntimeError(f"{arguments.script} was ended by signal {-code}")
    sys.exit(code)


def _split(rest):
    """What stands before the first -- and after it."""
    if "--" not in rest:
        return rest, []
    cut = rest.index("--")
    return rest[:cut], rest[cut + 1 :]


def _check(arguments):
    if not Path(arguments.script).is_file():
        raise UsageError(f"no script {arguments.script!r}")
    for name in ("until", "timeout"):
        if not 0 < getattr(arguments, name) < float("inf"):
            raise UsageError(f"--{name} must be finite and > 0, not {getattr(arguments, name):g}")
    if arguments.until > MOST_TIME:
        raise UsageError(
            f"--until {arguments.until:g} is more rows, one each millisecond, than memory holds: at"
            f" most {MOST_TIME:g} s"
        )
    if not 0 <= arguments.seed <= MOST_SEED:
        raise UsageError(f"--seed must be from 0 to {MOST_SEED}, not {arguments.seed}")
    for name in ("record", "plot", "animate"):
        path = getattr(arguments, name)
        if path is not None and not Path(path).parent.is_dir():
            raise UsageError(f"--{name} {path}: no such folder")
        if path is not None and Path(path).is_dir():
            raise UsageError(f"--{name} {path} is a folder, not a file")
        if path is not None and name in ENDINGS and Path(path).suffix.lower() not in ENDINGS[name]:
            raise UsageError(
                f"--{name} must end in one of {', '.join(ENDINGS[name])}, not {path!r}"
            )
    if not Path(arguments.plots).is_dir():
        raise UsageError(f"--plots {arguments.plots}: no such folder")
