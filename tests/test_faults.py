"""Faults of machines and hands: full disks, interrupts, kills, two at once, streams that nobody reads.

Whatever happens, a file has its final name only when it is whole, and what had the name before stays.
"""

import contextlib
import multiprocessing
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time

import pytest

import fivebar as fb
from fivebar.base.folders import locked_folder
from fivebar.base.tables import is_part
from fivebar.base.workers import end_with_parent
from fivebar.cli import main
from fivebar.study.speed_accuracy.store import Partial
from tests.helpers import ROOT
from tests.helpers.commands import SAME, python, with_files
from tests.helpers.needs import need
from tests.helpers.writers import DIRECT, LINE, ROBOT, writers, writing_functions

NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))
ROUNDS = 60 if NIGHTLY else 3
WRITERS = writers()


@pytest.mark.deep
def test_files_are_written_by_what_gives_them_their_name_last():
    assert writing_functions() == set(DIRECT), (
        "use tables.written, saved or replaced, or say in helpers/writers.py why not"
    )


@contextlib.contextmanager
def little_room(size):
    """No file may become larger; what a full disk says, without the rights to mount one."""
    before, handler = (
        resource.getrlimit(resource.RLIMIT_FSIZE),
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
    )
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.deep
@pytest.mark.parametrize("name", WRITERS)
def test_no_room_leaves_what_was_there(name, tmp_path):
    write, file = WRITERS[name]
    path = tmp_path / file
    path.write_bytes(b"before")
    with little_room(30), pytest.raises(OSError, match="too large|No space"):
        write(path)
    assert path.read_bytes() == b"before" and list(tmp_path.iterdir()) == [path]
    write(path)
    assert path.stat().st_size > 30 and list(tmp_path.iterdir()) == [path]


FULL = ["track", "--from", "0.09", "0.068", "--to", "0", "0.1", "--duration", "1", "--out"]


@pytest.mark.deep
def test_a_full_disk_is_said_and_leaves_nothing(tmp_path):
    need("bubblewrap")
    place = tmp_path / "disk"
    place.mkdir()
    inside = f'"{sys.executable}" -m fivebar {" ".join(FULL)} {place}/run; echo "code $?"; ls -A {place}/run'
    run = subprocess.run(
        ["bwrap", "--dev-bind", "/", "/", "--size", "8192", "--tmpfs", place, "sh", "-c", inside],
        cwd=ROOT,
        text=True,
        capture_output=True,
        timeout=60,
    )
    assert "run.csv: No space left on device" in run.stderr and "Traceback" not in run.stderr, (
        run.stderr
    )
    assert run.stdout.endswith("code 1\n"), run.stdout


def test_measurements_end_with_the_disk_and_go_on_with_another(tmp_path):
    partial = Partial(tmp_path / "a.jsonl", {})
    rows = [{"problem": "p", "method": "m", "knob": k} for k in range(3)]
    with little_room(100), pytest.raises(OSError, match="a.jsonl"):
        for row in rows:
            partial.add(row)
    assert Partial(tmp_path / "a.jsonl", {}).rows == rows[:2]


@pytest.mark.deep
def test_a_folder_that_may_not_be_written(tmp_path):
    need("bubblewrap")
    inside = f'"{sys.executable}" -m fivebar {" ".join(FULL)} {tmp_path}/run'
    run = subprocess.run(
        ["bwrap", "--dev-bind", "/", "/", "--ro-bind", tmp_path, tmp_path, "sh", "-c", inside],
        cwd=ROOT,
        text=True,
        capture_output=True,
        timeout=60,
    )
    assert run.returncode == 1 and "Read-only" in run.stderr and "Traceback" not in run.stderr, (
        run.stderr
    )


# Two at once

INTO = {
    "chart": ["chart", "geometry", "--quick"],
    "sweep": ["sweep", "bars", "--grid", "l1=0.1:0.2:3"],
    "grading": ["grade", "lab1", str(ROOT / "tests/data/hand_ins")],
}


@pytest.mark.parametrize("what", INTO)
def test_a_folder_of_results_has_one_writer_at_a_time(what, tmp_path, capsys, monkeypatch):
    killed, theirs = tmp_path / f".{'x' * 40}.123-4.part", tmp_path / "film.part"
    killed.touch(), theirs.touch()
    with locked_folder(tmp_path, what):
        assert main([*INTO[what], "--out", str(tmp_path)]) == 2
        assert (
            f"another {what} writes to {tmp_path}: wait for its end, or give another\n"
            in capsys.readouterr().err
        )
        assert theirs.exists() and not killed.exists()
    monkeypatch.setattr(
        "fivebar.base.folders.fcntl.flock", lambda *_: os.listdir(tmp_path / "none")
    )  # no locks here
    with locked_folder(tmp_path, what), locked_folder(tmp_path, what):
        (tmp_path / "file").touch()
    assert main([*INTO[what], "--out", str(tmp_path / "file")]) == 2
    assert f"{tmp_path / 'file'} is a file, not a folder" in capsys.readouterr().err


def test_a_process_whose_parent_is_killed_ends(monkeypatch):
    ended = threading.Event()
    reader, writer = multiprocessing.Pipe(duplex=False)
    monkeypatch.setattr(os, "_exit", lambda code: ended.set())
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    end_with_parent(reader)
    assert not ended.wait(0.05)
    writer.close()
    assert ended.wait(60)
    reader.close()


# Streams


def into(name, mode="w"):
    """A file that a stream goes to, or its closed pipe."""
    if name != "pipe":
        return open(name, mode)
    read, write = os.pipe()
    os.close(read)
    return os.fdopen(write, mode)


@pytest.mark.parametrize(
    "words", [["design", "--list"], ["--help"], ["sweep", "bars", "--grid", "l1=0.1:0.2:400"]]
)
@pytest.mark.parametrize("name", ["/dev/full", "pipe"])
def test_what_nobody_reads_is_a_failure_and_said_once(name, words, monkeypatch, capfd):
    """Python keeps 8 kB back, and would fail with them at its end: "Exception ignored", exit code 120."""
    with into(name) as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        assert main(words) == 1
        stream.write("more"), stream.flush()  # to nowhere, now
    assert capfd.readouterr().err == (
        "" if name == "pipe" else "fivebar: stdout: No space left on device\n"
    )


@pytest.mark.parametrize("name", ["/dev/full", "pipe"])
@pytest.mark.parametrize(
    "words, code", [(["track", "none.csv"], 2), (["track"], 2), (["export", "--ou"], 2)]
)
def test_messages_that_nobody_reads_change_no_exit_code(name, words, code, monkeypatch):
    with into(name) as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        try:
            assert main(words) == code
        except SystemExit as end:
            assert end.code == code


def test_messages_of_a_closed_stderr_are_no_data(monkeypatch, capsys):
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(sys, name, None)
    assert main(["track"]) == 2
    for name in ("stdin", "stdout", "stderr"):
        getattr(sys, name).close()
    assert capsys.readouterr() == ("", "")


# Interrupts and kills

WRITING = """import sys, fivebar as fb
run = fb.simulate(fb.FiveBar(), fb.ComputedTorque(fb.FiveBar(), 100, 20), fb.line((0.09, 0.068), (0.08, 0.075), 2.0))
print("ready", flush=True)
while True:
    run.to_csv(sys.argv[1])"""


@pytest.mark.deep
def test_a_killed_writer_leaves_a_whole_file(tmp_path):
    draw, path = random.Random(1), tmp_path / "run.csv"
    with (
        python(["-c", WRITING], path, cwd=ROOT) as one,
        python(["-c", WRITING], path, cwd=ROOT) as other,
    ):
        for each in (one, other):  # two processes with one output
            assert each.stdout.readline() == "ready\n"
        while not path.exists():  # however slow they are
            assert one.poll() is None and other.poll() is None
            time.sleep(0.01)
        for _ in range(ROUNDS):
            time.sleep(draw.uniform(0.01, 0.2))
            assert len(fb.Run.from_csv(path).t) == 2001
        one.kill(), other.kill()
    assert len(fb.Run.from_csv(path).t) == 2001
    assert all(is_part(left.name) for left in tmp_path.iterdir() if left != path)


def test_two_threads_with_one_output(tmp_path):
    run, faults = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE), []

    def write():
        try:
            for _ in range(10):
                run.to_csv(tmp_path / "run.csv")
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=write) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert not faults and len(fb.Run.from_csv(tmp_path / "run.csv").t) == len(run.t)
    assert len(list(tmp_path.iterdir())) == 1


def test_an_interrupt_while_numpy_is_imported_is_no_traceback(tmp_path):
    """NumPy cannot be imported again then, and the message needs none of it."""
    (tmp_path / "numpy.py").write_text("raise KeyboardInterrupt\n", encoding="utf-8")
    code = "import sys; from fivebar.cli import main; sys.exit(main())"
    run = subprocess.run(
        [sys.executable, "-c", code, "design", "--help"],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (130, "fivebar: interrupted\n")


@pytest.mark.deep
def test_an_interrupt_at_any_time_says_so_and_leaves_nothing_half(tmp_path):
    draw = random.Random(2)
    with_files(tmp_path)
    commands = [
        ["map", "--out", "a.png"],
        ["track", "--case", "task-1", "--out", "b"],
        [
            "plan",
            "--from",
            "0.09",
            "0.068",
            "--to",
            "0.08",
            "0.075",
            "--duration",
            "0.5",
            "--out",
            "d",
        ],
        [*FULL, "c"],
        *SAME,
        ["draw", "path.csv", "--out", "e"],
        [
            "design",
            "workspace_area",
            "bars",
            "--bound",
            "l1=0.05:0.3",
            "--bound",
            "l2=0.05:0.3",
            "--out",
            "f",
        ],
        ["chart", "chip", "--quick", "--out", "g"],
        ["study", "ladder", "--robots", "lab", "--out", "h"],
        ["sweep", "dexterous_area", "--grid", "l1=0.1:0.2:40", "--workers", "2", "--out", "i"],
        [*INTO["grading"], "--jobs", "2", "--out", "j"],
        ["export", "--format", "mjcf", "--out", "l"],
        ["calibrate", "poses.csv", "--out", "k"],
    ]
    for k in range(ROUNDS):
        with python(
            ["-m", "fivebar"],
            *commands[k % len(commands)],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            start_new_session=True,
        ) as run:
            # By then the interpreter has begun with our own code, or nearly.
            time.sleep(0.1 + draw.uniform(0, 3.0 if NIGHTLY else 1.3))
            with contextlib.suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGINT)  # as a terminal does: to it and all that it began
            _, err = run.communicate(timeout=120)
        if run.returncode != 0:  # it was not done before
            assert run.returncode in (1, 130, -signal.SIGINT)
            # Before `main` has begun, the interpreter itself may still be loading, and says it in its own way.
            assert "Traceback" not in err or ", in main" not in err, err
        for path in tmp_path.rglob("*"):
            assert path.is_dir() or path.stat().st_size > 0 and not is_part(path.name), path
