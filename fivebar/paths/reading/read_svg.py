"""SVG drawings: paths and basic shapes, read by svgelements; what cannot be drawn is listed."""

from __future__ import annotations

import io
import math
import re
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import svgelements  # the extra `draw`

from ...base.tables import STRANGE
from ..fit import Bezier, Ellipse
from ..pieces import Line
from .draft import Draft, Move, listed
from .svg_checks import LINE, SVG, clean, refuse_endless
from .svg_styles import styled
from .svg_viewports import viewport

DEEPEST = 200  # elements, each in another
NAMESPACE = re.compile(r"https?://[\w./#-]{1,80}")
MOST_NAMES = 1000  # of entities, and of their uses
CLOSED = 1e-12  # m, by which rounding may leave a closed path open


def read_svg(text: str, name: str, units: str | None = None) -> Draft:
    """The Draft of an SVG drawing: outlines of its shapes as they are seen, y up, the origin at the
    lower left.

    units: "mm", "px", ...: of its user units, where the file does not say how large it is; else px,
    1/96 inch. ValueError with file and line for what is no SVG, for bad path data and transforms,
    for units that contradict.
    """
    root = _tree(text, name)
    draft = Draft(name)
    styled(root, draft)
    to_metres = viewport(root, draft, units)
    if "Adobe Illustrator" in text[:2000] and any(
        "states no size" in words for words in draft.notes
    ):
        draft.notes.append("Illustrator's own units are of 1/72 inch: units pt would read them so")
    clean(root, draft)
    refuse_endless(root, name)
    source = io.BytesIO(ElementTree.tostring(root, "utf-8"))  # names of letters beyond ASCII stay
    unseen = []
    filled = []
    try:
        elements = list(svgelements.SVG.parse(source, reify=False, on_error="raise").elements())
    except (*STRANGE, SyntaxError) as error:  # the parser's errors are of syntax
        raise ValueError(
            f"{name}: svgelements cannot read it: {type(error).__name__}: {error}"
        ) from error
    for element in elements:
        if isinstance(element, svgelements.Shape):
            _add(element, to_metres, draft, unseen, filled)
    if filled:
        draft.notes.append(f"areas are not filled: their outlines are drawn{listed(filled)}")
    if unseen:
        draft.notes.append(
            f"{len(unseen)} shapes that are not seen are passed over{listed(unseen)}"
        )
    return draft


def _tree(text, name):
    """The elements, each with its line as an attribute."""
    depth = []
    parser = expat.ParserCreate("utf-8", "}")
    builder = ElementTree.TreeBuilder()

    def named(word):
        return "{" + word if "}" in word else word

    def start(tag, attributes):
        depth.append(tag)
        if len(depth) > DEEPEST:
            raise ValueError(
                f"{name}, line {parser.CurrentLineNumber}: elements nested deeper than {DEEPEST}"
            )
        line = {LINE: str(parser.CurrentLineNumber)}
        builder.start(
            named(tag),
            {named(key): value for key, value in attributes.items()} | line,
        )

    def entity(own, parameter, value, *_):
        """Illustrator's names of its namespaces are let through: a few, which nothing can be nested
        in.
        """
        if not parameter and NAMESPACE.fullmatch(value or "") and text.count("&") <= MOST_NAMES:
            return
        raise ValueError(
            f"{name}, line {parser.CurrentLineNumber}: entities are not read: save it as plain SVG"
        )

    def end(tag):
        depth.pop()
        builder.end(named(tag))

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.EntityDeclHandler = entity
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except expat.ExpatError as error:
        raise ValueError(
            f"{name}, line {error.lineno}: not XML: {expat.ErrorString(error.code)}"
        ) from None
    root = builder.close()
    if root.tag.removeprefix(SVG) != "svg":
        raise ValueError(f"{name}, line {root.get(LINE)}: not an SVG, but <{root.tag}>")
    return root


def _add(
    element,
    to_metres,
    draft,
    unseen,
    filled,
):
    """The moves along a shape's outline."""
    values = element.values
    m = element.transform
    line = int(values[LINE]) if LINE in values else None
    if (
        values.get("visibility") in ("hidden", "collapse")
        or values.get("stroke", "none") == values.get("fill") == "none"
    ):
        unseen.append(line)
        return
    if values.get("fill") not in (None, "none"):
        filled.append(line)
    wide, high, shift = to_metres

    def way(x, y):
        return complex(
            wide * (m.a * x + m.c * y),
            -high * (m.b * x + m.d * y),
        )

    def at(point):
        return way(point.x, point.y) + complex(wide * m.e, -high * m.f) + shift

    for segment in _reflected(svgelements.Path(element)):
        kind = type(segment).__name__
        if kind == "Move" or segment.start is None or segment.end is None:
            continue
        start = at(segment.start)
        end = at(segment.end)
        shape = None
        if kind == "CubicBezier":
            shape = Bezier(np.array([start, at(segment.control1), at(segment.control2), end]))
        elif kind == "QuadraticBezier":
            middle = at(segment.control)
            shape = Bezier(
                np.array(
                    [
                        start,
                        (start + 2 * middle) / 3,
                        (end + 2 * middle) / 3,
                        end,
                    ]
                )
            )
        elif kind == "Arc" and segment.sweep:
            shape = _ellipse(segment, way, at, start)
        elif kind == "Close" and abs(end - start) <= CLOSED:
            continue
        elif start != end:
            shape = Line((start.real, start.imag), (end.real, end.imag))
        else:  # of no length: it is listed later
            shape = Bezier(np.full(4, start))
        draft.moves.append(Move(shape, line=line))


def _reflected(segments):
    """Segments; smooth curves begin as the standard has it: only a curve of the same kind before is
    mirrored.
    """
    before = None
    for segment in segments:
        kind = type(segment).__name__
        if kind in ("CubicBezier", "QuadraticBezier") and segment.smooth:
            same = type(before).__name__ == kind
            own = "control" if kind == "QuadraticBezier" else "control1"
            if same:
                last = getattr(before, "control" if kind == "QuadraticBezier" else "control2")
            else:
                last = segment.start
            setattr(segment, own, last.reflected_across(segment.start))
        before = segment
        yield segment


def _ellipse(arc, way, at, start):
    """An elliptical arc by its conjugate radii, which any transform keeps."""
    across = arc.prx - arc.center
    up = arc.pry - arc.center
    side = math.copysign(
        1.0,
        across.x * up.y - across.y * up.x,
    )
    centre = at(arc.center)
    a = way(across.x, across.y)
    b = way(up.x, up.y)
    to = start - centre
    area = (a.conjugate() * b).imag
    if area == 0:
        return Bezier(np.array([start, start, at(arc.end), at(arc.end)]))
    t0 = math.atan2(
        (a.conjugate() * to).imag / area,
        (to.conjugate() * b).imag / area,
    )
    return Ellipse(
        centre,
        a,
        b,
        t0,
        t0 + side * float(arc.sweep),
    )
