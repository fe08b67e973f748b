"""What grading one submission found, as values that go to JSON and back."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, fields, replace

from ..report.pose_figure import pose_figure
from .ask import Asked, Wrong

SCHEMA = 1
# What a Check has of its Verdict.
OF_VERDICT = "share reason text wrong rows asked came off line source beside".split()


@dataclass(frozen=True)
class Check:
    """One check's result; outcome is right, partly, wrong, or broken where the check itself failed.

    points: earned of max_points; reason, text, wrong, rows, asked, came, off, line, source,
    remarks: as in Verdict, of what was asked first and was not right; place: the line in its
        author's words;
    function: whose answers were judged; beside: what the lab's own test says of them;
        misconception, hint: "" where none; spot: the line, what stands there and what would be
        right, "" where that was not found.
    """

    name: str
    title: str
    max_points: float
    points: float
    share: float
    outcome: str
    function: str = ""
    reason: str = ""
    text: str = ""
    wrong: int = 0
    rows: int = 0
    asked: str = ""
    came: str = ""
    off: float | None = None
    misconception: str = ""
    hint: str = ""
    line: int | None = None
    source: str = ""
    place: str = ""
    spot: str = ""
    remarks: tuple[str, ...] = ()
    beside: str = ""
    figure: str = field(default="", repr=False)  # SVG, for pages only


def checked(
    name: str, title: str, points: float, record: list[Asked], error: BaseException | None
) -> Check:
    """Return the Check of a test that ended with `error` (None: passed) after the `record` of what
    it asked.
    """
    test = name, title, points
    if error is not None and not isinstance(error, AssertionError):
        text = (
            f"the check itself failed: {type(error).__name__}: {' '.join(str(error).split())[:300]}"
        )
        return Check(*test, 0.0, 0.0, "broken", reason="broken", text=text)
    remarks = tuple(dict.fromkeys(remark for asked in record for remark in asked.verdict.remarks))
    functions = [asked.function for asked in record if asked.function]
    function = functions[-1] if functions else ""
    if error is None:
        beside = record[-1].verdict.beside if record else ""
        return Check(*test, points, 1.0, "right", function, remarks=remarks, beside=beside)
    if not isinstance(error, Wrong):  # a plain assert in the check
        text = " ".join(str(error).split())[:300] or "the check's assertion does not hold"
        return Check(*test, 0.0, 0.0, "wrong", function, "value", text, remarks=remarks)
    v, asked = error.verdict, record[-1]
    figure = ""
    if v.sample and asked.robot and asked.exercise:
        figure = pose_figure(asked.robot, asked.exercise, v.sample)
    return Check(
        *test,
        min(round(points * v.share, 2), points),
        outcome="partly" if v.share > 0 else "wrong",
        function=function,
        misconception=v.diagnosis.name if v.diagnosis else "",
        hint=v.diagnosis.hint if v.diagnosis else "",
        place=f"line {v.line}" if v.line else "",
        remarks=remarks,
        figure=figure,
        **{key: getattr(v, key) for key in OF_VERDICT},
    )


@dataclass(frozen=True)
class Report:
    """All checks of a lab on one submission, and all that is needed to grade it again with the same
    result.

    student, seed, robot, isolate, lab_hash, submission_hash: what was graded and how; trouble: what
    kept the file from being read or run to its end; notes: on the whole file; faults: of the lab
    itself; output: what the student's program printed; home: the inputs were public; ungraded: why
    there are no checks, which is nobody's 0 points;
    hints_from: the day from which students are told why, "" where that is not in the future;
    packages: that the program may import, beside NumPy and SciPy; no_program: nothing could be read
    that is a program for this lab, so that its 0 points are no mark.
    """

    lab: str
    submission: str
    checks: tuple[Check, ...]
    student: str = ""
    seed: str = ""
    robot: dict = field(default_factory=dict)
    isolate: str = "process"
    lab_hash: str = ""
    submission_hash: str = ""
    trouble: str = ""
    notes: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    output: str = ""
    seconds: float = 0.0
    home: bool = False
    ungraded: str = ""
    hints_from: str = ""
    packages: tuple[str, ...] = ()
    no_program: bool = False
    # To the one who grades, of this machine: not part of the result.
    warnings: tuple[str, ...] = field(default=(), repr=False)

    @property
    def points(self) -> float:
        return round(sum(check.points for check in self.checks), 2)

    @property
    def max_points(self) -> float:
        return sum(check.max_points for check in self.checks)

    @property
    def percent(self) -> float:
        return 100 * self.points / self.max_points if self.max_points else 0.0

    def as_json(self, figures: bool = False) -> dict:
        """Return plain data; with the figures, which show right answers, only where asked."""
        data = {"schema": SCHEMA, "points": self.points, "max_points": self.max_points} | asdict(
            self
        )
        del data["warnings"]
        for check in data["checks"]:
            if not figures:
                del check["figure"]
        return data

    @classmethod
    def from_json(cls, data: dict) -> Report:
        """Return a Report from `as_json`'s data. Raises KeyError, TypeError or ValueError where it
        is something else.
        """
        if data["schema"] != SCHEMA:
            raise ValueError(f"a result of schema {data['schema']}, not {SCHEMA}")
        names = {f.name for f in fields(cls)}
        checks = tuple(
            Check(**check | {"remarks": tuple(check["remarks"])}) for check in data["checks"]
        )
        lists = {name: tuple(data[name]) for name in ("notes", "faults", "packages")}
        return cls(
            **{name: value for name, value in data.items() if name in names}
            | lists
            | {"checks": checks}
        )


def joined(reports: list[Report]) -> Report:
    """Return one report of a hand-in for several labs; each check says of which lab it is."""
    if len(reports) == 1:
        return reports[0]
    checks = [replace(c, title=f"{r.lab}: {c.title}") for r in reports for c in r.checks]
    notes = [f"{r.lab}: {note}" for r in reports for note in (*filter(None, [r.trouble]), *r.notes)]
    return replace(
        reports[0],
        lab=" and ".join(report.lab for report in reports),
        submission=", ".join(dict.fromkeys(report.submission for report in reports)),
        checks=tuple(checks),
        trouble="",
        notes=tuple(notes),
        faults=tuple(fault for report in reports for fault in report.faults),
        output="".join(report.output for report in reports),
        seconds=round(sum(report.seconds for report in reports), 3),
        no_program=all(report.no_program for report in reports),
    )


def withheld(report: Report) -> Report:
    """Return what a student is shown: all of it, or before the day of the hints the
    points alone.
    """
    if not report.hints_from:
        return report
    bare = tuple(
        Check(
            c.name,
            c.title,
            c.max_points,
            c.points,
            c.share,
            c.outcome,
            reason="withheld" if c.share < 1 else "",
        )
        for c in report.checks
    )
    note = f"Explanations are given from {report.hints_from} on."
    return replace(report, checks=bare, notes=(*report.notes, note), output="")
