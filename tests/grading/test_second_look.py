"""What a second question tells: answers that change."""

import pytest

from fivebar.grading import Reply, check
from fivebar.grading.judging.questions import changing


def test_only_values_can_change():
    a, b, lost = (
        Reply("value", [1.0, 2.0]),
        Reply("value", [1.0, 2.5]),
        Reply("exception", text="ValueError"),
    )
    assert (
        changing([a, a], [a, b])
        and not changing([a, lost], [a, b])
        and not changing([a, a], [a, lost])
    )


EXERCISES = """
import numpy as np
from fivebar.grading import Exercise, Misconception

EXERCISES = [
    Exercise("pull(q) -> f", lambda robot, q: robot.m * np.cos(q), wrong=(
        Misconception("mass forgotten", "Which unit has f?", lambda robot, q: np.cos(q)),)),
    Exercise("count(q) -> n", lambda robot, q: q),
    Exercise("both(q) -> a, b", lambda robot, q: (q, -q)),
]
"""
NAMES = "pull", "count", "both"
CHECKS = """
def test_pull(ask, draw):
    ask("pull", draw.uniform(-1, 1, 12))

def test_count(ask, draw):
    ask("count", draw.uniform(-1, 1, 12))

def test_both(ask, draw):
    ask("both", draw.uniform(-1, 1, 12))
"""


@pytest.mark.parametrize("pull, name", [("m * cos(q) + q", ""), ("cos(q)", "mass forgotten")])
def test_what_the_same_question_refutes_is_not_named(tmp_path, pull, name):
    (tmp_path / "weights").mkdir()
    (tmp_path / "weights/exercises.py").write_text(EXERCISES, encoding="utf-8")
    (tmp_path / "weights/test_lab.py").write_text(CHECKS, encoding="utf-8")
    space = {"calls": [], "grown": []}
    exec(
        f"from math import cos\nm = 0.5\ndef pull(q): return {pull}\n"
        "def count(q): calls.append(q); return len(calls)\n"
        "def both(q): grown.extend([q, -q]); return grown",
        space,
    )
    found = check("weights", labs=tmp_path, **{name: space[name] for name in NAMES}).checks
    assert found[0].misconception == name or name == ""
    changing = "another answer to the same question, asked again"
    assert found[1].misconception == found[2].misconception == changing
