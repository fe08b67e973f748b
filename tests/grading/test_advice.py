"""What is said of wrong answers is true: names that were given falsely, and mistakes paid for once."""

import re

import pytest

from fivebar.grading.advice.advice import Advice
from fivebar.grading.grade import check, grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from tests.helpers import DATA
from tests.helpers.hand_ins import FOLDER
from tests.helpers.lab_session import SOLUTIONS

FRESH = FOLDER / "fresh"


def report(lab, base, folder, *changes, fails=False):
    """The report on a file of the corpus with these changes, (old, new)."""
    source = (FRESH / f"{base}.py").read_text("utf-8")
    for old, new in changes:
        assert old in source
        source = source.replace(old, new)
    path = folder / "my.py"
    path.write_text(source, encoding="utf-8")
    found = grade(find_lab(lab), Job(path, seed="advice"))
    assert not found.faults
    assert fails or not any("search for what is wrong failed" in note for note in found.notes)
    return found


def said(found, function=""):
    """All that is said of wrong checks: (function, text, name)."""
    return [
        (c.function, c.text, c.misconception)
        for c in found.checks
        if c.share < 1 and function in ("", c.function)
    ]


@pytest.mark.deep
def test_zeros_of_a_function_still_to_be_written_are_no_mistake_in_a_formula(tmp_path):
    body = (FRESH / "amoro_blocks.py").read_text("utf-8").split("def dkm_passive(")[1]
    body = body.split("):\n", 1)[1].split("\n\n\n")[0]
    found = report("amoro", "amoro_blocks", tmp_path, (body, "    return 0, 0"))
    assert {name for _, _, name in said(found)} == {
        "always the same answer, whatever the arguments: is it still to be written?"
    }
    assert found.points == 18


def test_a_mistake_in_c_keeps_its_name_beside_one_in_M(tmp_path):
    source = (SOLUTIONS / "lab5.py").read_text("utf-8")
    wrong = source.replace("zz2 + m * JJ", "zz1 + m * JJ").replace("[m * (J", "[(J")
    wrong = wrong.replace("), m * (J", "), (J")
    path = tmp_path / "my.py"
    path.write_text(wrong, encoding="utf-8")
    found = grade(find_lab("lab5"), Job(path))
    names = [name for function, _, name in said(found) if function == "dynamic_model"]
    assert names.count("mass forgotten in c") == len(names) - 1 > 0
    told = {remark for check in found.checks for remark in check.remarks}
    assert told == {"judged with the right dynamic_model in place of your own, which is wrong"}


@pytest.mark.deep
def test_a_pseudo_inverse_is_told_that_no_answer_exists_and_no_more(tmp_path):
    found = report("lab2", "lab2", tmp_path, ("linalg.inv(", "linalg.pinv("))
    assert said(found) and all(
        text.startswith("gave an answer where none exists") and name == ""
        for _, text, name in said(found)
    )


@pytest.mark.deep
def test_the_end_of_a_step_is_no_rounding(tmp_path):
    source = (FRESH / "lab4.py").read_text("utf-8")
    bisection = source[source.index("            lo, hi") : source.index("        before = now")]
    found = report("lab4", "lab4", tmp_path, (bisection, "            return i / N\n"))
    assert {name for _, _, name in said(found)} == {"no bisection: the end of a step of 1/500"}


@pytest.mark.deep
def test_one_mode_for_both_legs_is_named_beside_a_clamped_cosine(tmp_path):
    changes = (
        ("acos(cosine)", "acos(max(-1.0, min(1.0, cosine)))"),
        ("l22, gamma2)", "l22, gamma1)"),
    )
    names = {name for _, _, name in said(report("lab1", "lab1", tmp_path, *changes)) if name}
    assert names == {"gamma1 in place of gamma2 in the right active joint"}


@pytest.mark.deep
def test_nothing_is_said_to_be_always_0_beside_right_answers(tmp_path):
    change = (
        "    a1 = q11 + q12\n    a2 = q21 + q22\n    n1",
        (
            "    if np.sin(q12) > 0.5:\n        return 0, 0\n"
            "    a1 = q11 + q12\n    a2 = q21 + q22\n    n1"
        ),
    )
    found = report("lab2", "lab2", tmp_path, change)
    assert said(found, "dkm_passive") and not any(
        re.search("always|whatever|0 ", name) for _, _, name in said(found)
    )


@pytest.mark.deep
def test_millimetres_are_told_in_lab_8(tmp_path):
    change = "    return e1, e2", "    return 1000 * e1, 1000 * e2"
    names = {name for _, _, name in said(report("lab8", "lab8", tmp_path, change), "misses")}
    assert names == {"a wrong factor"} or all("factor" in name for name in names)


@pytest.mark.deep
def test_a_name_used_before_it_has_a_value_is_told_in_pythons_words(tmp_path):
    change = "    rates = A @ x", ""
    source = (FRESH / "lab5.py").read_text("utf-8")
    assert change[0] not in source
    found = report(
        "lab5",
        "lab5",
        tmp_path,
        ("    M = np.diag([zz1, zz2]) + m", "    m = m / 1\n    M = np.diag([zz1, zz2]) + m"),
    )
    function, text, name = said(found, "dynamic_model")[0]
    assert "UnboundLocalError" in text and "'m'" in text and name == "m = m / 1 too much"


@pytest.mark.deep
def test_a_column_added_to_a_row_is_no_product_and_not_copied_to_other_checks(tmp_path):
    change = "    return M, c\n\n\ndef inverse", "    return M, c[:, None]\n\n\ndef inverse"
    found = report("lab5", "lab5", tmp_path, change)
    assert {function for function, _, _ in said(found)} == {"inverse_dynamics", "forward_dynamics"}
    assert not any("matrix product" in text or name for _, text, name in said(found))


SINGULAR = "def AB(q12, q22):", "def AB(q12, q22):\n    q12 = q12 + 0.0"


def test_a_solved_system_at_a_singularity_has_no_mistake_but_that(tmp_path):
    """Two arguments that do not count are not exchanged because rounding gives an answer."""
    found = report("lab7", "lab7", tmp_path, SINGULAR)
    assert {name for function, _, name in said(found) if function in ("dkm", "ikm")} <= {""}


HELPERS = {
    "B without l": ("amoro", "amoro_blocks", ("= l * (u22.T @ v21)", "= (u22.T @ v21)"), 18),
    "a sign in B": ("amoro", "amoro_blocks", ("= l * (u12.T @ v11)", "= -l * (u12.T @ v11)"), 18),
    "a bracket in d": (
        "amoro",
        "amoro_blocks",
        (
            "-l * q11D**2 * (u12.T @ u11)[0, 0] - l * (q11D + q12D)**2",
            "-l * (q11D**2 * (u12.T @ u11)[0, 0] - (q11D + q12D)**2)",
        ),
        18,
    ),
    "an unknown slip in A": (
        "amoro",
        "amoro_trig",
        ("[mt.cos(q21 + q22), mt.sin(q21 + q22)]", "[mt.cos(q21 + q22), mt.sin(q21 + 0.3 * q22)]"),
        18,
    ),
    "both legs' d exchanged": (
        "amoro",
        "amoro_trig",
        ("return np.array([b1, b2])", "return np.array([b2, b1])"),
        18,
    ),
}


@pytest.mark.deep
@pytest.mark.parametrize("lab, base, change, points", HELPERS.values(), ids=HELPERS)
def test_a_wrong_helper_is_paid_for_by_the_first_function_that_it_spoils(
    tmp_path, lab, base, change, points
):
    found = report(lab, base, tmp_path, change)
    assert points <= found.points <= points + 0.1  # a row may be right by chance
    assert len({function for function, _, _ in said(found)}) == 1
    told = [remark for c in found.checks for remark in c.remarks if "judged with" in remark]
    assert told and all(name for _, _, name in said(found))


@pytest.mark.deep
def test_a_wrong_helper_is_called_by_the_mistake_that_it_holds(tmp_path):
    changes = (
        ("l * (u12.T @ v11)", "l * (u12.T @ get_u11(q11))"),
        ("l * (u22.T @ v21)", "l * (u22.T @ get_u21(q21))"),
    )
    found = report("amoro", "amoro_blocks", tmp_path, *changes)
    name = "a quarter turn missing in v of the proximal bar, in your compute_A_B"
    assert {told for _, _, told in said(found)} == {name} and found.points == 18
    assert {c.spot for c in found.checks if c.share < 1} == {
        "line 42: get_u11(q11): right answers come with v11, in 2 formulas"
    }


@pytest.mark.deep
def test_a_wrong_matrix_of_poses_and_rates_is_compared_with_A_too(tmp_path):
    rates = "q11, q12, q21, q22, q11D, q12D, q21D, q22D"
    added = f"""def drag({rates}):
    u, v = q11 + q12, q21 + q22
    return np.array([[-mt.sin(u), mt.cos(u)], [mt.sin(v), mt.cos(v)]])


def dkm("""
    wrong = ("[q11DD, q21DD]) + b)", f"[q11DD, q21DD]) + b + drag({rates})[0])")
    found = report("amoro", "amoro_trig", tmp_path, ("def dkm(", added), wrong)
    assert found.points == found.max_points - 2


@pytest.mark.deep
def test_a_6_typed_as_5_in_a_quintic_is_paid_for_by_the_trajectory(tmp_path):
    source = (DATA / "solutions/lab6.py").read_text("utf-8")
    path = tmp_path / "my.py"
    path.write_text(source.replace("+ 6 * u**5", "+ 5 * u**5"), encoding="utf-8")
    found = grade(find_lab("lab6"), Job(path, seed="advice"))
    assert {function for function, _, _ in said(found)} == {"trajectory"}
    assert found.points == 20 - 4 + found.checks[0].points + found.checks[1].points


@pytest.mark.deep
def test_a_helper_that_is_no_model_earns_nothing(tmp_path):
    change = (
        "[[mt.cos(q11 + q12), mt.sin(q11 + q12)],\n                     [mt.cos(q21 + q22), mt.sin(q21 + q22)]]",
        "[[17.0 * q11**2, 1.0], [q22 - 5 * q12**3, 2.0]]",
    )
    assert report("amoro", "amoro_trig", tmp_path, change).points == 10


@pytest.mark.deep
def test_the_order_of_the_functions_does_not_matter_where_a_helper_is_called_by_another(tmp_path):
    changes = (
        ("= l * (u22.T @ v21)", "= (u22.T @ v21)"),
        (
            "def compute_d(q11, q12",
            "def of_both(a, b, c, e):\n    return compute_A_B(a, b, c, e)\n\n\ndef compute_d(q11, q12",
        ),
        (
            "    A, B = compute_A_B(q11, q12, q21, q22)\n    xiDD = ",
            "    A, B = of_both(q11, q12, q21, q22)\n    xiDD = ",
        ),
    )
    assert report("amoro", "amoro_blocks", tmp_path, changes[0], changes[1]).points == 18


def test_a_name_is_not_denied_where_its_mistake_gives_right_answers():
    """At constant speed, and on and on: a path that rests before and after is a matter of its own."""
    space = {}
    exec(
        "def trajectory(t, x0, y0, x1, y1, duration):\n"
        "    s, xD, yD = t / duration, (x1 - x0) / duration, (y1 - y0) / duration\n"
        "    return x0 + s * (x1 - x0), y0 + s * (y1 - y0), xD, yD, 0.0, 0.0\n",
        space,
    )
    between, beyond, *_ = check("lab6", trajectory=space["trajectory"]).checks
    assert between.misconception == "constant speed" and beyond.share < 1
    assert not beyond.misconception


def test_points_stand_where_the_search_fails(tmp_path, monkeypatch):
    def fail(advice):
        raise ZeroDivisionError("a seam")

    monkeypatch.setattr(Advice, "tell", fail)
    found = report("lab1", "lab1", tmp_path, ("D = np.linalg.norm(PQ)", "D = 1"), fails=True)
    (note,) = [note for note in found.notes if "ZeroDivisionError: a seam" in note]
    assert "The points stand" in note and 0 < found.points < found.max_points


@pytest.mark.deep
def test_a_slip_of_a_constructor_and_one_beside_it_are_told_in_their_places(tmp_path):
    found = report(
        "amoro",
        "amoro_legs",
        tmp_path,
        ("self.phi = q1 + q2", "self.phi = q2"),
        ("math.acos(dist", "math.asin(dist"),
        ("self.n2() / l - self.q1D\n", "self.n2() / l\n"),
        ("+ l * self.q1D**2 * self.e1()", "- l * self.q1D**2 * self.e1()"),
    )
    lines = {c.function: c.spot.split(":")[0] for c in found.checks if c.spot}
    passive = {"dkm_passive": "line 57", "dkm2_passive": "line 63"}
    assert lines == {"igm": "line 43", "ikm": "line 20"} | passive


@pytest.mark.deep
def test_a_name_that_functions_of_one_helper_do_not_share_gives_way_to_the_helpers(tmp_path):
    square = "-phiD / math.sin(phi) ** 2"
    found = report(
        "amoro-biglide", "biglide_cotangents", tmp_path, (square, square.removesuffix(" ** 2"))
    )
    (name,) = {name for _, _, name in said(found)}
    assert name.endswith(", in your cot_dot")
