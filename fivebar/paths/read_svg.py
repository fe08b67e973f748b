"""SVG drawings: paths and basic shapes, read by svgelements; what cannot be drawn is listed."""

from __future__ import annotations

import io
import math
import re
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import svgelements  # the extra `draw`

from .draft import Draft, Move, listed
from .fit import Bezier, Ellipse
from .pieces import Line

SVG = "{http://www.w3.org/2000/svg}"
LINE = "data-fivebar-line"
SHAPES = "path", "rect", "circle", "ellipse", "line", "polyline", "polygon"
CONTAINERS = "svg", "g", "a", "switch", "defs", "symbol", "use", "style"
SILENT = "title", "desc", "metadata"
PIXELS = {"": 1.0, "px": 1.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4, "pt": 96 / 72, "pc": 16.0, "q": 96 / 101.6}
METRE = 0.0254 / 96  # of a pixel, by CSS
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "Z": 0, "A": 7}
TRANSFORMS = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewx": (1,), "skewy": (1,)}
LENGTHS = "x", "y", "width", "height", "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2"
SIZES = "r", "rx", "ry", "width", "height"  # which are not negative
MOST = 100_000  # elements, those counted that `use` repeats


def read_svg(text: str, name: str, units: str | None = None) -> Draft:
    """The Draft of an SVG drawing: outlines of its shapes as they are seen, y up, the origin at the lower left.

    units: "mm", "px", ...: of its user units, where the file does not say how large it is; else px, 1/96 inch.
    ValueError with file and line for what is no SVG, for bad path data and transforms, for units that contradict.
    """
    root = _tree(text, name)
    draft = Draft(name)
    _clean(root, draft)
    to_metres = _viewport(root, draft, units)
    _refuse_endless(root, name)
    source = io.BytesIO(ElementTree.tostring(root))
    unseen = []
    try:
        elements = list(svgelements.SVG.parse(source, reify=False, on_error="raise").elements())
    except (ValueError, AttributeError, TypeError, IndexError, ZeroDivisionError, RecursionError) as error:
        raise ValueError(f"{name}: svgelements cannot read it: {type(error).__name__}: {error}") from error
    for element in elements:
        if isinstance(element, svgelements.Shape):
            _add(element, to_metres, draft, unseen)
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


def _clean(root, draft):
    """Take out what is not drawn, and list it; check what is."""
    passed = {}

    def visit(element):
        for child in list(element):
            tag = child.tag.removeprefix(SVG)
            if tag not in SHAPES + CONTAINERS:
                if tag not in SILENT and not tag.startswith("{"):
                    passed.setdefault(tag, []).append(int(child.get(LINE)))
                element.remove(child)
                continue
            _check(child, tag, draft.name, passed)
            visit(child)

    _check(root, "svg", draft.name, passed)
    visit(root)
    draft.said += [f"<{tag}> is passed over{listed(lines)}" for tag, lines in sorted(passed.items())]


def _check(element, tag, name, passed):
    line = int(element.get(LINE))
    where = f"{name}, line {line}: <{tag}>"
    if "transform" in element.attrib:
        _check_transform(element.get("transform"), where)
    style = element.get("style", "") + (element.text or "") * (tag == "style")
    if re.search(r"(^|[;{\s])transform\s*:", style):
        raise ValueError(f"{where}: a transform in a style is not read: make it an attribute")
    for key in ("clip-path", "mask", "stroke-dasharray", "filter", "marker-start", "marker-mid", "marker-end"):
        if element.get(key, "none") != "none" or re.search(rf"(^|[;\s]){key}\s*:(?!\s*none)", style):
            passed.setdefault(key, []).append(line)
            element.attrib.pop(key, None)
    for key, owners in (("d", "path"), ("points", "polyline polygon")):
        if tag not in owners.split():
            element.attrib.pop(key, None)  # svgelements hands them on to what is inside
    if tag not in SHAPES:
        return
    for key in LENGTHS:
        if key in element.attrib:
            _length(element.get(key), f"{where}: {key}", key in SIZES)
    if tag == "path":
        _check_data(element.get("d", ""), where)
    if tag in ("polyline", "polygon"):
        left = NUMBER.sub(" ", element.get("points", "")).replace(",", " ").strip()
        if left or len(NUMBER.findall(element.get("points", ""))) % 2:
            raise ValueError(f"{where}: points must be pairs of numbers, not {element.get('points')[:60]!r}")


def _length(text, where, positive=False):
    """(number, unit) of a length."""
    found = re.fullmatch(rf"\s*({NUMBER.pattern})\s*([a-zA-Z%]*)\s*", text)
    if not found or found[2].lower() not in PIXELS:
        raise ValueError(
            f"{where} must be a number, perhaps with one of {', '.join(filter(None, PIXELS))}, not {text[:40]!r}"
        )
    if positive and float(found[1]) < 0:
        raise ValueError(f"{where} must not be negative, but is {text}")
    return float(found[1]), found[2].lower()


def _check_data(data, where):
    """ValueError for path data that the standard does not know."""
    if data.strip() in ("", "none"):
        return
    parts = re.split(r"([A-Za-df-z])", data)  # e is of numbers
    if parts[0].strip(" \t\r\n,") or parts[1] not in "Mm":
        raise ValueError(f"{where}: d must begin with M or m, not {data.strip()[:20]!r}")
    for command, text in zip(parts[1::2], parts[2::2]):
        count = COUNTS.get(command.upper())
        if count is None:
            raise ValueError(f"{where}: d has no command {command!r}")
        found, left = _arguments(text, command.upper() == "A")
        if left:
            raise ValueError(f"{where}: d has {left[:20]!r} after {command}")
        if (found % count if count else found) or (count and not found):
            raise ValueError(f"{where}: d gives {command} {found} numbers, it takes {count}")


def _arguments(text, arc):
    """How many numbers a text is, and what in it is none; an arc's flags need nothing between them."""
    count, at = 0, 0
    blank = re.compile(r"[\s,]*")
    while at < len(text):
        at = blank.match(text, at).end()
        found = re.compile(r"[01]").match(text, at) if arc and count % 7 in (3, 4) else NUMBER.match(text, at)
        if not found or found.end() == at:
            break
        count, at = count + 1, found.end()
    return count, text[at:].strip()


def _check_transform(text, where):
    left = text
    for kind, numbers in re.findall(r"([A-Za-z]+)\s*\(([^()]*)\)", text):
        count = len(NUMBER.findall(numbers))
        if NUMBER.sub(" ", numbers).replace(",", " ").strip() or count not in TRANSFORMS.get(kind.lower(), ()):
            raise ValueError(f"{where}: transform {kind}({numbers[:40]}) is not one that SVG has")
        left = left.replace(f"{kind}", "", 1)
    if re.sub(r"\([^()]*\)", " ", left).replace(",", " ").strip():
        raise ValueError(f"{where}: transform {text[:40]!r} is not one that SVG has")


def _viewport(root, draft, units):
    """(metres per user unit along x, along y, shift in metres): from x + i y of the file, y down, to metres, y up."""
    where = f"{draft.name}, line {root.get(LINE)}: <svg>"
    size = {key: root.attrib.pop(key, None) for key in ("width", "height")}
    sizes = [None if v is None or "%" in v else _length(v, f"{where}: {key}", True) for key, v in size.items()]
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


def _refuse_endless(root, name):
    """ValueError where `use` repeats an element in itself, or more than can be meant."""
    known = {element.get("id"): element for element in root.iter() if element.get("id")}
    sizes = {}

    def size(element, above):
        key = id(element)
        if key in above or len(above) > 200:
            raise ValueError(f"{name}, line {element.get(LINE)}: <use> repeats itself without end, or too deep")
        if key not in sizes:
            target = known.get((element.get("{http://www.w3.org/1999/xlink}href") or element.get("href") or "#")[1:])
            inner = [target] if target is not None and element.tag.removeprefix(SVG) == "use" else []
            sizes[key] = 1 + sum(size(child, above | {key}) for child in (*element, *inner))
        return sizes[key]

    if size(root, frozenset()) > MOST:
        raise ValueError(f"{name}: more than {MOST} elements")


def _add(element, to_metres, draft, unseen):
    """The moves along a shape's outline."""
    values, m = element.values, element.transform
    line = int(values[LINE]) if LINE in values else None
    if (
        values.get("visibility") in ("hidden", "collapse")
        or values.get("stroke", "none") == values.get("fill") == "none"
    ):
        unseen.append(line)
        return
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
        elif start != end:
            shape = Line((start.real, start.imag), (end.real, end.imag))
        elif kind == "Close":
            continue
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
