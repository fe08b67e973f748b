"""What a second question tells of wrong answers: that they change from call to call."""

from __future__ import annotations

from ..exercise import Misconception
from ..worker.replies import Reply

CHANGES = Misconception(
    "another answer to the same question, asked again",
    "What does your function keep from call to call (a global, a list that grows, an argument that"
    " it changes), or draw at random?",
    None,
    idle=True,
)


def changing(first: list[Reply], again: list[Reply]) -> bool:
    """Return whether any of the values given to the same questions is another one the
    second time.
    """
    pairs = [(a.value, b.value) for a, b in zip(first, again) if a.kind == b.kind == "value"]
    return any(repr(a) != repr(b) for a, b in pairs)
