"""Errors of the models, and of what a user typed."""

from __future__ import annotations

import sys
import warnings


class UnreachableError(ValueError):
    """No pose closes the mechanism.

    Parameters
    ----------
    message : str
    gap : float
        By how many metres it does not close.
    index : tuple of int or None
        Place of the first such pose in a batch; None for one pose.

    Examples
    --------
    >>> import fivebar as fb
    >>> try:
    ...     fb.igm(fb.FiveBar(), (1.0, 0.0))
    ... except fb.UnreachableError as error:
    ...     round(error.gap, 3)
    0.879
    """

    def __init__(self, message: str, gap: float, index: tuple | None = None):
        super().__init__(message)
        self.gap = gap
        self.index = index


class SingularityError(ArithmeticError):
    """A model has no answer at a singular pose.

    Parameters
    ----------
    message : str
    margin : float
        The singular quantity.
    index : tuple of int or None
        Place of the first such pose in a batch; None for one pose.

    Examples
    --------
    >>> import fivebar as fb
    >>> fb.SingularityError("the distal bars are in line", 0.0).margin
    0.0
    """

    def __init__(self, message: str, margin: float, index: tuple | None = None):
        super().__init__(message)
        self.margin = margin
        self.index = index


def warn(words: str, category: type[Warning] = UserWarning) -> None:
    """Warn at the line outside this package that called it, by however many of its functions."""
    frame = sys._getframe(1)
    level = 2
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "fivebar":
        frame = frame.f_back
        level += 1
    warnings.warn(words, category, stacklevel=level)


class UsageError(Exception):
    """What the user typed on the command line, or a file named there, cannot be used."""
