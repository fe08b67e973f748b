"""A script's traceback as `python3 script.py` would print it: without the frames of the runtime."""

import os
import sys
from pathlib import Path
from types import TracebackType

HERE = str(Path(__file__).parent)
PACKAGE, STANDARD = Path(__file__).resolve().parents[2], Path(os.__file__).resolve().parent


def print_exception(error):
    """Print it by sys.excepthook, with the traceback of the script alone."""
    without_runtime(error)
    sys.excepthook(type(error), error, error.__traceback__)


def without_runtime(error, seen=()):
    """Take the runtime's frames out of the traceback, and out of those of its causes."""
    if error is None or error in seen:
        return
    error.__traceback__ = _cleaned(error.__traceback__)
    for other in (error.__cause__, error.__context__):
        without_runtime(other, (*seen, error))


def _cleaned(traceback):
    kept = [
        step for step in _steps(traceback) if not step.tb_frame.f_code.co_filename.startswith(HERE)
    ]
    result = None
    for step in reversed(kept):
        result = TracebackType(result, step.tb_frame, step.tb_lasti, step.tb_lineno)
    return result


def _steps(traceback):
    while traceback is not None:
        yield traceback
        traceback = traceback.tb_next


def is_users(file):
    """Return whether this source file is the user's: not Python's, not installed, not this
    package's.
    """
    path = Path(file).resolve()
    foreign = (
        STANDARD in path.parents
        or PACKAGE in path.parents
        or {"site-packages", "dist-packages"} & {*path.parts}
    )
    return path.suffix == ".py" and not foreign


def last_place(error):
    """Return (frame, line) of the last step in a file of the user's, or None."""
    places = [(step.tb_frame, step.tb_lineno) for step in _steps(error.__traceback__)]
    return next(
        (place for place in reversed(places) if is_users(place[0].f_code.co_filename)), None
    )
