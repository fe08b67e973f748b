"""Who handed in what: a folder with a file or a folder per student, also as Moodle and Canvas pack them."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

SUFFIXES = ".py", ".ipynb"
# "Ada Lovelace_4711_assignsubmission_file_" and "lovelaceada_LATE_123_45678_lab1.py": the name is what comes first
_MOODLE = re.compile(r"(?P<name>.+?)_\d+_assignsubmission_\w*")
_CANVAS = re.compile(r"(?P<name>.+?)_(?:LATE_)?\d+_\d+_.*", re.DOTALL)


@dataclass(frozen=True)
class Entry:
    """A student's id and file; trouble: why there is no file to grade."""

    student: str
    path: Path
    trouble: str = ""


def find_submissions(folder: Path, besides: Path | None = None) -> list[Entry]:
    """The entries of a folder by name; `besides`: a folder in it that is not a student's."""
    besides = besides and besides.resolve()
    parts = [path for path in sorted(folder.iterdir()) if not _hidden(path) and path.resolve() != besides]
    parts = [path for path in parts if path.is_symlink() or path.is_dir() or path.suffix in SUFFIXES]
    short = {path: _student(path) for path in parts}
    count = Counter(name for path in parts for name in {short[path].casefold(), path.name.casefold()})
    return [_entry(path, name if count[name.casefold()] == 1 else path.name) for path, name in short.items()]


def _hidden(path):
    return path.name.startswith((".", "__"))


def _student(path):
    name = path.name if path.is_dir() else path.stem
    found = _MOODLE.fullmatch(name) or _CANVAS.fullmatch(name)
    return found["name"] if found else name


def _entry(path, student):
    if path.is_symlink():
        return Entry(student, path, "it is a symbolic link: hand in the file itself")
    if not path.is_dir():
        return Entry(student, path)
    files = [p for p in sorted(path.rglob("*")) if p.suffix in SUFFIXES and not _within_hidden(p, path)]
    if len(files) == 1:
        return Entry(student, files[0])
    names = ", ".join(file.name for file in files[:5])
    held = f"{len(files)} programs ({names}): leave one" if files else "no .py, no .ipynb"
    return Entry(student, path, f"the folder holds {held}")


def _within_hidden(path, folder):
    return any(part.startswith((".", "__")) for part in path.relative_to(folder).parts)
