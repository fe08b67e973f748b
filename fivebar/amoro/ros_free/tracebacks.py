"""A script's traceback as `python3 script.py` would print it: without the frames of the runtime."""

import sys
from pathlib import Path
from types import TracebackType

HERE = str(Path(__file__).parent)


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
    kept = [step for step in _steps(traceback) if not step.tb_frame.f_code.co_filename.startswith(HERE)]
    result = None
    for step in reversed(kept):
        result = TracebackType(result, step.tb_frame, step.tb_lasti, step.tb_lineno)
    return result


def _steps(traceback):
    while traceback is not None:
        yield traceback
        traceback = traceback.tb_next


def last_place(error, folder):
    """(frame, line) of the last step in a file of this folder, or None."""
    places = [
        (step.tb_frame, step.tb_lineno)
        for step in _steps(error.__traceback__)
        if Path(step.tb_frame.f_code.co_filename).resolve().parent == folder
    ]
    return places[-1] if places else None
