"""One-line representations (`__repr__`) of results, and tables for notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .backend import is_symbolic


def single(parts: tuple) -> bool:
    """Return whether components are numbers, not batches or CasADi symbols."""
    return not any(is_symbolic(part) or np.ndim(part) for part in parts)


def vector(name: str, parts: tuple, unit: str) -> str:
    """Return components with their name and unit; of a batch the shape."""
    if single(parts):
        numbers = [float(part) for part in parts]
        rounding = 1e-15 * max(map(abs, numbers))
        words = ", ".join(f"{0.0 if abs(x) < rounding else x:.6g}" for x in numbers)
        return f"{name} = ({words}) {unit}".rstrip()
    if any(map(is_symbolic, parts)):
        return f"{name} of symbols"
    return f"{name} {(*np.broadcast_shapes(*map(np.shape, parts)), len(parts))}"


def working_words(working: Sequence[int]) -> str:
    """Return working modes (2,) in words."""
    left, right = working
    return f"working modes {left:+d} {right:+d}"


def one_line(what: str, *parts: str) -> str:
    """Return "<what: part, part>"."""
    return f"<{what}: {', '.join(filter(None, parts))}>"


def printable(text: str) -> str:
    """Return the text with an escape for what could move a cursor, reverse or hide something."""
    return "".join(c if c.isprintable() else _escape(c) for c in text)


def _escape(letter):
    return letter.encode("unicode_escape", "backslashreplace").decode()


def table(words: str, rows: Mapping[str, object]) -> str:
    """Return HTML of a line of words over a table of names and values."""
    from html import escape

    lines = "".join(
        f"<tr><th>{escape(k)}</th><td>{escape(str(v))}</td></tr>" for k, v in rows.items()
    )
    return f"<code>{escape(words)}</code><table>{lines}</table>"


def aligned(rows: Sequence[Sequence[str]], words: int) -> list[str]:
    """Return the lines of a table in columns: the first `words` of them left, the others right."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = []
    for row in rows:
        cells = [cell.rjust(width) for cell, width in zip(row, widths)]
        cells[:words] = [cell.ljust(width) for cell, width in zip(row[:words], widths)]
        lines.append("  ".join(cells).rstrip())
    return lines
