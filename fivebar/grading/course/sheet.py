"""A table as a spreadsheet or a learning platform wrote it: cells that are not changed stay as they
are, to the letter.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

from ...base.errors import UsageError

_COMMA = re.compile(r"-?\d+,\d+")


@dataclass(frozen=True)
class Sheet:
    """Rows of cells as they are written in the file, with their quotes.

    ends: what ends each row; sign: between two cells; mark: what the text begins with, a byte-order
    mark or "".
    """

    rows: list[list[str]]
    ends: list[str]
    sign: str
    mark: str

    @property
    def titles(self) -> list[str]:
        return [title.strip() for title in self.values(0)]

    def value(self, row: int, column: int) -> str:
        """Return a cell's text without its quotes, "" where the row has none."""
        cells = self.rows[row]
        if column >= len(cells):
            return ""
        cell = cells[column]
        quoted = cell.startswith('"') and cell.endswith('"')
        if len(cell) < 2 or not quoted:
            return cell
        return cell[1:-1].replace('""', '"')

    def values(self, row: int) -> list[str]:
        count = len(self.rows[row])
        return [self.value(row, k) for k in range(count)]

    def put(self, row: int, column: int, text: str) -> None:
        """Write a cell, in quotes where it had them or needs them."""
        cells = self.rows[row]
        cells += [""] * (column + 1 - len(cells))
        cells[column] = quoted(text, self.sign, cells[column].startswith('"'))

    def has_comma(self, *columns: int) -> bool:
        """Return whether numbers are written with a decimal comma, as their columns tell.

        Excel parts cells by semicolons where a comma is decimal.
        """
        if self.sign == ";":
            return True
        for row in range(1, len(self.rows)):
            for column in columns:
                text = self.value(row, column).strip()
                if _COMMA.fullmatch(text):
                    return True
        return False

    @property
    def text(self) -> str:
        text = self.mark
        for row, end in zip(self.rows, self.ends):
            text += self.sign.join(row) + end
        return text


def quoted(text: str, sign: str, always: bool = False) -> str:
    """Return a cell as CSV writes it."""
    special = f'{sign}"\r\n'
    needed = any(letter in text for letter in special)
    if not always and not needed:
        return text
    inner = text.replace('"', '""')
    return f'"{inner}"'


def read_sheet(path: Path) -> Sheet:
    """Return the table in a CSV file, as Excel, LibreOffice, Moodle or Canvas writes it.

    Raises UsageError where the file is none.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}") from None
    text, mark = _decoded(data)
    first = text.split("\n", 1)[0]
    sign = max(",;\t", key=first.count)
    cell = rf'("(?:[^"]|"")*"[^{sign}\r\n]*|[^{sign}\r\n]*)({sign}|\r\n|\n|\r|\Z)'
    rows: list[list[str]] = []
    ends: list[str] = []
    row: list[str] = []
    for found in re.finditer(cell, text):
        row.append(found[1])
        if found[2] == sign:
            continue
        if found[2] or row != [""]:
            rows.append(row)
            ends.append(found[2])
        row = []
    too_small = len(rows) < 2 or len(rows[0]) < 2
    if too_small or "\0" in text:
        raise UsageError(
            f"{path} is no sheet of marks: a line of titles and a line per student are asked"
        )
    return Sheet(rows, ends, sign, mark)


def _decoded(data):
    """Return (text, the mark to begin with when it is written again, as UTF-8)."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace"), "\ufeff"
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:  # as Excel saves it in Western Europe
        return data.decode("cp1252", errors="replace"), "\ufeff"
    without_mark = text.removeprefix("\ufeff")
    mark = "" if without_mark == text else "\ufeff"
    return without_mark, mark


def number_in(text: str) -> float | None:
    """Return the number in a cell, with a point or a comma; None where there is none."""
    with_point = text.strip().replace(",", ".")
    try:
        value = float(with_point)
    except ValueError:
        return None
    if abs(value) < 1e9:  # False for NaN
        return value
    return None
