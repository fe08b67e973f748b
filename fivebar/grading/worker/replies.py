"""What a worker process says about one call of a student's function: a claim, judged by others."""

from __future__ import annotations

from dataclasses import dataclass, field

KINDS = {
    "value": "returned a value",
    "exception": "raised an exception",
    "missing": "is not defined",
    "import": "was lost when the file failed",
    "timeout": "ran past its time limit",
    "unasked": "was not asked",
    "memory": "ran out of memory",
    "exit": "left the program",
    "killed": "was killed by a signal",
    "flood": "sent more than an answer can hold",
    "garbled": "sent something that is no answer",
}


@dataclass(frozen=True)
class Reply:
    """One call's outcome: its kind (of KINDS), the decoded value, and for a failure what happened
    and where.

    line, source: number and text of the last line of the student's own file that ran; seconds: of
        processor time; visits, beside: what a watched program showed, as `visits_of` and
        `beside_of` read it.
    """

    kind: str
    value: object = None
    text: str = ""
    line: int | None = None
    source: str = ""
    seconds: float = 0.0
    visits: dict[int, list] = field(default_factory=dict)
    beside: list[dict] = field(default_factory=list)

    @property
    def words(self) -> str:
        """What happened instead of a value."""
        return f"{KINDS[self.kind]}{': ' + self.text if self.text else ''}"
