"""A cohort's summary on disk: CSV tables and one page without scripts or network."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import astuple
from pathlib import Path
from urllib.parse import quote

from ..intake.cohort_folder import Entry
from ..intake.hand_in import Left
from ..report.outputs import CHECK_COLUMNS, check_rows, csv_text, file_name, write_whole
from ..report.page import page, text
from ..report.text import number
from ..results import Report
from .cohort import trouble_of
from .items import items, misconceptions, scores

STYLE = """
.fivebar table { border-collapse: collapse; width: 100%; }
.fivebar .wide { overflow-x: auto; }
.fivebar th { text-align: left; color: #57606a; font-weight: 500; }
.fivebar th, .fivebar td { padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #d8dee4;
  vertical-align: top; }
.fivebar td:first-child { min-width: 11rem; }
.fivebar td:nth-child(2):has(.bar) { width: 30%; min-width: 5rem; }
.fivebar .bar { print-color-adjust: exact; height: .8rem; margin-top: .35rem; background: #0969da; }
.fivebar .low { color: #c4320a; }
"""
TELLS = (
    "Tells: correlation of passing this check with the points in all others. Near 1 it separates"
    " those who know from those who do not; near 0 or below, look at the check or at what was"
    " taught."
)
SCORES = "student,submission,points,max_points,percent,word,trouble,not graded".split(",")
ITEMS = "check,title,max_points,students,pass_rate,mean_share,discrimination".split(",")
MISCONCEPTIONS = ("function", "misconception", "students")


def write_summary(
    out: Path, lab: str, entries: list[Entry], reports: list[Report], left: list[Left]
) -> None:
    """Write checks.csv, scores.csv, items.csv, misconceptions.csv and summary.html into a folder.

    left: what belongs to nobody. Who was not graded has no points in scores.csv, and is in none of
        the others.
    """
    graded = [report for report in reports if not report.ungraded]
    tables = {
        "checks": (CHECK_COLUMNS, [row for report in graded for row in check_rows(report)]),
        "scores": (SCORES, _scores(entries, reports, left)),
        "items": (ITEMS, [_item(item) for item in items(graded)] if graded else []),
        "misconceptions": (MISCONCEPTIONS, [(*key, n) for key, n in misconceptions(graded)]),
    }
    for name, (columns, rows) in tables.items():
        write_whole(out / f"{name}.csv", csv_text(columns, rows))
    body = _body(lab, graded) if graded else f"<h1>{text(lab)}</h1>"
    lost = [(text(report.student), text(report.ungraded)) for report in reports if report.ungraded]
    if lost:
        body += f"<h2>Not graded: run it again</h2>{_table(['Student', 'Reason'], lost)}"
    ignored = [(entry.student, item) for entry in entries for item in entry.left]
    ignored += [("", item) for item in left]
    if ignored:
        rows = [(text(student), text(item.name), text(item.word)) for student, item in ignored]
        body += f"<h2>Found and not graded</h2>{_table(['Student', 'File', 'Reason'], rows)}"
    write_whole(out / "summary.html", page(f"{lab}: {len(graded)} students", body, STYLE))


def _scores(entries, reports, left):
    """Yield a row for each entry, and for what belongs to nobody."""
    for entry, report in zip(entries, reports):
        score = report.points, report.max_points, round(report.percent, 2)
        word = "no program" if entry.trouble else "graded"
        if report.ungraded:
            score, word = (None, None, None), "not graded"
        rest = "; ".join(f"{item.name}: {item.word}" for item in entry.left)
        yield report.student, report.submission, *score, word, trouble_of(report), rest
    for item in left:
        yield "", item.name, None, None, None, "ignored", item.word, ""


def _item(item):
    *names, passed, mean, discrimination = astuple(item)
    tells = None if math.isnan(discrimination) else round(discrimination, 4)
    return *names, round(passed, 4), round(mean, 4), tells


def _body(lab, reports):
    of = scores(reports)
    bins = Counter(min(int(report.percent / 10), 9) for report in reports)
    shares = [
        (f"{10 * k} to {10 * k + 10} %", _bar(bins[k] / len(reports)), bins[k]) for k in range(10)
    ]
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
    return (
        f"<h1>{text(lab)}</h1><p>{of['students']} students, mean {of['mean']:.0f} %, median"
        f" {of['median']:.0f} %, all points: {of['full']}</p>"
        f"<h2>Scores</h2>{_table(['Score', 'share', 'students'], shares)}"
        f"<h2>Checks</h2><p>{TELLS}</p>"
        f"{_table(['Check', 'share', 'passed', 'mean', 'tells'], checks)}<h2>Misconceptions</h2>"
        f"{_table(['Misconception', 'share', 'students'], names)}<h2>Students</h2>"
        f"{_table(['Student', 'share', 'points'], map(_student, reports))}"
    )


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


def _table(titles, rows):
    """Return an HTML table of cells that are HTML already."""
    lines = ["".join(f"<th>{title}</th>" for title in titles)]
    for row in rows:
        lines.append("".join(f"<td>{cell}</td>" for cell in row))
    return f'<div class="wide"><table><tr>{"</tr><tr>".join(lines)}</tr></table></div>'
