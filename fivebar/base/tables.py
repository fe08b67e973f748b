"""Files that a user names, and the tables that fivebar writes: CSV under a comment line of JSON.

Files are written whole or not at all.
"""

from __future__ import annotations

import csv
import errno
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from io import StringIO
from itertools import count
from operator import methodcaller
from typing import IO, TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FilePath = str | os.PathLike
TextFile = FilePath | IO[str]
BinaryFile = FilePath | IO[bytes]
# Errors that reading a damaged file may raise.
STRANGE = (
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    ArithmeticError,
    RecursionError,
    MemoryError,
)
DPI = 200  # of pictures
_NUMBERS = count()  # of files being written: threads may write one at the same time
_PART = re.compile(r"\..{1,40}\.(\d+)-\d+\.part(\.\w+)?", re.DOTALL)
_CLEARED: set[str] = set()  # folders in which this process has looked for what killed ones left
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
WORDS = 120  # letters of a file's own that a message repeats


def must_increase(t: np.ndarray, whose: str) -> None:
    """Refuse times from which no motion can be shown."""
    if len(t) < 2:
        raise ValueError(f"{whose} has {len(t)} samples: a motion needs at least 2")
    bad = np.flatnonzero(~np.isfinite(t))
    if len(bad):
        raise ValueError(f"{whose}: t[{bad[0]}] is {t[bad[0]]}, not finite")
    late = np.flatnonzero(np.diff(t) <= 0) + 1
    if len(late):
        raise ValueError(
            f"{whose}: t[{late[0]}] = {t[late[0]]} is not after t[{late[0] - 1}] = {t[late[0] - 1]}"
        )


def file_or_path(file: TextFile | BinaryFile, does: str) -> Any:
    """Return a path, or an open file that can `does` ("read" or "write"); else raise TypeError.

    `open` would take integers, and so False and True, for the caller's own streams, and close them.
    """
    if not isinstance(file, (str, os.PathLike)) and not hasattr(file, does):
        raise TypeError(
            f"to {does}, a path (str or os.PathLike) or an open file is needed, not {file!r}"
        )
    if isinstance(file, (str, os.PathLike)) and "\0" in os.fsdecode(file):
        raise OSError(errno.EINVAL, "no file's name has a zero byte in it", os.fspath(file))
    return file


def whole_text(file: TextFile, what: str, most: int | None = None) -> tuple[str, str]:
    """Return the text of a file in UTF-8, UTF-16 or Windows-1252, and the file's name.

    Parameters
    ----------
    file : path or open text file
        The file.
    what : str
        What is read from it, for messages: "a table".
    most : int, optional
        Largest size, bytes.

    Raises
    ------
    ValueError
        The file is no text, or too large.
    """
    source = file_or_path(file, "read")
    if not isinstance(source, (str, os.PathLike)):
        text = source.read()
        if not isinstance(text, str):
            raise TypeError(f"{what} is read from a text file, but {file!r} is open for bytes")
        return text.removeprefix("\ufeff"), str(getattr(file, "name", "the open file"))
    name = os.fspath(source)
    with open(source, "rb") as opened:
        raw = opened.read(-1 if most is None else most + 1)
    if most is not None and len(raw) > most:
        raise ValueError(f"{name}: more than {most / 1e6:g} MB: not {what}")
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", errors="replace"), name
    if raw[:2] == b"PK":
        raise ValueError(f"{name}: a spreadsheet or a zip file; save its sheet as CSV")
    if b"\0" in raw:
        raise ValueError(f"{name}: not a text file, but a binary one")
    try:
        return raw.decode("utf-8-sig"), name
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace"), name


@contextmanager
def named(file: str) -> Iterator[None]:
    """Put the file's name before the message of a ValueError that lacks it."""
    try:
        yield
    except ValueError as error:
        if type(error) is not ValueError or file in str(error):
            raise
        raise ValueError(f"{file}: {error}") from None


def arrays_in(file: FilePath) -> dict[str, np.ndarray]:
    """Return the arrays in an NPZ file; ValueError for another file."""
    with open(file_or_path(file, "read"), "rb") as raw:
        try:
            with np.load(raw, allow_pickle=False) as found:
                return {name: found[name] for name in found.files}
        # zipfile, zlib and NumPy's reader of headers raise a dozen kinds of errors.
        except Exception as error:
            raise ValueError(
                f"{file}: no arrays as NumPy saves them: {type(error).__name__}: {error}"
            ) from None


def saved(figure: Figure, file: BinaryFile | None, **options: Any) -> Figure:
    """Write a figure to a file, if one is given, and return it; PNG without an ending."""
    if file is not None:
        kind: dict[str, str] = {}
        place = file_or_path(file, "write")
        if not hasattr(place, "write"):
            root, end = os.path.splitext(os.fspath(place))
            place = f"{root}{end or '.png'}"
            kind = {"format": end[1:] or "png"}
        with written(place, binary=True) as out:
            figure.savefig(out, **({"dpi": DPI} | kind | options))
    return figure


@contextmanager
def written(file: TextFile | BinaryFile, binary: bool = False) -> Iterator[IO]:
    """Open a file that gets its name once it is whole.

    Until then, and on failure, the file that had the name stays.
    """
    place = file_or_path(file, "write")
    if hasattr(place, "write"):
        yield place
        return
    with (
        replaced(place) as part,
        open(part, "wb") if binary else open(part, "w", newline="", encoding="utf-8") as out,
    ):
        yield out


@contextmanager
def replaced(file: FilePath, end: str = "") -> Iterator[str]:
    """Return the name of a file that takes the place of this one at the end of the block."""
    path = os.path.realpath(file)  # a link stays one
    direct = os.path.exists(path) and not os.path.isfile(
        path
    )  # a pipe or a device cannot be replaced
    place, name = os.path.split(path)
    part = (
        path
        if direct
        else os.path.join(place, f".{name[:40]}.{os.getpid()}-{next(_NUMBERS)}.part{end}")
    )
    if not direct:
        _clear(place)
    try:
        yield part
        if not direct:
            os.replace(part, path)
    except BaseException as error:
        if not direct and os.path.exists(part):
            os.unlink(part)
        if isinstance(error, OSError) and (
            error.filename == part or error.errno in FULL and error.filename is None
        ):
            error.filename = os.fspath(file)
        raise


def _clear(place):
    """Remove the files that killed processes left half-written in a folder, once a process."""
    if place in _CLEARED or not hasattr(os, "fork"):
        return  # On Windows a process cannot be asked without ending it.
    _CLEARED.add(place)
    with suppress(OSError):  # the folder cannot be read, or another process removes a file too
        for name in os.listdir(place):
            found = _PART.fullmatch(name)
            if found and _has_ended(int(found[1])):
                os.unlink(os.path.join(place, name))


def _has_ended(process):
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # It is another user's.
        pass
    return False


def is_part(name: str) -> bool:
    """Return whether `replaced` gave this name to a file that is not yet whole."""
    return _PART.fullmatch(name) is not None


def write(
    file: TextFile,
    kind: str,
    about: dict,
    header: Sequence[str],
    rows: Iterable[Sequence],
    end: str = "\r\n",
) -> None:
    """Write a table: a comment with its kind and what it is about, its header, its rows.

    Floats have all their digits; `end` ends the lines after the first.
    """
    first = f"# fivebar {kind}, SI units: {json.dumps(about, default=methodcaller('tolist'))}\n"
    with written(file) as out:
        out.write(first)
        lines = csv.writer(out, lineterminator=end)
        lines.writerow(header)
        lines.writerows(rows)


class Table:
    """A CSV file that fivebar wrote; it is read once, from first line to last.

    Its ValueErrors name file and line.
    """

    def __init__(self, file: TextFile):
        text, self.name = whole_text(file, "a table")
        self.first = text.partition("\n")[0]
        lines = StringIO(text, newline="")
        # Comments become empty lines: they may hold half a pair of quotes.
        self._reader = csv.reader("\n" if line.startswith("#") else line for line in lines)
        self._cells = self._filled_rows()

    def _filled_rows(self):
        try:
            yield from filter(None, self._reader)
        except csv.Error as error:
            raise self.error(f"not a row of a CSV file: {error}") from None

    def about(self, kind: str, what: str, parse: Callable[[Any], Any] = lambda about: about) -> Any:
        """Return what `parse` makes of the JSON in the first line, which must be of this kind.

        `what` is the file expected, for messages.
        """
        found = re.match(r"# fivebar (.+?), SI units: ", self.first)
        if found is None or found[1] != kind:
            instead = f"a fivebar {found[1]}" if found else f"it begins with {_short(self.first)!r}"
            raise ValueError(
                f"{self.name}, line 1: not {what}: {instead if self.first else 'it is empty'}"
            )
        try:
            return parse(json.loads(self.first[found.end() :]))
        except STRANGE as error:
            reason = f"{type(error).__name__}: {_short(str(error))}"
            raise ValueError(f"{self.name}, line 1: not {what}: {reason}") from None

    @cached_property
    def header(self) -> list[str]:
        """The names of the columns, each of them once."""
        names = [name.strip() for name in next(self._cells, ())]
        if twice := [name for name in dict.fromkeys(names) if name and names.count(name) > 1]:
            raise self.error(f"two columns are called {_short(', '.join(twice))}")
        return names

    def places(self, names: Sequence[str]) -> list[int]:
        """Return where the named columns are in a row."""
        if not self.header:
            raise ValueError(
                f"{self.name}: empty; needed a header with the columns {', '.join(names)}"
            )
        if missing := [name for name in names if name not in self.header]:
            found = _short(", ".join(self.header))
            raise self.error(
                f"no column {', '.join(missing)}; found {found}; needed {', '.join(names)}"
            )
        return [self.header.index(name) for name in names]

    def rows(self) -> Iterator[list[str]]:
        """Yield the rows under the header, as texts."""
        count = len(self.header)
        for cells in self._cells:
            if any(cells[count:]):
                raise self.error(f"{len(cells)} cells, where the header has {count}")
            yield cells

    def numbers(self, names: Sequence[str], finite: bool = True) -> np.ndarray:
        """Return the named columns (n, len(names)); the first is time, which increases from 0 on.

        With `finite`, inf and nan are refused; else only among the times.
        """
        wanted = [
            (k, name, finite or name == names[0]) for k, name in zip(self.places(names), names)
        ]
        table: list[list[float]] = []
        for cells in self.rows():
            row = [self._number(cells, *each) for each in wanted]
            if row[0] < 0:
                raise self.error(f"time must not be negative, but is {row[0]:g}")
            if table and row[0] <= table[-1][0]:
                raise self.error(f"time must increase, but {row[0]:g} follows {table[-1][0]:g}")
            table.append(row)
        if not table:
            raise ValueError(f"{self.name}: no rows under the header")
        return np.array(table)

    def error(self, message: str) -> ValueError:
        """Return the error to raise where the line read last is wrong."""
        return ValueError(f"{self.name}, line {self._reader.line_num}: {message}")

    def _number(self, cells, place, name, finite):
        try:
            value = float(cells[place])
        except (ValueError, IndexError):
            found = repr(_short(cells[place])) if place < len(cells) else "nothing"
            raise self.error(f"{name} must be a number, not {found}") from None
        if finite and not math.isfinite(value):
            raise self.error(f"{name} must be finite, not {value}")
        return value


def _short(text):
    text = text.strip()
    return text if len(text) <= WORDS else text[:WORDS] + "..."
