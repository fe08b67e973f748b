"""The command line: data on stdout, messages on stderr; exit 0 done, 1 the work failed, 2 wrong
usage, 130 interrupted.

Nothing that takes time is imported before `main` begins, which answers Ctrl-C.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module

from ..base.errors import UsageError

# Command -> (the file that has it, read when it is asked for, what it does).
COMMANDS = {
    "demo": ("track", "the AMORO lab's control task 1: table, CSV, picture, animation, page"),
    "track": ("track", "track a path; or compare controllers on one of the shipped cases"),
    "plan": ("plan", "plan an optimal motion between points or modes, through singularities too"),
    "draw": (
        "draw",
        "draw an SVG, G-code or CSV with the simulated robot: place, time, track, tables",
    ),
    "map": ("map", "singularity map: exact loci, a margin's field, aspects"),
    "linkage": ("linkage", "four-bars and other linkages: what turns, what locks; motion studies"),
    "play": ("play", "a live page: drag the robot, slide its bars, watch the singularities move"),
    "chart": ("chart", "speed against accuracy: measure methods, and draw their charts"),
    "calibrate": (
        "calibrate",
        "a robot as built: lengths and offsets from measurements, and what these cannot tell",
    ),
    "study": ("study", "which physics is worth its cost, measured here"),
    "certify": (
        "certify",
        "prove that a path is reached and keeps its margin, for all robots within tolerances",
    ),
    "identify": ("identify", "masses and friction of a robot, from logs of its motion and torques"),
    "export": ("export", "the robot as MJCF, URDF, SDF, or as C99 for a microcontroller"),
    "sweep": ("sweep", "figures of merit of many designs, on this machine or a Dask cluster"),
    "design": ("design", "the best robot for a task, or the Pareto front of two or three goals"),
    "run": ("script", "run a script of the AMORO lab without ROS"),
    "check": ("grade", "check your own solution of a lab, with hints"),
    "grade": ("grade", "grade a submission, or a folder of them, on hidden inputs"),
}
ERRNO = re.compile(r"\[Errno -?\d+\] ([^:]+): (['\"])(.*?)\2")  # as Python words an OSError
# At the start of an error, perhaps after its class: the argument that it is about.
ARGUMENT = re.compile(r"(?:[\w ]+: (?=\w+ must ))?(\w+)(?= must | is no option |: |\[)")
KEYWORD = re.compile(r"\b(\w+)=(?:\.\.\.|radius)")  # in an error: what is to be given
COLUMNS = re.compile(r"say which they are, by columns= or --columns .*")
INTERRUPTED = 128 + signal.SIGINT  # as a shell names the end by Ctrl-C
NEGATIVE = re.compile(r"-(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?( *[a-zµ°].*)?$", re.IGNORECASE)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; gives its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    for name, mode in {"stdin": "r", "stdout": "w", "stderr": "w"}.items():
        # A closed stream would give its number to the next file that is opened.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))
    # A locale without ² or µ is no reason to fail.
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            return _run(words)
        finally:
            _flush()
    except UsageError as error:
        return _complain(error, 2)
    except BrokenPipeError:  # whoever read the output has read enough
        return 1
    except (ValueError, ArithmeticError, OSError, MemoryError, RuntimeError, ImportError) as error:
        return _complain(error, 1)
    except KeyboardInterrupt as interrupt:
        return _complain(str(interrupt) or "interrupted", INTERRUPTED)
    finally:
        if argv is None:  # The interpreter ends: it would answer Ctrl-C with a traceback.
            signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run(words):
    parser = _parser(words[0] if words else "")
    if not words:
        parser.print_help()
        return 2
    arguments = parser.parse_args(words)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = partial(_show_warning, warnings.showwarning)
            arguments.run(arguments)
    except (TypeError, ValueError, UsageError) as error:
        raise _by_option(error, arguments) from None
    return 0


def _show_warning(usual, message, category, *where):
    """Write what the program warns of as a plain line; Python's own warnings as usual."""
    if category is UserWarning:
        _write(str(message))
    else:
        usual(message, category, *where)


def _by_option(error, arguments):
    """Return the error of a used option where it names an argument of Python; else the error."""
    text = KEYWORD.sub(r"--\1", str(error))
    if "--columns" not in arguments.parser.format_usage():
        text = COLUMNS.sub("write these names into its header", text)
    if found := ARGUMENT.match(text):
        option = "--" + found[1].replace("_", "-")
        is_used = vars(arguments).get(found[1]) not in (None, [])
        if is_used and option in arguments.parser.format_usage():
            text = option + text[found.end() :]
    return error if text == str(error) else UsageError(text)


def _flush():
    """Write what was printed while its failure can still be said: at the interpreter's end it is a
    strange message.
    """
    for name in ("stderr", "stdout"):
        stream = getattr(sys, name)
        try:
            stream.flush()
        except OSError as error:
            with open(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), stream.fileno())  # else the interpreter tries again
            if name == "stdout":
                raise OSError(error.errno, error.strerror, name) from None


def _complain(error, code):
    text = ERRNO.sub(r"\3: \1", " ".join(str(error).split()))
    with suppress(OSError):  # nobody hears it
        try:
            _write(text)
        finally:
            _flush()
    return code


def _write(text):
    """Write a line of this program to stderr; it may quote a file's hostile name."""
    if not text.isprintable():
        # NumPy, which this brings, cannot be imported after Ctrl-C in its own import.
        from ..base.representation import printable

        text = printable(text)
    print("fivebar: " + text, file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    """Knows -1e-3 as a number, and shows the usage of the command whose option is unknown."""

    def __init__(self, *arguments, **settings):
        super().__init__(*arguments, **settings)
        self._negative_number_matcher = NEGATIVE

    def parse_args(self, args=None, namespace=None):
        arguments, unknown = self.parse_known_args(args, namespace)
        if unknown:
            getattr(arguments, "parser", self).error(f"unrecognized arguments: {' '.join(unknown)}")
        return arguments


def _parser(asked):
    from importlib.metadata import version

    parser = _Parser(
        prog="fivebar", description="The five-bar parallel robot: models, control, singularities."
    )
    parser.add_argument("--version", action="version", version=f"fivebar {version('fivebar')}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    if asked in COMMANDS:
        import_module(f".{COMMANDS[asked][0]}", __package__).add_parsers(commands)
        for name, parser_of in commands.choices.items():
            words = COMMANDS[name][1]
            parser_of.description = parser_of.description or f"{words[0].upper()}{words[1:]}."
    else:
        for name, (_, words) in COMMANDS.items():
            commands.add_parser(name, help=words)
    return parser
