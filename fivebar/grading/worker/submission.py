"""Reads what a student hands in, a .py file or a notebook, without running, parsing or following anything of it."""

from __future__ import annotations

import codecs
import json
import os
import re
import stat
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path

MOST_SOURCE = 1_000_000  # bytes of a .py file, characters of a notebook's code
MOST_NOTEBOOK = 20_000_000  # bytes, with its outputs
MOST_NAME = 200  # characters of a file's name
ENCODINGS = ("utf-8", "ascii", "iso8859-1", "iso8859-15", "cp1252")  # none of them costs more than its length
_COOKIE = re.compile(rb"[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)")


class SubmissionError(ValueError):
    """A file that cannot be taken as a submission; the message says why, in a sentence."""


@dataclass(frozen=True)
class Submission:
    """A student's program: its file's name, its source, and its kind, "py" or "notebook".

    cells: for a notebook the first line of each code cell in `source`.
    """

    name: str
    source: str
    kind: str = "py"
    cells: tuple[int, ...] = ()

    def where(self, line: int) -> str:
        """A line of the source in the words of its author: "line 12", or "cell 3, line 2" in a notebook."""
        if not self.cells:
            return f"line {line}"
        cell = max(bisect_right(self.cells, line), 1)
        return f"code cell {cell}, line {line - self.cells[cell - 1] + 1}"


def read_submission(path: str | Path) -> Submission:
    """Submission in a .py or .ipynb file. Raises SubmissionError."""
    path = Path(path)
    name = path.name
    if not name.isprintable() or len(name) > MOST_NAME:
        raise SubmissionError(
            f"the file's name {name[:MOST_NAME]!r} is too long or holds characters that cannot be shown"
        )
    if path.suffix not in (".py", ".ipynb"):
        raise SubmissionError(f"{name} is neither a .py file nor an .ipynb notebook")
    notebook = path.suffix == ".ipynb"
    data = _bytes(path, MOST_NOTEBOOK if notebook else MOST_SOURCE)
    if not notebook:
        return Submission(name, _text(data, name, _encoding(data, name)))
    source, cells = _code(_text(data, name, "utf-8"), name)
    if len(source) > MOST_SOURCE:
        raise SubmissionError(f"{name} holds more than {MOST_SOURCE} characters of code")
    return Submission(name, source, "notebook", cells)


def _bytes(path, most):
    """A regular file's content, at most `most` bytes, no symbolic link followed, no pipe waited for."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError as error:
        if path.is_symlink():
            raise SubmissionError(f"{path.name} is a symbolic link: hand in the file itself") from None
        raise SubmissionError(f"{path.name} cannot be opened: {error.strerror}") from None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise SubmissionError(f"{path.name} is not a regular file")
    with open(descriptor, "rb") as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise SubmissionError(f"{path.name} is larger than {most / 1e6:g} MB")
    return data


def _encoding(data, name):
    """The encoding that a file states in its first two lines, as Python reads it."""
    for line in data.split(b"\n", 2)[:2]:
        if found := _COOKIE.match(line):
            word = found[1].decode("ascii", "replace")
            try:
                encoding = codecs.lookup(word).name
            except (LookupError, ValueError):
                encoding = ""
            if encoding not in ENCODINGS:
                raise SubmissionError(f"{name} states the encoding {word[:40]!r}: save it as UTF-8")
            return encoding
    return "utf-8"


def _text(data, name, encoding):
    try:
        text = data.decode("utf-8-sig" if encoding == "utf-8" else encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SubmissionError(
            f"{name} is not {encoding.upper()} text (byte 0x{data[error.start]:02x} in line {line}): save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _code(text, name):
    """(source of all code cells, first line of each); magics become empty lines."""
    try:
        cells = json.loads(text)["cells"]
        sources = [cell["source"] for cell in cells if cell["cell_type"] == "code"]
        parts = [source if isinstance(source, str) else "".join(source) for source in sources]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise SubmissionError(f"{name} is not a notebook of version 4 (no list of cells)") from None
    lines, starts = [], []
    for part in parts:
        starts.append(len(lines) + 1)
        whole = part.replace("\r\n", "\n").replace("\r", "\n").removesuffix("\n")
        own = whole.split("\n") if whole else []  # Python's lines: splitlines has more ends
        magic = part.lstrip().startswith("%%")
        lines += ["" if magic or line.lstrip().startswith(("%", "!", "?")) else line for line in own]
    return "\n".join(lines) + "\n", tuple(starts)
