"""What a chart is: problems, methods with their knob, and panels."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from matplotlib.figure import Figure

    from .store import Result

OURS = "fivebar"  # the family that the captions compare with all others
LIMIT = "the limit"  # the family of what nobody would write by hand for every model


class Failed(Exception):
    """The result of a method does not count; the message stands on the chart."""


@dataclass(frozen=True)
class Attempt:
    """A method ready to run on a problem.

    Parameters
    ----------
    call : () -> result; this is timed
    judge : result -> {measure: value}; raises Failed
    per : units of work in a call, by which its time is divided
    times : () -> (n,) s, where the call measures its own times
    """

    call: Callable[[], Any]
    judge: Callable[[Any], dict[str, float]]
    per: int = 1
    times: Callable[[], np.ndarray] | None = None


@dataclass(frozen=True)
class Method:
    """A way to solve the problems of a chart.

    Parameters
    ----------
    name : on the chart
    family : methods of one colour
    prepare : (problem, knob) -> Attempt
    knobs : numbers, or {problem: numbers} for the problems that it is tried on
    needs : functions () -> None or what this machine lacks; then the method is left out
    order : of convergence in the knob, where it has one
    """

    name: str
    family: str
    prepare: Callable[[str, Any], Attempt]
    knobs: tuple | dict[str, tuple] = (0,)
    needs: tuple[Callable[[], str | None], ...] = ()
    order: int | None = None

    def knobs_of(self, problem: str, quick: bool) -> tuple[float, ...]:
        """Return the knobs; in a quick run every other one, the first among them."""
        knobs = self.knobs.get(problem, ()) if isinstance(self.knobs, dict) else self.knobs
        chosen = knobs[::2] if quick else knobs
        return tuple(knob if isinstance(knob, int) else float(knob) for knob in chosen)


@dataclass(frozen=True)
class Panel:
    """One pair of axes: the measures x and y of a problem by all methods.

    `levels` are values of y to which the caption compares the times. Below 100 times `rounding`
    an error has no order. An error of 0 is drawn at `floor`; one above `ceiling` is a failure.
    `guide` is (factor, words): the line y = factor x.
    """

    problem: str
    title: str
    y: str = "error"
    ylabel: str = "error"
    x: str = "seconds"
    xlabel: str = "time of one run (s)"
    levels: tuple[float, ...] = ()
    rounding: float = 1e-15
    floor: float = 1e-17
    ceiling: float = float("inf")
    guide: tuple[float, str] | None = None


@dataclass(frozen=True)
class Chart:
    """A chart: its name and title, how to read it, problems {name: words}, methods, rows of panels.

    `step` maps a knob to the step in which the methods that have an order converge. The caption
    does not compare the families in `excluded`. `figure` and `summary` replace the usual ones of
    `picture` and `findings`. `limit` is for one attempt with all its repeats, s.
    """

    name: str
    title: str
    reading: str
    problems: dict[str, str]
    methods: tuple[Method, ...]
    panels: tuple[tuple[Panel, ...], ...]
    step: Callable[[float], float] = float
    excluded: tuple[str, ...] = (LIMIT,)
    figure: Callable[[Result], Figure] | None = None
    summary: Callable[[Result], tuple] | None = None
    limit: float = 60.0

    def jobs(self, quick: bool) -> list[tuple[str, Method, float]]:
        """Return (problem, method, knob) of all attempts, in the order in which they are made."""
        return [
            (problem, method, knob)
            for problem in self.problems
            for method in self.methods
            for knob in method.knobs_of(problem, quick)
        ]

    def method(self, name: str) -> Method:
        """Return the method of this name."""
        return next(method for method in self.methods if method.name == name)

    @property
    def all_panels(self) -> list[Panel]:
        """The panels, row by row."""
        return [panel for row in self.panels for panel in row]


def load(module: str) -> Chart:
    """Return the Chart that a module declares."""
    return import_module(module).chart()
