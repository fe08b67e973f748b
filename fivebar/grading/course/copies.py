"""Programs that are equal: to the letter, or after names, comments and formatting are set aside."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Mapping

MOST_LETTERS, MOST_LINE = 60_000, 4000  # of a source that is parsed: Python's parser takes time


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
        own = source if parts is None else tuple(sorted(set(parts) - known))
        if own:
            groups[own].append(student)
    found: list[tuple[tuple[str, ...], bool]] = []
    for students in groups.values():
        exact = all(sources[student] == sources[students[0]] for student in students)
        if len(students) > 1:
            found.append((tuple(students), exact))
    return found


def functions(source: str, asked: frozenset[str]) -> tuple[str, ...] | None:
    """Return the functions and classes of a program with plain names, None where it cannot be
    parsed.
    """
    if len(source) > MOST_LETTERS or max(map(len, source.split("\n"))) > MOST_LINE:
        return None
    try:
        tree = ast.parse(source)
        given = _given_names(tree) - asked
        parts = (ast.FunctionDef, ast.ClassDef)
        return tuple(_plain(node, given) for node in tree.body if isinstance(node, parts))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


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
        return numbers.setdefault(name, f"name{len(numbers)}") if name in given else name

    for node in ast.walk(function):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            node.name = plain(node.name)
            is_docstring = (
                isinstance(node.body[0], ast.Expr)
                and isinstance(node.body[0].value, ast.Constant)
                and isinstance(node.body[0].value.value, str)
            )
            if is_docstring:
                node.body = node.body[1:]
        elif isinstance(node, ast.arg):
            node.arg, node.annotation = plain(node.arg), None
        elif isinstance(node, ast.Name):
            node.id = plain(node.id)
    return ast.dump(function)
