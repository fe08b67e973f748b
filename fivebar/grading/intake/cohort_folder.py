"""Who handed in what: a folder with a file, a zip or a folder per student, also as Moodle and
Canvas pack them.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from ...base.errors import UsageError
from ..labs import Lab
from ..worker.submission import ARCHIVE, PROGRAMS, SubmissionError
from .hand_in import (
    CANVAS,
    MOODLE,
    NO_FILE,
    Left,
    ProgramFile,
    beside,
    choose,
    imported,
    is_hidden,
    listed,
    look_into,
    named_for,
    source_of,
)
from .students_robots import id_key, name_key


@dataclass(frozen=True)
class HandIn:
    """All that one student handed in: programs, and what is none.

    number: the participant's number as Moodle or Canvas has it in the name, "" where there is none;
    paths: the files and folders of the course's folder that are his.
    """

    student: str
    number: str
    paths: tuple[Path, ...]
    programs: tuple[ProgramFile, ...]
    left: tuple[Left, ...]


@dataclass(frozen=True)
class Entry:
    """A student's id and the program of his that is graded for one lab; trouble: why there is none.

    name: the program's path in the hand-in; siblings: files of his own that it may import; attempt:
    which one of his it is; the best counts.
    """

    student: str
    path: Path
    trouble: str = ""
    member: str = ""
    number: str = ""
    siblings: tuple[ProgramFile, ...] = ()
    attempt: int = 1
    name: str = ""


def is_one_hand_in(folder: Path, labs: Iterable[Lab]) -> bool:
    """Return whether a lab's own file lies in the folder itself, which is then one student's."""
    own = {lab.file().casefold() for lab in labs} - {""}
    return any(name.casefold() in own for name in os.listdir(folder))


def find_hand_ins(
    folder: Path, must_be_told_apart: bool = False, labs: Iterable[Lab] = ()
) -> tuple[list[HandIn], list[Left]]:
    """Return (the hand-ins of a folder by name, what in it is nobody's).

    labs: those whose file makes a folder that holds it one hand-in.

    Raises UsageError where two have the same id and must_be_told_apart: each id stands for a robot
    of its own.
    """
    if is_one_hand_in(folder, labs):
        return [_hand_in(folder.resolve().name, "", [folder])], []
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
    found = []
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
        found.append(_hand_in(short[key] if unique else paths[0].name, number, paths))
    return found, left


def _student(path):
    """Return (id, the number that Moodle or Canvas gives or "") in the name of a file or folder."""
    name = (
        path.stem
        if path.suffix.lower() in (*PROGRAMS, ARCHIVE) and not path.is_dir()
        else path.name
    )
    found = MOODLE.fullmatch(name) or CANVAS.fullmatch(name)
    return (found["name"], found["number"]) if found else (name, "")


def _hand_in(student, number, paths):
    programs: list = []
    left: list = []
    for path in paths:
        found = look_into(path)
        programs += found[0]
        left += found[1]
    return HandIn(student, number, tuple(paths), tuple(programs), tuple(left))


def entries_of(
    hand_ins: Iterable[HandIn], lab: Lab, file: str | None = None, named: bool = False
) -> list[Entry]:
    """Return the entries of a lab: one for each hand-in, or for each version of its file there.

    file: the name of the program in each hand-in. named: leave out who has no file of the lab's own
    name for it.
    """
    entries: list = []
    attempts: Counter = Counter()
    for hand_in in hand_ins:
        if named and not named_for(lab, hand_in.programs):
            continue
        for entry in _entries(hand_in, lab, file):
            attempts[name_key(entry.student)] += 1
            entries.append(replace(entry, attempt=attempts[name_key(entry.student)]))
    return entries


def _entries(hand_in, lab, file):
    programs, number = list(hand_in.programs), hand_in.number
    try:
        chosen = choose(lab, programs, file)
    except SubmissionError as error:
        trouble, left = str(error), hand_in.left
        if not programs and [item.name for item in left] == [path.name for path in hand_in.paths]:
            word = left[0].word
            trouble = f"it is {word}: hand in the file itself" if word in NO_FILE else word
        elif not programs:
            trouble += listed(left)
        yield Entry(hand_in.student, hand_in.paths[0], trouble, number=number)
        return
    for program in chosen:
        siblings, name = beside(program, programs), str(program).partition("/")[2]
        where = program.path, "", program.member, number, siblings
        yield Entry(hand_in.student, *where, name=name or str(program))


def not_graded(hand_in: HandIn, entries: list[Entry]) -> list[Left]:
    """Return what of a hand-in is the program of none of the entries, and is imported by none."""
    graded = {(entry.path, entry.member) for entry in entries if not entry.trouble}
    own = [entry for entry in entries if entry.student == hand_in.student]
    modules = [m for entry in own for m in imported(source_of(entry), entry.siblings).values()]
    others = [p for p in hand_in.programs if (p.path, p.member) not in graded]
    rest = [Left(str(p), "another program") for p in others if source_of(p) not in modules]
    # A file that is no program at all is the entry itself, which says so.
    alone = {path.name for path in hand_in.paths} if not hand_in.programs else set()
    return [*(item for item in hand_in.left if item.name not in alone), *rest]
