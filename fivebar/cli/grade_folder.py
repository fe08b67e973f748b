"""`fivebar grade` for folders of submissions, and what is handed out before."""

from ..base.checks import positive
from ..base.errors import UsageError
from ..base.tables import whole_text
from .options import print_json, print_message, usage_errors


def isolation(isolate):
    """Return how students' programs are confined, and why not better, in a line."""
    from ..grading.worker.places import bwrap_trouble

    if isolate == "bwrap":
        return "isolation: bwrap (a disk, processes and network of its own)"
    trouble = " ".join(bwrap_trouble().split())[:200]
    if trouble:
        return f"isolation: process (bubblewrap does not work here: {trouble})"
    return "isolation: process (bubblewrap works here and hides more: --isolate)"


def grade_folders(arguments, lab, secret, seed, limit, hints_from):
    """Grade folders of submissions into --out; the Reports of all that could be graded."""
    from ..base.folders import locked_folder
    from ..grading.course.course import Course
    from ..grading.course.gradebook import Gradebook
    from ..grading.course.settings import offer_settings, read_settings
    from ..grading.worker.places import bwrap_trouble

    out = arguments.out
    _check_folders(arguments)
    book = None
    if arguments.gradebook:  # what is wrong with it is better known now
        book = Gradebook(arguments.gradebook, lab, arguments.column)
    settings = read_settings(out)
    if settings.due and settings.late_percent and not book and (out / "gradebook.csv").exists():
        raise UsageError(
            f"{out / 'course.toml'} takes points off for late days, and when each was handed in is"
            " in the learning platform's sheet: give it again, --gradebook FILE"
        )
    course = Course(lab, out, settings, book)
    course.find(arguments.submission, arguments.file, secret is not None)
    _print_ignored(course.ignored)
    if not course.students:
        raise UsageError(
            f"{arguments.submission[0]} holds no submissions: a .py file, notebook or zip, or"
            " a folder, per student"
        )
    isolate = arguments.isolate or ("process" if bwrap_trouble() else "bwrap")
    print_message(isolation(isolate))
    with locked_folder(out, "grading", ("students",)):
        offer_settings(out, course.lab)
        how = seed, secret, isolate, limit, hints_from, settings.packages
        course.grade(how, arguments.jobs)
        filled = course.write()
    _print_course(course, filled)
    reports = course.reports()
    if arguments.json:
        print_json([report.as_json() for report in reports])
    else:
        print(course.words())
    faults = dict.fromkeys(fault for report in reports for fault in report.faults)
    if faults:
        raise RuntimeError(
            f"the lab itself has a fault, so the results do not count: {'; '.join(faults)}"
        )
    if lost := [report.student for report in reports if report.ungraded]:
        raise RuntimeError(
            f"{len(lost)} of {len(reports)} not graded: {', '.join(lost[:5])}; run it again"
        )
    return [report for report in reports if not report.no_program]


def _check_folders(arguments):
    out = arguments.out
    if out is None:
        raise UsageError("a folder of submissions needs --out DIR for the results")
    if arguments.student or arguments.html or arguments.csv:
        raise UsageError(
            "--student, --html and --csv are for one submission; a folder's files go to --out"
        )
    positive(arguments.jobs, "jobs")
    for folder in arguments.submission:
        if not folder.is_dir():
            raise UsageError(f"{folder} is no folder: several attempts are several folders")
        if folder.resolve() in (out.resolve(), *out.resolve().parents):
            raise UsageError(
                f"--out {out} lies within the submissions, where the results would be taken for a"
                f" student's: give a folder beside {folder}"
            )


def _print_course(course, filled):
    def tell(words, names):
        if names:
            print_message(f"{words} {', '.join(names)}")

    for graded in course.graded:
        for students, same in graded.equal:
            tell(f"{graded.name}: equal programs ({same}):", students)
    for state, names in course.without_mark().items():
        tell(f"marks.csv: no mark yet ({state}):", names)
    if filled:
        rest = f"rows without a hand-in: {filled.no_hand_in}"
        print_message(f"gradebook.csv: marks: {filled.count}; {rest}")
        tell("gradebook.csv: no row, or several, for", filled.no_row)


def _print_ignored(ignored):
    files = {}
    for student, item in ignored:
        if not student:
            print_message(f"not graded: {item.name}: {item.word}")
        elif item.word != "hidden":
            files.setdefault(student, []).append(f"{item.name} ({item.word})")
    for student, names in files.items():
        listed = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        print_message(f"{student}: also there, not graded: {listed}")


def hand_out(arguments, lab, secret):
    """Write each student's own student.py, or the lab's own and the files that tell of his
    robot.
    """
    from ..grading.intake.students_robots import draw_for, id_key, robot_for
    from ..grading.report.outputs import file_name, write_whole
    from ..grading.robots import has_models

    if arguments.out is None or secret is None:
        raise UsageError("--hand-out needs --out DIR and the course's secret")
    with usage_errors():
        text, _ = whole_text(arguments.hand_out, "a list of ids")
    if not lab.template():
        raise UsageError(f"--hand-out: {lab.name} has no student.py to hand out")
    if not lab.hides_robot and not has_models(lab.robot()):
        raise UsageError(
            f"--hand-out: robots for each student are five-bars and biglides; for its own kind,"
            f" {lab.name} needs HAND_OUT in its exercises.py"
        )
    students = {}
    for line in filter(None, map(str.strip, text.splitlines())):
        students.setdefault(id_key(line), line)
    for student in students.values():
        robot = robot_for(student, secret, lab.robot())
        files = lab.files_for(robot, draw_for(secret, student, lab.name))
        folder = arguments.out / file_name(student)
        folder.mkdir(parents=True, exist_ok=True)
        files = {"student.py": lab.template(robot if files is None else None), **(files or {})}
        for name, text in files.items():
            write_whole(folder / name, text)
            print(folder / name)
