"""The notebooks' stored outputs: small pictures and texts for a reader on the web; the tests prove them current.

`python -m tests.helpers.stored_outputs` renews them, all or those whose names begin with the words given.
"""

import base64
import io
import re
import sys
import tempfile
from pathlib import Path

import nbformat
import numpy as np
from jupyter_client import AsyncKernelManager
from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
from nbclient import NotebookClient
from PIL import Image
from traitlets import default

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
# The kernel's own coming change, which it announces when it is told to stop.
STRICT = """import warnings
warnings.simplefilter("error")
warnings.filterwarnings("default", category=PendingDeprecationWarning, module="ipykernel")"""
WIDEST, COLOURS = 800, 128  # of a stored picture: pixels, and entries of its palette
# Cells whose numbers and curves depend on the machine that runs them: times, local optima of the
# search for an exciting motion and what is identified from it, and an unstable loop.
TIMED = re.compile(
    r"seconds\(|solve_time|perf_counter|\bjit\b|\.2f\} s; largest"
    r"|exciting_trajectory|fb\.identify|replay\(|8100, measurement"
)
NUMBER = re.compile(r"[-+−]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE)
ALIKE, ROUNDING = 0.02, 1e-8  # of two numbers, relative; numbers that are nothing but rounding
PIXELS = 8.0  # mean difference of two pictures of 48 x 48 grey pixels, of 255


class OwnInterpreter(KernelSpecManager):
    """The only kernel is the interpreter that runs this, not one that Jupyter finds elsewhere."""

    def get_kernel_spec(self, kernel_name):
        command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        # Were fivebar missing, the install cell must not fetch one.
        return KernelSpec(
            argv=command, display_name="Python 3", language="python", env={"PIP_NO_INDEX": "1"}
        )


class OwnKernel(AsyncKernelManager):
    @default("kernel_spec_manager")
    def _only_ours(self):
        return OwnInterpreter(parent=self)


def executed(path, folder):
    """The notebook with the outputs of a fresh run in this folder, in which a warning is an error."""
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = []
    own = notebook.cells.copy()
    notebook.cells.insert(0, nbformat.v4.new_code_cell(STRICT))
    where = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, kernel_manager_class=OwnKernel, timeout=600, resources=where).execute()
    notebook.cells = own
    return notebook


def stored(outputs):
    """What of a cell's outputs is kept: printed text, a result's text, and its picture, small."""
    kept = []
    for output in outputs:
        if output.output_type == "stream" and kept and kept[-1].output_type == "stream":
            kept[-1].text += output.text  # the kernel sends what is printed in pieces
        elif output.output_type == "stream":
            kept.append(nbformat.v4.new_output("stream", name=output.name, text=output.text))
        else:
            data = {"text/plain": output.data["text/plain"]}
            if "image/png" in output.data:
                data["image/png"] = small(output.data["image/png"])
            kept.append(nbformat.v4.new_output("display_data", data=data))
    return kept


def small(png):
    """A picture in base64, no wider than WIDEST and of a palette."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    if picture.width > WIDEST:
        picture = picture.resize(
            (WIDEST, round(picture.height * WIDEST / picture.width)), Image.Resampling.LANCZOS
        )
    file = io.BytesIO()
    # By cover, not by the median cut, which mixes the colours of thin lines.
    palette = picture.quantize(
        COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE
    )
    palette.save(file, "PNG", optimize=True)
    return base64.b64encode(file.getvalue()).decode()


def differences(cell, fresh):
    """In what a cell's stored outputs are not those of a fresh run, as sentences; times may be others."""
    timed, new = bool(TIMED.search(cell.source)), stored(fresh)
    if [sorted(output.get("data", ["text"])) for output in cell.outputs] != [
        sorted(output.get("data", ["text"])) for output in new
    ]:
        yield f"{cell.id}: {len(cell.outputs)} outputs are stored, {len(new)} of other kinds come"
        return
    for old, output in zip(cell.outputs, new):
        before, after = (
            o.get("text") or o.get("data", {}).get("text/plain", "") for o in (old, output)
        )
        if " at 0x" not in after and not alike(before, after, timed):
            yield f"{cell.id}: stored is {before[:300]!r}, what comes is {after[:300]!r}"
        if "image/png" in output.get("data", {}):
            off = apart(old.data["image/png"], output.data["image/png"])
            if off > PIXELS and not timed:
                yield f"{cell.id}: its picture has changed, by {off:.1f} grey values of 255"


def alike(before, after, timed):
    """Whether two texts are the same but for rounding, and where a cell is timed for its numbers."""
    words = [re.sub(r"\s+", " ", NUMBER.sub("#", text)) for text in (before, after)]
    if words[0] != words[1]:
        return False
    numbers = [
        [float(word.replace("−", "-")) for word in NUMBER.findall(text)] for text in (before, after)
    ]
    return timed or all(
        abs(a - b) <= ALIKE * max(abs(a), abs(b)) or max(abs(a), abs(b)) < ROUNDING
        for a, b in zip(*numbers)
    )


def apart(one, other):
    """The mean difference of two pictures, as small grey ones."""
    pictures = [
        Image.open(io.BytesIO(base64.b64decode(png))).convert("L").resize((48, 48))
        for png in (one, other)
    ]
    return float(np.abs(np.subtract(*(np.asarray(picture, float) for picture in pictures))).mean())


def renew(path):
    with tempfile.TemporaryDirectory() as folder:
        fresh = executed(path, folder)
    for cell in fresh.cells:
        cell.metadata.pop("execution", None)
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = stored(cell.outputs), None
    fresh.metadata = {key: fresh.metadata[key] for key in ("kernelspec", "language_info")}
    fresh.metadata["language_info"] = {"name": "python"}
    nbformat.write(fresh, path)
    return path.stat().st_size


if __name__ == "__main__":
    chosen = [
        path for path in NOTEBOOKS if not sys.argv[1:] or path.name.startswith(tuple(sys.argv[1:]))
    ]
    sizes = [renew(path) for path in chosen]
    for path, size in zip(chosen, sizes):
        print(f"{path.name}: {size / 1e3:.0f} kB")
    print(f"{sum(sizes) / 1e6:.2f} MB")
