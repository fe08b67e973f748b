"""What objects say of themselves, in one line; in a notebook with their picture or a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .backend import is_symbolic


def single(parts: tuple) -> bool:
    """Whether components are numbers, not batches or CasADi symbols."""
    return not any(is_symbolic(part) or np.ndim(part) for part in parts)


def vector(name: str, parts: tuple, unit: str) -> str:
    """Components with their name and unit; of a batch its shape, and of CasADi symbols that they
    are.
    """
    if single(parts):
        numbers = [float(part) for part in parts]
        rounding = 1e-15 * max(map(abs, numbers))
        shown = (f"{0.0 if abs(part) < rounding else part:.6g}" for part in numbers)
        return f"{name} = ({', '.join(shown)}) {unit}".rstrip()
    if any(map(is_symbolic, parts)):
        return f"{name} of symbols"
    return f"{name} {(*np.broadcast_shapes(*map(np.shape, parts)), len(parts))}"


def one_line(what: str, *parts: str) -> str:
    """<what: part, part>."""
    return f"<{what}: {', '.join(filter(None, parts))}>"


def printable(text: str) -> str:
    """The text with whatever could move a cursor, reverse or hide something written as an
    escape.
    """
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape", "backslashreplace").decode()
        for c in text
    )


def table(words: str, rows: Mapping[str, object]) -> str:
    """HTML of a line of words over a table of names and values."""
    import html

    cells = (
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(str(value))}</td></tr>"
        for name, value in rows.items()
    )
    return f"<code>{html.escape(words)}</code><table>{''.join(cells)}</table>"


def aligned(rows: Sequence[Sequence[str]], words: int) -> list[str]:
    """Lines of a table in columns, the first `words` of them to the left, the others, numbers, to
    the right.
    """
    columns = [
        [
            cell.ljust(max(map(len, column))) if k < words else cell.rjust(max(map(len, column)))
            for cell in column
        ]
        for k, column in enumerate(zip(*rows))
    ]
    return ["  ".join(row).rstrip() for row in zip(*columns)]
