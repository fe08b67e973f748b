"""The notebooks: stored clean, run to their end without a warning, and their figures and pages are shown."""

import base64
import html
import io
import json
import re
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client import AsyncKernelManager
from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
from nbclient import NotebookClient
from PIL import Image
from traitlets import default

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))
SUBJECTS = (
    "quick_start geometry kinematics second_order singularities dynamics control biglide singularity_maps "
    "where_methods_fail speed_against_accuracy crossing_a_singularity other_mechanisms real_robots"
).split()
LABS = {f"0{n}": f'check("lab{n}", ' for n in range(1, 8)}
LARGEST = 3_000_000
# The kernel's own coming change, which it announces when it is told to stop.
STRICT = """import warnings
warnings.simplefilter("error")
warnings.filterwarnings("default", category=PendingDeprecationWarning, module="ipykernel")"""
INSTALL = 'import importlib.util\n\nif importlib.util.find_spec("fivebar") is None:\n    %pip install -q fivebar'
FETCHED = re.compile(r"""(?:\b(?:src|href|action)\s*=\s*["']?|url\(\s*["']?|@import\s+["']?|\bimport\s*\(?\s*["'])"""
                     r"""\s*(?:https?:)?//""", re.IGNORECASE)  # fmt: skip

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


class OwnInterpreter(KernelSpecManager):
    """The only kernel is the interpreter that runs this test, not one that Jupyter finds elsewhere."""

    def get_kernel_spec(self, kernel_name):
        command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        # Were fivebar missing, the install cell must not fetch one.
        return KernelSpec(argv=command, display_name="Python 3", language="python", env={"PIP_NO_INDEX": "1"})


class OwnKernel(AsyncKernelManager):
    @default("kernel_spec_manager")
    def _only_ours(self):
        return OwnInterpreter(parent=self)


def sources(notebook, kind):
    return [cell.source for cell in notebook.cells if cell.cell_type == kind]


def test_all_subjects_are_there():
    assert [path.stem for path in NOTEBOOKS] == [f"{n:02d}_{subject}" for n, subject in enumerate(SUBJECTS)]


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
            assert cell.outputs == [] and cell.execution_count is None


@each_notebook
def test_told_as_a_story(path):
    """First the install cell, then a title with a question; exercises at the end; links that lead somewhere."""
    notebook = nbformat.read(path, as_version=4)
    assert notebook.cells[0].source == INSTALL
    text = sources(notebook, "markdown")
    assert text[0].startswith("# ") and "?" in text[0]
    tasks = re.findall(r"^\d\. ", text[-1].partition("## Exercises")[2], flags=re.MULTILINE)
    assert 2 <= len(tasks) <= 4
    for link in re.findall(r"\]\(([^)]+)\)", "\n".join(text)):
        assert (path.parent / link).is_file(), link
    if path.stem[:2] in LABS:
        assert any(LABS[path.stem[:2]] in source for source in sources(notebook, "code"))
        assert f"fivebar check lab{int(path.stem[:2])} " in "\n".join(text)


@each_notebook
def test_runs_to_its_end(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    own = notebook.cells.copy()
    notebook.cells.insert(0, nbformat.v4.new_code_cell(STRICT))
    where = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, kernel_manager_class=OwnKernel, timeout=120, resources=where).execute()
    shown = [(cell.id, output) for cell in own if cell.cell_type == "code" for output in cell.outputs]
    pictures = 0
    for cell, output in shown:
        assert len(json.dumps(output)) < LARGEST, cell
        if output.output_type == "stream":
            assert output.name == "stdout", f"{cell}: {output.text}"
            continue
        assert not output.data["text/plain"].startswith("<Figure") or "image/png" in output.data, cell
        if "image/png" in output.data:
            picture = Image.open(io.BytesIO(base64.b64decode(output.data["image/png"])))
            assert min(picture.size) > 100 and len(picture.convert("RGB").getcolors(1 << 24)) > 10, cell
            pictures += 1
        if "text/html" in output.data:
            page = html.unescape(output.data["text/html"])
            assert not FETCHED.search(page), f"{cell}: {FETCHED.search(page)[0]}"
    assert pictures >= 2
    scenes = sum("view.scene(" in cell.source for cell in own if cell.cell_type == "code")
    assert sum("srcdoc=" in output.get("data", {}).get("text/html", "") for _, output in shown) == scenes
    if path.stem[:2] in LABS:
        pages = [output.get("data", {}).get("text/html", "") for _, output in shown]
        (report,) = (page for page in pages if "this session" in page)
        assert "looks like" in report and " points" in report
