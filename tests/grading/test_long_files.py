"""What a student's file may cost: long files and long expressions are read in the worker alone."""

import ast
import resource
import sys
import time

import pytest

from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import Submission
from tests.helpers.hand_ins import FOLDER

SOURCE = (FOLDER / "fresh" / "amoro_trig.py").read_text("utf-8")
SUM = " + ".join(f"{k} * q ** 2" for k in range(330))


@pytest.mark.every(4)
@pytest.mark.parametrize("start", ["", "np.float(1)\n"], ids=["today", "as-with-old-numpy"])
@pytest.mark.parametrize("terms", [330, 3000])
def test_a_sum_of_many_terms_is_read(terms, start):
    added = " + ".join(f"{k} * q ** 2" for k in range(terms))
    source = (
        f"import numpy as np\n{start}def f(q):\n    return {added}\nx = {added.replace('q', '1')}\n"
    )
    with Student(Submission("a.py", source)) as program:
        (reply,) = program.ask("f", [(1.0,)])
    assert reply.value == sum(range(terms)) and not (program.trouble and not start)


def test_what_is_too_deep_for_python_costs_its_own_line_alone():
    source = f"x = {'-' * 100_000}1\ny = {'(' * 5000}1{')' * 5000}\ndef f(q): return q\n"
    with Student(Submission("a.py", source)) as program:
        assert program.ask("f", [(1.5,)])[0].value == 1.5
        assert program.trouble is not None


@pytest.mark.deep
def test_the_graders_own_process_parses_nothing_of_a_student(tmp_path, monkeypatch):
    """Long and wrong, so that all that looks for mistakes is at work."""
    unused = "".join(f"\n\ndef more_{k}(q):\n    return {SUM}\n" for k in range(6))
    path = tmp_path / "my.py"
    path.write_text(SOURCE.replace("l * mt.sin(q22)]", "mt.sin(q22)]") + unused, encoding="utf-8")
    parse = ast.parse

    def own(source, *arguments, **options):
        assert "def more_1" not in str(source)
        return parse(source, *arguments, **options)

    monkeypatch.setattr(ast, "parse", own)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = grade(find_lab("amoro"), Job(path, seed="long"))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before  # kB, on macOS bytes
    assert not found.faults and found.points == 18
    assert grown < 300_000 * (1024 if sys.platform == "darwin" else 1)


@pytest.mark.deep
def test_pasted_expressions_of_25_kilobytes_are_graded_in_seconds(tmp_path):
    long = "0.0" + " + 0.0 * mt.sin(q11 + 2 * q12) * mt.cos(q21) ** 2" * 520
    assert len(long) > 25_000
    path = tmp_path / "my.py"
    path.write_text(
        SOURCE.replace("    b = vecb(", f"    extra = {long}\n    b = extra + vecb("),
        encoding="utf-8",
    )
    start = time.process_time()
    found = grade(find_lab("amoro"), Job(path, seed="long"))
    assert found.points == 20 and time.process_time() - start < 20
