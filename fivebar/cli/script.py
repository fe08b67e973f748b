"""`fivebar run`: a script of the AMORO lab on the simulated robot, in a process of its own."""

import argparse
import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from ..base.checks import number, positive, whole
from ..base.errors import UsageError
from .options import add_options

# The package's own folder may not be on the child's path; it is put last, where it shadows nothing.
CHILD = "import sys; sys.path.append({!r}); from fivebar.amoro.ros_free.child import main; main()"
# Before all else the child waits for the end of a pipe, so that it ends when this process does.
WATCH = (
    "import os, threading; "
    "threading.Thread(target=lambda: os.read({}, 1) or os._exit(1), daemon=True).start(); "
)
BACKEND = "module://fivebar.amoro.ros_free.figures"
MOST_SEED = 2**32 - 1
MOST_TIME = 10_000.0  # s: more than a GB of rows


def add_parsers(commands):
    """Add `run` to the program's commands."""
    options = argparse.ArgumentParser(prog="fivebar run", add_help=False, allow_abbrev=False)
    add_options(options, OPTIONS)
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
    run.set_defaults(run=lambda arguments: _run(arguments, options), parser=run)


OPTIONS = {
    "--until S": (5.0, "simulated time at which the script gets its KeyboardInterrupt"),
    "--record OUT.csv": "write the motion to a CSV file, a row each millisecond",
    "--bag OUT": "write the motion to a new folder, a bag of ROS 2 for PlotJuggler and Foxglove",
    "--plot OUT.png": "draw the motion",
    "--animate OUT.html": "write the motion as a 3-D page (.html), or .gif, .mp4, .webm",
    "--plots DIR": (".", "folder for the script's own windows and scopes"),
    "--show": "open windows in place of writing them to files",
    "--real-time": "not faster than real time; the script's clock is the computer's",
    "--seed N": (0, "of random and numpy.random"),
    "--exact-acceleration": (
        "joint accelerations of the dynamics, not velocity differences over 10 ms as in the lab"
    ),
    "--mark 1|2": (
        "the tracking error in the lab's control task of this number, as points; the script is"
        " confined, and may be a folder of hand-ins"
    ),
    "--lenient": "let arrays of one element pass for numbers, as older NumPy did",
    "--timeout S": (60.0, "wall time that the script may take without a step"),
    "--json": "the figures as JSON on stdout; what the script prints goes to stderr",
}


def _run(arguments, options):
    cut = [*arguments.rest, "--"].index("--")
    own, rest = arguments.rest[:cut], arguments.rest[cut + 1 :]
    arguments, unknown = options.parse_known_args(own, namespace=arguments)
    _check(arguments)
    if arguments.mark:
        from .mark import mark

        return mark(arguments, [*unknown, *rest])
    settings = json.dumps(vars(arguments), default=str)
    environment = {**os.environ, "PYTHONHASHSEED": str(arguments.seed)}
    if not arguments.show:
        environment["MPLBACKEND"] = BACKEND
    start = CHILD.format(str(Path(__file__).parents[2]))
    ends = ()
    if os.name == "posix":  # elsewhere a child gets no descriptors
        ends = os.pipe()[:1]  # this process never closes the other end
        start = WATCH.format(*ends) + start
    command = [sys.executable, "-P", "-c", start, settings, arguments.script, *unknown, *rest]
    child = subprocess.Popen(command, env=environment, pass_fds=ends)
    code = None
    while code is None:
        with suppress(KeyboardInterrupt):  # the child got it too, and it is the script's
            code = child.wait()
    if code < 0:
        raise RuntimeError(f"{arguments.script} was ended by signal {-code}")
    sys.exit(code)


def _check(arguments):
    script = Path(arguments.script)
    if not (script.is_file() or arguments.mark and script.is_dir()):
        raise UsageError(f"no script {arguments.script!r}")
    number(arguments.until, "until", 0.0, MOST_TIME, above=True)
    positive(arguments.timeout, "timeout")
    whole(0, MOST_SEED)(arguments.seed, "seed")
    if not arguments.plots.is_dir():
        raise UsageError(f"--plots {arguments.plots}: no such folder")
