"""Measurements: line by line while they are made, then a CSV file."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

from ...base.tables import TextFile, write, written
from .chart import Chart

# Columns of every chart. status: "ok"; "failed", word says how; "left out", word says what is
# missing.
COLUMNS = tuple("problem method knob status word seconds seconds_low seconds_high repeats".split())
KEY = {"problem": str, "method": str, "knob": (int, float)}


@dataclass(frozen=True, eq=False)
class Result:
    """Measurements of a chart: about (machine, versions, options), rows (dicts with COLUMNS and
    measures).
    """

    chart: Chart
    about: dict
    rows: list

    def of(self, problem: str, method: str | None = None, status: str = "ok") -> list[dict]:
        """Return the rows of a problem, of all methods or one."""
        return [
            row
            for row in self.rows
            if row["problem"] == problem
            and row["status"] == status
            and method in (None, row["method"])
        ]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all columns, the measures last."""
        measures = dict.fromkeys(name for row in self.rows for name in row)
        return tuple(dict.fromkeys((*COLUMNS, *measures)))

    def to_csv(self, path: TextFile) -> None:
        """Write a line for each attempt, below what it was measured on and a heading."""
        rows = []
        for row in self.rows:
            cells = [row.get(name) for name in self.columns]
            rows.append([float(cell) if isinstance(cell, float) else cell for cell in cells])
        write(path, f"chart {self.chart.name}", self.about, self.columns, rows, end="\n")


class Partial:
    """Measurements of an unfinished run, a line of JSON each, so that an interrupted run goes on.

    A file whose first line is not `about`, of another machine, version or kind of run, is begun
    anew. The last line may be cut off.
    """

    def __init__(self, path: Path, about: dict):
        self.path = path
        text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
        first, *rest = [_parsed(line) for line in text.splitlines()] or [None]
        self.rows = [row for row in rest if _is_row(row)] if first == about else []
        self._known = {_key(row): row for row in self.rows}
        with written(path) as file:
            for record in (about, *self.rows):
                file.write(json.dumps(record) + "\n")

    def add(self, row: dict) -> None:
        """Append a row, on the disk too."""
        self.rows.append(row)
        self._known[_key(row)] = row
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:  # that of a full disk has no name
            error.filename = str(self.path)
            raise

    def has(self, problem: str, method: str, knob: float) -> bool:
        """Return whether this attempt was made."""
        return (problem, method, knob) in self._known

    def row(self, problem: str, method: str, knob: float) -> dict:
        """Return the row of an attempt."""
        return self._known[problem, method, knob]

    def done(self) -> None:
        """Delete the file."""
        self.path.unlink()


def _key(row):
    return tuple(row[name] for name in KEY)


def _is_row(row):
    return isinstance(row, dict) and all(
        isinstance(row.get(name), kind) for name, kind in KEY.items()
    )


def _parsed(line):
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
