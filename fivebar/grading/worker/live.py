"""Functions of the user's own session in the place of a submission: at home, where nobody need be
kept out.
"""

from __future__ import annotations

import json
import linecache
import sys
from collections.abc import Callable

import numpy as np

from .cell.answers import call
from .cell.stand_in import ARRAYS, StandIn
from .replies import Reply
from .wire import reply


def from_functions(**functions: Callable) -> Live:
    """Return a Live student of the functions of a notebook or a script: `from_functions(dgm=dgm,
    igm=my_igm)`.
    """
    return Live(functions)


class Live:
    """Answers like a Student, in this process: without limits, without isolation. Ctrl-C ends
    it.
    """

    trouble, output, notes = None, "", ()
    form = ARRAYS  # as in Student

    def __init__(self, functions: dict[str, Callable]):
        strange = [name for name, function in functions.items() if not callable(function)]
        if strange:
            raise TypeError(
                f"{strange[0]} is a {type(functions[strange[0]]).__name__}, not a function"
            )
        self._functions = functions
        self.names = tuple(functions)
        self.outline: dict = {}  # what calls what is not looked up in a session
        scopes = [getattr(function, "__globals__", {}) for function in functions.values()]
        self.constants = {
            name: float(value)
            for scope in scopes
            for name, value in scope.items()
            if _is_number(value)
        }

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        """Do nothing: there is no process."""

    def ask(
        self,
        function: str,
        rows: list,
        constants: dict | None = None,
        limit: float | None = None,
        given: dict[str, Callable] | None = None,
    ) -> list[Reply]:
        """Return a Reply for each row of `function(*row)`; constants: its module's globals, set for
        this ask and put back.

        given: as in `Student.ask`, and put back as well.
        """
        if function not in self._functions:
            return [Reply("missing", text=f"no function {function}")] * len(rows)
        called = self._functions[function]
        space, constants = getattr(called, "__globals__", {}), constants or {}
        absent = sorted(set(constants) - {name for name in space if _is_number(space[name])})
        if absent:
            return [
                Reply("missing", text=f"the session has no constant {', '.join(absent)}")
            ] * len(rows)
        set_ = constants | {
            k: StandIn(space[k], right, self.form)
            for k, right in (given or {}).items()
            if callable(space.get(k))
        }
        kept = {name: space[name] for name in set_}
        space.update(set_)
        try:
            return [_reply(called, row) for row in rows]
        finally:
            space.update(kept)


def _is_number(value):
    """Return whether it is a plain number that a float can hold."""
    return type(value) in (int, float, np.float64) and abs(value) <= sys.float_info.max


def _reply(function, row):
    file = function.__code__.co_filename if hasattr(function, "__code__") else ""
    answer = call(function, row, file)
    if answer["k"] == "exception" and answer["t"].startswith("KeyboardInterrupt"):
        raise KeyboardInterrupt
    return reply(
        json.loads(json.dumps(answer)), [line.rstrip("\n") for line in linecache.getlines(file)]
    )
