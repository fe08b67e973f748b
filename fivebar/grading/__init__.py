"""Checks a student's functions in a process of their own and says which misconception they fell for."""

from .exercise import Exercise, Misconception
from .judge import Verdict, judge
from .replies import Reply

__all__ = ["Exercise", "Misconception", "Reply", "Verdict", "check", "judge"]


def __getattr__(name):
    if name == "check":
        from .grade import check

        return check
    raise AttributeError(f"module 'fivebar.grading' has no attribute {name!r}")
