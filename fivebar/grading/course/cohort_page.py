"""A cohort's summary on disk: CSV tables and one page without scripts or network."""

from __future__ import annotations

import math
from collections.abc import Iterable
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

BINS = 10  # of the histogram of scores, each 10 % wide
STYLE = """
.fivebar table { border-collapse: collapse; width: 100%; }
.fivebar .wide { overflow-x: auto; }
.fivebar th { text-align: left; color: #57606a; font-weight: 500; }
.fivebar th, .fivebar td { padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #d8dee4;
  vertical-align: top; }
.fivebar .n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums;
  overflow-wrap: normal; }
.fivebar td.name { min-width: 11rem; }
.fivebar .bar { width: 30%; min-width: 5rem; }
.fivebar .bar div, .fivebar .histogram div { print-color-adjust: exact; }
.fivebar .bar div { height: .8rem; margin-top: .35rem; background: #0969da; min-width: 1px; }
.fivebar .histogram { display: flex; align-items: flex-end; gap: 3px; height: 9rem;
  border-bottom: 1px solid #57606a; }
.fivebar .histogram div { flex: 1; background: #0969da; position: relative; }
.fivebar .histogram span { position: absolute; top: -1.3rem; width: 100%; text-align: center;
  font-size: .8rem; }
.fivebar .ends { display: flex; justify-content: space-between; font-size: .8rem; color: #57606a; }
.fivebar .chart { padding-top: 1.4rem; }
.fivebar .low { color: #c4320a; }
@media (max-width: 560px) { .fivebar th.bar, .fivebar td.bar { display: none; }
}
"""
TELLS = (
    "Tells: correlation of passing this check with the points in all others. Near 1 it separates"
    " those who know from those who do not; near 0 or below, look at the check or at what was"
    " taught."
)


def write_summary(
    out: Path, lab: str, entries: list[Entry], reports: list[Report], left: list[Left]
) -> None:
    """checks.csv, scores.csv, items.csv, misconceptions.csv and summary.html in the folder `out`.

    left: what was found and is nobody's. Who was not graded has no points in scores.csv, and is in
        none of the others.
    """
    all_reports, reports = reports, [report for report in reports if not report.ungraded]
    rows = [row for report in reports for row in check_rows(report)]
    write_whole(out / "checks.csv", csv_text(CHECK_COLUMNS, rows))
    columns = (
        "student",
        "submission",
        "points",
        "max_points",
        "percent",
        "word",
        "trouble",
        "not graded",
    )
    rows = [
        (*_score(report), word_of(entry, report), trouble_of(report), left_text(entry.left))
        for entry, report in zip(entries, all_reports)
    ]
    rows += [("", item.name, None, None, None, "ignored", item.word, "") for item in left]
    write_whole(out / "scores.csv", csv_text(columns, rows))
    columns = (
        "check",
        "title",
        "max_points",
        "students",
        "pass_rate",
        "mean_share",
        "discrimination",
    )
    rows = [
        (
            i.name,
            i.title,
            i.max_points,
            i.n,
            round(i.pass_rate, 4),
            round(i.mean, 4),
            _or_none(i.discrimination),
        )
        for i in items(reports)
    ]
    write_whole(out / "items.csv", csv_text(columns, rows))
    rows = [(*key, count) for key, count in misconceptions(reports)]
    write_whole(
        out / "misconceptions.csv", csv_text(("function", "misconception", "students"), rows)
    )
    beside = [(entry.student, item) for entry in entries for item in entry.left] + [
        ("", item) for item in left
    ]
    ungraded = [report for report in all_reports if report.ungraded]
    body = _body(lab, reports) if reports else f"<h1>{text(lab)}</h1>"
    body += _ungraded(ungraded) + _left(beside)
    write_whole(out / "summary.html", page(f"{lab}: {len(reports)} students", body, STYLE))


def word_of(entry: Entry, report: Report) -> str:
    """What became of an entry, in a word or two."""
    return "not graded" if report.ungraded else "no program" if entry.trouble else "graded"


def left_text(left: Iterable[Left]) -> str:
    return "; ".join(f"{item.name}: {item.word}" for item in left)


def _score(report):
    if report.ungraded:
        return report.student, report.submission, None, None, None
    return (
        report.student,
        report.submission,
        report.points,
        report.max_points,
        round(report.percent, 2),
    )


def _ungraded(reports):
    rows = [f"<tr><td>{text(r.student)}</td><td>{text(r.ungraded)}</td></tr>" for r in reports]
    return (
        f"<h2>Not graded: run it again</h2>{_table((('Student', ''), ('', '')), rows)}"
        if rows
        else ""
    )


def _left(beside):
    if not beside:
        return ""
    rows = [
        f"<tr><td>{text(student)}</td><td>{text(item.name)}</td><td>{text(item.word)}</td></tr>"
        for student, item in beside
    ]
    return f"<h2>Found and not graded</h2>{_table((('Student', ''), ('File', ''), ('', '')), rows)}"


def _or_none(value):
    return None if math.isnan(value) else round(value, 4)


def _body(lab, reports):
    of = scores(reports)
    return (
        f"<h1>{text(lab)}</h1><p>{of['students']} students, mean {of['mean']:.0f} %, median"
        f" {of['median']:.0f} %, "
        f"all points: {of['full']}</p>"
        f"<h2>Scores</h2>{_histogram([report.percent for report in reports])}"
        f"<h2>Checks</h2><p>{TELLS}</p>{_items(reports)}"
        f"<h2>Misconceptions</h2>{_misconceptions(reports)}"
        f"<h2>Students</h2>{_students(reports)}"
    )


def _histogram(percent):
    counts = [0] * BINS
    for value in percent:
        counts[min(int(value * BINS / 100), BINS - 1)] += 1
    bars = "".join(
        f'<div style="height: {100 * count / max(counts):.1f}%" title="{10 * k} to {10 * k + 10} %:'
        f' {count}">'
        f"<span>{count or ''}</span></div>"
        for k, count in enumerate(counts)
    )
    ends = '<div class="ends"><span>0 %</span><span>100 %</span></div>'
    return f'<div class="chart"><div class="histogram">{bars}</div>{ends}</div>'


def _table(head, rows):
    cells = "".join(f'<th class="{kind}">{label}</th>' for label, kind in head)
    return f'<div class="wide"><table><tr>{cells}</tr>{"".join(rows)}</table></div>'


def _bar(share):
    return f'<td class="bar"><div style="width: {100 * share:.1f}%"></div></td>'


def _items(reports):
    rows = []
    for item in items(reports):
        tells = (
            "–"
            if math.isnan(item.discrimination)
            else f"{item.discrimination:.2f}".replace("-", "−")
        )
        low = " low" if item.discrimination < 0.1 else ""
        rows.append(
            f'<tr><td class="name">{text(item.title)}</td>{_bar(item.pass_rate)}<td'
            f' class="n">{100 * item.pass_rate:.0f} %</td><td class="n">{100 * item.mean:.0f}'
            f' %</td><td class="n{low}">{tells}</td></tr>'
        )
    return _table(
        (("Check", ""), ("", "bar"), ("passed", "n"), ("mean", "n"), ("tells", "n")), rows
    )


def _misconceptions(reports):
    rows = [
        f'<tr><td class="name">{text(function)}: {text(name)}</td>{_bar(count / len(reports))}'
        f'<td class="n">{count}</td></tr>'
        for (function, name), count in misconceptions(reports)
    ]
    return (
        _table((("Misconception", ""), ("", "bar"), ("students", "n")), rows)
        if rows
        else "<p>None was recognised.</p>"
    )


def _students(reports):
    rows = []
    for report in sorted(reports, key=lambda r: (r.student.casefold(), r.student)):
        link = f"students/{quote(file_name(report.student))}.html"
        trouble = f'<div class="low">{text(trouble_of(report))}</div>' if trouble_of(report) else ""
        rows.append(
            f'<tr><td class="name"><a href="{link}">{text(report.student)}</a>{trouble}</td>'
            f'{_bar(report.percent / 100)}<td class="n">'
            f"{number(report.points)} / {number(report.max_points)}</td></tr>"
        )
    return _table((("Student", ""), ("", "bar"), ("points", "n")), rows)
