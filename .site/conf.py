"""Settings of Sphinx for the site; build.py calls it."""

import re

from docutils import nodes
from latex2mathml.converter import convert

import fivebar as fb

project = "fivebar"
author = "The fivebar authors"
version = release = fb.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["labs/**/*.py"]
html_theme = "furo"
html_title = f"fivebar {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_math_renderer = "mathml"
pygments_style, pygments_dark_style = "friendly", "monokai"
default_role = "code"
nb_execution_mode = "off"  # notebooks as stored; tests/test_notebooks.py runs them
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath", "html_image"]
autodoc_default_options = {"members": True}
autodoc_typehints = "none"  # docstrings say the shapes and units, too
napoleon_numpy_docstring, napoleon_google_docstring = True, False
suppress_warnings = ["ref.python"]  # a word of a type, such as robot, is no name to link
napoleon_use_ivar, napoleon_use_param = True, False


def plain(app, what, name, object_, options, lines):
    """Docstrings are plain text: in them * and | are themselves."""
    prose = next((k for k, line in enumerate(lines) if re.match("-+$", line)), len(lines)) - 1
    lines[:prose] = [line.lstrip() for line in lines[:prose]]
    for number, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            lines[number] = re.sub(r"([*|])", r"\\\1", line)


def given(app, what, name, object_, options, signature, returned):
    """Leave out the arguments of what only the package's own functions make."""
    return ("", returned) if "_" in re.findall(r"(?:^\(|, )(_)?", signature or "") else None


def formula(display):
    """Return a visitor that writes a formula as MathML, which browsers draw by themselves."""

    def visit(writer, node):
        writer.body.append(convert(node.astext(), display))
        raise nodes.SkipNode

    return visit


def setup(app):
    app.connect("autodoc-process-docstring", plain, priority=100)
    app.connect("autodoc-process-signature", given)
    app.add_html_math_renderer("mathml", (formula("inline"), None), (formula("block"), None))
