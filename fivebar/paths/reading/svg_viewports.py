"""The viewports of an SVG: how its units become metres, percentages numbers, and what is inside of
others groups.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from .draft import Draft, listed
from .svg_checks import LENGTHS, LINE, NUMBER, PIXELS, SVG, length, link_of

METRE = 0.0254 / 96  # of a pixel, by CSS
ACROSS = ("x", "width", "rx", "cx", "x1", "x2")
UP = ("y", "height", "ry", "cy", "y1", "y2")


def viewport(root: Element, draft: Draft, units: str | None) -> tuple[float, float, complex]:
    """(metres per user unit along x, along y, shift in metres): from x + i y of the file, y down,
    to metres, y up.
    """
    where = f"{draft.name}, line {root.get(LINE)}: <svg>"
    size = {key: root.attrib.pop(key, None) for key in ("width", "height")}
    sizes = [
        None if v is None or "%" in v or v == "auto" else length(v, f"{where}: {key}", True)
        for key, v in size.items()
    ]
    box = _box(root, where)
    keep = root.attrib.pop("preserveAspectRatio", "")
    if "transform" in root.attrib:
        raise ValueError(
            f"{where}: a transform of the whole drawing is not read: put its shapes into a group"
            " with it"
        )
    stated = [s for s in sizes if s and s[1] not in ("", "px")]
    if units is not None and stated:
        raise ValueError(
            f"{where}: units are given as {units}, but its size is {size['width']} x"
            f" {size['height']}"
        )
    unit = METRE if units is None else _unit(units)
    pixels = [
        None if s is None else s[0] * unit if s[1] in ("", "px") else s[0] * PIXELS[s[1]] * METRE
        for s in sizes
    ]
    if not stated and units is None:
        draft.notes.append("it states no size in mm: its units are read as pixels of 1/96 inch")
    flat = _Flat(root, draft)
    if box:
        own = box[2:]
    else:
        own = [p and p / unit for p in pixels]
    for child in list(root):
        flat.visit(child, root, own)
    if flat.switched:
        draft.notes.append(
            f"of <switch> the first part that can be drawn is{listed(flat.switched)}"
        )
    if box is None:
        return unit, unit, 1j * (pixels[1] or 0.0)
    wide, high = (s and s / n for s, n in zip(pixels, box[2:]))
    if not wide and not high:
        wide = high = unit
    wide, high = wide or high, high or wide
    size = [p or n * s for p, n, s in zip(pixels, box[2:], (wide, high))]
    wide, high, x, y = fit(box, size, keep)
    return wide, high, complex(x, size[1] - y)


def fit(box: list[float], size: list[float], keep: str) -> tuple[float, float, float, float]:
    """(scale along x, along y, shift along x, along y) that put a viewBox into a viewport, as
    preserveAspectRatio.
    """
    keep = keep.strip() or "xMidYMid"
    wide, high = (s / n for s, n in zip(size, box[2:]))
    spare = [0.0, 0.0]
    if not keep.startswith("none"):
        wide = high = max(wide, high) if keep.endswith("slice") else min(wide, high)
        share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
        spare = [
            (s - n * wide) * share.get(keep[k : k + 3], 0.5)
            for s, n, k in zip(size, box[2:], (1, 5))
        ]
    return wide, high, spare[0] - box[0] * wide, spare[1] - box[1] * high


def _box(element, where):
    text = element.attrib.pop("viewBox", None)
    if text is None:
        return None
    numbers = [float(n) for n in NUMBER.findall(text)]
    if (
        len(numbers) != 4
        or NUMBER.sub(" ", text).replace(",", " ").strip()
        or min(numbers[2:]) <= 0
    ):
        raise ValueError(f"{where}: viewBox must be four numbers, the last two > 0, not {text!r}")
    return numbers


def _unit(word):
    if word == "m":
        return 1.0
    if word.lower() not in PIXELS:
        raise ValueError(f"units: {word}: known are {', '.join(filter(None, PIXELS))}, m")
    return PIXELS[word.lower()] * METRE


class _Flat:
    """Makes groups with a transform of <svg>, <symbol>, <use> of symbols and <switch>, and numbers
    of percentages.
    """

    def __init__(self, root, draft):
        self.name = draft.name
        self.switched = []
        self.symbols = {}
        for each in root.iter(f"{SVG}symbol"):
            box = _box(
                each,
                f"{self.name}, line {each.get(LINE)}: <symbol>",
            )
            own = {key: each.attrib.pop(key, None) for key in ("width", "height")}
            self.symbols[each.get("id")] = box, each.attrib.pop("preserveAspectRatio", ""), own

    def visit(self, element, parent, size):
        """size: (width, height) of the viewport in user units, None where it is not known."""
        tag = element.tag.removeprefix(SVG)
        where = f"{self.name}, line {element.get(LINE)}: <{tag}>"
        for key in LENGTHS:
            value = element.get(key, "").strip()
            if value.endswith("%"):
                element.set(
                    key,
                    repr(self.number(value, key, size, f"{where}: {key}")),
                )
            elif value == "auto":
                del element.attrib[key]
        radii = {
            key: element.get(key)
            for key in ("rx", "ry")
            if tag == "ellipse" and key in element.attrib
        }
        for key in ("rx", "ry") if len(radii) == 1 else ():  # what is not given is as the other
            element.set(key, *radii.values())
        if tag == "svg":
            box = _box(element, where)
            keep = element.attrib.pop("preserveAspectRatio", "")
            size = self.placed(element, box, keep, {}, size, where)
            element.tag = f"{SVG}g"
        elif tag == "symbol":  # seen only where it is used
            size = (self.symbols[element.get("id")][0] or [0, 0, *size])[2:]
            hidden = Element(f"{SVG}defs", {LINE: element.get(LINE)})
            parent[list(parent).index(element)] = hidden
            element.tag = f"{SVG}g"
            hidden.append(element)
        elif tag == "use":
            href = link_of(element)
            box, keep, own = self.symbols.get(
                element.get(href, "#")[1:],
                (None, "", {}),
            )
            if href and box:
                inner = Element(
                    element.tag,
                    {href: element.attrib.pop(href), LINE: element.get(LINE)},
                )
                self.placed(element, box, keep, own, size, where)
                element.tag = f"{SVG}g"
                element[:] = [inner]
                return
        elif tag == "switch":
            self.switched.append(int(element.get(LINE)))
            element.tag = f"{SVG}g"
            drawn = [
                each
                for each in element
                if each.tag.startswith(SVG) and not each.get("requiredExtensions")
            ]
            element[:] = [each for each in drawn if each.tag != f"{SVG}foreignObject"][:1]
        for child in list(element):
            self.visit(child, element, size)

    def placed(
        self,
        element,
        box,
        keep,
        usual,
        size,
        where,
    ):
        """Give an element that opens a viewport its transform; the size inside of it."""
        values = {
            key: element.attrib.pop(key, usual.get(key)) for key in ("x", "y", "width", "height")
        }
        x, y = (_pixels(values[key] or "0", f"{where}: {key}") for key in ("x", "y"))
        across = [
            (
                full
                if values[key] in (None, "100%", "auto")
                else _pixels(values[key], f"{where}: {key}", True)
            )
            for key, full in zip(("width", "height"), size)
        ]
        words = [element.get("transform", ""), f"translate({x!r} {y!r})"]
        if box:
            if None in across:
                raise ValueError(
                    f"{where}: how large it is must be said: neither it nor what is around it has a"
                    " size"
                )
            wide, high, right, down = fit(box, across, keep)
            words.append(f"matrix({wide!r} 0 0 {high!r} {right!r} {down!r})")
        element.set("transform", " ".join(words).strip())
        return box[2:] if box else across

    def number(
        self,
        text,
        key,
        size,
        where,
    ):
        """A percentage of the viewport in user units."""
        share = length(text[:-1], where)[0] / 100
        if key in ACROSS or key in UP:
            full = size[key in UP]
        else:
            if None in size:
                full = None
            else:
                full = math.hypot(*size) / math.sqrt(2)
        if full is None:
            raise ValueError(f"{where} is {text} of a size that the file does not say")
        return share * full


def _pixels(text, where, positive=False):
    number, unit = length(text, where, positive)
    return number * PIXELS[unit]
