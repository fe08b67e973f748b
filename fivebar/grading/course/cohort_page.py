"""A cohort's summary on disk: CSV tables and one page without scripts or network."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import astuple
from pathlib import Path
from urllib.parse import quote

from ...visualization.document import table
from ..intake.hand_in import Left
from ..judging.results import Report
from ..report.outputs import CHECK_COLUMNS, check_rows, csv_text, file_name, write_whole
from ..report.page import page, text
from ..report.text import number
from .cohort import trouble_of
from .items import has_marks, items, misconceptions, scores_text, students_text

STYLE = """
.fivebar table { border-collapse: collapse; width: 100%; }
.fivebar .wide { overflow-x: auto; }
.fivebar th { text-align: left; color: #57606a; font-weight: 500; }
.fivebar th, .fivebar td { padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #d8dee4;
  vertical-align: top; }
.fivebar td:first-child { min-width: 11rem; }
.fivebar td:nth-child(2):has(.bar) { width: 30%; min-width: 5rem; }
.fivebar .bar { print-color-adjust: exact; height: .8rem; margin-top: .35rem; background: #0969da; }
.fivebar th, .fivebar td:has(.bar) ~ td { white-space: nowrap; }
.fivebar .low { color: #c4320a; }
@media screen and (prefers-color-scheme: dark) {
  .fivebar th, .fivebar td { border-color: #4c555f; }
  .fivebar th { color: #a9b2bc; }
  .fivebar .low { color: #ff9877; }
}
"""
TELLS = (
    "Tells: correlation of passing this check with the points in all others. Near 1 it separates"
    " those who know from those who do not; near 0 or below, look at the check or at what was"
    " taught."
)
ITEMS = "check,title,max_points,students,pass_rate,mean_share,discrimination".split(",")
MISCONCEPTIONS = ("function", "misconception", "students")


EQUAL = (
    "Functions that these students filled in alike; names, comments and formatting do not count,"
    " nor do functions of a line or two, which all must write."
)
Group = tuple[tuple[str, ...], str]  # students, and what of their programs is equal


def write_summary(
    out: Path, lab: str, reports: list[Report], ignored: list[tuple[str, Left]], equal: list[Group]
) -> None:
    """Write checks.csv, items.csv, misconceptions.csv and summary.html into a folder.

    reports: one of each student; ignored: what was found and not graded, with whose it is, "" for
    nobody's. Who was not graded, or handed in no program, is in none of the tables, and no 0 in
    the mean.
    """
    graded = [report for report in reports if has_marks(report)]
    tables = {
        "checks": (CHECK_COLUMNS, [row for report in graded for row in check_rows(report)]),
        "items": (ITEMS, [_item(item) for item in items(graded)] if graded else []),
        "misconceptions": (MISCONCEPTIONS, [(*key, n) for key, n in misconceptions(graded)]),
    }
    for name, (columns, rows) in tables.items():
        write_whole(out / f"{name}.csv", csv_text(columns, rows))
    body = _body(lab, graded) if graded else f"<h1>{text(lab)}</h1>"
    lost = [report for report in reports if report.ungraded]
    none = [report for report in reports if report.no_program]
    parts: dict[str, tuple[tuple[str, ...], list[tuple[str, ...]]]] = {
        "Not graded: run it again": (
            ("Student", "Reason"),
            [(r.student, r.ungraded) for r in lost],
        ),
        "No program, and so no mark yet": (
            ("Student", "Reason"),
            [(r.student, trouble_of(r)) for r in none],
        ),
        "Found and not graded": (
            ("Student", "File", "Reason"),
            [(student, item.name, item.word) for student, item in ignored],
        ),
    }
    if equal:
        rows = [(text(", ".join(students)), text(same)) for students, same in equal]
        body += f"<h2>Equal programs</h2><p>{EQUAL}</p>"
        body += table("Equal programs", ("Students", "Equal"), rows)
    for title, (columns, found) in parts.items():
        if found:
            body += f"<h2>{title}</h2>{table(title, columns, [map(text, row) for row in found])}"
    write_whole(out / "summary.html", page(f"{lab}: {students_text(len(graded))}", body, STYLE))


def _item(item):
    *names, passed, mean, discrimination = astuple(item)
    tells = None if math.isnan(discrimination) else round(discrimination, 4)
    return *names, round(passed, 4), round(mean, 4), tells


def _body(lab, reports):
    bins = Counter(min(int(report.percent / 10), 9) for report in reports)
    shares = []
    for k in range(10):
        tens = f"{10 * k} to {10 * k + 10} %"
        shares.append((tens, _bar(bins[k] / len(reports)), bins[k]))
    checks = [
        (
            text(item.title),
            _bar(item.pass_rate),
            f"{100 * item.pass_rate:.0f} %",
            f"{100 * item.mean:.0f} %",
            f"{item.discrimination:.2f}".replace("nan", "–"),
        )
        for item in items(reports)
    ]
    names = [
        (f"{text(function)}: {text(name)}", _bar(count / len(reports)), count)
        for (function, name), count in misconceptions(reports)
    ]
    parts = {
        "Scores": (("Score", "share", "students"), shares),
        "Checks": (("Check", "share", "passed", "mean", "tells"), checks),
        "Misconceptions": (("Misconception", "share", "students"), names),
        "Students": (("Student", "share", "points"), map(_student, reports)),
    }
    words = f"<h1>{text(lab)}</h1><p>{scores_text(reports)}</p>"
    for title, (heads, rows) in parts.items():
        if not rows:
            continue
        words += f"<h2>{title}</h2>"
        if title == "Checks":
            words += f"<p>{TELLS}</p>"
        words += table(title, heads, rows)
    return words


def _student(report):
    link = f"students/{quote(file_name(report.student))}.html"
    trouble = f'<div class="low">{text(trouble_of(report))}</div>'
    return (
        f'<a href="{link}">{text(report.student)}</a>{trouble}',
        _bar(report.percent / 100),
        f"{number(report.points)} / {number(report.max_points)}",
    )


def _bar(share):
    return f'<div class="bar" style="width: {100 * share:.1f}%"></div>'
