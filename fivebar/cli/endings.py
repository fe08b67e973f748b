"""Checks of the files that a command writes."""

from __future__ import annotations

from pathlib import Path

from ..base.errors import UsageError

PICTURES = (".png", ".svg", ".pdf")


def check_ending(option: str, path: Path | None, endings: tuple[str, ...] = PICTURES) -> None:
    """Raise UsageError unless a file's name has one of these endings."""
    if path is not None and path.suffix not in endings:
        known = f"{', '.join(endings[:-1])} or {endings[-1]}"
        raise UsageError(f"{option} must end in {known}, not {path.name!r}")
