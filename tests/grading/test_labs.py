"""The labs are honest: right solutions of any form earn all, empty ones nothing, and each mistake is named."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from fivebar.grading.intake.students_robots import robot_for
from fivebar.grading.labs import find_lab
from tests.helpers.hand_ins import HandIn, graded
from tests.helpers.lab_session import FOLDERS, LABS, SOLUTIONS, load, mistakes, results, score

FORMS = [(lab, path) for lab in FOLDERS for path in sorted(SOLUTIONS.glob(f"**/{lab}.py"))]
CHECKS = {lab: vars(load(lab, "test_lab")) for lab in FOLDERS}


def points(lab):
    """{title: points} of a lab's checks."""
    tests = [test for name, test in CHECKS[lab].items() if name.startswith("test_")]
    return {test.__doc__: test.pytestmark[0].args[0] for test in tests}


def test_there_are_eight_labs_each_solved_in_more_than_one_way():
    assert list(FOLDERS) == [f"lab{k}" for k in range(1, 9)]
    assert all(sum(lab == own for own, _ in FORMS) >= 2 for lab in FOLDERS)


@pytest.mark.every(21)
@pytest.mark.parametrize(
    ("lab", "path"), FORMS, ids=[str(p.relative_to(SOLUTIONS)) for _, p in FORMS]
)
def test_a_right_solution_of_any_form_gets_full_marks_and_no_diagnosis(lab, path):
    for seed in (1, 2):
        found = results(lab, path.read_text("utf-8"), seed=seed)
        assert {title: v.text for title, (_, v) in found.items() if v.share < 1} == {}
        assert [v.diagnosis for _, v in found.values() if v.diagnosis] == []


@pytest.mark.deep
@pytest.mark.parametrize("lab", FOLDERS)
def test_right_solutions_of_six_students_robots_get_full_marks_in_spite_of_rounding(lab):
    forms = [path.read_text("utf-8") for own, path in FORMS if own == lab]
    for k in range(6):
        robot = robot_for(f"student {k}", b"a secret", find_lab(lab).robot())
        found = results(lab, forms[k % len(forms)], robot, seed=k, noise=1e-13)
        assert {title: v.text for title, (_, v) in found.items() if v.share < 1} == {}, (k, robot)


@pytest.mark.parametrize("lab", FOLDERS)
def test_the_untouched_file_earns_nothing_and_says_which_task_is_next(lab):
    found = results(lab, (FOLDERS[lab] / "student.py").read_text("utf-8"))
    assert score(found) == 0
    for title, (_, verdict) in found.items():
        assert re.match(
            rf"raised an exception: NotImplementedError: {lab} task \d: |NotImpl", verdict.text
        ), title
        assert verdict.diagnosis is None


@pytest.mark.parametrize("every", [16, pytest.param(1, marks=pytest.mark.deep)])
@pytest.mark.parametrize("lab", FOLDERS)
def test_each_mistake_loses_points_and_has_no_other_name(lab, every):
    for function, name, source in list(mistakes(lab))[::every]:
        found = results(lab, source, only=function)
        lost = {title: verdict for title, (_, verdict) in found.items() if verdict.share < 1}
        named = {v.diagnosis.name for v in lost.values() if v.diagnosis}
        assert lost and named <= set(name.split(" | ")), f"{function}: {name}: {named}"


MISTAKES = [(lab, *mistake) for lab in FOLDERS for mistake in mistakes(lab)]


@pytest.mark.deep
@pytest.mark.every(40)
@pytest.mark.parametrize(
    ("lab", "function", "name", "source"),
    MISTAKES,
    ids=[f"{m[0]}: {m[1]}: {m[2]}" for m in MISTAKES],
)
def test_each_mistake_is_named_by_the_change_that_undoes_it(lab, function, name, source, tmp_path):
    case = HandIn(lab, "", "utf-8", name, source, {})
    wrong = [check for check in graded(case, tmp_path).checks if check.share < 1]
    # Where a helper is wrong, another function that calls it may pay.
    payers = [check for check in wrong if check.function == function] or wrong
    assert any(check.misconception or check.spot for check in payers)


@pytest.mark.parametrize("lab", FOLDERS)
def test_each_misconception_has_a_name_of_its_own_and_a_hint(lab):
    for exercise in load(lab, "exercises").EXERCISES:
        names = [wrong.name for wrong in exercise.wrong]
        assert len(set(names)) == len(names)
        assert all(wrong.hint.endswith((".", "?")) for wrong in exercise.wrong)


def test_there_are_more_than_three_hundred_mistakes():
    assert len(MISTAKES) >= 323


@pytest.mark.parametrize("lab", FOLDERS)
def test_the_statement_lists_the_checks_and_their_points(lab):
    text = (FOLDERS[lab] / "README.md").read_text("utf-8")
    table = {
        title: int(n) for title, n in re.findall(r"^\| (\w+: .+?) \| (\d+) \|$", text, re.MULTILINE)
    }
    assert table == points(lab)
    assert sum(n for title, n in table.items() if ": bonus" not in title) == 20
    assert f"fivebar check {lab} student.py" in text


@pytest.mark.parametrize("lab", FOLDERS)
def test_statement_and_file_have_the_signatures_of_the_exercises(lab):
    readme, student = (
        (FOLDERS[lab] / name).read_text("utf-8") for name in ("README.md", "student.py")
    )
    defined = {
        name: re.sub(r"\s+", " ", args).strip()
        for name, args in re.findall(r"def (\w+)\(([^)]*)\)", student)
    }
    for exercise in load(lab, "exercises").EXERCISES:
        assert defined[exercise.name] == ", ".join(exercise.arguments)
    for name in defined:
        assert f"{name}(" in readme


@pytest.mark.deep
def test_the_figures_are_those_that_the_statements_show(tmp_path):
    for script in LABS.glob("*figures.py"):
        subprocess.run([sys.executable, "-W", "error", script, tmp_path], check=True, timeout=120)
    drawn = {path.relative_to(tmp_path) for path in tmp_path.glob("**/*.png")}
    shown = set()
    for folder in FOLDERS.values():
        links = re.findall(r"\]\((.+?)\)", (folder / "README.md").read_text("utf-8"))
        files = [link.partition("#")[0] for link in links]
        assert [file for file in files if not (folder / file).is_file()] == []
        shown |= {Path(folder.name, file) for file in files if file.endswith(".png")}
    assert drawn == shown
    assert all((LABS / path).stat().st_size <= 60_000 for path in shown)


@pytest.mark.deep
@pytest.mark.parametrize("lab", FOLDERS)
def test_the_program_grades_a_solution_with_full_marks(lab):
    command = [sys.executable, "-m", "fivebar", "check", lab, SOLUTIONS / f"{lab}.py"]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=120)
    most = sum(points(lab).values())
    assert f"total {most} of {most} points" in shown.stdout, shown.stdout + shown.stderr


@pytest.mark.parametrize(
    ("function", "old", "new", "word"),
    [
        ("gains", "omega = 0.25 / period", "omega = 1.2 / period", "grows"),
        ("gains", "omega = 0.25 / period", "omega = 0.05 / period", "after 40 periods"),
        ("gains", "omega = 0.25 / period", "omega = 10.0", "after 40 periods"),
        ("gains", "return omega**2, 2 * omega", "return omega**2, 1.2 * omega", "overshoots"),
        ("gains", "return omega**2, 2 * omega", "return 2 * omega, omega**2", "e"),
        (
            "crossing_trajectory",
            "half = s * duration",
            "return trajectory(t, x0, y0, x1, y1, duration)",
            "0.1 N m",
        ),
        (
            "crossing_trajectory",
            "    half = s * duration",
            "    s = 0.97 * s\n    half = s * duration",
            "0.1 N m",
        ),
        ("crossing_trajectory", "half = s * duration", "half = s * duration / 40", "0.1 N m"),
        ("crossing_trajectory", "p * Y, pD * X", "p * Y, 1.1 * pD * X", "velocity is not"),
        ("crossing_trajectory", "pDD * X, pDD * Y", "0 * X, 0 * Y", "is not the derivative"),
        (
            "crossing_trajectory",
            "return x0 + p * X",
            "return x0 + 0.001 + p * X",
            "beside the task",
        ),
        ("crossing_trajectory", "return x0 + p * X", "return x0 + 0 * p * X", "beside the task"),
        ("crossing_trajectory", "    half = s", "    return None\n    half = s", "return missing"),
        (
            "crossing_trajectory",
            "    half = s",
            "    return 1, 2\n    half = s",
            "2 values where 6",
        ),
        (
            "crossing_trajectory",
            "    half = s",
            "    return [float('nan')] * 6\n    half = s",
            "nan",
        ),
        ("crossing_trajectory", "    half = s", "    return [1j] * 6\n    half = s", "complex"),
        (
            "crossing_trajectory",
            "    half = s",
            "    return [1e300] * 6\n    half = s",
            "beyond 1e+09",
        ),
        ("gains", "return omega**2, 2 * omega", "return 'fast'", "string"),
        ("gains", "return omega**2, 2 * omega", "return 9e8, 9e8", "grows"),
        (
            "computed_torque",
            "return M[0][0]",
            "return 1e308, -1e308\n    return M[0][0]",
            "beyond 1e+09",
        ),
        ("computed_torque", "return M[0][0]", "return 1j, 0\n    return M[0][0]", "complex"),
        ("computed_torque", "return M[0][0]", "return 0, 0\n    return M[0][0]", "value"),
    ],
)
def test_what_is_judged_by_what_it_does_says_what_goes_wrong(function, old, new, word):
    source = (SOLUTIONS / "lab6.py").read_text("utf-8")
    assert source.count(old) == 1
    lost = [
        v
        for _, v in results("lab6", source.replace(old, new), only=function).values()
        if v.share < 1
    ]
    assert lost and any(word in verdict.text for verdict in lost), [
        verdict.text for verdict in lost
    ]


@pytest.mark.parametrize(
    "new, word",
    [
        ("return (x0, y0, 0, 0, 0, 0) if t < 0.4 * duration else (x1, y1, 0, 0, 0, 0)", "jumps"),
        (
            "k = int(t / duration * 200) / 200; return x0 + (x1 - x0) * k, y0 + (y1 - y0) * k, 0, 0, 0, 0",
            "jumps",
        ),
        (
            "c, out = meets(x0, y0, x1, y1, duration)[0], trajectory(t, x0, y0, x1, y1, duration)\n"
            "    return out if abs(t - c) > 0.02 else (*out[:4], 0.0, 0.0)",
            "acceleration is not the derivative",
        ),
    ],
)
def test_a_motion_that_only_pretends_to_move_crosses_nothing(new, word):
    source = (SOLUTIONS / "lab6.py").read_text("utf-8")
    found = results(
        "lab6",
        source.replace("    half = s", f"    {new}\n    half = s"),
        only="crossing_trajectory",
    )
    assert [verdict.share for _, verdict in found.values()] == [0.0, 0.0]
    assert any(word in verdict.text for _, verdict in found.values()), [
        verdict.text for _, verdict in found.values()
    ]


@pytest.mark.parametrize(
    ("condition", "accepted", "refused"),
    [
        ("min(s1, s2) < 1e-9", 0, 0),
        ("False", 4, 0),
        ("s1 < 1e-9", 2, 0),
        ("max(s1, s2) < 1e-9", 4, 0),
        ("min(s1, s2) < 1e-14", 4, 0),
        ("min(s1, s2) < 1e-4", 0, 4),
    ],
)
def test_lab_2_asks_on_both_sides_of_the_smallest_sine_in_either_leg(condition, accepted, refused):
    source = (SOLUTIONS / "angles/lab2.py").read_text("utf-8")
    sines = "    s1, s2 = abs(math.sin(q12)), abs(math.sin(q22))\n"
    old = "    if min(abs(math.sin(q12)), abs(math.sin(q22))) < 1e-9:"
    assert old in source
    found = results("lab2", source.replace(old, f"{sines}    if {condition}:"), only="ikm")
    _, verdict = found["ikm: at a Type-1 singularity"]
    assert verdict.wrong == accepted + refused
    assert verdict.reason == ("accepted" if accepted else "nan" if refused else "")


OFF = """
import numpy as np

def shifted(function):
    def moved(*row):
        answer = function(*row)
        if isinstance(answer, (tuple, list)):
            return [0.37 + np.asarray(part) for part in answer]
        return None if answer is None else 0.37 + np.asarray(answer)
    return moved
"""


@pytest.mark.parametrize("lab", FOLDERS)
def test_wrong_answers_of_no_known_mistake_are_no_fault_of_the_lab(lab):
    """No wrong model that is compared with them is asked where it raises."""
    source = (SOLUTIONS / f"{lab}.py").read_text("utf-8") + OFF
    for exercise in load(lab, "exercises").EXERCISES:
        if not exercise.of_lists:
            source += f"{exercise.name} = shifted({exercise.name})\n"
    for seed in (1, 2):
        found = results(lab, source, seed=seed)
        judged = [verdict for _, verdict in found.values() if verdict.answers is not None]
        assert "value" in {verdict.reason for verdict in judged}
        assert not any(verdict.diagnosis for verdict in judged)
