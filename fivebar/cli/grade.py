"""`fivebar check` at home, `fivebar grade` for one submission or a folder of them."""

import datetime
import os
import sys
from pathlib import Path

from ..base.errors import UsageError
from .grade_folder import grade_folder, hand_out, isolation

SECRET = "FIVEBAR_SECRET"


def add_parsers(commands):
    """Add `check` and `grade` to the program's commands."""
    check = commands.add_parser("check")
    _common(check, "?")
    what = (
        "your .py file or notebook, or a folder or zip with it; without it you are told which one"
        " to fill in"
    )
    check.add_argument("file", type=Path, nargs="?", metavar="FILE", help=what)
    check.set_defaults(run=_check)

    grade = commands.add_parser("grade")
    _common(grade)
    grade.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE|FOLDER",
        help="a .py file, notebook or zip; a folder of them",
    )
    grade.add_argument(
        "--seed", help="of the hidden inputs (default: from the secret, else random; in the result)"
    )
    grade.add_argument(
        "--secret-file", type=Path, metavar="FILE", help=f"the course's secret (or in ${SECRET})"
    )
    grade.add_argument(
        "--student", metavar="ID", help="whose robot it is (default: by the file's name)"
    )
    grade.add_argument(
        "--isolate",
        choices=("process", "bwrap"),
        help="(default: a folder bwrap, if it works here)",
    )
    grade.add_argument(
        "--fail-under", type=float, metavar="P", help="exit 1 if a score is below P per cent"
    )
    grade.add_argument(
        "--gradescope", type=Path, metavar="FILE", help="write Gradescope's results.json"
    )
    grade.add_argument("--csv", type=Path, metavar="FILE", help="write a row per check")
    folder = grade.add_argument_group("a folder of submissions")
    folder.add_argument(
        "--gradebook", type=Path, metavar="CSV", help="Moodle's or Canvas' sheet, to be filled"
    )
    folder.add_argument(
        "--column", metavar="TITLE", help="of the marks in that sheet (default: the one that fits)"
    )
    folder.add_argument(
        "--jobs", type=int, default=1, metavar="N", help="graded at a time (default: %(default)s)"
    )
    folder.add_argument(
        "--dask", metavar="ADDRESS", help="grade on a Dask cluster that sees the same files"
    )
    folder.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="results, each as it comes; a second run goes on there",
    )
    folder.add_argument(
        "--hand-out",
        type=Path,
        metavar="IDS.txt",
        help="write each student's own student.py to --out",
    )
    grade.set_defaults(run=_grade)


def _common(parser, lab=None):
    parser.add_argument("lab", metavar="LAB", nargs=lab, help="lab1 ... or its full name")
    parser.add_argument("--labs", type=Path, metavar="DIR", help="a folder with labs of your own")
    parser.add_argument(
        "--file", dest="program", metavar="NAME", help="which of several files is meant (a pattern)"
    )
    parser.add_argument(
        "--hints-from",
        metavar="DATE",
        help="until this day reports show points and no explanations",
    )
    parser.add_argument("--time-limit", type=float, metavar="S", help="of one call (default: 2)")
    parser.add_argument(
        "--html", type=Path, metavar="FILE", help="write the report as a page, with figures"
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON on stdout")


def _check(arguments):
    from ..grading.grade import grade
    from ..grading.intake.hand_in import ProgramFile
    from ..grading.labs import find_lab, known_labs
    from ..grading.program import Job
    from ..grading.results import withheld

    if arguments.lab is None:
        names = ", ".join(lab.name for lab in known_labs(arguments.labs))
        raise UsageError(f"which lab, and which file of yours? The known ones are: {names}")
    lab, limit = find_lab(arguments.lab, arguments.labs), _limit(arguments)
    program, siblings = _program(arguments, lab)
    if arguments.file == program.path:  # one's own folder
        siblings = [
            ProgramFile(path, "", path.name) for path in sorted(arguments.file.parent.glob("*.py"))
        ]
    hints = hints_from(arguments, lab)
    job = Job(
        program.path, limit=limit, member=program.member, siblings=tuple(siblings), hints_from=hints
    )
    _show(arguments, withheld(grade(lab, job, home=True, watched=True)))


def _grade(arguments):
    from ..grading.grade import grade
    from ..grading.labs import find_lab
    from ..grading.program import Job
    from ..grading.variants import hidden_seed, robot_for

    lab, secret, limit = (
        find_lab(arguments.lab, arguments.labs),
        _secret(arguments.secret_file),
        _limit(arguments),
    )
    if arguments.hand_out:
        return hand_out(arguments, lab, secret)
    if arguments.file is None:
        raise UsageError("what is to be graded? Name a file or a folder")
    seed = arguments.seed or (hidden_seed(secret, lab.name) if secret else None)
    if arguments.file.is_dir() and not arguments.gradescope:
        reports = grade_folder(arguments, lab, secret, seed, limit, hints_from(arguments, lab))
        return _must_reach(arguments, reports)
    program, siblings = _program(arguments, lab)
    if arguments.dask:
        raise UsageError("--dask is for a folder of submissions: one is graded here")
    if arguments.out:
        raise UsageError(
            "--out is for a folder of submissions; for one there are --html, --csv, --json,"
            " --gradescope"
        )
    student = (
        arguments.student or (program.path if arguments.file.is_dir() else arguments.file).stem
    )
    robot, isolate = robot_for(student, secret, lab.robot()), arguments.isolate or "process"
    seed = seed or os.urandom(8).hex()
    job = Job(
        program.path,
        student,
        seed,
        robot,
        isolate,
        limit,
        "",
        program.member,
        tuple(siblings),
        hints_from(arguments, lab),
    )
    report = grade(lab, job, watched=True)
    for line in (isolation(isolate), *report.warnings):
        print(line, file=sys.stderr)
    if arguments.gradescope:
        from ..grading.report.outputs import gradescope_text

        _write(arguments.gradescope, gradescope_text(report))
    if arguments.csv:
        from ..grading.report.outputs import CHECK_COLUMNS, check_rows, csv_text

        _write(arguments.csv, csv_text(CHECK_COLUMNS, check_rows(report)))
    _show(arguments, report)
    _must_reach(arguments, [report])


def _program(arguments, lab):
    """The program in the file, folder or zip that is named, and those in it that it may import;
    says what is left.
    """
    from ..base.representation import printable
    from ..grading.intake.hand_in import beside, choose, look_into
    from ..grading.worker.submission import SubmissionError

    if arguments.file is None or not arguments.file.exists():
        to_fill_in, statement = lab.folder / "student.py", lab.folder / "README.md"
        hint = (
            f"; the lab's file to copy and fill in is {to_fill_in}" if to_fill_in.exists() else ""
        )
        hint += f", what is asked says {statement}" if hint and statement.exists() else ""
        missing = (
            "FILE is missing" if arguments.file is None else f"no file {str(arguments.file)!r}"
        )
        raise UsageError(f"{missing}{hint}")
    programs, left = look_into(arguments.file)
    try:
        program = choose(lab, programs, arguments.program)
    except SubmissionError as error:
        words = "; ".join(f"{item.name}: {item.word}" for item in left[:5])
        raise UsageError(f"{arguments.file}: {error}{f' ({words})' if words else ''}") from None
    if program.path != arguments.file:
        print(f"graded: {printable(str(program))}", file=sys.stderr)
    for item in left:
        print(f"not graded: {printable(item.name)}: {printable(item.word)}", file=sys.stderr)
    for other in programs:
        if other != program:
            print(f"not graded: {printable(str(other))}", file=sys.stderr)
    return program, beside(program, programs)


def _show(arguments, report):
    from ..grading.report.outputs import json_text
    from ..grading.report.text import report_text

    if arguments.html:
        from ..grading.report.page import report_page
        from ..grading.results import withheld

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
    """The course's secret as bytes, None where there is none."""
    given = os.environ.pop(SECRET, "")  # no process that this one starts shall see it
    try:
        secret = path.read_bytes().strip() if path else given.encode()
    except OSError as error:
        raise UsageError(f"--secret-file: {error}") from None
    if (path or given) and len(secret) < 8:
        raise UsageError(
            f"{f'--secret-file: {path}' if path else SECRET} holds fewer than 8 bytes: too easy to"
            " guess"
        )
    return secret or None


def hints_from(arguments, lab):
    """The day of the hints where it is to come, else ""; by the option, else by the lab."""
    given = arguments.hints_from or lab.hints_from()
    try:
        day = datetime.date.fromisoformat(given) if given else None
    except ValueError:
        raise UsageError(f"--hints-from: {given!r} is no day; write it as 2027-01-31") from None
    return given if day and datetime.date.today() < day else ""


def _limit(arguments):
    limit = arguments.time_limit
    if limit is not None and not 0 < limit <= 3600:
        raise UsageError(f"--time-limit must lie in 0..3600 s, not {limit:g}")
    return limit


def _write(path, text):
    from ..grading.report.outputs import write_whole

    try:
        write_whole(path, text)
    except (
        FileNotFoundError,
        IsADirectoryError,
        NotADirectoryError,
        PermissionError,
    ) as error:  # not a full disk
        raise UsageError(f"{path}: {error.strerror}") from None


def _must_reach(arguments, reports):
    low = [
        report
        for report in reports
        if arguments.fail_under is not None and report.percent < arguments.fail_under
    ]
    if low:
        names = ", ".join(report.student or report.submission for report in low[:5])
        raise RuntimeError(
            f"{len(low)} of {len(reports)} below {arguments.fail_under:g} %: {names}"
        )
