"""`fivebar check` at home, `fivebar grade` for one submission or a folder of them."""

import datetime
import os
import sys
from functools import partial
from pathlib import Path

from ..base.checks import number, optional
from ..base.errors import UsageError
from .grade_folder import grade_folders, hand_out, isolation
from .options import add_command, print_message, usage_errors

SECRET = "FIVEBAR_SECRET"
LAB = "lab1 (or 1), or its full name"
CHECK = {
    "[LAB]": LAB,
    "[SUBMISSION]": (
        "your .py file or notebook, or a folder or zip with it; without it you get the template"
    ),
}
COMMON = {
    "--file NAME": "which of several files is meant (a pattern)",
    "--labs DIR": "a folder with labs of your own",
    "--hints-from DATE": "until this day reports show points and no explanations",
    "--time-limit S": "of one call (default: 2)",
    "--html PAGE.html": "write the report as a page, with figures",
    "--json": "the result as JSON on stdout",
}
GRADE = {
    "LAB": LAB,
    "[SUBMISSION ...]": (
        "a .py file, notebook or zip; a folder of them, or a folder for each attempt"
    ),
    "--seed SEED": "of the hidden inputs (default: from the secret, else random; in the result)",
    "--secret-file FILE": f"the course's secret (or in ${SECRET})",
    "--student ID": "whose robot it is (default: by the file's name)",
    "--isolate process|bwrap": "(default: a folder bwrap, if it works here)",
    "--fail-under PERCENT": "exit 1 if a score is below",
    "--gradescope OUT.json": "write Gradescope's results.json",
    "--csv OUT.csv": "write a row per check",
}
FOLDER = {
    "--gradebook FILE": "Moodle's or Canvas' sheet, to be filled",
    "--column TITLE": "of the marks in that sheet (default: the one that fits)",
    "--jobs N": (1, "graded at a time"),
    "--out DIR": "results, and marks.csv and course.toml to edit; a second run goes on there",
    "--hand-out IDS.txt": "write each student's own student.py to --out",
}


def add_parsers(commands):
    """Add `check` and `grade` to the program's commands."""
    add_command(commands, "check", _check, (CHECK | COMMON,))
    groups = (GRADE | COMMON,), (FOLDER, "a folder of submissions")
    add_command(commands, "grade", _grade, *groups)


def _check(arguments):
    from ..grading.judging.results import withheld
    from ..grading.labs import find_lab, known_labs

    if arguments.lab is None:
        names = ", ".join(lab.name for lab in known_labs(arguments.labs))
        raise UsageError(f"which lab, and which file of yours? The known ones are: {names}")
    lab = find_lab(arguments.lab, arguments.labs)
    if arguments.submission is None:
        return _hand_out_template(lab)
    how = {"limit": _limit(arguments), "hints_from": hints_from(arguments, lab)}
    _show(arguments, withheld(_graded(arguments, lab, lambda lab: how, home=True)))


def _hand_out_template(lab):
    """Put the lab's file to fill in into this folder."""
    from ..grading.report.outputs import write_whole

    template, path = lab.template(), Path(lab.file() or "student.py")
    command = f"fivebar check {lab.name} {path}"
    if not template:
        raise UsageError(f"which file is yours? {lab.name} has none to fill in: {command}")
    if path.exists():
        raise UsageError(f"which file is yours? {path} is here already: {command}")
    write_whole(path, template)
    print(
        f"{path} is written: fill in its functions as {lab.folder}/README.md asks, then {command}"
    )


def _grade(arguments):
    from ..grading.intake.students_robots import hidden_seed, robot_for
    from ..grading.labs import find_lab

    lab = find_lab(arguments.lab, arguments.labs)
    secret = _secret(arguments.secret_file)
    limit = _limit(arguments)
    if arguments.hand_out:
        return hand_out(arguments, lab, secret)
    if not arguments.submission:
        raise UsageError("what is to be graded? Name a file or a folder")
    for path in arguments.submission:
        if not path.exists():
            raise UsageError(f"no file or folder {str(path)!r}")
    seed = arguments.seed or (hidden_seed(secret, lab.name) if secret else None)
    if _holds_hand_ins(arguments, lab):
        reports = grade_folders(arguments, lab, secret, seed, limit, hints_from(arguments, lab))
        return _must_reach(arguments, reports)
    if len(arguments.submission) > 1:
        raise UsageError("several submissions are graded in folders, a folder for each attempt")
    (arguments.submission,) = arguments.submission
    if arguments.out:
        raise UsageError(
            "--out is for a folder of submissions; for one there are --html, --csv, --json,"
            " --gradescope"
        )
    isolate = arguments.isolate or "process"
    seed = seed or os.urandom(8).hex()

    def how(lab):
        student = arguments.student or arguments.submission.resolve().stem
        robot = robot_for(student, secret, lab.robot())
        return {
            "student": student,
            "seed": seed,
            "robot": robot,
            "isolate": isolate,
            "limit": limit,
            "hints_from": hints_from(arguments, lab),
        }

    report = _graded(arguments, lab, how)
    for line in (isolation(isolate), *report.warnings):
        print_message(line)
    # A lab with a fault ends here, before files of points are written.
    _show(arguments, report)
    if arguments.gradescope:
        from ..grading.report.outputs import gradescope_text

        _write(arguments.gradescope, gradescope_text(report))
    if arguments.csv:
        from ..grading.report.outputs import CHECK_COLUMNS, check_rows, csv_text

        _write(arguments.csv, csv_text(CHECK_COLUMNS, check_rows(report)))
    _must_reach(arguments, [report])


def _holds_hand_ins(arguments, lab):
    """Return whether a folder is named that is not one student's: for Gradescope it always is."""
    from ..grading.intake.cohort_folder import entries_of, find_hand_ins, is_one_hand_in

    folder, *more = arguments.submission
    if not folder.is_dir() or arguments.gradescope:
        return False
    if arguments.out or more or not lab.file():
        return True
    if is_one_hand_in(folder, lab.with_others()):
        return False
    return len(entries_of(find_hand_ins(folder)[0], lab, named=True)) != 1


def _graded(arguments, lab, how, home=False):
    """Return the report on one hand-in, for all labs of which it holds the file.

    how: what gives, for a lab, the rest of a Job.
    """
    from ..grading.grade import grade
    from ..grading.intake.hand_in import ProgramFile, beside, choose, listed, look_into, named_for
    from ..grading.intake.program import Job
    from ..grading.judging.results import joined
    from ..grading.report.tries import with_try_counted
    from ..grading.worker.submission import SubmissionError

    path = arguments.submission
    if not path.exists():
        raise UsageError(f"no file {str(path)!r}; to fill in: fivebar check {lab.name}")
    programs, left = look_into(path)
    labs = [lab]
    if [program.path for program in programs] != [path]:
        labs += [other for other in lab.with_others()[1:] if named_for(other, programs)]
    versions, troubles = {}, {}
    for each in labs:
        try:
            versions[each] = choose(each, programs, arguments.file)
        except SubmissionError as error:
            if len(labs) > 1:  # the others have theirs
                print_message(f"{each.name}: {error}")
                troubles[each] = str(error)
                continue
            there = "" if programs else listed(left)
            raise UsageError(f"{path}: {error}{there}") from None
    graded = [program for chosen in versions.values() for program in chosen]
    for program in graded:
        if program.path != path:
            print_message(f"graded: {program}")
    ignored = [f"{item.name}: {item.word}" for item in left if item.word != "hidden"]
    ignored += [str(other) for other in programs if other not in graded]
    for words in ignored:
        print_message(f"not graded: {words}")
    if home and path in [program.path for program in programs if not program.member]:
        programs = [ProgramFile(p, "", p.name) for p in sorted(path.parent.glob("*.py"))]
    best = []
    for each, chosen in versions.items():
        jobs = [
            Job(p.path, member=p.member, siblings=beside(p, programs), **how(each)) for p in chosen
        ]
        reports = [grade(each, job, home=home, watched=True) for job in jobs]
        best.append(max(reports, key=lambda report: report.points))
        if home:
            best[-1] = with_try_counted(best[-1], each, path)
    if not home:
        best += [grade(each, Job(path, trouble=t, **how(each))) for each, t in troubles.items()]
    return joined(best)


def _show(arguments, report):
    from ..grading.report.outputs import json_text
    from ..grading.report.text import report_text

    if arguments.html:
        from ..grading.judging.results import withheld
        from ..grading.report.page import report_page

        _write(arguments.html, report_page(withheld(report)))
    if arguments.json:
        print(json_text(report), end="")
    else:
        print(report_text(report, colour=sys.stdout.isatty() and "NO_COLOR" not in os.environ))
    if report.faults:
        raise RuntimeError(
            f"the lab itself has a fault, so this result does not count: {'; '.join(report.faults)}"
        )


def _secret(path):
    """Return the course's secret as bytes, None where there is none."""
    given = os.environ.pop(SECRET, "")  # no process that this one starts shall see it
    try:
        secret = path.read_bytes().strip() if path else given.encode()
    except OSError as error:
        raise UsageError(f"--secret-file: {error}") from None
    if (path or given) and len(secret) < 8:
        source = f"--secret-file: {path}" if path else SECRET
        raise UsageError(f"{source} holds fewer than 8 bytes: too easy to guess")
    return secret or None


def hints_from(arguments, lab):
    """Return the day of the hints where it is to come, else ""; by the option, else by the lab."""
    given = arguments.hints_from or lab.hints_from()
    try:
        day = datetime.date.fromisoformat(given) if given else None
    except ValueError:
        raise UsageError(f"--hints-from: {given!r} is no day; write it as 2027-01-31") from None
    return given if day and datetime.date.today() < day else ""


def _limit(arguments):
    limit = partial(number, low=0.0, high=3600.0, above=True)
    return optional(limit)(arguments.time_limit, "time_limit")


def _write(path, text):
    from ..grading.report.outputs import write_whole

    with usage_errors(OSError):
        write_whole(path, text)


def _must_reach(arguments, reports):
    least = arguments.fail_under or 0.0
    low = [report for report in reports if report.percent < least]
    if low:
        names = ", ".join(report.student or report.submission for report in low[:5])
        raise RuntimeError(f"{len(low)} of {len(reports)} below {least:g} %: {names}")
