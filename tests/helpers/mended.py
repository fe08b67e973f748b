"""Whether a change that a report tells is where the mistake is, and holds elsewhere: carried out in the source, on other
rows of another robot, outside of the grader's own search."""

import ast
import difflib
import re
import sys

import numpy as np

from fivebar.grading import judge
from fivebar.grading.labs import find_lab
from fivebar.grading.samples import unequal_biglide, unequal_robot
from fivebar.grading.ten_models import TEN, TOLERANCE, columns_of, motions
from fivebar.grading.worker import places
from tests.helpers.mutants import answers

sys.path.insert(0, str(places.CELL))
from changes import WAVES, Variants  # noqa: E402
from scopes import short  # noqa: E402
from watched import Watched  # noqa: E402

sys.path.remove(str(places.CELL))

TOLD = re.compile(r"line (\d+): (.*): right answers come with (.*)")
NUMBERS = {
    "L": "l",
    "dist": "d",
    "D": "d",
    "m": "mR",
    "masse": "mR",
    "Izz": "ZZ1R",
}  # files' names -> the lab's


def in_the_right_place(case, base, spot):
    """Whether each change that is told is in a function, or in a line outside of them, that the mistake is in."""
    wrong = _changed_lines(base, case.source)
    functions = [
        range(node.lineno, node.end_lineno + 1)
        for node in ast.walk(ast.parse(case.source))
        if isinstance(node, ast.FunctionDef)
    ]
    guilty = [lines for lines in functions if wrong & set(lines)]
    return all(
        line in wrong or any(line in lines for lines in guilty) for line, _, _ in _changes(spot)
    )


def holds_elsewhere(case, function, spot):
    """Whether the function is right on fresh rows of a robot of which no two numbers agree, with the change made; None
    where this cannot be said: in a lab of other functions."""
    lab = find_lab(case.lab)
    if function not in TEN or "amoro" not in lab.name:
        return None
    source = _carried_out(case.source, lab, function, _changes(spot))
    if source is None:
        return None
    draw = np.random.default_rng(77)
    robot = unequal_biglide(draw) if "biglide" in lab.name else unequal_robot(draw)
    numbers = {file: getattr(robot, own[0]) for file, own in lab.constants().items()}
    numbers |= {name: numbers[own] for name, own in NUMBERS.items() if own in numbers}
    shared = {
        own: value for keys in lab.constants().values() for own, value in _shared(robot, keys)
    }
    robot = type(robot)(**(robot.parameters | shared))
    columns = columns_of(function, motions(robot, draw, 24))
    source = re.sub(r"(?m)^(from lab_amoro|import rclpy|import matplotlib).*$", "", source)
    for name, value in numbers.items():  # what the file computes from them follows
        source = re.sub(rf"(?m)^{name}\s*=[^=].*$", f"{name} = {value!r}", source)
    replies = answers(source.split("if __name__")[0], numbers, function, columns)
    exercise = lab.exercises()[function]
    return judge(exercise, robot, columns, replies, TOLERANCE).share == 1


def _shared(robot, keys):
    """The numbers of a robot for which a file has one name: all get the first one's value."""
    return [(key, getattr(robot, keys[0])) for key in keys]


def _changes(spot):
    return [
        (int(line), old, new)
        for part in spot.split("; and ")
        for line, old, new in TOLD.findall(part)
    ]


def _changed_lines(base, source):
    """The lines of the source that the base has not, and those beside lines that are gone."""
    lines = set()
    for kind, _, _, low, high in difflib.SequenceMatcher(
        None, base.split("\n"), source.split("\n"), autojunk=False
    ).get_opcodes():
        if kind != "equal":
            lines |= set(range(low + 1, high + 1)) or {low, low + 1}
    return lines


def _carried_out(source, lab, function, changes):
    """The source with the changes made, one after the other."""
    body = ast.parse(source).body
    for line, old, new in changes:
        body = _made(body, lab, function, line, old, new) or _written(
            body, lab, function, line, old, new
        )
        if body is None:
            return None
    return ast.unparse(ast.fix_missing_locations(ast.Module(body, [])))


def _made(body, lab, function, line, old, new):
    """The program after a change of a list, None where it is not in it."""
    variants = Variants(body, function, [*lab.exercises()], [], WAVES[-1])
    found = [k for k, c in enumerate(variants.changes) if _is(c, line, old, new)]
    return variants.changed(found[:1])[0] if found else None


def _written(body, lab, function, line, old, new):
    """The program with a formula written in one place or two, None where there is no such place."""
    watched = Watched(body, function, [*lab.exercises()])
    new, _, places = new.partition(", in ")
    words = watched.told([[-1]])["changes"]
    numbers = [
        k
        for k, group in enumerate(watched.groups)
        if words[k][0] == line and short(words[k][3]) == old and (len(group) > 1) == bool(places)
    ]
    used = {node.id for part in body for node in ast.walk(part) if isinstance(node, ast.Name)}
    missing = {"acos", "asin", "atan2", "sin", "cos", "sqrt", "pi"} - used
    text = re.sub(rf"(?<![.\w])({'|'.join(missing)})\b", r"__import__('math').\1", new)
    return watched.changed([[numbers[0], "", text]])[0] if numbers else None


def _is(change, line, old, new):
    if min(one.place[0] for one in change.members) != line:
        return False
    told = change.told
    return told[3] == old and told[4] == new
