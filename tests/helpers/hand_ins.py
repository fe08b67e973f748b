"""The corpus of hand-ins: bases with patches and their true mistakes, graded, and how many are named."""

import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fivebar.grading.grade import grade
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from tests.helpers import DATA
from tests.helpers.mended import holds_elsewhere, in_the_right_place

FOLDER = DATA / "hand_ins"


@dataclass(frozen=True)
class HandIn:
    """A file of the corpus: `truths` has function -> regular expression of each of its mistakes."""

    lab: str
    base: str
    encoding: str
    title: str
    source: str
    truths: dict


def hand_ins(file: str = "cases.txt") -> Iterator[HandIn]:
    for block in re.split(r"(?m)^== ", (FOLDER / file).read_text("utf-8"))[1:]:
        head, *lines = block.rstrip().split("\n")
        words, title = head.split(": ", 1)
        lab, base, encoding = (words.split() + ["utf-8"])[:3]
        source = (FOLDER / f"{base}.py").read_text("utf-8")
        for hunk in re.findall(r"(?:^-.*\n)+(?:^\+.*\n)*", "\n".join(lines) + "\n", re.MULTILINE):
            source = patched(source, hunk.splitlines(), title)
        truths = dict(line[2:].split(": ", 1) for line in lines if line.startswith("= "))
        yield HandIn(lab, base, encoding, title, source, truths)


def patched(source, hunk, title):
    """The source with the hunk's lines exchanged; blanks within a line do not count where it is looked for."""
    old, new = ([line[1:] for line in hunk if line[0] == sign] for sign in "-+")
    lines, wanted = source.split("\n"), [re.sub(r"\s", "", line) for line in old]
    bare = [re.sub(r"\s", "", line) for line in lines]
    found = [k for k in range(len(bare)) if bare[k : k + len(old)] == wanted]
    assert len(found) == 1, f"{title}: {old} is found {len(found)} times"
    return "\n".join([*lines[: found[0]], *new, *lines[found[0] + len(old) :]])


def graded(case, folder, seed="corpus"):
    path = Path(folder) / "hand_in.py"
    path.write_bytes(case.source.encode(case.encoding))
    report = grade(find_lab(case.lab), Job(path, seed=seed))
    assert not any("search for what is wrong failed" in note for note in report.notes)
    return report


def outcome(case, report):
    """(functions whose mistake is named, {(function, name)} of names that are not true, points lost beside them)."""
    named, false, lost = set(), set(), 0
    for check in report.checks:
        true = case.truths.get(check.function)
        notes = " ".join((check.misconception, check.spot, check.text, *check.remarks))
        beside = re.match("(consistent with|fails in) your", check.misconception)
        told = check.misconception and not beside or check.spot
        if true is not None and (re.search(true, notes, re.DOTALL) or mends(case, check)):
            named.add(check.function)
        elif told:
            false.add((check.function, f"{check.misconception} {check.spot}".strip()))
        lost += (check.max_points - check.points) * (true is None)
    return named, false, lost


@cache
def _base(base):
    return (FOLDER / f"{base}.py").read_text("utf-8")


@cache
def _mends(case_key, function, spot):
    case = _CASES[case_key]
    return in_the_right_place(case, _base(case.base), spot) and (
        holds_elsewhere(case, function, spot) is not False
    )


_CASES = {}


def mends(case, check):
    """Whether a change is told that is made where the mistake is, and makes the function right elsewhere, too."""
    _CASES[case.title, case.source] = case
    return "right answers come with" in check.spot and _mends(
        (case.title, case.source), check.function, check.spot
    )


def main(files):
    """Prints what is named of each file, and the sums."""
    mistakes = found = wrongly = right = full = 0
    cases = [case for file in files for case in hand_ins(file)]
    for case in cases:
        with tempfile.TemporaryDirectory() as folder:
            report = graded(case, folder)
        named, false, lost = outcome(case, report)
        mistakes, found, wrongly = (
            mistakes + len(case.truths),
            found + len(named),
            wrongly + len(false),
        )
        right, full = (
            right + (not case.truths),
            full + (not case.truths and report.points == report.max_points),
        )
        print(
            f"{case.lab} {case.base}: {case.title}: {report.points} points, {len(named)} of {len(case.truths)} named"
        )
        for name in sorted(set(case.truths) - named):
            texts = {f"{c.text} [{c.misconception}]" for c in report.checks if c.function == name}
            print(f"    missed in {name}: {' | '.join(sorted(texts))[:300]}")
        for name in sorted(false):
            print("    NOT TRUE:", *name)
        if lost:
            print(f"    {lost:g} points lost beside the mistakes")
    print(
        f"named {found} of {mistakes}, {wrongly} not truly; full marks for {full} of {right} right files"
    )


if __name__ == "__main__":
    main(sys.argv[1:] or ["cases.txt"])
