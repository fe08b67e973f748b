"""The answers to the notebooks' exercises: one for each, and what they claim is computed."""

import re

import matplotlib
import nbformat
import pytest

from tests.helpers import DATA
from tests.helpers.needs import need
from tests.helpers.stored_outputs import NOTEBOOKS

ANSWERS = DATA / "answers"


def test_each_exercise_has_an_answer():
    asked = 0
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        exercises = re.findall(
            r"^(\d)\. ", cells[-1].source.partition("## Exercises")[2], re.MULTILINE
        )
        answers = re.findall(
            r"^## (\d)$",
            (ANSWERS / f"{path.name[:2]}.md").read_text(encoding="utf-8"),
            re.MULTILINE,
        )
        assert answers == exercises, path.name
        asked += len(exercises)
    assert asked == 75 and len(list(ANSWERS.glob("*.md"))) == len(NOTEBOOKS)


FAST = {"00", "01", "02", "05"}  # for the short run of the tests; the others are deep


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[] if path.stem in FAST else pytest.mark.deep)
        for path in sorted(ANSWERS.glob("*.md"))
    ],
)
def test_what_an_answer_claims_is_so(path, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    session = {"__name__": "__main__"}
    text = path.read_text(encoding="utf-8")
    if "import mujoco" in text:
        need("other simulators")
    if "import jax" in text:
        need("JAX")
    for match in re.finditer(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        before = "\n" * text.count("\n", 0, match.start(1))
        exec(compile(before + match[1], str(path), "exec"), session)
