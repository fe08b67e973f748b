"""What the models raise when a pose does not exist or a model has no answer there."""

from __future__ import annotations


class UnreachableError(ValueError):
    """No pose closes the mechanism; `gap` is by how many metres, `index` where in a batch (None for
    one pose).
    """

    def __init__(self, message: str, gap: float, index: tuple | None = None):
        super().__init__(message)
        self.gap = gap
        self.index = index


class SingularityError(ArithmeticError):
    """The model asked for has no answer at a singular pose; `margin` is the singular quantity,
    `index` as above.
    """

    def __init__(self, message: str, margin: float, index: tuple | None = None):
        super().__init__(message)
        self.margin = margin
        self.index = index


class UsageError(Exception):
    """What the user typed on the command line, or a file named there, cannot be used."""
