"""Read what a student hands in, a .py file or a notebook, without running, parsing or following
anything of it.
"""

from __future__ import annotations

import codecs
import io
import json
import lzma
import os
import re
import stat
import zipfile
import zlib
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

PROGRAMS, ARCHIVE = (".py", ".ipynb"), ".zip"
MOST_SOURCE = 1_000_000  # bytes of a .py file, characters of a notebook's code
MOST_NOTEBOOK = 20_000_000  # bytes, with its outputs
MOST_ARCHIVE = 50_000_000  # bytes of a zip
UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    RuntimeError,
    ValueError,
    EOFError,
    OSError,
)  # of a zip
MOST_NAME = 200  # characters of a file's name
ENCODINGS = (
    "utf-8",
    "ascii",
    "iso8859-1",
    "iso8859-15",
    "cp1252",
)  # none of them costs more than its length
OF_PYTHON = (
    "%%time\n",
    "%%time ",
    "%%capture",
    "%%prun",
)  # magics of a cell whose code the notebook's session runs
_IN_ZIP = re.compile(rf"(.+?\{ARCHIVE})/(.+)", re.DOTALL | re.IGNORECASE)  # a zip in the zip
_NOTEBOOK = re.compile(r'\s*\{\s*"(cells|metadata|nbformat)')  # how a notebook's JSON begins
_COOKIE = re.compile(rb"[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)")


class SubmissionError(ValueError):
    """A file that cannot be taken as a submission; the message says why, in a sentence."""


@dataclass(frozen=True)
class Submission:
    """A student's program: its file's name, its source, and its kind, "py" or "notebook".

    cells: for a notebook the first line of each code cell in `source`; remark: a sentence on how it
        was read, or "".
    """

    name: str
    source: str
    kind: str = "py"
    cells: tuple[int, ...] = ()
    remark: str = ""

    def where(self, line: int) -> str:
        """Return a line of the source in the words of its author: "line 12", or "cell 3, line 2" in
        a notebook.
        """
        if not self.cells:
            return f"line {line}"
        cell = max(bisect_right(self.cells, line), 1)
        return f"code cell {cell}, line {line - self.cells[cell - 1] + 1}"


def read_submission(path: str | Path, member: str = "") -> Submission:
    """Return submission in a .py or .ipynb file, or in such a member of a zip. Raises
    SubmissionError.
    """
    path = Path(path)
    name = PurePosixPath(with_slashes(member)).name if member else path.name
    if not name.isprintable() or len(name) > MOST_NAME:
        raise SubmissionError(
            f"the file's name {name[:MOST_NAME]!r} is too long or holds characters that cannot be"
            " shown"
        )
    suffix = PurePosixPath(name).suffix.lower()
    if suffix not in PROGRAMS:
        raise SubmissionError(f"{name} is neither a .py file nor an .ipynb notebook")
    notebook = suffix == ".ipynb"
    most = MOST_NOTEBOOK if notebook else MOST_SOURCE
    data = _member(path, member, most) if member else _bytes(path, most)
    text, remark = (_text(data, name, "utf-8"), "") if notebook else _source(data, name)
    if not (notebook or _NOTEBOOK.match(text)):
        return Submission(name, text, remark=remark)
    if not notebook:
        remark = f"{name} is a notebook, and is graded as one: its name should end with .ipynb."
    source, cells = _code(text, name)
    if len(source) > MOST_SOURCE:
        raise SubmissionError(f"{name} holds more than {MOST_SOURCE} characters of code")
    return Submission(name, source, "notebook", cells, remark)


@contextmanager
def opened(path: Path) -> Iterator:
    """Yield a regular file open for reading, no symbolic link followed, no pipe waited for. Raises
    SubmissionError.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError as error:
        if path.is_symlink():
            raise SubmissionError(
                f"{path.name} is a symbolic link: hand in the file itself"
            ) from None
        raise SubmissionError(f"{path.name} cannot be opened: {error.strerror}") from None
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise SubmissionError(f"{path.name} is not a regular file")
    with open(descriptor, "rb") as file:
        yield file


@contextmanager
def opened_archive(path: Path) -> Iterator[zipfile.ZipFile]:
    """Yield a zip whose members can be read one by one; nothing is unpacked to disk. Raises
    SubmissionError.
    """
    with opened(path) as file:
        if os.fstat(file.fileno()).st_size > MOST_ARCHIVE:
            raise SubmissionError(f"{path.name} is larger than {MOST_ARCHIVE / 1e6:g} MB")
        try:
            with zipfile.ZipFile(file) as archive:
                yield archive
        except SubmissionError:
            raise
        except UNREADABLE as error:
            raise SubmissionError(f"{path.name} is no zip that can be read: {error}") from None


def files_of(archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """Return the files in a zip."""
    return [info for info in archive.infolist() if not info.is_dir() and info.filename]


@contextmanager
def inner_archive(archive: zipfile.ZipFile, member: str) -> Iterator[zipfile.ZipFile]:
    """Yield a zip that lies in a zip. Raises what UNREADABLE names."""
    with archive.open(member) as file:
        data = _within(file.read(MOST_ARCHIVE + 1), MOST_ARCHIVE, member)
    with zipfile.ZipFile(io.BytesIO(data)) as inner:
        yield inner


def with_slashes(member: str) -> str:
    """Return a member's path: some programs of Windows write it with backslashes."""
    return member.replace("\\", "/")


def _member(path, member, most):
    with opened_archive(path) as archive, ExitStack() as stack:
        found = _IN_ZIP.fullmatch(member)
        if found and member not in archive.namelist():
            archive, member = stack.enter_context(inner_archive(archive, found[1])), found[2]
        try:
            with archive.open(member) as file:
                data = file.read(most + 1)
        except KeyError:
            raise SubmissionError(f"{path.name} holds no {member}") from None
    return _within(data, most, member)


def _bytes(path, most):
    with opened(path) as file:
        return _within(file.read(most + 1), most, path.name)


def _within(data, most, name):
    if len(data) > most:
        raise SubmissionError(f"{name} is larger than {most / 1e6:g} MB")
    return data


def _source(data, name):
    """Return (text, remark) of a .py file: as Python reads it, else as the editor meant that wrote
    it.
    """
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")):
        if data.startswith(mark):
            return (
                _text(data, name, encoding),
                f"{name} is saved as UTF-16, which Python cannot run: save it as UTF-8.",
            )
    encoding = _encoding(data, name)
    try:
        return _text(data, name, encoding), ""
    except SubmissionError as error:
        if encoding != "utf-8":
            raise
        text = _text(data, name, "iso8859-1")
        return text, f"{error}. It was read as Latin-1; Python itself would not run it."


def _encoding(data, name):
    """Return the encoding that a file states in its first two lines, as Python reads it."""
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
            f"{name} is not {encoding.upper()} text (byte 0x{data[error.start]:02x} in line"
            f" {line}): save it as UTF-8"
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _code(text, name):
    """Return (source of all code cells, first line of each); magics become empty lines."""
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
        magic = part.lstrip().startswith("%%") and not part.lstrip().startswith(OF_PYTHON)
        lines += [
            "" if magic or line.lstrip().startswith(("%", "!", "?")) else line for line in own
        ]
    return "\n".join(lines) + "\n", tuple(starts)
