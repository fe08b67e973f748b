"""The notebooks: they run without a warning, their figures and pages are shown, and what is stored is current."""

import base64
import html
import io
import json
import re
from pathlib import Path

import bokeh
import nbformat
import numpy as np
import pytest
from PIL import Image

from tests.helpers.needs import need
from tests.helpers.stored_outputs import NOTEBOOKS, differences, executed

SUBJECTS = (
    "quick_start geometry kinematics second_order singularities dynamics control biglide singularity_maps "
    "where_methods_fail speed_against_accuracy crossing_a_singularity other_mechanisms real_robots measured_data "
    "drawing design gradients photograph"
).split()
LABS = {f"0{n}": f'check("lab{n}", ' for n in range(1, 8)}
LARGEST = 3_000_000
INSTALL = """import importlib.util

if importlib.util.find_spec("fivebar") is None:
    %pip install -q ..  # the clone that this notebook is in"""
EXTRAS = {"17_gradients": '"..[jax]"'}  # in place of ..
FETCHED = re.compile(
    r"""(?:\b(?:src|href|action)\s*=\s*["']?|url\(\s*["']?|@import\s+["']?|\bimport\s*\(?\s*["'])"""
    r"""\s*(?:https?:)?//""",
    re.IGNORECASE,
)

SHOW = re.compile(r"view\.scene\(|^fb\.play\(|^\w+\.page\(", re.MULTILINE)  # what shows itself
BOKEH = (Path(bokeh.__file__).parent / "server/static/js/bokeh.min.js").read_text(
    "utf-8"
)  # MathJax for TeX

QUICK = "00_quick_start"  # the only one that the short run of the tests executes
each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def sources(notebook, kind):
    return [cell.source for cell in notebook.cells if cell.cell_type == kind]


def headings(page):
    """The anchors of a Markdown file's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_all_subjects_are_there():
    assert [path.stem for path in NOTEBOOKS] == [
        f"{n:02d}_{subject}" for n, subject in enumerate(SUBJECTS)
    ]


@each_notebook
def test_stored_clean(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    assert notebook.metadata.language_info == {"name": "python"}
    ids = [cell.id for cell in notebook.cells]
    assert ids == ["install", *(f"cell-{k:02d}" for k in range(1, len(ids)))]
    for cell in notebook.cells:
        assert cell.source == cell.source.strip()
        assert cell.metadata == ({"tags": ["install"]} if cell.id == "install" else {})
        if cell.cell_type == "code":
            assert cell.execution_count is None
            assert {kind for output in cell.outputs for kind in output.get("data", ())} <= {
                "text/plain",
                "image/png",
            }


def test_stored_outputs_are_small():
    assert sum(path.stat().st_size for path in NOTEBOOKS) < 3_000_000
    for path in NOTEBOOKS:
        for cell in nbformat.read(path, as_version=4).cells:
            for output in cell.get("outputs", ()):
                assert len(output.get("data", {}).get("image/png", "")) < 200_000, (
                    path.name,
                    cell.id,
                )


DEFAULT_COLOURS = {
    "blue": "1f77b4",
    "orange": "ff7f0e",
    "green": "2ca02c",
    "red": "d62728",
}  # Matplotlib's


@each_notebook
def test_pictures_have_the_style_of_the_package(path):
    notebook = nbformat.read(path, as_version=4)
    code = "\n".join(sources(notebook, "code"))
    if "import matplotlib.pyplot as plt" in code:
        assert re.search(r"^fb\.plot\.use_style\(\)", code, re.MULTILINE), (
            "its plots have other colours"
        )
    for cell in notebook.cells:
        for output in cell.get("outputs", ()) if "plt." in cell.source else ():
            if picture := output.get("data", {}).get("image/png"):
                pixels = np.asarray(
                    Image.open(io.BytesIO(base64.b64decode(picture))).convert("RGB"), int
                )
                for name, colour in DEFAULT_COLOURS.items():
                    off = np.abs(pixels - list(bytes.fromhex(colour))).max(axis=-1)
                    assert (off <= 8).sum() < 60, f"{cell.id}: Matplotlib's own {name}"


@each_notebook
def test_told_as_a_story(path):
    """First the install cell, then a title with a question; exercises at the end; links that lead somewhere."""
    notebook = nbformat.read(path, as_version=4)
    assert notebook.cells[0].source == INSTALL.replace("..", EXTRAS.get(path.stem, ".."))
    text = sources(notebook, "markdown")
    assert text[0].startswith("# ") and "?" in text[0]
    tasks = re.findall(r"^\d\. ", text[-1].partition("## Exercises")[2], flags=re.MULTILINE)
    assert 2 <= len(tasks) <= 5
    for link in re.findall(r"\]\(([^)]+)\)", "\n".join(text)):
        file, _, heading = link.partition("#")
        assert (path.parent / file).is_file(), link
        assert not heading or heading in headings(path.parent / file), link
    if path.stem[:2] in LABS:
        assert any(LABS[path.stem[:2]] in source for source in sources(notebook, "code"))
        assert f"fivebar check lab{int(path.stem[:2])} " in "\n".join(text)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=[] if path.stem == QUICK else pytest.mark.deep)
        for path in NOTEBOOKS
    ],
    ids=lambda path: path.stem,
)
def test_runs_to_its_end_and_gives_what_is_stored(path, tmp_path):
    if "import mujoco" in path.read_text(encoding="utf-8"):
        need("other simulators")  # else its cell says what to install, which is not what is stored
    if path.stem == "17_gradients":
        need("JAX")
    own = executed(path, tmp_path).cells
    before = nbformat.read(path, as_version=4).cells
    outdated = [
        line
        for old, new in zip(before, own)
        if "outputs" in old
        for line in differences(old, new.outputs)
    ]
    assert outdated == [], "renew it: python -m tests.helpers.stored_outputs"
    shown = [
        (cell.id, output) for cell in own if cell.cell_type == "code" for output in cell.outputs
    ]
    pictures = 0
    for cell, output in shown:
        assert len(json.dumps(output)) < LARGEST, cell
        if output.output_type == "stream":
            assert output.name == "stdout", f"{cell}: {output.text}"
            continue
        assert not output.data["text/plain"].startswith("<Figure") or "image/png" in output.data, (
            cell
        )
        if "image/png" in output.data:
            picture = Image.open(io.BytesIO(base64.b64decode(output.data["image/png"])))
            assert (
                min(picture.size) > 100 and len(picture.convert("RGB").getcolors(1 << 24)) > 10
            ), cell
            pictures += 1
        if "text/html" in output.data:
            page = html.unescape(output.data["text/html"]).replace(BOKEH, "")
            assert not FETCHED.search(page), f"{cell}: {FETCHED.search(page)[0]}"
    assert pictures >= 2
    scenes = sum(bool(SHOW.search(cell.source)) for cell in own if cell.cell_type == "code")
    assert (
        sum("srcdoc=" in output.get("data", {}).get("text/html", "") for _, output in shown)
        == scenes
    )
    if path.stem[:2] in LABS:
        pages = [output.get("data", {}).get("text/html", "") for _, output in shown]
        (report,) = (page for page in pages if "this session" in page)
        assert "looks like" in report and " points" in report
