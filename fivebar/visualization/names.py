"""What `show` may be."""

from __future__ import annotations

from collections.abc import Iterable


def names_of(show: str | Iterable[str]) -> tuple[str, ...]:
    """The names in `show`, one or several; TypeError for what is neither."""
    names = (show,) if isinstance(show, str) or not isinstance(show, Iterable) else tuple(show)
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"show must be a name or several, not {name!r}")
    return names
