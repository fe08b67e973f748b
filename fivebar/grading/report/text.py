"""The report as plain text: every check, and for each that is not right what was asked, what came,
and why.
"""

from __future__ import annotations

import builtins
import shutil
import textwrap
from collections.abc import Iterator

from ...base.representation import printable
from ..judging.results import Check, Report
from ..worker.replies import KINDS

COLOURS = {"right": "32", "to do": "36", "partly": "33", "wrong": "31", "broken": "35"}
OUTCOMES = {
    "value": "wrong value",
    "nan": "nan or infinity",
    "shape": "not as many numbers as are asked",
    "type": "no number",
    "accepted": "gave an answer where none exists: raise an error, or return nan or None",
}
PRINTED = 20  # lines of the program's own
HOME = (
    "The inputs here are public. Grading uses hidden ones of the same kind, so pass by the model,"
    " not by the numbers."
)


def number(value: float) -> str:
    """Return points without needless decimals."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def not_started(check: Check) -> bool:
    """Return the student has not come to it yet: a friendlier word than wrong."""
    return (
        check.reason == "exception"
        and "NotImplementedError" in check.text
        or check.reason == "missing"
        and "no function" in check.text
    )


def nothing_is_filled_in(report: Report) -> bool:
    """Return whether no check of a report has come to anything that the student wrote."""
    return bool(report.checks) and all(map(not_started, report.checks))


def word(check: Check) -> str:
    """Return a check's outcome in one word or two."""
    return "to do" if not_started(check) else check.outcome


def facts(check: Check) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of what a student can do something with, most telling first."""
    if check.outcome == "right":
        if check.beside:
            yield "lab's test", check.beside
        return
    if check.outcome == "broken":
        yield (
            "fault",
            f"{check.text}. This is a fault of the lab, not yours: tell whoever gave it to you.",
        )
        return
    if not_started(check):
        yield (
            "task",
            check.text.removeprefix(KINDS[check.reason] + ": ").removeprefix(
                "NotImplementedError: "
            ),
        )
    elif check.text:
        yield "why", check.text
        if check.rows > 1:
            yield "how many", f"{check.wrong} of {check.rows} calls; the first:"
        if check.asked:
            yield "call", check.asked
        if check.came and check.reason in ("value", "nan", "shape", "type", "accepted"):
            yield "returned", check.came
        if check.off is not None and check.reason == "value":
            yield "off by", f"{check.off:.3g}"
    if check.line and not not_started(check):
        yield "where", f"{check.place}: {check.source.strip()}"
    if check.beside:
        yield "lab's test", check.beside
    yield from _advice(check)


def _advice(check):
    if check.misconception:
        yield "looks like", check.misconception
        yield "hint", check.hint
    if check.spot:
        yield "in detail", check.spot


def told(check: Check) -> Iterator[tuple[str, str]]:
    """Yield (label, text) of what may be told where inputs are hidden: nothing that the program
    itself could have chosen.
    """
    if check.outcome == "broken":
        yield from facts(check)
    elif not_started(check):
        yield "task", "not filled in yet"
    elif check.outcome != "right" and check.reason != "withheld":
        name = check.text.removeprefix(KINDS["exception"]).strip(": ").split(":")[0]
        known = check.reason == "exception" and isinstance(getattr(builtins, name, None), type)
        yield (
            "why",
            OUTCOMES.get(check.reason)
            or KINDS.get(check.reason, "not right") + (f": {name}" if known else ""),
        )
        if check.rows > 1:
            yield "how many", f"{check.wrong} of {check.rows} calls"
        yield from _advice(check)


def same_fault(check: Check) -> tuple | None:
    """Return what two checks share if reading one of their explanations is enough."""
    if check.misconception:
        return check.function, check.misconception
    if check.reason in ("", "broken", "withheld"):
        return None
    return check.reason, check.text, check.line, check.reason != "import" and check.function


def check_lines(check: Check, width: int, known: dict | None = None) -> list[str]:
    """Return one check's lines; `known` maps faults already explained to the title of the check
    that did.
    """
    score = f"{number(check.points)}/{number(check.max_points)}"
    title = printable(check.title)
    lines = textwrap.wrap(
        title, width, initial_indent=f"{word(check):<7} {score:>7}  ", subsequent_indent=" " * 17
    )
    fault = same_fault(check)
    if known is not None and fault is not None:
        if fault in known:
            if not not_started(check):
                lines += _wrapped("", f'as in "{known[fault]}"', width)
            return lines
        known[fault] = title
    for label, text in facts(check):
        lines += _wrapped(label, printable(text), width)
    return lines


def _wrapped(label, text, width):
    head = f"{label:>15}  "
    return textwrap.wrap(
        text, width, initial_indent=head, subsequent_indent=" " * 17, break_on_hyphens=False
    )


def report_text(report: Report, width: int | None = None, colour: bool = False) -> str:
    """Return the whole report for a terminal of `width` columns (None: this one's, at most 100)."""
    width = max(60, min(width or shutil.get_terminal_size().columns, 100))
    total = total_words(report)
    lines = [*textwrap.wrap(f"{report.lab}: {printable(report.submission)}: {total}", width), ""]
    for text in headlines(report):
        lines += [*textwrap.wrap(printable(text), width), ""]
    known: dict = {}
    for check in shown_checks(report):
        first, *rest = check_lines(check, width, known)
        if colour:
            first = f"\x1b[{COLOURS[word(check)]}m{first[:7]}\x1b[0m{first[7:]}"
        lines += [first, *rest]
    for text in closing(report):
        lines += ["", *textwrap.wrap(printable(text), width)]
    if report.output.strip():
        rows = report.output.rstrip().splitlines()
        lines += ["", "Your program printed:", *(f"  {printable(row)}" for row in rows[:PRINTED])]
        lines += ["  and more"] * (len(rows) > PRINTED)
    if not report.no_program:
        lines += ["", f"total {total}"]
    return "\n".join(lines)


def total_words(report: Report) -> str:
    """Return the points in words."""
    if report.no_program:
        return "no points, as there is no program for this lab"
    return f"{number(report.points)} of {number(report.max_points)} points"


def shown_checks(report: Report) -> tuple[Check, ...]:
    """Return the checks of which something can be said: none where there is no program."""
    return () if report.no_program else report.checks


def headlines(report: Report) -> Iterator[str]:
    """Yield what to know before reading the checks."""
    if report.trouble:
        yield report.trouble
    elif nothing_is_filled_in(report):
        yield (
            "Nothing is filled in yet: each check below says which task it belongs to. Begin with"
            " the first."
        )
    yield from report.notes
    if report.faults:
        yield (
            f"The lab itself has a fault, so this result does not count: {'; '.join(report.faults)}"
        )


def closing(report: Report) -> Iterator[str]:
    remarks: dict = {}
    for check in report.checks:
        for remark in check.remarks:
            remarks.setdefault(remark, []).append(check.function or check.title)
    for remark, where in remarks.items():
        yield f"{', '.join(dict.fromkeys(where))}: {remark}."
    if report.home:
        yield HOME
