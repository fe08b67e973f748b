"""What a chart is: problems, methods with their knob, and panels. Declared here, run and drawn
elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from ...base.errors import UsageError
from ..chart_names import CHARTS

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np

MODULES = {name: f"{__package__}.charts.{module}" for name, (module, _) in CHARTS.items()}


class Failed(Exception):
    """A method gave a result that does not count; the message is the word for it on the chart."""


@dataclass(frozen=True)
class Attempt:
    """A method made ready: call () -> result is what is timed; judge (result) -> {measure: value},
    or raises Failed.

    per: units of work in a call, by which its time is divided; times: () -> (n,) s where the call
        has measured its own.
    """

    call: Callable[[], object]
    judge: Callable[[object], dict[str, float]]
    per: int = 1
    times: Callable[[], np.ndarray] | None = None


@dataclass(frozen=True)
class Method:
    """A way to solve the chart's problems: prepare (problem, knob) -> Attempt, run for each knob of
    each problem.

    knobs: (number, ...), or {problem: (number, ...)} for those that it is tried on. family: methods
        of one colour;
    needs: keys of `machine.NEEDED` without which it is left out; order: of convergence in the knob,
        where it has one.
    """

    name: str
    family: str
    prepare: Callable[[str, float], Attempt]
    knobs: tuple | dict[str, tuple] = (0,)
    needs: tuple[str, ...] = ()
    order: int | None = None

    def knobs_of(self, problem: str, quick: bool) -> tuple[float, ...]:
        """The knobs, in a quick run every other one, the first among them."""
        knobs = self.knobs.get(problem, ()) if isinstance(self.knobs, dict) else self.knobs
        return tuple(
            k if isinstance(k, int) else float(k) for k in (knobs[::2] if quick else knobs)
        )


@dataclass(frozen=True)
class Panel:
    """One pair of axes: a problem's measures x and y by all methods.

    levels: values of y at which the caption compares the times; rounding: below 100 of it an error
        has no order.
    """

    problem: str
    title: str
    y: str = "error"
    ylabel: str = "error"
    x: str = "seconds"
    xlabel: str = "time of one run (s)"
    levels: tuple[float, ...] = ()
    rounding: float = 1e-15
    floor: float = 1e-17  # an error of 0 is drawn here
    ceiling: float = float("inf")  # a larger error counts as a failure
    guide: tuple | None = None  # (factor, words): the line y = factor x


OURS = "fivebar"  # the family that the captions compare with all others
LIMIT = "the limit"  # the family of what nobody would write by hand for every model


@dataclass(frozen=True)
class Chart:
    """A chart: its name; title, a sentence; how to read it; problems {name: words}; methods; rows
    of panels.
    """

    name: str
    title: str
    reading: str
    problems: dict[str, str]
    methods: tuple[Method, ...]
    panels: tuple  # of rows, tuples of Panel
    step: Callable[[float], float] | None = (
        None  # knob -> step, in which the methods that have an order converge
    )
    apart: tuple = (LIMIT,)  # families that the caption compares apart from the others
    picture: str | None = (
        None  # module with figure(result) and caption(result) where the usual ones do not fit
    )
    limit: float = 60.0  # s, for one attempt with all its repeats

    def jobs(self, quick: bool) -> list[tuple[str, Method, float]]:
        """(problem, method, knob) of all attempts, in the order in which they are made."""
        return [
            (p, m, knob)
            for p in self.problems
            for m in self.methods
            for knob in m.knobs_of(p, quick)
        ]

    def method(self, name: str) -> Method:
        return next(m for m in self.methods if m.name == name)


def module_of(name: str) -> str:
    """The module of a chart; UsageError, with the known ones, for a name that is none."""
    if name not in MODULES:
        raise UsageError(f"no chart {name!r}; the known ones are {', '.join(MODULES)}, and all")
    return MODULES[name]


def load(module: str) -> Chart:
    """The Chart that a module declares."""
    return import_module(module).chart()
