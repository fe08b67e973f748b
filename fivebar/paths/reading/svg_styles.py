"""The styles of an SVG, from attributes, `style` and <style>, made attributes; what they hide is
taken out.
"""

from __future__ import annotations

import re
from typing import NamedTuple
from xml.etree.ElementTree import Element

from .draft import Draft, listed
from .svg_checks import CONTAINERS, LENGTHS, LINE, PASSED, SHAPES, SVG

READ = "display", "visibility", "fill", "stroke", "transform-origin", *PASSED, *LENGTHS
COMMENT = re.compile(r"/\*.*?\*/|<!--|-->", re.DOTALL)
AT = re.compile(r"@[\w-]+[^;{]*(?:;|\{(?:[^{}]*\{[^{}]*\})*[^{}]*\})")
RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
SIMPLE = re.compile(r"(\*|[A-Za-z][\w-]*)?((?:[.#][\w-]+)*)")


class _Rule(NamedTuple):
    """chain: ((">" or " ", tag, ids, classes), ...) from the element up; rank: its specificity, and
    its order.
    """

    chain: tuple
    rank: tuple
    declared: dict[str, tuple[bool, str]]


def styled(root: Element, draft: Draft) -> None:
    """Put what styles say where attributes are; what is not displayed becomes <defs>, for <use> may
    show parts of it.

    ValueError for a transform in a style.
    """
    rules = []
    odd = {}
    hidden = []
    for sheet in [each for each in root.iter() if each.tag.removeprefix(SVG) == "style"]:
        _read(sheet, draft.name, rules, odd)
    rules.sort(key=lambda rule: rule.rank)

    def visit(element, above):
        lineage = [element, *above]
        if element.tag.removeprefix(SVG) in SHAPES + CONTAINERS:
            _put(element, lineage, rules, draft.name)
            if element.get("display", "").lower() == "none" and element is not root:
                hidden.append(int(element.get(LINE)))
                element.tag = (  # a shape, too, so that <use> finds what it is not to show
                    f"{SVG}defs"
                )
            element.attrib.pop("display", None)
        for child in list(element):
            if child.tag.removeprefix(SVG) == "style":
                element.remove(child)
            else:
                visit(child, lineage)

    visit(root, [])
    if root.attrib.pop("display", None) == "none":
        hidden.append(int(root.get(LINE)))
    draft.notes += [
        f"style rule {text!r} is not read{listed(lines)}" for text, lines in sorted(odd.items())
    ]
    if hidden:
        draft.notes.append(f"what is not displayed is passed over{listed(hidden)}")


def _read(sheet, name, rules, odd):
    line = int(sheet.get(LINE))
    text = COMMENT.sub(" ", sheet.text or "")
    for rule in AT.findall(text):
        odd.setdefault(rule.split("{")[0].strip()[:40], []).append(line)
    for selectors, body in RULE.findall(AT.sub(" ", text)):
        declared = _declared(body, f"{name}, line {line}: <style>")
        for selector in selectors.split(","):
            chain = _chain(selector.strip())
            if chain:
                rank = (
                    sum(len(part[2]) for part in chain),
                    sum(len(part[3]) for part in chain),
                    sum(part[1] != "*" for part in chain),
                )
                rules.append(_Rule(chain, (rank, len(rules)), declared))
            elif set(declared) & {"display", "visibility", "fill", "stroke"}:
                odd.setdefault(selector.strip()[:40], []).append(line)


def _declared(text, where):
    """{property: (whether it is important, value)} of what is read."""
    found = {}
    for part in text.split(";"):
        key, _, value = part.partition(":")
        key = key.strip().lower()
        value = value.strip()
        if key in ("transform", "rotate", "scale", "translate"):
            raise ValueError(f"{where}: a transform in a style is not read: make it an attribute")
        if key in READ and value:
            found[key] = "!" in value, value.split("!")[0].strip()
    return found


def _chain(selector):
    """The parts of a selector of tags, ids, classes, descendants and children, from the last up; ()
    for any other.
    """
    found = []
    way = " "
    for word in reversed(selector.replace(">", " > ").split()):
        if word == ">":
            way = ">"
            continue
        simple = SIMPLE.fullmatch(word)
        if not simple:
            return ()
        ids = set(re.findall(r"#([\w-]+)", simple[2]))
        classes = set(re.findall(r"\.([\w-]+)", simple[2]))
        found.append((way, simple[1] or "*", ids, classes))
        way = " "
    return tuple(found)


def _meets(chain, lineage):
    """Whether the first of a lineage meets a selector's first part, and those above it the rest."""
    if _simply(chain[0], lineage[0]):
        at = {0}
    else:
        at = set()
    for part in chain[1:]:
        if part[0] == ">":
            above = {k + 1 for k in at}
        else:
            above = range(
                min(at, default=len(lineage)) + 1,
                len(lineage),
            )
        at = {k for k in above if k < len(lineage) and _simply(part, lineage[k])}
    return bool(at)


def _simply(part, element):
    _, tag, ids, classes = part
    own = tag in ("*", element.tag.removeprefix(SVG)) and ids <= {element.get("id")}
    return own and classes <= set(element.get("class", "").split())


def _put(element, lineage, rules, name):
    """Set what the rules and its own style say of an element, the important last."""
    own = _declared(
        element.attrib.pop("style", ""),
        f"{name}, line {element.get(LINE)}: <{element.tag.removeprefix(SVG)}>",
    )
    sheets = [rule.declared for rule in rules if _meets(rule.chain, lineage)]
    for important in (False, True):
        for declared in (*sheets, own):
            element.attrib |= {
                key: value for key, (strong, value) in declared.items() if strong == important
            }
