"""Who handed in what: a folder with a file, a zip or a folder per student, also as Moodle and
Canvas pack them.
"""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from ...base.errors import UsageError
from ..labs import Lab
from ..variants import id_key
from ..worker.submission import ARCHIVE, PROGRAMS, SubmissionError
from .hand_in import (
    CANVAS,
    MOODLE,
    NO_FILE,
    Left,
    ProgramFile,
    beside,
    choose,
    is_hidden,
    look_into,
)


@dataclass(frozen=True)
class Entry:
    """A student's id and program; trouble: why there is none to grade; left: what else he handed
    in.

    number: the participant's number as Moodle or Canvas has it in the name, "" where there is none;
    siblings: files of his own that the program may import.
    """

    student: str
    path: Path
    trouble: str = ""
    member: str = ""
    number: str = ""
    left: tuple[Left, ...] = ()
    siblings: tuple[ProgramFile, ...] = ()


def find_submissions(
    folder: Path, lab: Lab, file: str | None = None, must_be_told_apart: bool = False
) -> tuple[list[Entry], list[Left]]:
    """Return (the entries of a folder by name, what in it is nobody's). file: the name of the
    program in each hand-in.

    Raises UsageError where two entries have the same id and must_be_told_apart: each id stands for
    a robot of its own.
    """
    groups: dict = {}
    left: list = []
    for name in sorted(os.listdir(folder)):
        path = folder / name
        if is_hidden(name):
            left.append(Left(name, "hidden"))
        elif path.is_symlink() or path.is_dir() or path.suffix.lower() in (*PROGRAMS, ARCHIVE):
            student, number = _student(path)
            groups.setdefault((student, number) if number else (name,), []).append(path)
        else:
            left.append(Left(name, "no program"))
    short = {key: _student(paths[0])[0] for key, paths in groups.items()}
    count = Counter(
        name
        for key, paths in groups.items()
        for name in {id_key(short[key]), id_key(paths[0].name)}
    )
    entries = []
    for key, paths in groups.items():
        unique = count[id_key(short[key])] == 1
        if must_be_told_apart and not unique:
            same = [
                path.name
                for k, p in groups.items()
                for path in p
                if id_key(short[k]) == id_key(short[key])
            ]
            raise UsageError(
                f"{', '.join(same)} have the same id, {short[key]!r}: which robot is whose? Leave"
                " one, or name each by its student's id as it was at --hand-out"
            )
        number = key[1] if len(key) > 1 else ""
        entries.append(_entry(short[key] if unique else paths[0].name, number, paths, lab, file))
    return entries, left


def _student(path):
    """Return (id, the number that Moodle or Canvas gives or "") in the name of a file or folder."""
    name = (
        path.stem
        if path.suffix.lower() in (*PROGRAMS, ARCHIVE) and not path.is_dir()
        else path.name
    )
    found = MOODLE.fullmatch(name) or CANVAS.fullmatch(name)
    return (found["name"], found["number"]) if found else (name, "")


def _entry(student, number, paths, lab, file):
    programs, left = [], []
    for path in paths:
        found = look_into(path)
        programs += found[0]
        left += found[1]
    try:
        program = choose(lab, programs, file)
    except SubmissionError as error:
        trouble = str(error)
        if not programs and [item.name for item in left] == [path.name for path in paths]:
            word, left = left[0].word, []
            trouble = f"it is {word}: hand in the file itself" if word in NO_FILE else word
        left += [Left(str(other), "not graded") for other in programs]
        return Entry(student, paths[0], trouble, number=number, left=tuple(left))
    left += [Left(str(other), "not graded") for other in programs if other != program]
    return Entry(
        student, program.path, "", program.member, number, tuple(left), beside(program, programs)
    )
