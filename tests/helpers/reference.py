"""Reference pages of the public names, from their docstrings, by pdoc: python -m tests.helpers.reference docs"""

import re
import sys
from pathlib import Path
from types import ModuleType

import pdoc

import fivebar as fb

PARTS = (
    "amoro",
    "grading",
    "guide",
    "linkages",
    "optimal_design",
    "study",
    "visualization.pages",
    "visualization.plot",
    "visualization.view",
)
# Its text is run in a confined process, where other modules are.
LEFT_OUT = "!fivebar.amoro.ros_free._confined"
CONVERT = pdoc.docstrings.convert


def public() -> list[str]:
    """What `import fivebar as fb` offers, parts left out."""
    return [
        name
        for name in dir(fb)
        if not name.startswith("_") and not isinstance(getattr(fb, name), ModuleType)
    ]


def apart(docstring: str, *how: object) -> str:
    """A docstring in Markdown, in which each argument begins a line of its own, as in the source.

    The guide is one page here: links from one of its files to another lead to a heading of that page.
    """
    text = CONVERT(re.sub(r"\n(?=[\w*]+(, [\w*]+)*(:|  ) *\S)", "  \n", docstring), *how)
    text = re.sub(r"\]\(\w+\.md#", "](#", text)
    return re.sub(r"\]\((\w+)\.md\)", r"](#\1)", text)


def build(folder: Path) -> None:
    """Write the pages: one of fivebar's names, and one of each part."""
    everything = fb.__all__
    fb.__all__ = public()  # Parts have their own pages.
    pdoc.docstrings.convert = apart
    try:
        modules = ("fivebar", *(f"fivebar.{part}" for part in PARTS), LEFT_OUT)
        pdoc.pdoc(*modules, output_directory=folder)
    finally:
        fb.__all__ = everything
        pdoc.docstrings.convert = CONVERT


if __name__ == "__main__":
    build(Path(sys.argv[1]))
