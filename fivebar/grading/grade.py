"""Grades one submission: the lab's checks run by pytest in this process, the student's program in
another.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import time
from collections.abc import Callable
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from ..base.progress import progress
from .intake.program import Job, NoProgram, Program, session
from .intake.students_robots import PUBLIC_SEED, robot_from
from .labs import Lab, find_lab
from .plugin import Checks
from .report.shown import ShownReport
from .robots import parameters_of
from .worker.sandbox import IsolationError, KilledError
from .worker.submission import MOST_ARCHIVE

# No file is written, no one else's options, conftest.py or plugins are read, nothing is printed.
_OPTIONS = (
    f"-c {os.devnull} --noconftest --import-mode=importlib --assert=plain --capture=sys"
    " -pno:terminal -pno:cacheprovider -pno:faulthandler -pno:warnings -pno:unraisableexception"
).split()
OTHER_ROBOT = "The constants of your file are another robot's"
OTHER_LAB = "This is the file of"
OF_ANOTHER = OTHER_ROBOT, OTHER_LAB
_FOREIGN = ("PYTEST_ADDOPTS", "PYTEST_PLUGINS", "PYTEST_CURRENT_TEST")


def run_checks(lab: Lab, program: Program, seed: str, watched: bool = False) -> Checks:
    """Return the lab's checks on a Program; `found` has a Check per test. watched: by somebody, who
    is shown a bar.
    """
    checks = Checks(program, seed)
    # With another robot's numbers all is wrong, and no search finds more than that.
    notes = () if lab.hides_robot else _notes(lab, program.robot_in(lab), program)
    checks.explains = not any(note.startswith(OF_ANOTHER) for note in notes)
    with (
        _alone(lab),
        progress(unit=" checks", leave=False) if watched else nullcontext() as checks.bar,
    ):
        # Without a --confcutdir pytest would look through every folder above the lab.
        where = ("--rootdir", lab.folder.parent, "--confcutdir", lab.folder.parent, lab.tests)
        code = pytest.main([*_OPTIONS, *map(str, where)], plugins=[checks])
    if checks.interrupted:
        raise KeyboardInterrupt
    if checks.killed:
        raise checks.killed
    try:
        checks.tell_advice(lab)
    except (IsolationError, KilledError):
        raise
    except ZeroDivisionError as error:  # no fault of the lab, and the points are known
        checks.notes.append(
            f"The search for what is wrong failed ({type(error).__name__}: {error}). The points"
            " stand, but a mistake that several functions share may cost more than once."
        )
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED) and not checks.trouble:
        checks.trouble.append(f"pytest ended with {code!r}: are there tests in {lab.tests.name}?")
    return checks


@contextmanager
def _alone(lab):
    """Run this process without pytest's outside settings and without an older copy of the lab."""
    _forget(lab)
    with (
        patch.dict(os.environ, PYTEST_DISABLE_PLUGIN_AUTOLOAD="1"),
        patch.object(sys, "dont_write_bytecode", True),
    ):
        for name in _FOREIGN:
            os.environ.pop(name, None)
        try:
            yield
        finally:
            _forget(lab)


def _forget(lab):
    for name, module in list(sys.modules.items()):
        if getattr(module, "__file__", None) == str(lab.tests):
            del sys.modules[name]


def grade(lab: Lab, job: Job, home: bool = False, watched: bool = False) -> ShownReport:
    """Return report on one file; home: the inputs are public and the report says that others exist;
    watched: `run_checks`.

    """
    before = time.perf_counter()
    digest = job_hash(job)  # a file replaced from now on is graded again
    program = job.open()
    try:
        checks = run_checks(lab, program, job.seed, watched)
    finally:
        program.student.close()
    return _report(
        lab,
        checks,
        before,
        home,
        submission=job.name,
        student=job.student,
        isolate=job.isolate,
        submission_hash=digest,
        hints_from=job.hints_from,
        packages=job.packages,
    )


def check(
    lab: str,
    submission: str | Path | None = None,
    *,
    seed: str = PUBLIC_SEED,
    labs: str | Path | None = None,
    **functions: Callable,
) -> ShownReport:
    """Return report on functions of a notebook's session, `check("lab1", dgm=dgm)`, or on a file,
    `check("lab1", "my.py")`.

    lab: a lab's name, in full or short; labs: the folder of labs of one's own. The functions run in
    this process, so that this is for oneself; a file runs in its own.
    """
    lab = find_lab(lab, labs)
    if (submission is None) == (not functions):
        raise TypeError(
            'check a file, check("lab1", "my.py"), or functions, check("lab1", dgm=dgm)'
        )
    if submission is not None:
        return grade(lab, Job(Path(submission), seed=seed), home=True, watched=True)
    before = time.perf_counter()
    checks = run_checks(lab, session(functions), seed)
    return _report(lab, checks, before, True, submission="this session")


def _report(lab, checks, before, home, **rest):
    program, robot = checks.program, checks.program.robot_in(lab)
    student, where, trouble = program.student, program.where, program.student.trouble
    if isinstance(student, NoProgram):
        trouble = f"Nothing can be graded: {trouble.text}."
    elif trouble is not None:
        place = f"{where(trouble.line)}, `{trouble.source.strip()}`: " if trouble.line else ""
        absent = "is not available here" in trouble.text  # though it may be at home
        words = "A line is passed over" if absent else "The file has a line that fails"
        trouble = f"{words}: {place}{trouble.text}. What works without that line is graded."
    none_right = not any(check.points for check in checks.found)
    return ShownReport(
        lab.name,
        checks=tuple(replace(c, place=where(c.line)) if c.line else c for c in checks.found),
        seed=checks.seed,
        robot=parameters_of(program.robot or robot),
        lab_hash=lab.hash(),
        trouble=trouble or "",
        notes=(
            *filter(None, [program.remark]),
            *_about_robot(lab, robot, checks),
            *_old_numpy(program),
            *checks.notes,
        ),
        faults=tuple(checks.trouble),
        output=student.output,
        seconds=round(time.perf_counter() - before, 3),
        home=home,
        no_program=isinstance(student, NoProgram) or bool(_other_lab(lab, program) and none_right),
        warnings=tuple(student.notes),
        **rest,
    )


def _old_numpy(program):
    """Yield what a file does that only the NumPy of its year did: it is graded as it ran then."""
    for reply in getattr(program.student, "mended", ()):
        place = f"{program.where(reply.line)}, `{reply.source.strip()}`: " if reply.line else ""
        yield (
            f"{place}{reply.text} The file is graded as it ran before; the same may stand in other"
            " lines."
        )


def _about_robot(lab, robot, checks):
    if lab.hides_robot:
        return ()
    return _notes(lab, robot, checks.program) or _absent(lab, robot, checks)


def _notes(lab, robot, program):
    """Return a file that holds another robot than the one it is graded for explains wrong answers
    everywhere.
    """
    if words := _other_lab(lab, program):
        return (words,)
    if lab.constants():
        return program.robot_of_file(lab)[1]
    numbers, constants = parameters_of(robot).items(), program.student.constants
    other = []
    for name, right in numbers:
        own = constants.get(name, right)
        if own != right:
            other.append(f"{name} = {own:g} (graded for {right:g})")
    if other:
        return (f"{OTHER_ROBOT}: {', '.join(other)}.",)
    standard = parameters_of(lab.robot())
    own = [f"{name} = {value:g}" for name, value in numbers if value != standard[name]]
    return (f"Graded for the robot of this file: {', '.join(own)}.",) if own else ()


def _other_lab(lab, program):
    """Return a sentence where a file has the names of another lab's numbers and none of this one's
    own, else "".
    """
    here, given = set(lab.constants()), program.student.constants.keys()
    for other in lab.family() if here else ():
        there = set(other.constants())
        if there - here and there - here <= given and not (here - there) & given:
            names = " and ".join(sorted(there - here))
            return (
                f"{OTHER_LAB} {other.name}, not of {lab.name}: it gives numbers to {names}."
                f" Hand in your own file for {lab.name}."
            )
    return ""


def _absent(lab, robot, checks):
    """Yield the numbers that a file does not give, and on which right answers depend where points
    were lost.
    """
    given = checks.program.student.constants
    if lab.constants() or not given:
        return
    wrong = {check.function for check in checks.found if check.reason == "value"}
    asked = [rows for ask in checks.asks for rows in ask.rows_asked if rows.exercise.name in wrong]
    absent = []
    for name, value in parameters_of(robot).items():
        changed = {name: 1.01 * value}
        if name not in given and any(_depends(rows, changed) for rows in asked):
            absent.append(name)
    if absent:
        yield (
            f"Your program gives no number to {', '.join(absent)}: it is judged as if it had the"
            " robot's."
        )


def _depends(rows, numbers):
    """Return whether right answers are other ones for a robot with these numbers."""
    other = replace(rows, robot=robot_from(rows.robot, numbers))
    return not (rows.constants or np.array_equal(rows.expected, other.expected, equal_nan=True))


def job_hash(job: Job) -> str:
    """Return the SHA-256 of a job's file and those beside it that it may import, "" where the file
    itself is none.
    """
    digest = file_hash(job.path)
    if not digest or not (job.member or job.siblings):
        return digest
    siblings = [(file.member, file_hash(file.path)) for file in job.siblings]
    content = repr((digest, job.member, siblings))
    return hashlib.sha256(content.encode("utf-8", "surrogatepass")).hexdigest()


def file_hash(path: str | Path) -> str:
    """Return the SHA-256 of a plain file's bytes, "" for anything else: a pipe, a link, what is too
    large to be read.
    """
    try:
        status = os.lstat(path)
        if not stat.S_ISREG(status.st_mode) or status.st_size > MOST_ARCHIVE:
            return ""
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
