"""Wrong tries at home: the line and the change that gives right answers are told from the second
one on.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from ...models.machine_code import cache_folder
from ..judging.results import Report
from ..labs import Lab
from .outputs import write_whole

MOST_FILES = 200  # remembered


def tries_file() -> Path:
    """Return the file in which wrong tries are counted. Raises OSError where there is no home."""
    return cache_folder() / "tries.json"


def with_try_counted(report: Report, lab: Lab, program: Path) -> Report:
    """Return the report of a check at home with what may be told after so many wrong tries.

    A function's try is wrong if one of its checks is; the same file checked again is no new try.
    """
    least = lab.spots_from()
    known, trouble = _read()
    key = f"{lab.name}: {program.resolve()}"
    last = known.pop(key, {})
    wrong: dict = last.get("wrong", {})
    if last.get("file") != report.submission_hash:
        functions = {check.function for check in report.checks if check.share < 1}
        wrong = {name: wrong.get(name, 0) + 1 for name in sorted(functions)}
    known[key] = {"file": report.submission_hash, "wrong": wrong}
    notes = (*report.notes, trouble) if trouble else report.notes
    try:
        _write(dict([*known.items()][-MOST_FILES:]))
    except OSError as error:
        trouble = f"Wrong tries cannot be counted: {error}"
        notes = (*notes, trouble) if any(check.spot for check in report.checks) else notes
    checks = []
    for check in report.checks:
        tries = wrong.get(check.function, 0)
        if check.spot and tries < least:
            later = f"this is wrong try {tries}; wrong try {least} shows the line and the change"
            check = replace(check, spot=later)
        checks.append(check)
    return replace(report, checks=tuple(checks), notes=notes)


def _read():
    """Return what is counted, and a sentence where the file is not one of ours: counting then
    begins anew.
    """
    try:
        text = tries_file().read_text("utf-8")
    except OSError:
        return {}, ""
    try:
        known = json.loads(text)
        rows = [row["wrong"] for row in known.values()]
        counts = [count for wrong in rows for count in wrong.values()]
    except (ValueError, AttributeError, TypeError, KeyError):
        counts = [None]
    if all(type(count) is int and count >= 0 for count in counts):
        return known, ""
    return {}, f"{tries_file()} is damaged: wrong tries are counted from 0 again."


def _write(known):
    tries_file().parent.mkdir(parents=True, exist_ok=True)
    write_whole(tries_file(), json.dumps(known, indent=1))
