"""SVG drawings: paths and basic shapes, read by svgelements; what cannot be drawn is listed."""

from __future__ import annotations

import io
import math
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import svgelements  # the extra `draw`

from .draft import Draft, Move, listed
from .fit import Bezier, Ellipse
from .pieces import Line
from .svg_checks import LINE, NUMBER, PIXELS, SVG, clean, length, refuse_endless

METRE = 0.0254 / 96  # of a pixel, by CSS
CLOSED = 1e-12  # m, by which rounding may leave a closed path open


def read_svg(text: str, name: str, units: str | None = None) -> Draft:
    """The Draft of an SVG drawing: outlines of its shapes as they are seen, y up, the origin at the lower left.

    units: "mm", "px", ...: of its user units, where the file does not say how large it is; else px, 1/96 inch.
    ValueError with file and line for what is no SVG, for bad path data and transforms, for units that contradict.
    """
    root = _tree(text, name)
    draft = Draft(name)
    clean(root, draft)
    to_metres = _viewport(root, draft, units)
    refuse_endless(root, name)
    source = io.BytesIO(ElementTree.tostring(root))
    unseen, filled = [], []
    try:
        elements = list(svgelements.SVG.parse(source, reify=False, on_error="raise").elements())
    except (ValueError, AttributeError, TypeError, IndexError, ZeroDivisionError, RecursionError) as error:
        raise ValueError(f"{name}: svgelements cannot read it: {type(error).__name__}: {error}") from error
    for element in elements:
        if isinstance(element, svgelements.Shape):
            _add(element, to_metres, draft, unseen, filled)
    if filled:
        draft.said.append(f"areas are not filled: their outlines are drawn{listed(filled)}")
    if unseen:
        draft.said.append(f"{len(unseen)} shapes that are not seen are passed over{listed(unseen)}")
    return draft


def _tree(text, name):
    """The elements, each with its line as an attribute."""
    parser, builder = expat.ParserCreate("utf-8", "}"), ElementTree.TreeBuilder()

    def named(word):
        return "{" + word if "}" in word else word

    def start(tag, attributes):
        line = {LINE: str(parser.CurrentLineNumber)}
        builder.start(named(tag), {named(key): value for key, value in attributes.items()} | line)

    def refuse(*_):
        raise ValueError(f"{name}, line {parser.CurrentLineNumber}: entities are not read: save it as plain SVG")

    parser.StartElementHandler, parser.EndElementHandler = start, lambda tag: builder.end(named(tag))
    parser.CharacterDataHandler, parser.EntityDeclHandler = builder.data, refuse
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except expat.ExpatError as error:
        raise ValueError(f"{name}, line {error.lineno}: not XML: {expat.ErrorString(error.code)}") from None
    root = builder.close()
    if root.tag.removeprefix(SVG) != "svg":
        raise ValueError(f"{name}, line {root.get(LINE)}: not an SVG, but <{root.tag}>")
    return root


def _viewport(root, draft, units):
    """(metres per user unit along x, along y, shift in metres): from x + i y of the file, y down, to metres, y up."""
    where = f"{draft.name}, line {root.get(LINE)}: <svg>"
    size = {key: root.attrib.pop(key, None) for key in ("width", "height")}
    sizes = [None if v is None or "%" in v else length(v, f"{where}: {key}", True) for key, v in size.items()]
    box = root.attrib.pop("viewBox", None)
    keep = root.attrib.pop("preserveAspectRatio", "xMidYMid").strip()
    if box is not None:
        numbers = [float(n) for n in NUMBER.findall(box)]
        if len(numbers) != 4 or NUMBER.sub(" ", box).replace(",", " ").strip() or min(numbers[2:]) <= 0:
            raise ValueError(f"{where}: viewBox must be four numbers, the last two > 0, not {box!r}")
    stated = [s for s in sizes if s and s[1] not in ("", "px")]
    if units is not None and stated:
        raise ValueError(f"{where}: units are given as {units}, but its size is {size['width']} x {size['height']}")
    unit = METRE if units is None else _unit(units)
    pixels = [None if s is None else s[0] * unit if s[1] in ("", "px") else s[0] * PIXELS[s[1]] * METRE for s in sizes]
    if not stated and units is None:
        draft.said.append("it states no size in mm: its units are read as pixels of 1/96 inch")
    if box is None:
        return unit, unit, 1j * (pixels[1] or 0.0)
    wide, high = (s and s / n for s, n in zip(pixels, numbers[2:]))
    if not wide and not high:
        wide = high = unit
    wide, high = wide or high, high or wide
    shift = 0j
    if not keep.startswith("none"):
        pixels = [p or n * s for p, n, s in zip(pixels, numbers[2:], (wide, high))]
        scale = max(wide, high) if keep.endswith("slice") else min(wide, high)
        share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
        spare = [p - n * scale for p, n in zip(pixels, numbers[2:])]
        shift = complex(spare[0] * share.get(keep[1:4], 0.5), spare[1] * share.get(keep[5:8], 0.5))
        wide = high = scale
    total = pixels[1] if pixels[1] is not None else numbers[3] * high
    return wide, high, complex(shift.real - numbers[0] * wide, total - shift.imag + numbers[1] * high)


def _unit(word):
    if word == "m":
        return 1.0
    if word.lower() not in PIXELS:
        raise ValueError(f"units: {word}: known are {', '.join(filter(None, PIXELS))}, m")
    return PIXELS[word.lower()] * METRE


def _add(element, to_metres, draft, unseen, filled):
    """The moves along a shape's outline."""
    values, m = element.values, element.transform
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
        return complex(wide * (m.a * x + m.c * y), -high * (m.b * x + m.d * y))

    def at(point):
        return way(point.x, point.y) + complex(wide * m.e, -high * m.f) + shift

    for segment in svgelements.Path(element):
        kind = type(segment).__name__
        if kind == "Move" or segment.start is None or segment.end is None:
            continue
        start, end = at(segment.start), at(segment.end)
        shape = None
        if kind == "CubicBezier":
            shape = Bezier(np.array([start, at(segment.control1), at(segment.control2), end]))
        elif kind == "QuadraticBezier":
            middle = at(segment.control)
            shape = Bezier(np.array([start, (start + 2 * middle) / 3, (end + 2 * middle) / 3, end]))
        elif kind == "Arc" and segment.sweep:
            shape = _ellipse(segment, way, at, start)
        elif kind == "Close" and abs(end - start) <= CLOSED:
            continue
        elif start != end:
            shape = Line((start.real, start.imag), (end.real, end.imag))
        else:  # of no length: it is listed later
            shape = Bezier(np.full(4, start))
        draft.moves.append(Move(shape, line=line))


def _ellipse(arc, way, at, start):
    """An elliptical arc by its conjugate radii, which any transform keeps."""
    across, up = arc.prx - arc.center, arc.pry - arc.center
    side = math.copysign(1.0, across.x * up.y - across.y * up.x)
    centre, a, b = at(arc.center), way(across.x, across.y), way(up.x, up.y)
    to = start - centre
    area = (a.conjugate() * b).imag
    if area == 0:
        return Bezier(np.array([start, start, at(arc.end), at(arc.end)]))
    t0 = math.atan2((a.conjugate() * to).imag / area, (to.conjugate() * b).imag / area)
    return Ellipse(centre, a, b, t0, t0 + side * float(arc.sweep))
