"""Style sheets of a drawing, written into the style of each element.

Read are selectors of tags, classes and ids, within others (g path) or as their children (g > path).
"""

import re

COMMENT = re.compile(r"/\*.*?(\*/|\Z)", re.DOTALL)
KNOWN = re.compile(r"[-\w.#*>,]*")
NAME = re.compile(r"[.#]?[-\w]+|[*>]")
MOST = 20_000_000  # rules looked at, over all elements


def read_sheet(text, rules):
    """Append the rules of a style sheet; return the words of selectors and @-rules not read.

    A rule is (steps, (specificity, number, declarations)). Steps are sets of the names that
    elements must have: the last one itself, those before it the elements around it. A child has
    the name ">".
    """
    unread = []
    around = []
    parts = re.split("([{}])", COMMENT.sub("", text) + "{}")
    for words, brace in zip(parts[::2], parts[1::2]):
        if brace == "{":
            around.append(words)
        elif len(around) > 1:
            around.pop()
            unread.append("a nested rule")
        elif around:
            for prelude in around.pop().split(";"):  # @import "a.css"; path
                odd = [word for word in prelude.split() if not KNOWN.fullmatch(word)]
                unread += odd[:1]
                for selector in [] if odd else filter(str.strip, prelude.split(",")):
                    compounds = re.sub(r">\s*", " >", selector).split()
                    steps = tuple(frozenset(NAME.findall(compound)) for compound in compounds)
                    names = len(re.findall(r"[-\w]+", selector))
                    specificity = selector.count("#"), selector.count("."), names
                    rules.append((steps, (specificity, len(rules), words)))
    return unread


def apply_rules(root, rules):
    """Write into the style of each element what the rules give it: the last value counts."""
    todo = [(root, set(rules))]
    looked_at = 0
    while todo:
        element, sought = todo.pop()  # the steps that are left of each rule
        names = {">", "*", element.tag.rpartition("}")[2], "#" + element.get("id", "")}
        names.update("." + word for word in element.get("class", "").split())
        found = []
        below = {(steps, rule) for steps, rule in sought if ">" not in steps[0]}
        for (first, *rest), rule in sought:
            if first <= names and rest:
                below.add((tuple(rest), rule))
            elif first <= names:
                found.append(rule)
        looked_at += len(sought) + len(found)
        if looked_at > MOST:
            raise ValueError("it has too many rules of CSS for its elements")
        todo += [(child, below) for child in element]
        bodies = [words for _, _, words in sorted(found)]
        parts = ";".join([*bodies, COMMENT.sub("", element.get("style", ""))]).split(";")
        parts.sort(key=lambda part: "!" in part)  # important ones last
        element.set("style", ";".join(part.partition("!")[0] for part in parts))
