"""A course's settings: `course.toml` in the folder of results, written there for the teacher to
edit.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import date, datetime, time
from fnmatch import fnmatchcase
from importlib.util import find_spec
from pathlib import Path

from ...base.errors import UsageError
from ..judging.results import Report
from ..labs import Lab
from ..report.outputs import write_whole

FILE = "course.toml"
TEMPLATE = """\
# Settings of this course, for {lab}. Remove the # before a line to use it, and run the same
# command again. Only `packages` lets programs run again.

# labs = ["{lab}"]             # those that count; without this line all that have files here
# due = 2027-01-31 18:00:00    # see also the columns "days late" and "extra days" of marks.csv
# late_percent = 10            # of the mark, lost for each day begun after `due`
# packages = ["sympy"]         # that programs may import, beside NumPy and SciPy

# [points.{lab}]               # of single checks; * stands for any letters. Names are in items.csv
# "test_*" = 0.5
# {check} = 2
"""


@dataclass(frozen=True)
class Settings:
    """What a teacher set: labs that count (None: all), when they are due, the share of the mark
    lost for a day, packages that may be imported, and the points of checks by lab.
    """

    labs: tuple[str, ...] | None = None
    due: datetime | None = None
    late_percent: float = 0.0
    packages: tuple[str, ...] = ()
    points: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def weighted(self, report: Report) -> Report:
        """Return a report with this course's points for its checks. The shares stay."""
        points = self.points.get(report.lab, {})
        for pattern in points:
            if report.checks and not any(fnmatchcase(c.name, pattern) for c in report.checks):
                raise UsageError(f"{FILE}: no check of {report.lab} is called {pattern!r}")
        checks = []
        for check in report.checks:
            most = [value for pattern, value in points.items() if _means(pattern, check)]
            if most:
                earned = min(round(most[-1] * check.share, 2), most[-1])
                check = replace(check, max_points=most[-1], points=earned)
            checks.append(check)
        return replace(report, checks=tuple(checks))


def _means(pattern, check):
    """Return whether a check is meant: one that does not count is not by a pattern."""
    if check.max_points == 0:
        return pattern == check.name
    return fnmatchcase(check.name, pattern)


def read_settings(out: Path) -> Settings:
    """Return the settings in a folder of results. Raises UsageError where one is not as asked."""
    path = out / FILE
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, NotADirectoryError):
        return Settings()
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise UsageError(
            f"{path}: {error}; a time reads 2027-01-31 18:00:00, a number 10.5"
        ) from None
    for name in found:
        if name not in Settings.__dataclass_fields__:
            known = ", ".join(Settings.__dataclass_fields__)
            raise UsageError(f"{path}: there is no setting {name!r}; there are {known}")
    values = {name: _CHECKS[name](path, name, value) for name, value in found.items()}
    return Settings(**values)


def offer_settings(out: Path, lab: Lab) -> None:
    """Write the file of settings where there is none yet; what it shows are the lab's names."""
    if not (out / FILE).exists():
        checks = re.findall(r"(?m)^def (test_\w+)", lab.tests.read_text("utf-8"))
        check = checks[0] if checks else "test_dgm_all_over"
        write_whole(out / FILE, TEMPLATE.format(lab=lab.name, check=check))


def _names(path, name, value):
    if isinstance(value, list) and all(isinstance(word, str) for word in value):
        return tuple(value)
    raise UsageError(f'{path}: {name} is a list of names, {name} = ["one", "two"]')


def _packages(path, name, value):
    for package in _names(path, name, value):
        # A submission that imports fivebar would hand in fivebar's answers.
        if package == "fivebar" or not package.isidentifier():
            raise UsageError(f"{path}: {package!r} is no package that programs may import")
        if find_spec(package) is None:
            raise UsageError(f"{path}: the package {package} is not installed here")
    return tuple(value)


def _due(path, name, value):
    if isinstance(value, datetime):
        return value.astimezone().replace(tzinfo=None) if value.tzinfo else value
    if isinstance(value, date):
        return datetime.combine(value, time(23, 59, 59))
    raise UsageError(f"{path}: due is a time without quotes, due = 2027-01-31 18:00:00")


def _percent(path, name, value):
    if _is_number(value) and 0 <= value <= 100:
        return float(value)
    raise UsageError(f"{path}: {name} is a number from 0 to 100, not {value!r}")


def _points(path, name, value):
    if isinstance(value, dict) and all(isinstance(checks, dict) for checks in value.values()):
        numbers = [points for checks in value.values() for points in checks.values()]
        if all(_is_number(points) and 0 <= points <= 1e6 for points in numbers):
            return value
    raise UsageError(f"{path}: points reads [points.LAB] and below it lines CHECK = POINTS")


def _is_number(value):
    return type(value) in (int, float)


_CHECKS = {
    "labs": _names,
    "due": _due,
    "late_percent": _percent,
    "packages": _packages,
    "points": _points,
}
