"""What was measured: kept line by line while it is measured, then a CSV file that can be read again."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .chart import Chart

if TYPE_CHECKING:
    from pathlib import Path

BASE = ("problem", "method", "knob", "status", "word", "seconds", "seconds_low", "seconds_high", "repeats")
TEXT = ("problem", "method", "status", "word")
# status: "ok"; "failed", word says how; "left out", word says what is missing.


@dataclass(frozen=True, eq=False)
class Result:
    """A chart's measurements: the chart, about (machine, versions, options), rows (dicts with BASE and measures)."""

    chart: Chart
    about: dict
    rows: list

    def of(self, problem: str, method: str | None = None, status: str = "ok") -> list[dict]:
        """Rows of a problem, of all methods or one."""
        return [
            r for r in self.rows if r["problem"] == problem and r["status"] == status and method in (None, r["method"])
        ]

    def to_csv(self, path: Path) -> None:
        """One line per attempt under a header line with what it was measured on; written whole or not at all."""
        measures = list(dict.fromkeys(name for row in self.rows for name in row if name not in BASE))
        part = path.with_name(path.name + ".part")
        with open(part, "w", newline="", encoding="utf-8") as file:
            file.write(f"# fivebar chart {self.chart.name}, SI units: {json.dumps(self.about)}\n")
            writer = csv.DictWriter(file, (*BASE, *measures), restval="", lineterminator="\n")
            writer.writeheader()
            writer.writerows(
                {k: repr(float(v)) if isinstance(v, float) else v for k, v in row.items()} for row in self.rows
            )
        os.replace(part, path)


def from_csv(path: Path, chart: Chart) -> Result:
    """The Result that `to_csv` wrote; ValueError names the line of what is not one."""
    with open(path, newline="", encoding="utf-8") as file:
        first, start = file.readline(), f"# fivebar chart {chart.name}, SI units: "
        if not first.startswith(start):
            raise ValueError(f"{path}, line 1: not a CSV file of the chart {chart.name}")
        about = json.loads(first[len(start) :])
        rows, known = [], {(problem, method.name) for problem in chart.problems for method in chart.methods}
        for number, row in enumerate(csv.DictReader(file), start=3):
            try:
                rows.append({k: v if k in TEXT else float(v) for k, v in row.items() if v != "" or k in TEXT})
            except (TypeError, ValueError):
                raise ValueError(f"{path}, line {number}: not numbers: {row}") from None
            if (row["problem"], row["method"]) not in known:
                raise ValueError(
                    f"{path}, line {number}: the chart {chart.name} has no method {row['method']!r} on a problem "
                    f"{row['problem']!r}: the file is of another version"
                )
    return Result(chart, about, rows)


class Partial:
    """The measurements of a run that is not at its end, a line of JSON each, so that an interrupted run goes on.

    about: what must be equal for it to go on; a file of another machine, version or kind of run is begun anew.
    """

    def __init__(self, path: Path, about: dict) -> None:
        self.path, self.rows, self.begun_anew = path, [], False
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        found = [_parsed(line) for line in lines]
        if found and found[0] == about:
            self.rows = [row for row in found[1:] if row is not None]  # None: cut off in the middle of a line
        else:
            self.begun_anew = bool(found)
        self._known = {_key(row): row for row in self.rows}
        part = path.with_name(path.name + ".part")
        part.write_text("".join(json.dumps(each) + "\n" for each in (about, *self.rows)), encoding="utf-8")
        os.replace(part, path)

    def add(self, row: dict) -> None:
        self.rows.append(row)
        self._known[_key(row)] = row
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def has(self, problem: str, method: str, knob: float) -> bool:
        return (problem, method, knob) in self._known

    def row(self, problem: str, method: str, knob: float) -> dict:
        return self._known[problem, method, knob]

    def done(self) -> None:
        self.path.unlink()


def _key(row):
    return row["problem"], row["method"], row["knob"]


def _parsed(line):
    try:
        return json.loads(line)
    except ValueError:
        return None
