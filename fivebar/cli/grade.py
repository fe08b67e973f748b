"""`fivebar check` at home, `fivebar grade` for one submission or a folder of them."""

import json
import os
import sys
from pathlib import Path

from ..errors import UsageError

SECRET = "FIVEBAR_SECRET"


def add_parsers(commands):
    """Add `check` and `grade` to the program's commands."""
    check = commands.add_parser("check")
    _common(check)
    check.add_argument("file", type=Path, metavar="FILE", help="your .py file or notebook")
    check.set_defaults(run=_check)

    grade = commands.add_parser("grade")
    _common(grade)
    grade.add_argument(
        "file", type=Path, nargs="?", metavar="FILE|FOLDER", help="a .py file, a notebook, or a folder of submissions"
    )
    grade.add_argument("--seed", help="of the hidden inputs (default: from the secret, else random; in the result)")
    grade.add_argument("--secret-file", type=Path, metavar="FILE", help=f"the course's secret (or in ${SECRET})")
    grade.add_argument("--student", metavar="ID", help="whose robot it is (default: by the file's name)")
    grade.add_argument("--isolate", choices=("process", "bwrap"), help="(default: a folder bwrap, if it works here)")
    grade.add_argument("--fail-under", type=float, metavar="P", help="exit 1 if a score is below P per cent")
    grade.add_argument("--gradescope", type=Path, metavar="FILE", help="write Gradescope's results.json")
    grade.add_argument("--csv", type=Path, metavar="FILE", help="write a row per check")
    folder = grade.add_argument_group("a folder of submissions")
    folder.add_argument("--jobs", type=int, default=1, metavar="N", help="graded at a time (default: %(default)s)")
    folder.add_argument("--out", type=Path, metavar="DIR", help="results, each as it comes; a second run goes on there")
    folder.add_argument("--hand-out", type=Path, metavar="IDS.txt", help="write each student's own student.py to --out")
    grade.set_defaults(run=_grade)


def _common(parser):
    parser.add_argument("lab", metavar="LAB", help="lab1 ... or its full name")
    parser.add_argument("--labs", type=Path, metavar="DIR", help="a folder with labs of your own")
    parser.add_argument("--time-limit", type=float, metavar="S", help="of one call (default: 2)")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write the report as a page, with figures")
    parser.add_argument("--json", action="store_true", help="the result as JSON on stdout")


def _check(arguments):
    from ..grading.grade import grade
    from ..grading.labs import find_lab
    from ..grading.program import Job

    _must_be_file(arguments.file)
    job = Job(arguments.file, limit=_limit(arguments))
    _show(arguments, grade(find_lab(arguments.lab, arguments.labs), job, home=True))


def _grade(arguments):
    from ..grading.grade import grade
    from ..grading.labs import find_lab
    from ..grading.program import Job
    from ..grading.variants import hidden_seed, robot_for

    lab, secret, limit = find_lab(arguments.lab, arguments.labs), _secret(arguments.secret_file), _limit(arguments)
    if arguments.hand_out:
        return _hand_out(arguments, lab, secret)
    if arguments.file is None:
        raise UsageError("what is to be graded? Name a file or a folder")
    seed = arguments.seed or (hidden_seed(secret, lab.name) if secret else None)
    if arguments.file.is_dir() and not arguments.gradescope:
        return _cohort(arguments, lab, secret, seed, limit)
    path = _only_program(arguments.file) if arguments.file.is_dir() else arguments.file
    _must_be_file(path)
    if arguments.out:
        raise UsageError("--out is for a folder of submissions; for one there are --html, --csv, --json, --gradescope")
    student = arguments.student or path.stem
    robot = robot_for(student, secret, lab.robot())
    job = Job(path, student, seed or os.urandom(8).hex(), robot, arguments.isolate or "process", limit)
    report = grade(lab, job)
    print(*report.warnings, sep="\n", end="\n" if report.warnings else "", file=sys.stderr)
    if arguments.gradescope:
        from ..grading.report.outputs import gradescope_text

        _write(arguments.gradescope, gradescope_text(report))
    if arguments.csv:
        from ..grading.report.outputs import CHECK_COLUMNS, check_rows, csv_text

        _write(arguments.csv, csv_text(CHECK_COLUMNS, check_rows(report)))
    _show(arguments, report)
    _must_reach(arguments, [report])


def _show(arguments, report):
    from ..grading.report.outputs import json_text
    from ..grading.report.text import report_text

    if arguments.html:
        from ..grading.report.page import report_page

        _write(arguments.html, report_page(report))
    if arguments.json:
        print(json_text(report), end="")
    else:
        sys.stdout.reconfigure(errors="backslashreplace")
        print(report_text(report, colour=sys.stdout.isatty() and "NO_COLOR" not in os.environ))
    if report.faults:
        raise RuntimeError(f"the lab itself has a fault, so this result does not count: {'; '.join(report.faults)}")


def _cohort(arguments, lab, secret, seed, limit):
    from ..grading.course.cohort import begin, run_cohort
    from ..grading.course.cohort_page import write_summary
    from ..grading.course.items import summary_text
    from ..grading.course.submissions import find_submissions
    from ..grading.worker.places import bwrap_trouble

    if arguments.out is None:
        raise UsageError("a folder of submissions needs --out DIR for the results")
    if arguments.student or arguments.html or arguments.csv:
        raise UsageError("--student, --html and --csv are for one submission; a folder's files go to --out")
    if arguments.jobs < 1:
        raise UsageError(f"--jobs must be at least 1, not {arguments.jobs}")
    entries = find_submissions(arguments.file, arguments.out)
    if not entries:
        raise UsageError(f"{arguments.file} holds no submissions: a .py file or notebook, or a folder, per student")
    isolate = arguments.isolate or ("process" if bwrap_trouble() else "bwrap")
    cohort = begin(lab, arguments.out, seed, secret, isolate, limit)
    reports = run_cohort(cohort, entries, arguments.jobs)
    write_summary(arguments.out, lab.name, reports)
    if arguments.json:
        print(json.dumps([report.as_json() for report in reports], indent=1))
    else:
        print(summary_text(lab.name, reports))
        print(arguments.out / "summary.html")
    faults = dict.fromkeys(fault for report in reports for fault in report.faults)
    if faults:
        raise RuntimeError(f"the lab itself has a fault, so the results do not count: {'; '.join(faults)}")
    _must_reach(arguments, reports)


def _hand_out(arguments, lab, secret):
    from ..grading.report.outputs import file_name, write_whole
    from ..grading.variants import robot_for, with_constants

    if arguments.out is None or secret is None:
        raise UsageError("--hand-out needs --out DIR and the course's secret")
    try:
        lines = arguments.hand_out.read_text(encoding="utf-8").splitlines()
        source = (lab.folder / "student.py").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"--hand-out: {error}") from None
    for student in dict.fromkeys(line.strip() for line in lines if line.strip()):
        path = arguments.out / file_name(student) / "student.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, with_constants(source, robot_for(student, secret, lab.robot())))
        print(path)


def _secret(path):
    """The course's secret as bytes, None where there is none."""
    given = os.environ.pop(SECRET, "")  # no process that this one starts shall see it
    try:
        secret = path.read_bytes().strip() if path else given.encode()
    except OSError as error:
        raise UsageError(f"--secret-file: {error}") from None
    if (path or given) and len(secret) < 8:
        raise UsageError(f"{f'--secret-file: {path}' if path else SECRET} holds fewer than 8 bytes: too easy to guess")
    return secret or None


def _limit(arguments):
    limit = arguments.time_limit
    if limit is not None and not 0 < limit <= 3600:
        raise UsageError(f"--time-limit must lie in 0..3600 s, not {limit:g}")
    return limit


def _must_be_file(path):
    if not path.is_file():
        raise UsageError(f"no file {str(path)!r}")


def _only_program(folder):
    found = [path for path in sorted(folder.iterdir()) if path.suffix in (".py", ".ipynb") and path.is_file()]
    if len(found) != 1:
        names = ", ".join(path.name for path in found) or "none"
        raise UsageError(f"{folder} must hold one .py file or notebook, not: {names}")
    return found[0]


def _write(path, text):
    from ..grading.report.outputs import write_whole

    try:
        write_whole(path, text)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}") from None


def _must_reach(arguments, reports):
    low = [report for report in reports if arguments.fail_under is not None and report.percent < arguments.fail_under]
    if low:
        names = ", ".join(report.student or report.submission for report in low[:5])
        raise RuntimeError(f"{len(low)} of {len(reports)} below {arguments.fail_under:g} %: {names}")
