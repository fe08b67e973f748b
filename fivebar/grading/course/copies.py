"""Programs that are equal: to the letter, or after names, comments and formatting are set aside."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Mapping

# The most of a source that is parsed: Python's parser takes time.
MOST_LETTERS = 60_000
MOST_LINE = 4000


def equal_programs(
    sources: Mapping[str, str], template: str, asked: frozenset[str]
) -> list[tuple[tuple[str, ...], bool]]:
    """Return groups (students, equal to the letter) of more than one.

    Programs are equal where they have the same functions, in any order and whatever their
    arguments, variables and helpers are called. Functions as the template has them do not count.
    asked: the names of functions that a lab gives.
    """
    known = set(functions(template, asked) or ())
    groups: dict = defaultdict(list)
    for student, source in sources.items():
        if source == template:
            continue
        parts = functions(source, asked)
        if parts is None:
            own = source
        else:
            own = tuple(sorted(set(parts) - known))
        if own:
            groups[own].append(student)
    found: list[tuple[tuple[str, ...], bool]] = []
    for students in groups.values():
        if len(students) == 1:
            continue
        distinct = {sources[student] for student in students}
        exact = len(distinct) == 1
        found.append((tuple(students), exact))
    return found


def functions(source: str, asked: frozenset[str]) -> tuple[str, ...] | None:
    """Return the functions and classes of a program with plain names, None where it cannot be
    parsed.
    """
    longest_line = max(map(len, source.split("\n")))
    if len(source) > MOST_LETTERS or longest_line > MOST_LINE:
        return None
    try:
        tree = ast.parse(source)
        given = _given_names(tree) - asked
        found = []
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                found.append(_plain(node, given))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    return tuple(found)


def _given_names(tree):
    """Return the names that a program gives: of variables, arguments, functions and imports."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.alias):
            names.add(node.asname or node.name)
    return names


def _plain(function, given):
    """Return a function's syntax tree as text, the given names numbered as they come."""
    numbers: dict[str, str] = {}

    def plain(name):
        if name not in given:
            return name
        return numbers.setdefault(name, f"name{len(numbers)}")

    for node in ast.walk(function):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            node.name = plain(node.name)
            if _is_text(node.body[0]):
                node.body = node.body[1:]  # without its docstring
        elif isinstance(node, ast.arg):
            node.arg = plain(node.arg)
            node.annotation = None
        elif isinstance(node, ast.Name):
            node.id = plain(node.id)
    return ast.dump(function)


def _is_text(statement):
    if not isinstance(statement, ast.Expr):
        return False
    value = statement.value
    return isinstance(value, ast.Constant) and isinstance(value.value, str)
