"""Functions that students have in common: to the letter, or after names, comments and formatting
are set aside.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Mapping
from itertools import combinations

from ..worker.cell.reading import statements

# The most of a source that is parsed: Python's parser takes time.
MOST_LETTERS = 60_000
MOST_LINE = 4000
# Syntax nodes of a function that is compared, and of all that two students share.
SHORTEST = 60
LEAST = 150
MOST_ALIKE = 3  # students who have the same function, however few there are in all


def equal_programs(
    sources: Mapping[str, str], template: str, asked: frozenset[str]
) -> list[tuple[tuple[str, ...], str]]:
    """Return groups (students, what of their programs is equal) of more than one.

    What students filled in is compared function by function, in any order and whatever their
    arguments, variables and helpers are called. It does not count what the template has, what most
    of a class have, as another template may have it, or what is so short that all must write it.
    asked: the names of functions that a lab gives.
    """
    handed_out = functions(template, asked)
    parts: dict[str, dict[str, tuple[str, int]]] = {}
    for student, source in sources.items():
        parts[student] = {
            text: told
            for text, told in functions(source, asked).items()
            if told[1] >= SHORTEST and text not in handed_out
        }
    owners = Counter(text for found in parts.values() for text in found)
    common = {text for text, count in owners.items() if count > max(MOST_ALIKE, len(sources) / 2)}
    groups: dict[frozenset[str], dict[str, None]] = {}
    for one, other in combinations(parts, 2):
        shared = frozenset(parts[one].keys() & parts[other].keys() - common)
        if sum(parts[one][text][1] for text in shared) >= LEAST:
            groups.setdefault(shared, {}).update({one: None, other: None})
    return [(tuple(students), _words(sources, parts, *students)) for students in groups.values()]


def _words(sources, parts, first, *others):
    """Return what students share."""
    if all(sources[student] == sources[first] for student in others):
        return "all, to the letter"
    same = set.intersection(*(set(parts[student]) for student in (first, *others)))
    names = sorted(parts[first][text][0] for text in same)
    return f"{', '.join(names)}, but for names and formatting"


def functions(source: str, asked: frozenset[str]) -> dict[str, tuple[str, int]]:
    """Return the functions and classes of a program with plain names, each as text -> (its own
    name, its number of syntax nodes); the program as it is, too, where not all can be parsed.
    """
    longest_line = max(map(len, source.split("\n")))
    if len(source) > MOST_LETTERS or longest_line > MOST_LINE:
        return {source: ("all", LEAST)}
    body, error = statements(source, "")
    found = {source: ("all", LEAST)} if error else {}
    given = _given_names(ast.Module(body, [])) - asked
    try:
        for node in body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                name = node.name
                found[_plain(node, given)] = name, sum(1 for _ in ast.walk(node))
    except RecursionError:  # too deep to be written as text
        found[source] = "all", LEAST
    return found


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
            if ast.get_docstring(node) is not None:
                node.body = node.body[1:]
        elif isinstance(node, ast.arg):
            node.arg = plain(node.arg)
            node.annotation = None
        elif isinstance(node, ast.Name):
            node.id = plain(node.id)
    return ast.dump(function)
