"""What a cohort's results say about the lab: how hard each check is, how well it tells, which
misconceptions it met.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from statistics import correlation, fmean, median

from ..judging.results import Report


@dataclass(frozen=True)
class Item:
    """One check over n students.

    pass_rate: part of them with all its points; mean: share of its points earned on average;
    discrimination: the point-biserial correlation of passing with the points in all other checks,
        nan where either does not vary.
    """

    name: str
    title: str
    max_points: float
    n: int
    pass_rate: float
    mean: float
    discrimination: float


def items(reports: list[Report]) -> list[Item]:
    """Return an Item per check, in the lab's order. All reports are of one lab."""
    found = []
    for k, check in enumerate(reports[0].checks):
        mine = [report.checks[k] for report in reports]
        passed = [float(c.outcome == "right") for c in mine]
        rest = [_points_without(report, check.name) for report in reports]
        varies = min(passed) < max(passed) and min(rest) < max(rest)
        found.append(
            Item(
                check.name,
                check.title,
                check.max_points,
                len(mine),
                fmean(passed),
                fmean(c.share for c in mine),
                correlation(passed, rest) if varies else math.nan,
            )
        )
    return found


def has_marks(report: Report) -> bool:
    """Return whether a report tells what a student can do: it was graded, by a lab without a fault,
    and there was a program.
    """
    return not (report.ungraded or report.faults or report.no_program)


def _all_right(report):
    return all(check.outcome == "right" for check in report.checks)


def _points_without(report, name):
    return sum(check.points for check in report.checks if check.name != name)


def misconceptions(reports: list[Report]) -> list[tuple[tuple[str, str], int]]:
    """Return ((function, misconception), number of students), the most frequent first."""
    met: Counter = Counter()
    for report in reports:
        met.update(
            {
                (check.function, check.misconception)
                for check in report.checks
                if check.misconception
            }
        )
    return sorted(met.items(), key=lambda pair: (-pair[1], pair[0]))


def students_text(count: int) -> str:
    """Return how many students."""
    return f"{count} student{'s' * (count != 1)}"


def scores_text(reports: list[Report]) -> str:
    """Return number of students, mean and median in per cent of the points, and how many have all
    points.
    """
    percent = [report.percent for report in reports]
    middle = f"mean {fmean(percent):.0f} %, median {median(percent):.0f} %"
    full = sum(_all_right(report) for report in reports)
    return f"{students_text(len(reports))}, {middle}, with all points: {full}"


def summary_text(lab: str, reports: list[Report]) -> str:
    """Return the scores in a line, without those who handed in no program."""
    reports = list(filter(has_marks, reports))
    return f"{lab}: {scores_text(reports) if reports else 'nobody is graded'}"
