"""Checks a student's functions in a process of their own and says which misconception they fell
for.
"""

from .exercise import Exercise, Misconception
from .grade import check
from .judging.judge import Verdict, judge
from .worker.live import from_functions
from .worker.places import bwrap_trouble
from .worker.replies import Reply
from .worker.sandbox import IsolationError
from .worker.student import Student
from .worker.submission import Submission, SubmissionError, read_submission

__all__ = [
    "Exercise",
    "IsolationError",
    "Misconception",
    "Reply",
    "Student",
    "Submission",
    "SubmissionError",
    "Verdict",
    "bwrap_trouble",
    "check",
    "from_functions",
    "judge",
    "read_submission",
]
