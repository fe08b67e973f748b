"""kill -9 of the grader, of its processes and of students' workers, at random moments: nothing lost, wrong or left."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fivebar.grading.worker.places import bwrap_trouble
from tests.helpers import ROOT
from tests.helpers.needs import need

from ..helpers.grading_lab import RIGHT, SHIFTED, write_lab, written
from ..helpers.processes import descendants

ROUNDS = 150 if os.environ.get("FIVEBAR_NIGHTLY") else 6  # a third of each kind
STUDENTS = 10
PACE = RIGHT.replace("    return", "    for _ in range(200_000):\n        pass\n    return")


def victims(pid, kind):
    """Processes that a killer of this kind may choose: the grader itself, its processes, students' workers."""
    if kind == "grader":
        return [pid]
    below = descendants(pid)
    workers = {p for p, line in below.items() if b"grading/worker/cell" in line or b"/cell" in line}
    loops = {p for p, line in below.items() if b"multiprocessing-fork" in line} - workers
    return sorted(loops if kind == "process" else workers)


def alive(mark):
    """Processes with the mark in their environment or, of a confined worker, on their command line."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            state = (place / "stat").read_text("utf-8").rpartition(")")[2].split()[0]
            if state != "Z" and mark.encode() in (place / "environ").read_bytes():
                found.append(place.name)
        except OSError:
            continue
    return found


@pytest.mark.deep
@pytest.mark.parametrize("isolate", ["process", "bwrap"])
def test_nothing_is_lost_or_kept_wrong_and_nothing_is_left(tmp_path, isolate):
    if isolate == "bwrap" and bwrap_trouble():
        need("bubblewrap")
    draw, temporary = random.Random(isolate), tmp_path / "temporary"
    temporary.mkdir()
    labs, folder = write_lab(tmp_path / "mylabs"), tmp_path / "submissions"
    wanted = {}
    for k in range(STUDENTS):
        written(folder / f"s{k}.py", PACE if k % 2 else SHIFTED)
        wanted[f"s{k}"] = 4 if k % 2 else 1
    mark = f"killed-{os.getpid()}-{draw.random()}"
    environment = os.environ | {"TMPDIR": str(temporary), "KILLED_MARK": mark}
    struck = dict.fromkeys(("grader", "process", "worker"), 0)
    while sum(struck.values()) < ROUNDS:
        out = tmp_path / f"out{sum(struck.values())}"
        command = [
            sys.executable,
            "-m",
            "fivebar",
            "grade",
            "elbow",
            str(folder),
            "--labs",
            str(labs),
        ]
        command += ["--out", str(out), "--isolate", isolate, "--jobs", "2"]
        code = None
        while code != 0:  # the same command goes on until all is graded
            run = subprocess.Popen(
                command,
                cwd=ROOT,
                env=environment,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
            )
            time.sleep(0.3)
            while run.poll() is None and sum(struck.values()) < ROUNDS:
                time.sleep(draw.uniform(0, 0.4))
                kind = min(struck, key=lambda kind: (struck[kind], draw.random()))
                if chosen := victims(run.pid, kind):
                    try:
                        os.kill(draw.choice(chosen), signal.SIGKILL)
                        struck[kind] += 1
                    except ProcessLookupError:
                        pass  # it ended meanwhile
            err = run.communicate(timeout=120)[1].decode()
            code = run.returncode
            assert code in (0, 1, -9), err
            # Killed, Python itself may tell of a process that was just being started.
            assert code == -9 or "Traceback" not in err, err
            for path in (out / "students").glob("s*.json"):
                kept = json.loads(path.read_text("utf-8"))
                assert (
                    kept["points"] == wanted[path.stem]
                    and not kept["trouble"]
                    and not kept["faults"]
                ), kept
        assert {path.stem for path in (out / "students").glob("*.json")} == set(wanted)
        assert [path.name for path in out.rglob(".*")] == []
    end = time.monotonic() + 60
    while left := alive(mark):
        assert time.monotonic() < end, [Path(f"/proc/{pid}/cmdline").read_bytes() for pid in left]
        time.sleep(0.1)
    assert list(temporary.iterdir()) == []
    print(isolate, struck)
