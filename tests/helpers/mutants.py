"""Files with one thing changed at random, and whether what is named of them holds elsewhere, too."""

import ast
import copy
import random
import re
import sys
import warnings
from dataclasses import replace
from types import ModuleType

import numpy as np

from fivebar.base import old_numpy
from fivebar.grading import Reply, judge
from fivebar.grading.labs import find_lab
from fivebar.grading.ten_models import TEN, TOLERANCE, columns_of, motions
from tests.helpers import DATA

SWAPS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.MatMult: ast.Mult,
    ast.Pow: ast.Mult,
}
FOLDER = DATA / "hand_ins"
NAMES = {
    "sin": "cos",
    "cos": "sin",
    "q11": "q21",
    "q21": "q11",
    "q12": "q22",
    "q22": "q12",
    "q11D": "q21D",
    "q12D": "q11D",
    "q21D": "q22D",
    "gamma1": "gamma2",
    "gamma2": "gamma1",
    "u11": "u12",
    "u12": "u11",
    "v11": "v12",
    "v12": "v11",
    "x1": "x2",
    "y1": "y2",
    "A": "B",
    "B": "A",
    "d1": "d2",
    "t1": "t2",
    "xD": "yD",
    "l": "d",
    "d": "l",
}


def mutants(source: str, n: int, seed: int):
    """n sources that differ from this one by one operator, name, number or sign."""
    draw, tree = random.Random(seed), ast.parse(source)
    places = [k for k, node in enumerate(ast.walk(tree)) if _changes(node)]
    for place in draw.sample(places, min(n, len(places))):
        changed = copy.deepcopy(tree)
        node = list(ast.walk(changed))[place]
        draw.choice(_changes(node))(node)
        yield ast.unparse(ast.fix_missing_locations(changed))


def _changes(node):
    """Functions that change a node of the syntax tree in place."""
    if isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
        yield_ = [lambda n: setattr(n, "op", SWAPS[type(n.op)]())]
        if isinstance(node.op, ast.Mult | ast.Div):
            yield_.append(
                lambda n: n.__dict__.update(right=ast.Constant(1), op=ast.Mult())
            )  # a factor forgotten
        if isinstance(node.op, ast.Add | ast.Sub):
            yield_.append(
                lambda n: n.__dict__.update(right=ast.Constant(0), op=ast.Add())
            )  # a term forgotten
        return yield_
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in NAMES:
        return [lambda n: setattr(n, "id", NAMES[n.id])]
    if isinstance(node, ast.Attribute) and node.attr in ("sin", "cos"):
        return [lambda n: setattr(n, "attr", NAMES[n.attr])]
    if isinstance(node, ast.Attribute) and node.attr == "T":
        return [lambda n: setattr(n, "attr", "real")]
    if isinstance(node, ast.Constant) and node.value in (2, 0.5):
        return [lambda n: setattr(n, "value", 1)]
    return []


def answers(source, constants, name, columns):
    """Replies of a function of this source."""
    module = ModuleType("student")
    old_numpy.install()
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy's of its class `matrix`
        try:
            # As the grader runs it: old files take arrays of one element for numbers.
            exec(old_numpy.compiled(source, "student"), module.__dict__)
        except Exception:
            return None
        module.__dict__.update(
            {key: value for key, value in constants.items() if key in module.__dict__}
        )
        return [
            _reply(module.__dict__.get(name), row)
            for row in zip(*(np.asarray(c).tolist() for c in columns))
        ]


def _reply(function, row):
    try:
        value = function(*row)
        return Reply("value", list(value) if isinstance(value, tuple) else value)
    except Exception as error:
        return Reply("exception", text=f"{type(error).__name__}: {error}")


def tried(lab, base, n, seed):
    """(mutant, function, name given or "", does it hold on other rows of a robot of other numbers?) of wrong ones."""
    lab = find_lab(lab)
    robot, draw, found = lab.robot(), np.random.default_rng(seed), []
    other = replace(
        robot,
        **{key: 1.15 * getattr(robot, key) for keys in lab.constants().values() for key in keys},
    )
    exercises = lab.exercises()
    source = (FOLDER / f"{base}.py").read_text("utf-8").split("if __name__")[0]
    source = re.sub(r"(?m)^(from lab_amoro|import rclpy|import matplotlib).*$", "", source)
    for name, ours in (
        ("L", "l"),
        ("dist", "d"),
        ("D", "d"),
        ("m", "mR"),
        ("masse", "mR"),
        ("Izz", "ZZ1R"),
    ):
        source = re.sub(rf"\b{name}\b", ours, source)
    for k, mutant in enumerate(mutants(source, n, seed)):
        acc, fresh = motions(robot, draw, 16), motions(other, draw, 24)
        for name in TEN:
            found += [
                (k, name, *case)
                for case in _named(lab, exercises[name], mutant, robot, other, acc, fresh)
            ]
    return found


def _named(lab, exercise, source, robot, other, acc, fresh):
    constants = {file: getattr(robot, own[0]) for file, own in lab.constants().items()}
    columns = columns_of(exercise.name, acc)
    replies = answers(source, constants, exercise.name, columns)
    if replies is None:
        return
    verdict = judge(exercise, robot, columns, replies, TOLERANCE)
    if verdict.share == 1 or verdict.reason != "value":
        return
    if verdict.diagnosis is None:
        yield "", None
        return
    held = columns_of(exercise.name, fresh)
    others = {file: getattr(other, own[0]) for file, own in lab.constants().items()}
    again = judge(exercise, other, held, answers(source, others, exercise.name, held), TOLERANCE)
    other_name = again.diagnosis.name if again.diagnosis else ""
    # A plain relation holds numbers, which another robot changes.
    same = re.sub(r"[-\d.e]+", "", other_name) == re.sub(r"[-\d.e]+", "", verdict.diagnosis.name)
    yield verdict.diagnosis.name, same or f"there: {other_name or 'nothing'}"


if __name__ == "__main__":
    lab, base, n, seed = sys.argv[1:]
    cases = tried(lab, base, int(n), int(seed))
    for case in cases:
        print(*case)
    named = [case for case in cases if case[2]]
    print(
        f"{len(cases)} wrong answers, {len(named)} named, {sum(case[3] is True for case in named)} hold elsewhere"
    )
