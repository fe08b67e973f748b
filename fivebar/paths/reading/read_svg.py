"""Read the outlines of an SVG drawing with svgelements."""

from __future__ import annotations

import io
import math
import re
from collections import defaultdict
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import svgelements

from ...base.tables import STRANGE
from ...base.units import METRES
from ..fit import Bezier, Ellipse
from ..pieces import Line
from .css import apply_rules, read_sheet
from .draft import Draft, Move, listed

SVG = "{http://www.w3.org/2000/svg}"
LINE = "data-fivebar-line"  # the attribute that carries an element's line through svgelements
INCH = METRES["in"]
IN_METRES = METRES | {"": INCH / 96, "px": INCH / 96, "pt": INCH / 72, "pc": INCH / 6}
PATH_DATA = re.compile(r"\s*(none|[Mm][MmLlHhVvCcSsQqTtAaZz\deE+\-.,\s]*)?")
TRANSFORM = re.compile(r"([\s,]*(matrix|translate|scale|rotate|skew[XY])\s*\([\d\seE.,+-]*\))*\s*")
NOT_DRAWN = "text", "image", "foreignObject"
NOT_APPLIED = "mask", "stroke-dasharray", "filter", "marker-start", "marker-mid", "marker-end"
TEMPLATES = (
    "symbol",
    "marker",
    "mask",
    "clipPath",
    "pattern",
)  # drawn only where something uses them
# What svgelements would take from the element around, as if it were a style.
OWN = {
    "svg": {"x": "0", "y": "0", "width": "100%", "height": "100%"},
    "rect": {"x": "0", "y": "0", "width": "0", "height": "0"},
    "use": {"x": "0", "y": "0"},
}
LENGTHS = ("x", "y", "width", "height", "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2")
INVISIBLE = "invisible shapes are not drawn"
ZERO = re.compile(r"\s*[+-]?(0+\.?0*|\.0+)%?\s*")
LINKS = "href", "{http://www.w3.org/1999/xlink}href"
MOST = 100_000  # elements, counting each copy that <use> makes
CLOSED = 1e-12  # m, by which rounding may leave a closed path open


def read_svg(text: str, name: str, units: str | None = None) -> Draft:
    """Return the outlines of the visible shapes, y up, the origin at the lower left.

    units: of a drawing whose size has no unit, "mm" for example; by default CSS pixels, 1/96 inch.
    """
    root = _tree(text, name)
    draft = Draft(name)
    passed: defaultdict[str, list] = defaultdict(list)
    _apply_sheets(root, passed)
    for element in root.iter():
        _check(element, name)
    _give_own_lengths(root, name)
    _refuse_repetition(root, name, passed)
    _choose_branches(root, passed)
    _hide_templates(root)
    source = io.BytesIO(ElementTree.tostring(root, "utf-8"))
    try:
        svg = svgelements.SVG.parse(source, reify=False, on_error="raise", parse_display_none=True)
        shapes = list(_shapes(svg, passed))
        metres = _metres_per_pixel(svg, draft, units)
    except (*STRANGE, SyntaxError, RecursionError) as error:
        reason = str(error) or "its width or height is not understood: write them in mm"
        raise ValueError(f"{name}: cannot be read as SVG: {reason}") from error
    origin = 1j * metres * float(svg.height or 0.0)
    for tag in NOT_DRAWN:
        for element in root.iter(SVG + tag):
            passed[f"<{tag}> is not drawn"].append(element.get(LINE))
    for shape in shapes:
        _add(shape, metres, origin, draft, passed)
    draft.notes += [f"{what}{listed(map(int, lines))}" for what, lines in sorted(passed.items())]
    return draft


def _tree(text, name):
    """Return the root element; each element has its line as an attribute."""
    parser = expat.ParserCreate("utf-8", "}")
    builder = ElementTree.TreeBuilder()

    def qualified(word):
        return "{" + word if "}" in word else word

    def start(tag, attributes):
        values = {qualified(key): value for key, value in attributes.items()}
        builder.start(qualified(tag), values | {LINE: str(parser.CurrentLineNumber)})

    def end(tag):
        builder.end(qualified(tag))

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except expat.ExpatError as error:
        raise ValueError(f"{name}: not XML: {error}") from None
    root = builder.close()
    if root.tag.removeprefix(SVG) != "svg":
        raise ValueError(f"{name}, line {root.get(LINE)}: not an SVG, but <{root.tag}>")
    return root


def _apply_sheets(root, passed):
    """Apply style sheets, of which svgelements reads few selectors."""
    rules = []
    for sheet in root.iter(f"{SVG}style"):
        text = sheet.text or ""
        if "media" in sheet.attrib:
            text = f"@media {{{text}}}"
        sheet.text = ""
        for words in read_sheet(text, rules):
            passed[f"{words} of CSS is not applied"].append(sheet.get(LINE))
    apply_rules(root, rules)


def _check(element, name):
    """Raise ValueError for what svgelements would silently read as something else."""
    tag = element.tag.removeprefix(SVG)
    where = f"{name}, line {element.get(LINE)}: <{tag}>"
    # A path without d draws nothing; svgelements needs one.
    data = element.attrib.setdefault("d", "") if tag == "path" else ""
    try:
        svgelements.Path(data)
        valid = PATH_DATA.fullmatch(data)
    except STRANGE:
        valid = None
    if not valid:
        raise ValueError(f"{where}: d is not valid path data: {data.strip()[:40]!r}")
    transform = element.get("transform", "")
    if not TRANSFORM.fullmatch(transform):
        raise ValueError(f"{where}: not a valid transform: {transform[:40]!r}")
    moves = re.search(r"(?<![-\w])transform", element.get("style"))
    if moves or "transform-origin" in element.attrib:
        raise ValueError(f"{where}: write its transform as one attribute, without an origin")
    if tag == "symbol" and "viewBox" in element.attrib:
        raise ValueError(f"{where}: a symbol with a viewBox is not read: expand its copies")
    if tag == "ellipse" and ("rx" in element.attrib) != ("ry" in element.attrib):
        raise ValueError(f"{where}: rx and ry are both needed")


def _give_own_lengths(root, name):
    """Give each element its own place and size; ValueError for % that svgelements misreads."""
    root.attrib |= {"x": "0", "y": "0"}
    # svgelements keeps the size of the last <svg>, and swaps that of one without a viewBox.
    is_read = "viewBox" in root.attrib
    for element in root.iter():
        if element is not root:
            tag = element.tag.removeprefix(SVG)
            element.attrib = OWN.get(tag, {}) | element.attrib
            in_percent = any(element.get(key, "").strip().endswith("%") for key in LENGTHS)
            if in_percent and not is_read:
                raise ValueError(
                    f"{name}, line {element.get(LINE)}: <{tag}>: lengths in % are read only in a"
                    " drawing of one <svg>, which has a viewBox"
                )
            is_read = is_read and tag != "svg"


def _refuse_repetition(root, name, passed):
    """Raise ValueError where <use> repeats itself, or more elements than a drawing has.

    List in `passed` where it has nothing to repeat.
    """
    known = {element.get("id"): element for element in root.iter() if element.get("id")}
    sizes = {}

    def size(element, above):
        key = id(element)
        if key in above:
            raise ValueError(f"{name}, line {element.get(LINE)}: <use> repeats itself without end")
        if key not in sizes:
            links = [element.get(link) for link in LINKS if link in element.attrib]
            target = known.get(links[0][1:]) if links else None
            if target is None and element.tag == f"{SVG}use":
                passed["<use> finds nothing to draw"].append(element.get(LINE))
            parts = [*element] if target is None else [*element, target]
            sizes[key] = 1 + sum(size(part, above | {key}) for part in parts)
        return sizes[key]

    if size(root, frozenset()) > MOST:
        raise ValueError(f"{name}: more than {MOST} elements")


def _choose_branches(root, passed):
    """Leave of each <switch> the first branch that a reader of English without extensions sees."""
    for switch in list(root.iter(f"{SVG}switch")):
        passed["of <switch> one branch is drawn"].append(switch.get(LINE))
        seen = [branch for branch in switch if _is_seen(branch)]
        for branch in list(switch):
            if branch not in seen[:1]:
                switch.remove(branch)


def _is_seen(branch):
    """Return whether a branch of a <switch> asks for nothing that this reader does not have."""
    languages = branch.get("systemLanguage", "en").split(",")
    speaks = any(language.strip().lower().startswith("en") for language in languages)
    has_extensions = "requiredExtensions" in branch.attrib
    return speaks and not has_extensions and branch.tag != f"{SVG}foreignObject"


def _hide_templates(root):
    """Put templates into <defs>, because svgelements draws them where they are defined."""
    for parent in list(root.iter()):
        for k, child in enumerate(parent):
            tag = child.tag.removeprefix(SVG)
            if tag in TEMPLATES:
                if tag == "symbol":  # as what a <use> copies
                    child.tag = f"{SVG}g"
                parent[k] = ElementTree.Element(f"{SVG}defs")
                parent[k].append(child)


def _shapes(element, passed):
    """Yield the shapes of a group that are shown, and list where a group clips them."""
    values = element.values
    if values.get("display", "").lower() == "none" or ZERO.fullmatch(values.get("opacity", "")):
        passed[INVISIBLE].append(values[LINE])
        return
    if values.get("clip-path", "none") != "none":
        passed["clip-path is not applied"].append(values[LINE])
    if isinstance(element, svgelements.Shape):
        yield element
    elif isinstance(element, list):
        for part in element:
            yield from _shapes(part, passed)


def _metres_per_pixel(svg, draft, units):
    """Return m per unit of svgelements' coordinates, from the drawing's width or from `units`."""
    if units is not None and units not in IN_METRES:
        known = ", ".join(filter(None, IN_METRES))
        raise ValueError(f"units of an SVG must be one of {known}, not {units!r}")
    size = re.fullmatch(r"\s*([\d.eE+-]+)\s*(mm|cm|in|pt|pc)\s*", str(svg.values.get("width")))
    if size is None:
        if units is None:
            draft.notes.append("it states no size in mm: its units are read as pixels of 1/96 inch")
        return IN_METRES[units or "px"]
    if units is not None:
        raise ValueError(f"units are given as {units}, but its width is {size[0]}")
    # svgelements rounds a millimetre to 3.7795296 px; the ratio of widths does not.
    return float(size[1]) * IN_METRES[size[2]] / float(svg.width)


def _add(element, metres, origin, draft, passed):
    """Add the moves along a shape's outline, and list what of its look is not drawn."""
    values = element.values
    matrix = element.transform
    line = int(values[LINE])
    hidden = values.get("visibility") in ("hidden", "collapse")
    is_filled = _is_painted(values, "fill")
    if hidden or not (is_filled or _is_painted(values, "stroke")):
        passed[INVISIBLE].append(line)
        return
    for key in NOT_APPLIED:
        if values.get(key, "none") != "none":
            passed[f"{key} is not applied"].append(line)

    def direction(vector):
        x = matrix.a * vector.x + matrix.c * vector.y
        y = matrix.b * vector.x + matrix.d * vector.y
        return metres * complex(x, -y)

    def place(point):
        return direction(point) + metres * complex(matrix.e, -matrix.f) + origin

    outlines = [[]]
    for segment in _with_smooth_starts(svgelements.Path(element)):
        kind = type(segment).__name__
        if kind == "Move" or segment.start is None or segment.end is None:
            outlines.append([])
            continue
        with np.errstate(all="ignore"):  # numbers too large are refused with the curve
            outlines[-1] += [place(segment.point(t)) for t in (0.0, 0.3, 0.7, 1.0)]
        start = place(segment.start)
        end = place(segment.end)
        if kind == "CubicBezier":
            controls = [start, place(segment.control1), place(segment.control2), end]
            shape = Bezier(np.array(controls))
        elif kind == "QuadraticBezier":
            control = place(segment.control)
            controls = [start, (start + 2 * control) / 3, (end + 2 * control) / 3, end]
            shape = Bezier(np.array(controls))
        elif kind == "Arc" and segment.sweep:
            shape = _ellipse(segment, direction, place)
        elif kind == "Close" and abs(end - start) <= CLOSED:
            continue
        elif start != end:
            shape = Line((start.real, start.imag), (end.real, end.imag))
        else:  # of no length: Draft lists it
            shape = Bezier(np.full(4, start))
        draft.moves.append(Move(shape, line=line))
    if is_filled and any(map(_encloses_area, outlines)):
        passed["areas are not filled: their outlines are drawn"].append(line)


def _is_painted(values, what):
    """Return whether the fill or the stroke of a shape is not transparent."""
    paint = values.get(what, "none")
    opacity = values.get(f"{what}-opacity", "")
    return paint not in ("none", "transparent") and not ZERO.fullmatch(opacity)


def _encloses_area(outline):
    """Return whether points of a curve are not all on one line."""
    if not outline:
        return False
    away = np.array(outline) - outline[0]
    longest = away[np.abs(away).argmax()]
    return np.abs((away * longest.conjugate()).imag).max() > CLOSED * abs(longest)


def _with_smooth_starts(segments):
    """Yield segments; S and T mirror a control point only after a curve of the same kind.

    SVG 1.1, 8.3.6 and 8.3.7; svgelements mirrors that of any curve.
    """
    before = None
    for segment in segments:
        kind = type(segment).__name__
        if kind in ("CubicBezier", "QuadraticBezier") and segment.smooth:
            first = "control1"
            last = "control2"
            if kind == "QuadraticBezier":
                first = last = "control"
            mirrored = segment.start
            if type(before).__name__ == kind:
                mirrored = getattr(before, last).reflected_across(segment.start)
            setattr(segment, first, mirrored)
        before = segment
        yield segment


def _ellipse(arc, direction, place):
    """Return an elliptical arc by its conjugate radii, which any affine transform keeps."""
    along = arc.prx - arc.center
    across = arc.pry - arc.center
    side = math.copysign(1.0, along.x * across.y - along.y * across.x)
    centre = place(arc.center)
    a = direction(along)
    b = direction(across)
    start = place(arc.start)
    area = (a.conjugate() * b).imag
    if area == 0:
        end = place(arc.end)
        return Line((start.real, start.imag), (end.real, end.imag))
    # start - centre = a cos t0 + b sin t0
    radius = start - centre
    sine = (a.conjugate() * radius).imag / area
    cosine = (radius.conjugate() * b).imag / area
    t0 = math.atan2(sine, cosine)
    return Ellipse(centre, a, b, t0, t0 + side * float(arc.sweep))
