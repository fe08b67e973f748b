"""A folder of submissions: found, graded by several processes, interrupted at any moment, gone on with."""

import json
import random
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from fivebar.base.errors import UsageError
from fivebar.cli import main
from fivebar.grading import grade as graded
from fivebar.grading.course import cohort as cohort_module
from fivebar.grading.course import graders
from fivebar.grading.course.cohort import (
    STATE,
    Cohort,
    GraderError,
    _one,
    begin,
    run_cohort,
    trouble_of,
)
from fivebar.grading.grade import grade
from fivebar.grading.intake.cohort_folder import Entry, entries_of, find_hand_ins
from fivebar.grading.intake.program import Job
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.sandbox import IsolationError
from tests.helpers import ROOT

from ..helpers.grading_lab import (
    CRASHES,
    HALF,
    HANGS,
    RIGHT,
    SHIFTED,
    UNTOUCHED,
    write_lab,
    written,
)
from ..helpers.processes import descendants


@pytest.fixture
def labs(tmp_path):
    return write_lab(tmp_path / "mylabs")


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "submissions"


def command(labs, folder, out, *options):
    return [
        "grade",
        "elbow",
        str(folder),
        "--labs",
        str(labs),
        "--out",
        str(out),
        "--isolate",
        "process",
        *options,
    ]


def entries_in(folder, lab):
    return entries_of(find_hand_ins(folder)[0], lab)


def points(out):
    return {
        path.stem: json.loads(path.read_text("utf-8"))["points"]
        for path in (out / "students").glob("*.json")
    }


@pytest.mark.deep
def test_a_cohort_with_all_that_can_happen(labs, folder, tmp_path, capsys):
    for name, source in {
        "anna": RIGHT,
        "ben": SHIFTED,
        "carl": HALF,
        "dora": UNTOUCHED,
        "emil": CRASHES,
        "gina": HANGS,
        "fred": "import os\nos._exit(0)\n",
        "=HYPERLINK(1)": RIGHT,
        "<img src=x onerror=alert(1)>": RIGHT,
    }.items():
        written(folder / f"{name}.py", source)
    (folder / "latin.py").write_bytes(RIGHT.encode() + b"# l'angle oppos\xe9\n")
    (folder / "empty").mkdir()
    out = tmp_path / "out"
    assert main(command(labs, folder, out, "--jobs", "2", "--time-limit", "1")) == 0
    printed = capsys.readouterr()
    assert "elbow: 10 students" in printed.out
    met = (out / "misconceptions.csv").read_text("utf-8")
    assert "elbow,origin in the base joint" in met
    for words in (
        "emil: A line is passed over",
        "gina: 1 × timeout, 2 × unasked",
        "empty: Nothing can be graded",
    ):
        assert words in printed.err
    got = points(out)
    assert len(got) == 11 and got["anna"] == got["emil"] == got["latin"] == 4 and got["ben"] == 1
    assert got["dora"] == got["fred"] == got["gina"] == got["empty"] == 0 and 0 < got["carl"] < 3
    assert "is not UTF-8 text" in (out / "students" / "latin.html").read_text("utf-8")
    assert {path.name for path in out.iterdir()} == {
        STATE,
        "students",
        "checks.csv",
        "marks.csv",
        "items.csv",
        "misconceptions.csv",
        "summary.html",
        "course.toml",
        "feedback.zip",
    }
    assert len((out / "checks.csv").read_text("utf-8").splitlines()) == 1 + 3 * 10
    assert "'=HYPERLINK(1)," in (out / "marks.csv").read_text("utf-8")
    page = (out / "summary.html").read_text("utf-8")
    assert (
        "<img" not in page
        and "&lt;img src=x onerror=alert(1)&gt;" in page
        and 'href="students/anna.html"' in page
    )
    assert all((out / "students" / f"{stem}.html").exists() for stem in got)
    stamps = {path: path.stat().st_mtime_ns for path in (out / "students").glob("*.json")}
    written(folder / "ben.py", RIGHT)
    assert main(command(labs, folder, out, "--time-limit", "1", "--json", "--fail-under", "1")) == 1
    printed = capsys.readouterr()
    assert "9 of 11 are graded already" in printed.err and "3 of 10 below 1 %" in printed.err
    assert len(json.loads(printed.out)) == 11 and points(out)["ben"] == 4
    again = {path.stem for path, stamp in stamps.items() if path.stat().st_mtime_ns != stamp}
    assert again == {"ben", "empty"}  # what has changed, and what there was no file of


@pytest.mark.deep
def test_what_is_graded_again(labs, folder, tmp_path):
    entry = Entry("anna", written(folder / "anna.py", RIGHT))
    lab, out = find_lab("elbow", labs), tmp_path / "out"
    first = begin(Cohort(lab, out, None, None, "process", None))
    assert first.done(entry) is None
    run_cohort(first, [entry], 1)
    assert first.done(entry).points == 4
    assert (
        begin(Cohort(lab, out, None, None, "process", None)).seed == first.seed
    )  # of the earlier run
    with_secret = Cohort(lab, out, first.seed, b"a secret", "process", None)
    assert with_secret.done(entry) is None  # another robot
    with pytest.raises(UsageError, match="graded with another secret, or without one"):
        begin(with_secret)
    assert begin(Cohort(lab, out, "other", None, "process", None)).done(entry) is None
    first.file(entry, ".json").write_text("{}", encoding="utf-8")
    assert first.done(entry) is None
    run_cohort(first, [entry], 1)
    lab.tests.write_text(lab.tests.read_text("utf-8") + "\n", encoding="utf-8")
    assert first.done(entry) is None
    (out / STATE).write_text("[]", encoding="utf-8")
    assert main(command(labs, folder, out)) == 2
    (out / STATE).write_text('{"lab": "wrist", "seed": "1"}', encoding="utf-8")
    assert main(command(labs, folder, out)) == 2


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


# The command, which goes no further than to the third result until it is interrupted.
HELD = """import signal, sys, threading
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
from fivebar.base.errors import UsageError
from fivebar.cli import main
from fivebar.grading.course import cohort
write, stop, stopped = cohort.write_whole, cohort.Workers.stop, threading.Event()
def held(path, text):
    if len(list(path.parent.glob("*.json"))) >= 3:
        print("some are graded", flush=True)
        stopped.wait()
    write(path, text)
def stopping(workers):
    stopped.set()
    stop(workers)
cohort.write_whole, cohort.Workers.stop = held, stopping
sys.exit(main(sys.argv[1:]))"""


@pytest.mark.deep
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_killed_at_any_moment_and_gone_on_with(labs, folder, tmp_path, number):
    for k in range(12):
        written(folder / f"s{k:02d}.py", RIGHT if k % 2 else SHIFTED)
    out = tmp_path / "out"
    run = subprocess.Popen(
        [sys.executable, "-c", HELD, *command(labs, folder, out)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert run.stdout.readline() == "some are graded\n"
    started = descendants(run.pid)
    assert started
    run.send_signal(number)
    err = run.communicate(timeout=60)[1]
    wait_for(lambda: not any(Path(f"/proc/{process}").exists() for process in started))
    kept = points(out)  # each file is whole
    assert 3 <= len(kept) < 12 and not (out / "summary.html").exists()
    if number == signal.SIGINT:
        assert (
            run.returncode == 130
            and "interrupted" in err
            and "goes on from there" in err
            and "Traceback" not in err
        )
    seeds = {
        json.loads(path.read_text("utf-8"))["seed"] for path in (out / "students").glob("*.json")
    }
    run = subprocess.run(
        [sys.executable, "-m", "fivebar", *command(labs, folder, out)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0 and f"{len(kept)} of 12 are graded already" in run.stderr
    assert points(out) == {f"s{k:02d}": (4 if k % 2 else 1) for k in range(12)}
    assert {
        json.loads(path.read_text("utf-8"))["seed"] for path in (out / "students").glob("*.json")
    } == seeds


def test_an_interrupt_that_a_waiting_thread_receives_is_answered(
    labs, folder, tmp_path, monkeypatch
):
    """Python's handler runs in the main thread, which must wake up for it."""
    stopped = threading.Event()
    first = threading.Lock()

    class Interrupted:
        def ask(self, job, lab):
            if first.acquire(blocking=False):  # one Ctrl-C: a second might come to pytest
                signal.pthread_kill(threading.get_ident(), signal.SIGINT)
            stopped.wait(30)
            raise GraderError("stopped")

        def stop(self):
            stopped.set()

    monkeypatch.setattr(cohort_module, "Workers", Interrupted)
    entries = [Entry(name, written(folder / f"{name}.py", RIGHT)) for name in "abc"]
    cohort = begin(Cohort(find_lab("elbow", labs), tmp_path / "out", "s", None, "process", None))
    with pytest.raises(KeyboardInterrupt, match="0 are graded; the same command goes on"):
        run_cohort(cohort, entries, 2)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a second one would be ignored


@pytest.mark.deep
def test_interrupted_at_random_moments_it_says_so_within_seconds(labs, folder, tmp_path):
    draw = random.Random(3)
    for name in "abcd":
        written(folder / f"{name}.py", SHIFTED)
    for k in range(10):
        run = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "fivebar",
                *command(labs, folder, tmp_path / str(k), "--jobs", "2"),
            ],
            cwd=ROOT,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert run.stderr.readline().startswith("isolation")
        time.sleep(draw.uniform(0, 1.5))
        run.send_signal(signal.SIGINT)
        before = time.monotonic()
        if k % 2:  # a second Ctrl-C leaves nothing half done
            time.sleep(0.05)
            run.send_signal(signal.SIGINT)
        err = run.communicate(timeout=60)[1]
        assert time.monotonic() - before < 10, err
        last = err.strip().splitlines()[-1]
        assert run.returncode == 130
        assert re.fullmatch(
            r"fivebar: interrupted(: \d are graded; the same command goes on from there)?", last
        )


@pytest.mark.deep
def test_hostile_numbers_and_lines_cost_one_student(labs, folder, tmp_path):
    """Constants that no float holds, and a line that takes Python's parser minutes, in the grader's own process."""
    written(folder / "a.py", RIGHT.replace("l11 = 0.09", f"l11 = 1{'0' * 400}"))
    written(folder / "b.py", RIGHT + "x=1;" * 60_000)
    written(folder / "c.py", RIGHT)
    cohort = begin(Cohort(find_lab("elbow", labs), tmp_path / "out", "s", None, "process", None))
    assert [report.points for report in run_cohort(cohort, entries_in(folder, cohort.lab), 1)][
        ::2
    ] == [0, 4]


@pytest.mark.parametrize(
    "error, key", [(ValueError("strange"), "failed"), (IsolationError("no room"), "error")]
)
def test_a_failure_of_the_grader_costs_one_student_and_one_of_the_machine_stops_it(
    labs, folder, tmp_path, monkeypatch, error, key
):
    def fails_unless_told(lab, task):
        if task.trouble:
            return grade(lab, task)
        raise error

    monkeypatch.setattr(graders, "grade", fails_unless_told)
    cohort = begin(Cohort(find_lab("elbow", labs), tmp_path / "out", "s", None, "process", None))
    entry = Entry("a", written(folder / "a.py", RIGHT))
    direct = SimpleNamespace(
        ask=lambda job, lab: graders.grade_job(graders.sendable(job), lab.folder)
    )
    assert key in direct.ask(cohort.job(entry), cohort.lab)
    if key == "error":
        with pytest.raises(GraderError, match="no room"):
            _one(cohort, entry, direct)
    else:
        report = _one(cohort, entry, direct)
        assert (
            "ValueError: strange" in report.ungraded
            and report.checks == ()
            and not cohort.file(entry, ".json").exists()
        )


def test_a_file_replaced_while_it_is_graded_is_graded_again(labs, folder, tmp_path, monkeypatch):
    entry = Entry("a", written(folder / "a.py", SHIFTED))
    cohort = begin(Cohort(find_lab("elbow", labs), tmp_path / "out", "s", None, "process", None))
    run = graded.run_checks
    monkeypatch.setattr(
        graded, "run_checks", lambda *a: entry.path.write_text(RIGHT, encoding="utf-8") and run(*a)
    )
    report = grade(cohort.lab, Job(entry.path, "a", "s", cohort.job(entry).robot))
    written(cohort.file(entry, ".json"), json.dumps(report.as_json()))
    assert report.points < report.max_points and cohort.done(entry) is None
    entry.path.write_text(SHIFTED, encoding="utf-8")
    assert cohort.done(entry).points == report.points


def test_an_enormous_file_is_refused_without_reading_it(tmp_path):
    with open(tmp_path / "a.py", "wb") as file:
        file.truncate(1 << 40)
    assert graded.file_hash(tmp_path / "a.py") == ""


@pytest.mark.deep
def test_a_graders_process_that_dies_costs_one_student(labs, folder, tmp_path, capsys):
    """The lab itself kills the process that grades: only for one student, who has no points, not 0."""
    tests = labs / "elbow" / "test_lab.py"
    code = "import os\n    if abs(ask.call('elbow', 0.0)[0] - 7) < 1:\n        os.kill(os.getpid(), 9)\n"
    tests.write_text(
        tests.read_text("utf-8") + f"\n\ndef test_deadly(ask):\n    {code}", encoding="utf-8"
    )
    written(folder / "a.py", RIGHT)
    written(folder / "b.py", RIGHT.replace("-d / 2 +", "7 +"))
    written(folder / "c.py", RIGHT)
    cohort = begin(Cohort(find_lab("elbow", labs), tmp_path / "out", "s", None, "process", None))
    a, b, c = run_cohort(cohort, entries_in(folder, cohort.lab), 2)
    assert a.points == c.points == 5 and b.checks == () and "killed, 3 times" in trouble_of(b)
    assert points(tmp_path / "out") == {"a": 5, "c": 5}
    assert main(command(labs, folder, tmp_path / "out")) == 1
    printed = capsys.readouterr()
    assert (
        "2 of 3 are graded already" in printed.err
        and "1 of 3 not graded: b; run it again" in printed.err
    )
    assert "elbow: 2 students" in printed.out
    _, row_a, row_b, _ = (tmp_path / "out" / "marks.csv").read_text("utf-8-sig").splitlines()
    assert row_a.startswith("a,5,,5,5,graded,") and row_b.startswith("b,,,,5,not graded: elbow,")
    assert "NOT GRADED: " in row_b
    assert "Not graded: run it again" in (tmp_path / "out" / "summary.html").read_text("utf-8")


@pytest.mark.deep
def test_hidden_inputs_are_the_same_for_all_and_a_grade_is_had_again(
    labs, folder, tmp_path, capsys
):
    written(folder / "anna.py", SHIFTED)
    written(folder / "ben.py", SHIFTED)
    out = tmp_path / "out"
    assert main(command(labs, folder, out)) == 0
    anna, ben = (
        json.loads((out / "students" / f"{name}.json").read_text("utf-8"))
        for name in ("anna", "ben")
    )
    assert [check["asked"] for check in anna["checks"]] == [
        check["asked"] for check in ben["checks"]
    ]
    capsys.readouterr()
    again = [
        "grade",
        "elbow",
        str(folder / "anna.py"),
        "--labs",
        str(labs),
        "--seed",
        anna["seed"],
        "--json",
    ]
    assert main(again) == 0
    data = json.loads(capsys.readouterr().out)
    for check in anna["checks"]:
        del check["figure"]
    assert {**data, "seconds": 0} == {**anna, "seconds": 0}
    assert anna["seed"] not in (out / "students" / "anna.html").read_text("utf-8")
