"""A function that asks the grader, in the place of one of the student's own; standard library
only.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator

MOST_TRIES = 3  # at the student's own function, to see in which form it answers
# Forms of vectors and matrices, of which one is meant where the own function shows none.
ARRAYS, COLUMNS, MATRICES = FORMS = range(3)


class StandIn:
    """Called like `own`; gives the right numbers in the form in which own gives its wrong ones.

    ask(row) -> the numbers of each returned name, lists in lists, or None where there is no answer:
    own then says so in its own way, an exception or nan. usual: of FORMS, where own gives none.
    """

    def __init__(self, own: Callable, ask: Callable[[list], list | None], usual: int = ARRAYS):
        self._own, self.ask, self._form, self._tries = own, ask, None, 0
        self._usual = usual

    def __call__(self, *args: object, **named: object) -> object:
        bound = inspect.signature(self._own).bind(*args, **named)
        bound.apply_defaults()
        answer = self.ask(list(bound.args))
        if answer is None:
            return self._own(*args, **named)
        flat = list(_numbers(answer))
        if self._form is None and self._tries < MOST_TRIES:
            self._tries += 1
            self._form = self._found(args, named, len(flat))
        return (
            _usual(answer, self._usual)
            if self._form is None
            else _filled(self._form[0], iter(flat))
        )

    def _found(self, args, named, count):
        """Return (what own gives,) if that has as many numbers, else None."""
        try:
            value = self._own(*args, **named)
            return (value,) if len(list(_numbers(value))) == count else None
        except Exception:
            return None


def _numbers(value) -> Iterator:
    """Yield the numbers of a value, in order. Raises TypeError where it holds something else."""
    if isinstance(value, tuple | list):
        for part in value:
            yield from _numbers(part)
    elif (numpy := sys.modules.get("numpy")) and isinstance(value, numpy.ndarray):
        yield from numpy.asarray(value).ravel()
    else:
        yield float(value)


def _filled(form, numbers):
    """Return the form with these numbers in it."""
    if isinstance(form, tuple | list):
        parts = [_filled(part, numbers) for part in form]
        return type(form)(*parts) if hasattr(form, "_fields") else type(form)(parts)
    numpy = sys.modules.get("numpy")
    if numpy and isinstance(form, numpy.ndarray):
        return (
            numpy.array([next(numbers) for _ in range(form.size)], float)
            .reshape(form.shape)
            .view(type(form))
        )
    return next(numbers)


def _usual(answer, form):
    """As the statements ask for it: floats and arrays of this form, one alone in no tuple."""
    parts = tuple(_array(part, form) if isinstance(part, list) else part for part in answer)
    return parts if len(parts) > 1 else parts[0]


def _array(part, form):
    numpy = sys.modules.get("numpy")
    if not numpy:
        return part
    if form != ARRAYS and not isinstance(part[0], list):
        part = [[number] for number in part]
    return numpy.matrix(part) if form == MATRICES else numpy.array(part)
