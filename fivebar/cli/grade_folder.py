"""`fivebar grade` for a folder of submissions, and what is handed out before."""

import codecs
import json
import sys

from ..base.errors import UsageError


def isolation(isolate):
    """Return how students' programs are confined, and why not better, in a line."""
    from ..grading.worker.places import bwrap_trouble

    if isolate == "bwrap":
        return "isolation: bwrap (a disk, processes and network of its own)"
    trouble = " ".join(bwrap_trouble().split())[:200]
    if trouble:
        return f"isolation: process (bubblewrap does not work here: {trouble})"
    return "isolation: process (bubblewrap works here and hides more: --isolate)"


def grade_folder(arguments, lab, secret, seed, limit, hints_from):
    """Grade a folder of submissions into --out; the Reports of all that could be graded."""
    from ..base.folders import locked_folder
    from ..grading.course.cohort import begin, run_cohort
    from ..grading.course.cohort_page import write_summary
    from ..grading.course.gradebook import fill_gradebook
    from ..grading.course.items import summary_text
    from ..grading.intake.cohort_folder import find_submissions
    from ..grading.worker.places import bwrap_trouble

    folder, out = arguments.file, arguments.out
    if out is None:
        raise UsageError("a folder of submissions needs --out DIR for the results")
    if arguments.student or arguments.html or arguments.csv:
        raise UsageError(
            "--student, --html and --csv are for one submission; a folder's files go to --out"
        )
    if arguments.jobs < 1:
        raise UsageError(f"--jobs must be at least 1, not {arguments.jobs}")
    if folder.resolve() in (out.resolve(), *out.resolve().parents):
        raise UsageError(
            f"--out {out} lies within the submissions, where the results would be taken for a"
            f" student's: give a folder beside {folder}"
        )
    if arguments.gradebook:
        # What is wrong with it is better known now.
        fill_gradebook(arguments.gradebook, lab, [], [], arguments.column)
    entries, left = find_submissions(folder, lab, arguments.program, secret is not None)
    _print_ignored(entries, left)
    if not entries:
        raise UsageError(
            f"{folder} holds no submissions: a .py file, notebook or zip, or a folder, per student"
        )
    isolate = arguments.isolate or ("process" if bwrap_trouble() else "bwrap")
    print(isolation(isolate), file=sys.stderr)
    with locked_folder(out, "grading", ("students",)):
        cohort = begin(lab, out, seed, secret, isolate, limit, hints_from)
        reports = run_cohort(cohort, entries, arguments.jobs)
        write_summary(out, lab.name, entries, reports, left)
        if arguments.gradebook:
            _fill(arguments, lab, entries, reports)
    graded = [report for report in reports if not report.ungraded]
    if arguments.json:
        print(json.dumps([report.as_json() for report in reports], indent=1))
    else:
        print(summary_text(lab.name, graded))
        print(out / "summary.html")
    faults = dict.fromkeys(fault for report in reports for fault in report.faults)
    if faults:
        raise RuntimeError(
            f"the lab itself has a fault, so the results do not count: {'; '.join(faults)}"
        )
    if lost := [report.student for report in reports if report.ungraded]:
        raise RuntimeError(
            f"{len(lost)} of {len(reports)} not graded: {', '.join(lost[:5])}; run it again"
        )
    return graded


def _fill(arguments, lab, entries, reports):
    from ..base.representation import printable
    from ..grading.course.gradebook import fill_gradebook
    from ..grading.report.outputs import write_whole

    filled = fill_gradebook(arguments.gradebook, lab, entries, reports, arguments.column)
    write_whole(arguments.out / "gradebook.csv", filled.text)
    print(
        f"gradebook.csv: {filled.count} marks; {filled.no_hand_in} rows without a hand-in",
        file=sys.stderr,
    )
    if filled.no_row:
        names = printable(", ".join(filled.no_row))
        print(f"gradebook.csv: no row, or several, for {names}", file=sys.stderr)
    if filled.no_program:
        names = printable(", ".join(filled.no_program))
        print(f"gradebook.csv: no program that could be graded for {names}", file=sys.stderr)


def _print_ignored(entries, left):
    from ..base.representation import printable

    for item in left:
        print(f"not graded: {printable(item.name)}: {printable(item.word)}", file=sys.stderr)
    for entry in entries:
        if entry.left:
            files = printable(", ".join(f"{item.name} ({item.word})" for item in entry.left[:6]))
            student = printable(entry.student)
            print(f"{student}: also there, not graded: {files}", file=sys.stderr)


def hand_out(arguments, lab, secret):
    """Write each student's own student.py, or the lab's own and the files that tell of his
    robot.
    """
    from ..grading.report.outputs import file_name, write_whole
    from ..grading.variants import draw_for, id_key, robot_for, with_constants

    if arguments.out is None or secret is None:
        raise UsageError("--hand-out needs --out DIR and the course's secret")
    try:
        lines = _ids(arguments.hand_out.read_bytes())
        source = (lab.folder / "student.py").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"--hand-out: {error}") from None
    students = {}
    for line in filter(None, map(str.strip, lines)):
        students.setdefault(id_key(line), line)
    for student in students.values():
        robot = robot_for(student, secret, lab.robot())
        files = lab.files_for(robot, draw_for(secret, student, lab.name))
        folder = arguments.out / file_name(student)
        folder.mkdir(parents=True, exist_ok=True)
        if files is None:
            files = {"student.py": with_constants(source, robot)}
        else:
            files = {"student.py": source, **files}
        for name, text in files.items():
            write_whole(folder / name, text)
            print(folder / name)


def _ids(data):
    """Return the lines of a list of ids, also as Windows' editors save it, with a mark at its
    start.
    """
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if wide else "utf-8-sig").splitlines()
