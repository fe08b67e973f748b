"""What an SVG may hold, checked line by line before it is read: what is not drawn is taken out and
listed.
"""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

from .draft import Draft, listed

SVG = "{http://www.w3.org/2000/svg}"
LINE = "data-fivebar-line"
SHAPES = "path", "rect", "circle", "ellipse", "line", "polyline", "polygon"
CONTAINERS = "svg", "g", "a", "switch", "defs", "symbol", "use"
SILENT = "title", "desc", "metadata"
PIXELS = {
    "": 1.0,
    "px": 1.0,
    "in": 96.0,
    "cm": 96 / 2.54,
    "mm": 96 / 25.4,
    "pt": 96 / 72,
    "pc": 16.0,
    "q": 96 / 101.6,
}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "Z": 0, "A": 7}
TRANSFORMS = {
    "matrix": (6,),
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewx": (1,),
    "skewy": (1,),
}
LENGTHS = "x", "y", "width", "height", "r", "rx", "ry", "cx", "cy", "x1", "y1", "x2", "y2"
SIZES = "r", "rx", "ry", "width", "height"  # which are not negative
PASSED = (  # properties that change how a line looks
    "clip-path",
    "mask",
    "stroke-dasharray",
    "filter",
    "marker",
    "marker-start",
    "marker-mid",
    "marker-end",
)
HREF = "href", "{http://www.w3.org/1999/xlink}href"
MOST = 100_000  # elements, those counted that `use` repeats


def clean(root: Element, draft: Draft) -> None:
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
    draft.notes += [
        f"<{tag}> is passed over{listed(lines)}" for tag, lines in sorted(passed.items())
    ]


def _check(element, tag, name, passed):
    line = int(element.get(LINE))
    where = f"{name}, line {line}: <{tag}>"
    if "transform" in element.attrib:
        _check_transform(element.get("transform"), where)
        if element.get("transform-origin", "0 0").replace("px", "").split() != ["0", "0"]:
            raise ValueError(f"{where}: transform-origin is not read: write it into the transform")
    for key in PASSED:
        if element.attrib.pop(key, "none") != "none":
            passed.setdefault(key, []).append(line)
    for key, owners in (("d", "path"), ("points", "polyline polygon")):
        if tag not in owners.split():
            element.attrib.pop(key, None)  # svgelements hands them on to what is inside
    if tag not in (*SHAPES, "use"):
        return
    for key in LENGTHS:
        if key in element.attrib:
            length(
                element.get(key),
                f"{where}: {key}",
                key in SIZES,
            )
    if tag == "path":
        _check_data(element.get("d", ""), where)
    if tag in ("polyline", "polygon"):
        left = NUMBER.sub(" ", element.get("points", "")).replace(",", " ").strip()
        if left or len(NUMBER.findall(element.get("points", ""))) % 2:
            raise ValueError(
                f"{where}: points must be pairs of numbers, not {element.get('points')[:60]!r}"
            )


def length(text: str, where: str, positive: bool = False) -> tuple[float, str]:
    """(number, unit) of a length."""
    found = re.fullmatch(rf"\s*({NUMBER.pattern})\s*([a-zA-Z%]*)\s*", text)
    if not found or found[2].lower() not in PIXELS:
        raise ValueError(
            f"{where} must be a number, perhaps with one of {', '.join(filter(None, PIXELS))}, not"
            f" {text[:40]!r}"
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
    """How many numbers a text is, and what in it is none; an arc's flags need nothing between
    them.
    """
    count = 0
    at = 0
    blank = re.compile(r"[\s,]*")
    while at < len(text):
        at = blank.match(text, at).end()
        if arc and count % 7 in (3, 4):
            found = re.compile(r"[01]").match(text, at)
        else:
            found = NUMBER.match(text, at)
        if not found or found.end() == at:
            break
        count = count + 1
        at = found.end()
    return count, text[at:].strip()


def _check_transform(text, where):
    left = text
    for kind, numbers in re.findall(r"([A-Za-z]+)\s*\(([^()]*)\)", text):
        count = len(NUMBER.findall(numbers))
        if NUMBER.sub(" ", numbers).replace(",", " ").strip() or count not in TRANSFORMS.get(
            kind.lower(), ()
        ):
            raise ValueError(f"{where}: transform {kind}({numbers[:40]}) is not one that SVG has")
        left = left.replace(f"{kind}", "", 1)
    if re.sub(r"\([^()]*\)", " ", left).replace(",", " ").strip():
        raise ValueError(f"{where}: transform {text[:40]!r} is not one that SVG has")


def link_of(element: Element) -> str | None:
    """The attribute by which an element repeats another one, None without: href before xlink:href,
    as SVG 2 has it.
    """
    return next((key for key in HREF if key in element.attrib), None)


def refuse_endless(root: Element, name: str) -> None:
    """ValueError where `use` repeats an element in itself, or more than can be meant."""
    known = {element.get("id"): element for element in root.iter() if element.get("id")}
    sizes = {}

    def size(element, above):
        key = id(element)
        if key in above or len(above) > 200:
            raise ValueError(
                f"{name}, line {element.get(LINE)}: <use> repeats itself without end, or too deep"
            )
        if key not in sizes:
            target = known.get(element.get(link_of(element), "")[1:])
            if target is not None and element.tag.removeprefix(SVG) == "use":
                inner = [target]
            else:
                inner = []
            sizes[key] = 1 + sum(size(child, above | {key}) for child in (*element, *inner))
        return sizes[key]

    if size(root, frozenset()) > MOST:
        raise ValueError(f"{name}: more than {MOST} elements")
