"""Reads a source statement by statement, as far as it can be read; standard library only."""

import ast
import contextlib
import re
import sys
from collections.abc import Iterator

DEEP = 20_000  # calls in each other, to read a source
_START = re.compile(r"[A-Za-z_@(\[\"']")
_HEAD = re.compile(r"def \w+\([^()]*\)")
_CONTINUED = re.compile(r"(elif|else|except|finally)\b")


@contextlib.contextmanager
def deep() -> Iterator[None]:
    """Let Python read expressions of some thousand terms, as symbolic packages print them."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, DEEP))
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)


def statements(source: str, file: str) -> tuple[list[ast.stmt], Exception | None]:
    """Return a source's statements, as far as they can be read, and the error where not all can."""
    try:
        return ast.parse(source, file).body, None
    except Exception as error:
        return _pieces(source, file), error


def _pieces(source, file):
    """Return the top-level statements of a file with syntax errors that can be read by
    themselves; a function that cannot be read raises its error.
    """
    lines = [f"{line}\n" for line in source.split("\n")]
    starts = [
        i
        for i, line in enumerate(lines)
        if _START.match(line)
        and not _CONTINUED.match(line)
        and not (i and lines[i - 1].startswith("@"))
    ]
    body = []
    for start, stop in zip(starts, [*starts[1:], len(lines)]):
        text = "".join(lines[start:stop])
        try:
            piece = ast.parse(text, file)
        except Exception as error:
            piece = _raising(text, error)
        body += ast.increment_lineno(piece, start).body
    return body


def _raising(text, error):
    """Return a function of the same head as one that cannot be read, which raises why in the line
    that is wrong; nothing where the head cannot be read either.
    """
    head = _HEAD.match(text)
    if not head or not isinstance(error, SyntaxError):
        return ast.Module([], [])
    below = "\n" * (error.lineno - 1 - head[0].count("\n"))
    try:
        return ast.parse(f"{head[0]}:{below} raise SyntaxError({error.msg!r})")
    except SyntaxError:
        return ast.Module([], [])
