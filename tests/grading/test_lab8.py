"""Lab 8: measured points of a robot of one's own are handed out, and who calibrates it gets full marks."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from tests.helpers import DATA
from tests.helpers.lab_session import FOLDERS, SOLUTIONS, load, results

RIGHT = (SOLUTIONS / "lab8.py").read_text("utf-8")
UNKNOWN = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")


def calibrated(path):
    found = fb.calibrate(fb.FiveBar(), path, UNKNOWN, sigma=2e-5)
    assert found.fits and found.rank == 7 and max(found.sd[name] for name in UNKNOWN[:5]) < 2.5e-5
    return tuple(found.values[name] for name in UNKNOWN[:5])


def test_the_points_in_the_lab_are_those_of_the_standard_robot():
    truth = load("lab8", "exercises").as_built(fb.FiveBar())
    assert np.abs(np.array(calibrated(FOLDERS["lab8"] / "measured.csv")) - truth[:5]).max() < 1e-4


@pytest.mark.deep
def test_hand_out_calibrate_and_grade(tmp_path, capsys):
    ids, secret, out = tmp_path / "ids.txt", tmp_path / "secret", tmp_path / "handout"
    ids.write_text("anna\nbob\n", encoding="utf-8")
    secret.write_text("a long secret", encoding="utf-8")
    options = ["--secret-file", str(secret)]
    assert main(["grade", "lab8", "--hand-out", str(ids), *options, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert printed.count("student.py") == printed.count("measured.csv") == 2
    assert (out / "anna/student.py").read_text("utf-8") == (
        FOLDERS["lab8"] / "student.py"
    ).read_text("utf-8")
    found = {name: calibrated(out / name / "measured.csv") for name in ("anna", "bob")}
    assert np.abs(np.subtract(found["anna"], found["bob"])).max() > 2e-4
    typed = RIGHT.replace("return best[1][:5]", f"return {found['anna']}")
    for source, points in ((RIGHT, "20 of 20"), (typed, "16 of 20")):
        hand_in = tmp_path / "anna.py"
        hand_in.write_text(source, encoding="utf-8")
        assert main(["grade", "lab8", str(hand_in), *options]) == 0
        told = capsys.readouterr().out
        assert (
            f"total {points} points" in told and "robot of this file" not in told
        )  # nothing gives lengths away


@pytest.mark.deep
def test_task_5_asks_for_the_wrong_point_and_for_no_numbers():
    """To calibrate with all points is not enough, in nearly all draws; its own numbers typed in never are."""
    lab = load("lab8", "exercises")
    off = []
    for seed in range(40):
        draw = np.random.default_rng(seed)
        truth = lab.as_drawn(draw)
        rows = lab.rows_of(truth, draw, 30, 2e-5)
        rows[draw.integers(30), 2:] += 0.01 * np.array([0.6, 0.8])
        space: dict = {}
        exec(RIGHT, space)
        found = space["calibrate"](rows[:, :2].tolist(), rows[:, 2:].tolist())
        off.append(np.abs(np.array(found[:5]) - truth[:5]).max())
    assert np.mean(np.array(off) > 1e-4) >= 0.95


@pytest.mark.every(2)
@pytest.mark.parametrize(
    ("function", "old", "new", "words"),
    [
        (
            "own_robot",
            "return best[1][:5]",
            "return 0.09, 0.09, 0.09, 0.09, 0.118",
            "these are the numbers of the drawing",
        ),
        (
            "own_robot",
            "return best[1][:5]",
            "return [v + 2e-4 for v in best[1][:5]]",
            "is off by 0.2",
        ),
        ("own_robot", "return best[1][:5]", "return best[1][:4]", "4 values where 5"),
        ("own_robot", "return best[1][:5]", "return [float('nan')] * 5", "nan"),
        ("own_robot", "if best is None or size < best[0]", "if best is None", "one that is right"),
        ("calibrate", "range(12)", "range(1)", "is off by"),
        ("calibrate", "range(12)", "range(2)", "enough of them"),
        ("calibrate", "range(12)", "range(0)", "these are the numbers of the drawing"),
        ("calibrate", "return tuple(p)", "return None", "return missing"),
    ],
)
def test_what_falls_short_is_said(function, old, new, words):
    assert RIGHT.count(old) == 1
    found = results("lab8", RIGHT.replace(old, new), only=function)
    assert any(words in verdict.text for _, verdict in found.values()), [
        verdict.text for _, verdict in found.values()
    ]


LARGEST = """    p = calibrate(q, xi)
    e = [max(map(abs, misses(*p, *a, *b))) for a, b in zip(q, xi)]
    for k in [e.index(max(e))]:"""


@pytest.mark.parametrize("points", ["range(len(q) - 1)", "range(1, len(q))"])
def test_who_leaves_out_the_largest_error_or_never_one_of_the_points_is_wrong(points):
    """As the paper warns: the point with the largest error need not be the wrong one."""
    loop = "    for k in range(len(q)):"
    assert RIGHT.count(loop) == 1
    for seed in range(2):
        for wrong in (LARGEST, f"    for k in {points}:"):
            found = results("lab8", RIGHT.replace(loop, wrong), seed=seed, only="own_robot")
            assert sorted(verdict.share for _, verdict in found.values()) == [0.0, 1.0]


OWN = """

def own_robot(q, xi):
    q, xi = np.asarray(q), np.asarray(xi)
    best = None
    for k in range(len(q)):
        keep = np.arange(len(q)) != k
        p = calibrate(q[keep].tolist(), xi[keep].tolist())
        cost = np.sum(rows(p, q[keep], xi[keep])[0] ** 2)
        if best is None or cost < best[1]:
            best = p, cost
    return tuple(best[0][:5])
"""
RETURNED = "    p, _ = fit(q, xi)\n    return tuple(p)\n"


@pytest.mark.every(3)
@pytest.mark.parametrize(
    ("returned", "points"),
    [
        (RETURNED, 20),
        # Two mistakes that no single change mends: own_robot is judged with the right calibrate.
        ("    p, _ = fit(q[:-4], xi[:-4])\n    return p[1], p[0], 1.01 * p[2], *p[3:]\n", 14),
        # Numbers that do not depend on what was measured are no calibration.
        ("    return 0.09, 0.09, 0.09, 0.09, 0.118, 0.0, 0.0\n", 10),
    ],
    ids=["right", "wrong", "constant"],
)
def test_own_robot_does_not_pay_for_a_wrong_calibrate(tmp_path, returned, points):
    source = (DATA / "hand_ins/fresh/lab8_gauss.py").read_text("utf-8")
    source = source[: source.index("\n\ndef own_robot")] + OWN
    path = tmp_path / "student.py"
    path.write_text(source.replace(RETURNED, returned), "utf-8")
    assert grade(find_lab("lab8"), Job(path)).points == points
