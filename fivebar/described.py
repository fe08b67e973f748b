"""What objects say of themselves, in one line."""

from __future__ import annotations

import numpy as np

from ._backend import is_symbolic


def single(parts: tuple) -> bool:
    """Whether components are numbers, not batches or CasADi symbols."""
    return not any(is_symbolic(part) or np.ndim(part) for part in parts)


def vector(name: str, parts: tuple, unit: str) -> str:
    """Components with their name and unit; of a batch its shape, and of CasADi symbols that they are."""
    if single(parts):
        return f"{name} = ({', '.join(f'{float(part):.6g}' for part in parts)}) {unit}".rstrip()
    if any(map(is_symbolic, parts)):
        return f"{name} of symbols"
    return f"{name} {(*np.broadcast_shapes(*map(np.shape, parts)), len(parts))}"


def one_line(what: str, *parts: str) -> str:
    """<what: part, part>."""
    return f"<{what}: {', '.join(filter(None, parts))}>"
