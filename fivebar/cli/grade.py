"""`fivebar check` at home, `fivebar grade` for one submission or a folder of them."""

import codecs
import json
import os
import sys
from pathlib import Path

from ..errors import UsageError

SECRET = "FIVEBAR_SECRET"


def add_parsers(commands):
    """Add `check` and `grade` to the program's commands."""
    check = commands.add_parser("check", help="check your own solution of a lab, with hints")
    _common(check)
    check.add_argument("file", type=Path, metavar="FILE", help="your .py file or notebook, or a folder or zip with it")
    check.set_defaults(run=_check)

    grade = commands.add_parser("grade", help="grade a submission, or a folder of them, on hidden inputs")
    _common(grade)
    grade.add_argument(
        "file",
        type=Path,
        nargs="?",
        metavar="FILE|FOLDER",
        help="a .py file, notebook or zip; a folder of them",
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
    parser.add_argument("--file", dest="program", metavar="NAME", help="which of several files is meant (a pattern)")
    parser.add_argument("--time-limit", type=float, metavar="S", help="of one call (default: 2)")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write the report as a page, with figures")
    parser.add_argument("--json", action="store_true", help="the result as JSON on stdout")


def _check(arguments):
    from ..grading.grade import grade
    from ..grading.intake.hand_in import ProgramFile
    from ..grading.labs import find_lab
    from ..grading.program import Job

    lab, limit = find_lab(arguments.lab, arguments.labs), _limit(arguments)
    program, siblings = _program(arguments, lab)
    if arguments.file == program.path:  # one's own folder
        siblings = [ProgramFile(path, "", path.name) for path in sorted(arguments.file.parent.glob("*.py"))]
    job = Job(program.path, limit=limit, member=program.member, siblings=tuple(siblings))
    _show(arguments, grade(lab, job, home=True))


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
    program, siblings = _program(arguments, lab)
    if arguments.out:
        raise UsageError("--out is for a folder of submissions; for one there are --html, --csv, --json, --gradescope")
    student = arguments.student or (program.path if arguments.file.is_dir() else arguments.file).stem
    robot, isolate = robot_for(student, secret, lab.robot()), arguments.isolate or "process"
    seed = seed or os.urandom(8).hex()
    job = Job(program.path, student, seed, robot, isolate, limit, member=program.member, siblings=tuple(siblings))
    report = grade(lab, job)
    for line in (_isolation(isolate), *report.warnings):
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
    """The program in the file, folder or zip that is named, and those in it that it may import; says what is left."""
    from ..grading.intake.hand_in import beside, choose, look_into
    from ..grading.report.text import printable
    from ..grading.worker.submission import SubmissionError

    if not arguments.file.exists():
        raise UsageError(f"no file {str(arguments.file)!r}")
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


def _isolation(isolate):
    from ..grading.worker.places import bwrap_trouble

    if isolate == "bwrap":
        return "isolation: bwrap (a disk, processes and network of its own)"
    trouble = " ".join(bwrap_trouble().split())[:200]
    why = f"bubblewrap does not work here: {trouble}" if trouble else "bubblewrap works here and hides more: --isolate"
    return f"isolation: process ({why})"


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
    from ..grading.course.cohort import alone, begin, run_cohort
    from ..grading.course.cohort_page import write_summary
    from ..grading.course.items import summary_text
    from ..grading.intake.cohort_folder import find_submissions
    from ..grading.worker.places import bwrap_trouble

    folder, out = arguments.file, arguments.out
    if out is None:
        raise UsageError("a folder of submissions needs --out DIR for the results")
    if arguments.student or arguments.html or arguments.csv:
        raise UsageError("--student, --html and --csv are for one submission; a folder's files go to --out")
    if arguments.jobs < 1:
        raise UsageError(f"--jobs must be at least 1, not {arguments.jobs}")
    if folder.resolve() in (out.resolve(), *out.resolve().parents):
        raise UsageError(
            f"--out {out} lies within the submissions, where the results would be taken for a student's: give a folder "
            f"beside {folder}"
        )
    entries, left = find_submissions(folder, lab, arguments.program, secret is not None)
    _say_what_is_left(entries, left)
    if not entries:
        raise UsageError(f"{folder} holds no submissions: a .py file, notebook or zip, or a folder, per student")
    isolate = arguments.isolate or ("process" if bwrap_trouble() else "bwrap")
    print(_isolation(isolate), file=sys.stderr)
    with alone(out):
        cohort = begin(lab, out, seed, secret, isolate, limit)
        reports = run_cohort(cohort, entries, arguments.jobs)
        write_summary(out, lab.name, entries, reports, left)
    graded = [report for report in reports if not report.ungraded]
    if arguments.json:
        print(json.dumps([report.as_json() for report in reports], indent=1))
    else:
        print(summary_text(lab.name, graded))
        print(out / "summary.html")
    faults = dict.fromkeys(fault for report in reports for fault in report.faults)
    if faults:
        raise RuntimeError(f"the lab itself has a fault, so the results do not count: {'; '.join(faults)}")
    if lost := [report.student for report in reports if report.ungraded]:
        raise RuntimeError(f"{len(lost)} of {len(reports)} not graded: {', '.join(lost[:5])}; run it again")
    _must_reach(arguments, graded)


def _say_what_is_left(entries, left):
    from ..grading.report.text import printable

    for item in left:
        print(f"not graded: {printable(item.name)}: {printable(item.word)}", file=sys.stderr)
    for entry in entries:
        if entry.left:
            words = "; ".join(f"{item.name} ({item.word})" for item in entry.left[:6])
            more = f" and {len(entry.left) - 6} more" if len(entry.left) > 6 else ""
            print(f"{printable(entry.student)}: also there, not graded: {printable(words)}{more}", file=sys.stderr)


def _hand_out(arguments, lab, secret):
    from ..grading.report.outputs import file_name, write_whole
    from ..grading.variants import id_key, robot_for, with_constants

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
        path = arguments.out / file_name(student) / "student.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, with_constants(source, robot_for(student, secret, lab.robot())))
        print(path)


def _ids(data):
    """The lines of a list of ids, also as Windows' editors save it, with a mark at its start."""
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if wide else "utf-8-sig").splitlines()


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
