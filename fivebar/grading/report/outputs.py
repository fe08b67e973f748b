"""Results as files: JSON, Gradescope's results.json, CSV; each written whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from hashlib import sha256
from pathlib import Path

from ...base.representation import printable
from ...base.tables import replaced
from ..judging.results import Report, withheld
from .text import headlines, told, word

CHECK_COLUMNS = (
    "student submission check title function max_points points share outcome reason misconception"
    " wrong rows off"
).split()
# What has no accent to be left out.
_WHOLE_LETTERS = str.maketrans("ŁłØøĐđßÆæ", "LlOoDdsAa")
_HASHED = re.compile("-[0-9a-f]{16}$")  # an id of this form could be another one's file name
# At the start of a cell, or of what one becomes where a semicolon, a bar or a tab is taken to part
# cells.
_FORMULA = re.compile("(^|[;|\t])(?=\\s*[=+@\uff1d\uff0b\uff20\uff0d-])|^(?=[\t\r\n])")


def write_whole(path: str | Path, text: str) -> None:
    """Put text into a file so that at any moment the old content is there or the new one, also
    after a crash.
    """
    with (
        replaced(path) as part,
        open(part, "w", encoding="utf-8", errors="backslashreplace", newline="") as file,
    ):
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


def json_text(report: Report) -> str:
    return json.dumps(report.as_json(), indent=1, allow_nan=False) + "\n"


def file_name(student: str) -> str:
    """Return a file name for a student's id: plain letters, and a hash of the id where those do not
    tell it from others.
    """
    known = student.translate(_WHOLE_LETTERS)
    letters = unicodedata.normalize("NFKD", known).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", letters).strip("_")[:60]
    if plain and plain == student.lower() == student and not _HASHED.search(plain):
        return plain
    return (
        f"{plain or 'student'}-{sha256(student.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}"
    )


def plain_cell(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula."""
    return printable(_FORMULA.sub(r"\1'", text))


def cell(value: object) -> object:
    """Return a CSV cell, a text as `plain_cell`."""
    if not isinstance(value, str):
        return "" if value is None else value
    return plain_cell(value)


def csv_text(columns: Sequence[str], rows: Iterable) -> str:
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(columns)
    writer.writerows(map(cell, row) for row in rows)
    return file.getvalue()


def check_rows(report: Report) -> Iterator[tuple]:
    """Yield one row per check, in the order of CHECK_COLUMNS."""
    for check in report.checks:
        found = vars(report) | vars(check) | {"check": check.name, "outcome": word(check)}
        found["share"] = round(check.share, 6)
        yield tuple(found[column] for column in CHECK_COLUMNS)


def gradescope_text(report: Report) -> str:
    """Return the results.json that Gradescope's harness reads; all of it plain text.

    Students see it, and may hand in again: it tells no input, and no text or number that came from
        their program.
    """
    report = withheld(report)
    tests = []
    for check in report.checks:
        output = [f"{label}: {printable(words)}" for label, words in told(check)]
        tests.append(
            {
                "name": printable(check.title),
                "name_format": "text",
                "score": check.points,
                "max_score": check.max_points,
                "status": "passed" if check.outcome == "right" else "failed",
                "output": "\n".join(output),
                "output_format": "text",
                "visibility": "visible",
            }
        )
    result = {
        "score": report.points,
        "execution_time": report.seconds,
        "output": "\n".join(map(printable, headlines(report))),
        "output_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "tests": tests,
    }
    return json.dumps(result, indent=1, allow_nan=False) + "\n"
