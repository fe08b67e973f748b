"""`fivebar run --mark`: controllers' tracking errors as points, for a script or for many."""

import sys
from pathlib import Path
from typing import Any, NamedTuple

from ..base.errors import UsageError
from .options import print_json, print_message, write_options

LIMIT = 60.0  # s of wall time for one script
MOST_SCRIPTS = 3  # of a hand-in that are tried
COLUMNS = ("student", "file", "points", "of", "largest error (mm)", "trouble")


class Tried(NamedTuple):
    """One script's tracking error, None where there is none: trouble says why; said: what the
    script printed.
    """

    student: str
    name: str
    tracking: dict | None
    trouble: str = ""
    said: str = ""
    run: Any = None

    @property
    def points(self):
        return self.tracking["points"] if self.tracking else -1.0


def mark(arguments, rest):
    """Mark a script, or the hand-ins of a folder, and print what came of it."""
    from ..amoro.ros_free.tracking import words
    from ..grading.worker.places import bwrap_trouble

    path = Path(arguments.script)
    isolate = "process" if bwrap_trouble() else "bwrap"
    how = arguments.mark, arguments.until, isolate
    if path.is_file() and path.suffix == ".py":
        tried = _of_script(path, rest, how)
        print(tried.said, end="", file=sys.stderr)
        if arguments.json:
            print_json({"tracking": tried.tracking, "trouble": tried.trouble})
        if tried.trouble:
            print_message(f"fivebar run: {tried.trouble}")
        if not tried.tracking:
            raise RuntimeError(f"--mark {arguments.mark}: no mark")
        if not arguments.json:
            print(words(tried.tracking))
        run = tried.run
        writers = {"record": run.to_csv, "plot": run.plot, "animate": run.animate}
        for file in write_options(arguments, writers):
            print_message(f"fivebar run: wrote {file}")
        return
    found = [_best(hand_in, how) for hand_in in _hand_ins(path)]
    if arguments.json:
        print_json([tried._asdict() | {"run": None} for tried in found])
        return
    _print_table(found)


def _print_table(found):
    from ..grading.report.outputs import csv_text

    rows = []
    for tried in found:
        about = tried.tracking
        error = about and round(1e3 * about["largest_error_m"], 4)
        values = (about["points"], about["of"], error) if about else ("", "", "")
        rows.append((tried.student, tried.name, *values, tried.trouble))
    print(csv_text(COLUMNS, rows).replace("\r", ""), end="")


def _hand_ins(path):
    """Return the hand-ins in a folder of a course; a zip is one, and a folder with a lab's own file
    or a file called control.py in it.
    """
    from ..grading.intake.cohort_folder import HandIn, find_hand_ins, is_one_hand_in
    from ..grading.intake.hand_in import look_into
    from ..grading.labs import find_lab

    labs = find_lab("amoro").family()
    if path.is_dir() and not is_one_hand_in(path, labs) and not list(path.glob("control*.py")):
        found = find_hand_ins(path)[0]
        if not found:
            raise UsageError(f"{path} holds no hand-ins: a file, zip or folder per student")
        return found
    programs, left = look_into(path)
    return [HandIn(path.stem, "", (path,), tuple(programs), tuple(left))]


def _best(hand_in, how):
    """Return the best of a hand-in's scripts that drive the robot."""
    from ..grading.intake.hand_in import beside, imported

    scripts = {}
    for program in hand_in.programs:
        text = _text(program.path, program.member)
        if "apply_efforts" in text and "class Robot" not in text:
            scripts[program] = text
    if not 0 < len(scripts) <= MOST_SCRIPTS:
        named = {p: text for p, text in scripts.items() if "control" in Path(p.name).name}
        if not 0 < len(named) <= MOST_SCRIPTS:
            trouble = f"{len(scripts)} programs call apply_efforts: which one is the controller?"
            return Tried(hand_in.student, "", None, trouble if scripts else "no controller")
        scripts = named
    tried = []
    for program, text in scripts.items():
        modules = imported(text, beside(program, hand_in.programs))
        name = program.name.partition("/")[2] or program.name
        tried.append(_tried(hand_in.student, name, text, [], modules, how))
    return max(tried, key=lambda one: one.points)


def _of_script(path, rest, how):
    """Return a script marked that is named with its arguments, of which a .py file may be one."""
    from ..grading.intake.hand_in import ProgramFile, imported

    text = _text(path)
    files = {file.stem: ProgramFile(file, "", file.name) for file in path.parent.glob("*.py")}
    modules = imported(text, files.values())
    for argument in rest:
        if argument.endswith(".py") and Path(argument).is_file():
            modules[Path(argument).stem] = _text(Path(argument))
    return _tried(path.stem, path.name, text, rest, modules, how)


def _text(path, member=""):
    from ..grading.worker.submission import SubmissionError, read_submission

    try:
        return read_submission(path, member).source
    except SubmissionError as error:
        return f"raise ImportError({str(error)!r})\n"


def _tried(student, name, text, rest, modules, how):
    """Run a script confined, on a robot that is simulated here, and mark the robot's motion."""
    from ..amoro.ros_free.marking import MarkedRobot, confined_program
    from ..grading.worker.replies import KINDS
    from ..grading.worker.student import Student
    from ..grading.worker.submission import Submission

    task, until, isolate = how
    robot = MarkedRobot(until)
    program, lab = confined_program()
    with Student(
        Submission(name, program), isolate, limit=LIMIT, total=LIMIT, modules=modules | lab
    ) as worker:
        (reply,) = worker.ask("run", [[text, name, rest, [*modules]]], given={"lab": robot.answer})
        said = worker.output
    tracking, why = robot.tracking(task)
    ended = reply.value if isinstance(reply.value, str) else ""
    if reply.kind != "value":
        ended = f"the script {KINDS[reply.kind]}: {reply.text}".removesuffix(": ")
    trouble = "; ".join(filter(None, (robot.trouble or ended, why)))
    return Tried(student, name, tracking, trouble, said, robot.run())
