"""Checks a student's functions in a process of their own and says which misconception they fell for."""

from .exercise import Exercise, Misconception
from .judge import Verdict, judge
from .replies import Reply

__all__ = ["Exercise", "Misconception", "Reply", "Verdict", "judge"]
