"""What was measured: kept line by line while it is measured, then a CSV file that can be read
again.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...base.tables import TextFile, opened, write, written
from .chart import Chart

if TYPE_CHECKING:
    from pathlib import Path

BASE = (
    "problem",
    "method",
    "knob",
    "status",
    "word",
    "seconds",
    "seconds_low",
    "seconds_high",
    "repeats",
)
TEXT = ("problem", "method", "status", "word")
# status: "ok"; "failed", word says how; "left out", word says what is missing.


@dataclass(frozen=True, eq=False)
class Result:
    """A chart's measurements: the chart, about (machine, versions, options), rows (dicts with BASE
    and measures).
    """

    chart: Chart
    about: dict
    rows: list

    def of(self, problem: str, method: str | None = None, status: str = "ok") -> list[dict]:
        """Rows of a problem, of all methods or one."""
        return [
            r
            for r in self.rows
            if r["problem"] == problem and r["status"] == status and method in (None, r["method"])
        ]

    def to_csv(self, path: TextFile) -> None:
        """One line per attempt under a header line with what it was measured on; written whole or
        not at all.
        """
        names = (
            *BASE,
            *dict.fromkeys(name for row in self.rows for name in row if name not in BASE),
        )
        rows = (
            [float(v) if isinstance(v, float) else v for v in map(row.get, names)]
            for row in self.rows
        )
        write(path, f"chart {self.chart.name}", self.about, names, rows, end="\n")


def from_csv(path: TextFile, chart: Chart) -> Result:
    """The Result that `to_csv` wrote; ValueError names the line of what is not one."""
    rows, known = (
        [],
        {(problem, method.name) for problem in chart.problems for method in chart.methods},
    )
    with opened(path) as table:
        about = table.about(f"chart {chart.name}", f"a CSV file of the chart {chart.name}")
        table.places(("problem", "method"))
        for cells in table.rows():
            row = dict(zip(table.header, cells))
            try:
                rows.append(
                    {
                        k: v if k in TEXT else float(v)
                        for k, v in row.items()
                        if v != "" or k in TEXT
                    }
                )
            except ValueError:
                raise table.error(f"not numbers: {row}") from None
            problem, method = row.get("problem"), row.get("method")
            if (problem, method) not in known:
                raise table.error(
                    f"the chart {chart.name} has no method {method!r} on a problem {problem!r}: the"
                    " file is of another version"
                )
    return Result(chart, about, rows)


class Partial:
    """The measurements of a run that is not at its end, a line of JSON each, so that an interrupted
    run goes on.

    about: what must be equal for it to go on; a file of another machine, version or kind of run is
        begun anew.
    """

    def __init__(self, path: Path, about: dict):
        self.path, self.rows = path, []
        lines = (
            path.read_text(encoding="utf-8", errors="replace").splitlines() if path.exists() else []
        )
        found = [_parsed(line) for line in lines]
        if found and found[0] == about:
            self.rows = [
                row for row in found[1:] if _is_row(row)
            ]  # the last may be cut off in the middle
        self._known = {_key(row): row for row in self.rows}
        with written(path) as file:
            file.writelines(json.dumps(each) + "\n" for each in (about, *self.rows))

    def add(self, row: dict) -> None:
        self.rows.append(row)
        self._known[_key(row)] = row
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:  # a full disk's has no name
            error.filename = str(self.path)
            raise

    def has(self, problem: str, method: str, knob: float) -> bool:
        return (problem, method, knob) in self._known

    def row(self, problem: str, method: str, knob: float) -> dict:
        return self._known[problem, method, knob]

    def done(self) -> None:
        self.path.unlink()


def _key(row):
    return row["problem"], row["method"], row["knob"]


_KEY = str, str, (int, float)


def _is_row(row):
    return isinstance(row, dict) and all(
        isinstance(row.get(k), t) for k, t in zip(("problem", "method", "knob"), _KEY)
    )


def _parsed(line):
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
