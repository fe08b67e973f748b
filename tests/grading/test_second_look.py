"""What a second question tells: typed numbers, answers that change, factors that other masses tell apart."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading import Exercise, Reply, check
from fivebar.grading.second_look import changing, typed

OWN, OTHER = fb.FiveBar(), fb.FiveBar(0.1, 0.11, 0.12, 0.13, 0.14, 0.003, 0.004, 0.7)
Q = np.linspace(-1, 1, 9)
EXERCISE = Exercise("f(q) -> x", lambda robot, q: robot.l11 * np.cos(q) + robot.d * robot.m)


@pytest.mark.parametrize(
    "names, told",
    [
        (["l11"], "l11 of your own"),
        (["d"], "d of your own"),
        (["l11", "m"], "l11 and m of"),
        (["l11", "d", "m"], "l11, d and m of"),
    ],
)
def test_the_fewest_typed_numbers_that_explain_all_are_named(names, told):
    mixed = replace(OTHER, **{name: getattr(OWN, name) for name in names})
    replies = [Reply("value", float(x)) for x in EXERCISE.answer(mixed, Q)]
    assert typed(EXERCISE, OTHER, OWN, (Q,), replies, np.full(9, 1e-9)).name.startswith(told)
    replies[3] = Reply("value", 0.5)
    assert typed(EXERCISE, OTHER, OWN, (Q,), replies, np.full(9, 1e-9)) is None


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
]
"""
CHECKS = """
def test_pull(ask, draw):
    ask("pull", draw.uniform(-1, 1, 12))

def test_count(ask, draw):
    ask("count", draw.uniform(-1, 1, 12))
"""


@pytest.mark.parametrize(
    "pull, name", [("2 * m * cos(q)", "f is 2 times the right one"), ("cos(q)", "mass forgotten")]
)
def test_what_other_masses_or_the_same_question_refute_is_not_named(tmp_path, pull, name):
    (tmp_path / "weights").mkdir()
    (tmp_path / "weights/exercises.py").write_text(EXERCISES, encoding="utf-8")
    (tmp_path / "weights/test_lab.py").write_text(CHECKS, encoding="utf-8")
    space = {"calls": []}
    exec(
        f"from math import cos\nm = 0.5\ndef pull(q): return {pull}\n"
        "def count(q): calls.append(q); return len(calls)",
        space,
    )
    found = check("weights", labs=tmp_path, pull=space["pull"], count=space["count"]).checks
    assert found[0].misconception.startswith(name)
    assert found[1].misconception == "another answer to the same question, asked again"
