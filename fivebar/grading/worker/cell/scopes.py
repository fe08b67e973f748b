"""The functions of a program with the names that have a value in them, and copies of its trees;
standard library only.
"""

from __future__ import annotations

import ast
import builtins
import contextlib
import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from types import FunctionType, ModuleType
from typing import Any

WHOLE = 0, 1, 2  # numbers that stand for themselves
MOST_OF_ARRAY = 200  # nodes of a vector or a matrix: what is larger are data
MOST_NODES = 3_000  # of a function: symbolic expressions that were pasted are left as they are
DEPTH = 3  # of objects that hold objects
MOST_TEXT = 120  # characters quoted: what is told can be carried out
REWRITES: list[Callable[[ast.Module], ast.Module]] = []  # of this process's file
LEG_NUMBER = re.compile(r"(?<=[A-Za-z_])(?<!tan)[12](?=\d|D|\b)")


@dataclass(frozen=True)
class Scope:
    """The names of a function, or of a line that makes an array of the file: arguments in order,
    those to which it gives a value, numbers of the file; all of them; functions of the file with
    their arguments; known: all names with a value; values: those of numbers that are no small whole
    ones.
    """

    function: ast.FunctionDef | ast.Lambda | ast.Assign
    name: str
    arguments: list[str]
    stored: list[str]
    constants: list[str]
    names: frozenset[str]
    functions: dict[str, list[str]]
    known: frozenset[str]
    values: dict[str, float]

    def like(self, name: str) -> list[str]:
        """Return names that are taken for this one by mistake: other digits, u and v, x and y."""
        bare = _bare(name)
        return sorted(other for other in self.names if other != name and _bare(other) == bare)


def _bare(name):
    return re.sub(r"^v", "u", re.sub(r"^y", "x", re.sub(r"\dt?", "", name)))


def scopes(body: list[ast.stmt], function: str, apart: list[str]) -> Iterator[Scope]:
    """Yield a function's scope, and those of the functions that it calls and of the arrays that it
    reads.
    """
    # Methods of one name may be of several classes.
    defined: dict[str, list] = {name: [(node, name)] for name, node in arrays(body).items()}
    arguments = {}
    for node in body:
        owner = node if isinstance(node, ast.ClassDef) else None
        for part in owner.body if owner else [node]:
            made, name = function_of(part)
            if made is None or sum(1 for _ in ast.walk(made)) > MOST_NODES:
                continue
            called = owner.name if owner and name == "__init__" else name
            defined.setdefault(called, []).append((made, called))
            arguments[called] = _own_arguments(made)
    lines = [node for node in body if isinstance(node, ast.Assign) and not function_of(node)[0]]
    constants = names_in(chain(*(node.targets for node in lines)), ast.Store)
    values: dict[str, float] = {}
    for node in lines:
        value = getattr(node.value, "value", None)
        if isinstance(value, float) and value not in WHOLE:
            values |= dict.fromkeys(names_in(node.targets, ast.Store), value)
    top = {part.asname or part.name for node in body for part in getattr(node, "names", ())}
    waiting, seen = deque([function]), []
    while waiting:
        name = waiting.popleft()
        if name in seen or name not in defined or (name in apart and name != function):
            continue
        seen.append(name)
        for node, _ in defined[name]:
            parts = ast.walk(node)
            waiting += [getattr(part, "id", getattr(part, "attr", "")) for part in parts]
    for node, name in chain(*(defined[name] for name in seen)):
        given = {part.arg for part in ast.walk(node) if isinstance(part, ast.arg)} - {"self"}
        stored = sorted({*names_in([node], ast.Store)})
        known = {*given, *stored, *constants, *defined, *top}
        yield Scope(
            node,
            name,
            _own_arguments(node),
            stored,
            constants,
            frozenset({*names_in([node]), *given, *constants}),
            arguments,
            frozenset({*known, *dir(builtins)}),
            values,
        )


def names_in(nodes: Iterable[ast.AST], *contexts: type) -> list[str]:
    """Return the names in trees that are read, ast.Load, or get a value, ast.Store; else both."""
    names = [part for part in chain(*map(ast.walk, nodes)) if isinstance(part, ast.Name)]
    return [name.id for name in names if isinstance(name.ctx, contexts or ast.expr_context)]


def function_of(node: ast.stmt) -> tuple[ast.FunctionDef | ast.Lambda | None, str]:
    """Return the function that a statement makes, and its name; None where it makes none."""
    if isinstance(node, ast.FunctionDef):
        return node, node.name
    if isinstance(node, ast.Assign) and isinstance(node.value, ast.Lambda):
        target = node.targets[0]
        if isinstance(target, ast.Name):
            return node.value, target.id
    return None, ""


def arrays(body: list[ast.stmt]) -> dict[str, ast.Assign]:
    """Return the lines that make an array of the file, which nothing changes later, or compute one
    from such, by its name.
    """
    parts = [part for node in body for part in ast.walk(node)]
    names: set[str] = set()
    for part in parts:
        if isinstance(part, ast.Global):
            names |= {*part.names}
        elif isinstance(part, ast.AugAssign):
            names.add(getattr(part.target, "id", ""))
        elif isinstance(part, ast.Subscript) and isinstance(part.ctx, ast.Store):
            names.add(getattr(part.value, "id", ""))
    top = [node for node in body if not isinstance(node, ast.FunctionDef | ast.ClassDef)]
    stored = names_in(top, ast.Store)
    names |= {name for name in stored if stored.count(name) > 1}
    functions = {name for _, name in map(function_of, body)}
    found: dict[str, ast.Assign] = {}
    for node in top:
        target = node.targets[0] if isinstance(node, ast.Assign) else None
        if not isinstance(node, ast.Assign) or not isinstance(target, ast.Name):
            continue
        made, used = [*ast.walk(node.value)], {*names_in([node.value])}
        is_array = any(isinstance(part, ast.List) for part in made) or used & found.keys()
        if len(made) > MOST_OF_ARRAY or used & functions:
            continue
        if is_array and target.id not in names | functions:
            found[target.id] = node
    return found


def _target(node):
    return node.targets[0].id


def _own_arguments(function):
    if isinstance(function, ast.Assign):
        return []
    return [part.arg for part in function.args.args if part.arg != "self"]


def other_leg(text: str) -> str:
    """Return a formula with the names of one leg in place of those of the other."""
    return LEG_NUMBER.sub(lambda found: str(3 - int(found[0])), text)


def rebuilt(node: ast.AST, put: Callable) -> Any:
    """Return a copy of a tree; put(node, its copy) gives what comes in its place."""
    fields = {name: _copied(value, put) for name, value in ast.iter_fields(node)}
    return put(node, ast.copy_location(type(node)(**fields), node))


def _copied(value, put):
    if isinstance(value, ast.AST):
        return rebuilt(value, put)
    if not isinstance(value, list):
        return value
    parts = []
    for part in value:
        copy = _copied(part, put)
        parts += copy if isinstance(copy, list) else [copy]
    return parts


def exchanged(body: list[ast.stmt], swaps: dict[int, Any]) -> list[ast.stmt]:
    """Return a program's statements with other nodes in place of some; swaps: id of a node -> the
    one in its place.
    """

    def put(old, copy):
        new = swaps.get(id(old), copy)
        for part in ast.walk(new) if isinstance(new, ast.expr) and new is not copy else ():
            if getattr(part, "lineno", 0) == 1:  # a text of its own was read
                ast.copy_location(part, old)
        return new

    made = [rebuilt(node, put) for node in body]
    return [ast.fix_missing_locations(node) for node in made]


def compiled(body: list[ast.stmt], scopes: list[Scope], put: Callable) -> dict[str, Any]:
    """Return the code of the statements that hold these functions, rebuilt, by name; as the file
    itself, with what REWRITES says.
    """
    inside = {id(scope.function) for scope in scopes}
    code = {}
    for node in body:
        if any(id(part) in inside for part in ast.walk(node)):
            made = ast.Module([rebuilt(node, put)], [])
            for rewrite in REWRITES:
                made = rewrite(made)
            name = getattr(node, "name", "") or function_of(node)[1] or _target(node)
            with contextlib.suppress(SyntaxError, ValueError):  # it is left as it stands
                code[name] = compile(ast.fix_missing_locations(made), "<changed>", "exec")
    return code


def put_in(space: dict, code: dict[str, Any], apart: list[str]) -> bool:
    """Put compiled functions into a module; return whether a class is among them. Objects of such
    a class that the module holds become objects of the new one.
    """
    for name, lines in code.items():
        if name not in apart:
            exec(lines, space)
    classes = {name: space[name] for name in code if isinstance(space.get(name), type)}
    for value in [*space.values()] if classes else ():
        _renew(value, classes, DEPTH)
    return bool(classes)


def _renew(value, classes, depth):
    if isinstance(value, ModuleType | FunctionType | type) or not hasattr(value, "__dict__"):
        return
    if (new := classes.get(type(value).__name__)) is not None:
        value.__class__ = new
    for part in vars(value).values() if depth else ():
        _renew(part, classes, depth - 1)


def short(text: str) -> str:
    """Return a formula as it is quoted, without the modules that what is tried needs."""
    text = re.sub(r"__import__\('(numpy|math)'\)\.(linalg\.)?", "", text)
    text = text.replace(" - -", " + ").replace(" + -", " - ")
    text = re.sub(r"globals\(\)\['(\w+)'\]", r"the file's \1", text)
    return text if len(text) <= MOST_TEXT else f"{text[: MOST_TEXT - 4]} ..."
