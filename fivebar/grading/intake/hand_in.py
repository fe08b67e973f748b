"""Looks into a hand-in, a file, a folder or a zip, without following or unpacking anything, and
finds its program.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from ..labs import Lab
from ..worker.submission import (
    ARCHIVE,
    PROGRAMS,
    UNREADABLE,
    SubmissionError,
    files_of,
    inner_archive,
    opened_archive,
    read_submission,
    with_slashes,
)

if TYPE_CHECKING:
    from .cohort_folder import Entry

MOST_FILES, DEEPEST = 2000, 12  # of one hand-in
NO_FILE = LINK, SPECIAL = "a symbolic link", "no regular file"
MOST_ZIPS = 20  # in a zip that are looked into
MOST_READ = 100  # programs that are read to find the one to grade
# "Ada Lovelace_4711_assignsubmission_file_" and "lovelaceada_LATE_123_45678_lab1.py": the name is
# what comes first, and the number after it is the person's, the same in all that one has handed in.
MOODLE = re.compile(
    r"(?P<name>.+?)_(?P<number>\d+)_assignsubmission_[^_]*_?(?P<file>.*)", re.DOTALL
)
CANVAS = re.compile(r"(?P<name>.+?)_(?:LATE_)?(?P<number>\d+)_\d+_(?P<file>.*)", re.DOTALL)
LEAVE_ONE = "leave one; --file NAME means the one of that name in each hand-in"
MOST_VERSIONS = 3  # of one file in a hand-in that are all graded
# What systems add to a name that is there already: "x (1)", "x - Copie", and Canvas' "x-1".
_COPY = re.compile(r"([ _-]*(\(\d+\)|copy|copie|kopie)|-\d+)$")
_DEFINED = re.compile(r"^[ \t]*def\s+(\w+)\s*\(", re.MULTILINE)
_IMPORT = re.compile(r"^[ \t]*(?:from|import)[ \t]+(.*)", re.MULTILINE)


@dataclass(frozen=True)
class ProgramFile:
    """A program's place: a file, or a member of a zip; `name`: its path within the hand-in."""

    path: Path
    member: str = ""
    name: str = ""

    def __str__(self) -> str:
        return self.name or self.path.name


@dataclass(frozen=True)
class Left:
    """Something found and not graded, and why in a few words."""

    name: str
    word: str


def is_hidden(name: str) -> bool:
    return name.startswith((".", "__"))


def look_into(path: Path) -> tuple[list[ProgramFile], list[Left]]:
    """Return the programs in a file, folder or zip, and all that is none. Never raises for what it
    finds.
    """
    programs: list = []
    left: list = []
    _look(path, path.name or path.resolve().name, 0, programs, left)
    return programs, left


def _look(path, name, depth, programs, left):
    if len(programs) + len(left) >= MOST_FILES:
        if left[-1:] != [rest := Left("more", f"only {MOST_FILES} files are looked at")]:
            left.append(rest)
        return
    try:
        mode = os.lstat(path).st_mode
        if stat.S_ISLNK(mode):
            left.append(Left(name, LINK))
        elif stat.S_ISDIR(mode) and depth < DEEPEST:
            for inner in sorted(os.listdir(path)):
                if is_hidden(inner):
                    left.append(Left(f"{name}/{inner}", "hidden"))
                else:
                    _look(path / inner, f"{name}/{inner}", depth + 1, programs, left)
        elif stat.S_ISDIR(mode):
            left.append(Left(name, "too deep"))
        elif not stat.S_ISREG(mode):
            left.append(Left(name, SPECIAL))
        elif path.suffix.lower() in PROGRAMS:
            programs.append(ProgramFile(path, "", name))
        elif path.suffix.lower() == ARCHIVE:
            _look_into_zip(path, name, programs, left)
        else:
            left.append(Left(name, "no program"))
    except OSError as error:
        left.append(Left(name, f"cannot be opened: {error.strerror}"))


def _look_into_zip(path, name, programs, left):
    members: dict = {}
    opened = 0
    try:
        with opened_archive(path) as archive:
            for info in files_of(archive):
                members[info.filename] = info
                if info.filename.lower().endswith(ARCHIVE) and opened < MOST_ZIPS:
                    opened += 1
                    members |= _in_zip(archive, info.filename)
    except SubmissionError as error:
        left.append(Left(name, str(error)))
        return
    for member, info in list(members.items())[:MOST_FILES]:
        place = PurePosixPath(with_slashes(member))
        inner, suffix = f"{name}/{place}", place.suffix.lower()
        if any(is_hidden(part) for part in place.parts):
            left.append(Left(inner, "hidden"))
        elif suffix == ARCHIVE:
            if not any(other.startswith(f"{member}/") for other in members):
                left.append(Left(inner, "a zip in a zip that cannot be read"))
        elif suffix not in PROGRAMS:
            left.append(Left(inner, "no program"))
        elif info.flag_bits & 1:
            left.append(Left(inner, "locked by a password"))
        else:
            programs.append(ProgramFile(path, member, inner))
    if len(members) > MOST_FILES:
        left.append(Left(name, f"only {MOST_FILES} files are looked at"))


def _in_zip(archive, member):
    """Return the files in a zip in a zip by their member's name there, none where it cannot be
    read.
    """
    try:
        with inner_archive(archive, member) as inner:
            return {f"{member}/{info.filename}": info for info in files_of(inner)}
    except UNREADABLE:
        return {}


def functions_of(lab: Lab) -> frozenset[str]:
    """Return the functions that a lab asks for: those of its student.py, else of its exercises."""
    if template := lab.template():
        return frozenset(_DEFINED.findall(template))
    return frozenset(lab.exercises())


def choose(
    lab: Lab, programs: list[ProgramFile], wanted: str | None = None
) -> tuple[ProgramFile, ...]:
    """Return the program to grade, or where the lab's own file is there in several versions, those.

    wanted: a file's name or the end of its path, also as a pattern (`*_models.py`). Without it a
    file is meant that has the lab's own name for it, else the one that defines most of what the
    lab asks. Copies of one file count as one, and an untouched student.py not beside a filled one.
    Raises SubmissionError where none can be meant, or several.
    """
    if not programs:
        raise SubmissionError("there is no .py, .ipynb or .zip with one")
    if len({found["number"] for found in map(_person, programs) if found}) > 1:
        raise SubmissionError(
            "it holds the hand-ins of several people, as Moodle or Canvas packs them: unpack it,"
            " and grade that folder"
        )
    if wanted is not None:
        named = [program for program in programs if _is_called(program, wanted)]
        if not named:
            raise SubmissionError(
                f"none of the programs there ({_listed(programs)}) is called {wanted}"
            )
        programs = named
    elif named := named_for(lab, programs):
        return _versions(lab, named)
    else:
        programs = _not_of_others(lab, programs)
    if len(programs) == 1:
        return (programs[0],)
    asked = functions_of(lab)
    defined = {
        program: len(asked & set(_DEFINED.findall(source_of(program))))
        for program in programs[:MOST_READ]
    }
    most = max(defined.values())
    if most == 0:
        raise SubmissionError(
            f"none of {len(programs)} programs ({_listed(programs)}) defines a function of this"
            f" lab: {LEAVE_ONE}"
        )
    best = _different(lab, [program for program in defined if defined[program] == most])
    if len(best) > 1:
        raise _several(best)
    return best


def named_for(lab: Lab, programs: Iterable[ProgramFile]) -> list[ProgramFile]:
    """Return the programs that have the lab's own name; else copies of it, as "x (1).py"; else
    those whose name holds it, as "x_final.py". None where the lab gives no name.
    """
    if not lab.file():
        return []
    name = PurePosixPath(lab.file()).stem.casefold()
    stems = {program: _stem(program).casefold() for program in programs}
    exact = [program for program, stem in stems.items() if stem == name]
    copies = [program for program, stem in stems.items() if _plain(stem) == name]
    alike = [program for program, stem in stems.items() if name in _plain(stem)]
    return exact or copies or alike


def _stem(program):
    """Return a file's name without its ending, and without what Moodle or Canvas puts before it."""
    name = PurePosixPath(str(program)).name
    found = MOODLE.fullmatch(name) or CANVAS.fullmatch(name)
    return PurePosixPath(found["file"] if found else name).stem


def _plain(stem):
    return re.sub("[ -]+", "_", _COPY.sub("", stem))


def _versions(lab, named):
    """Return the different ones of a lab's own file: scripts where there are some, not notebooks
    beside them.
    """
    scripts = [program for program in named if program.name.lower().endswith(".py")]
    found = _different(lab, scripts or named)
    if len(found) > MOST_VERSIONS:
        raise _several(found)
    return found


def _not_of_others(lab, programs):
    """Return the programs that have no other lab's name. Raises SubmissionError where none is
    left.
    """
    others = {
        program: other.name
        for other in lab.family()
        if other != lab
        for program in named_for(other, programs)
    }
    left = [program for program in programs if program not in others]
    if not left:
        name = next(iter(others.values()))
        raise SubmissionError(
            f"there is no {lab.file()}: {_listed(list(others))} is the file of the lab {name}"
        )
    return left


def _different(lab, programs):
    """Return one program of each content, the first of its copies; no untouched one, of this lab
    or another, beside others.
    """
    found = {source_of(program): program for program in reversed(programs)}
    folders = [path.parent for path in lab.folder.parent.glob("*/student.py")]
    for folder in sorted(folders, key=lambda folder: folder == lab.folder):
        if len(found) > 1:
            found.pop(Lab(folder).template(), None)
    return tuple(sorted(found.values(), key=str))


def _several(programs):
    return SubmissionError(
        f"{len(programs)} programs could be meant ({_listed(programs)}): {LEAVE_ONE}"
    )


def _person(program):
    """Return whose it is by the learning platform's name for it, where a zip holds those of a
    course; or None.
    """
    own = str(program).partition("/")[2].partition("/")[0]
    return MOODLE.fullmatch(own) or CANVAS.fullmatch(own)


def beside(program: ProgramFile, programs: Iterable[ProgramFile]) -> tuple[ProgramFile, ...]:
    """Return the other .py files in the program's own folder, which it may import."""
    folder = PurePosixPath(program.name).parent
    return tuple(
        other
        for other in programs
        if other != program
        and PurePosixPath(other.name).parent == folder
        and other.name.lower().endswith(".py")
    )


def imported(source: str, siblings: Iterable[ProgramFile]) -> dict[str, str]:
    """Return module's name -> source of those of the program's siblings that it imports, or one of
    those does.
    """
    found: dict = {}
    waiting = [source]
    known = {}
    for file in siblings:
        stem = _stem(file)
        known[stem if stem.isidentifier() else _COPY.sub("", stem)] = file
    while waiting and len(found) < MOST_READ:
        words = set(re.findall(r"\w+", " ".join(_IMPORT.findall(waiting.pop()))))
        for name in sorted((words & set(known)) - set(found) - sys.stdlib_module_names):
            found[name] = source_of(known[name])
            waiting.append(found[name])
    return found


def _is_called(program, wanted):
    parts = str(program).casefold().split("/")
    wanted = wanted.replace("\\", "/").casefold().split("/")
    return len(wanted) <= len(parts) and all(map(fnmatchcase, parts[-len(wanted) :], wanted))


def source_of(program: ProgramFile | Entry) -> str:
    """Return a program's source, or a line that is no other's where it cannot be read."""
    try:
        return read_submission(program.path, program.member).source
    except SubmissionError:
        return f"# unreadable: {program}"


def listed(left: Iterable[Left]) -> str:
    """Return ", only ..." of what is there in place of a program, "" where nothing is."""
    names = []
    for item in left:
        if item.word != "hidden":
            why = "" if item.word == "no program" else f" ({item.word})"
            names.append(f"{item.name.rpartition('/')[2]}{why}")
    return f", only {', '.join(names[:5])}" if names else ""


def _listed(programs):
    names = [str(program).partition("/")[2] or str(program) for program in programs[:5]]
    return ", ".join(names)
