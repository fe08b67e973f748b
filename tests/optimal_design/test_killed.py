"""kill -9 of a worker or of the driver in the middle of a sweep: nothing lost but the chunks in hand, nothing twice.

With FIVEBAR_NIGHTLY=1 fifty times.
"""

import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.progress import progress
from fivebar.base.shards import read_chunk
from fivebar.base.workers import WorkerPool, compute_chunks
from tests.helpers import ROOT

KILLS = (
    range(50) if os.environ.get("FIVEBAR_NIGHTLY") else [0, pytest.param(1, marks=pytest.mark.deep)]
)
DESIGNS, CHUNK, WORKERS = 60, 2, 2
PATIENCE = 120  # s: no measure of speed, but an end
IN_HAND = 2 * max(WORKERS, os.cpu_count()) + 1  # chunks, and the one that is being written
PROGRAM = f"""
import os, sys, time
import fivebar as fb

def slow(robot):
    with open(sys.argv[2], "a") as log:
        log.write(f"{{robot.l11!r}} {{os.getpid()}}\\n")
    while os.path.exists(sys.argv[2] + ".held") and len(open(sys.argv[2]).readlines()) >= int(sys.argv[3]):
        time.sleep(0.002)
    return robot.l11 + robot.l12

fb.sweep(slow, fb.optimal_design.grid(dict(l1=[0.1 + k / 1000 for k in range({DESIGNS})])), out=sys.argv[1], workers={WORKERS},
         chunk={CHUNK})
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    file = tmp_path_factory.mktemp("killed") / "slow.py"
    file.write_text(PROGRAM, encoding="utf-8")
    return file


def begun(program, out, log, until=DESIGNS):
    """A run; while there is `held(log)`, its workers wait when so many designs are begun."""
    command = [sys.executable, program, out, log, str(until)]
    return subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)


def held(log):
    return log.with_name(log.name + ".held")


def finish(run):
    notes = run.communicate(timeout=PATIENCE)[1]
    assert (run.returncode, notes) == (0, "")


def lines(log):
    return [line.split() for line in log.read_text("utf-8").splitlines()] if log.exists() else []


def done(out):
    """Designs in the chunks on disk."""
    chunks = [read_chunk(path, "sweep") for path in sorted(out.glob("chunk-*.npz"))]
    return {repr(float(x)) for chunk in chunks for x in chunk.rows.ravel()}


def bytes_of(out):
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


@pytest.fixture(scope="module")
def whole(program, tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "out"
    run = begun(program, out, out.parent / "log")
    finish(run)
    return bytes_of(out)


def on_the_way(kill, program, out, log):
    """A run of which some designs are done, and whose workers wait."""
    wanted = int(np.random.default_rng(kill).integers(1, DESIGNS - 2 * CHUNK))
    held(log).touch()
    run, end = begun(program, out, log, wanted), time.monotonic() + PATIENCE
    while len(lines(log)) < wanted:
        assert time.monotonic() < end and run.poll() is None
        time.sleep(0.002)
    return run


@pytest.mark.deep
@pytest.mark.parametrize("kill", KILLS)
def test_a_killed_driver(kill, program, whole, tmp_path):
    out, log = tmp_path / "out", tmp_path / "log"
    run = on_the_way(kill, program, out, log)
    run.kill()
    held(log).unlink()
    run.communicate()
    workers = {int(pid) for _, pid in lines(log)}
    end = time.monotonic() + PATIENCE
    while any(os.path.exists(f"/proc/{pid}") and not zombie(pid) for pid in workers):
        assert time.monotonic() < end, "a worker outlives its driver"
        time.sleep(0.01)
    kept, before = done(out), len(lines(log))
    assert before - len(kept) <= IN_HAND * CHUNK
    again = begun(program, out, log)
    finish(again)
    counts = Counter(name for name, _ in lines(log))
    assert {counts[name] for name in kept} <= {1}
    assert len(lines(log)) - before == DESIGNS - len(kept)
    assert bytes_of(out) == whole


@pytest.mark.deep
@pytest.mark.parametrize("kill", KILLS)
def test_a_killed_worker(kill, program, whole, tmp_path):
    out, log = tmp_path / "out", tmp_path / "log"
    run = on_the_way(kill, program, out, log)
    kept = done(out)
    os.kill(int(lines(log)[-1][1]), signal.SIGKILL)
    held(log).unlink()
    finish(run)
    counts = Counter(name for name, _ in lines(log))
    assert {counts[name] for name in kept} <= {1}
    assert sum(counts.values()) - DESIGNS <= IN_HAND * CHUNK
    assert bytes_of(out) == whole


def zombie(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return re.search(r"\) (\w)", file.read())[1] == "Z"
    except FileNotFoundError:
        return True


def test_a_design_that_kills_its_worker_every_time_is_named(tmp_path):
    with pytest.raises(
        RuntimeError, match=r"killed.*3 times without a chunk.*the chunks in hand were .*goes on"
    ):
        fb.sweep(fatal, {"l1": [0.1, 0.11]}, out=tmp_path / "out", workers=2, chunk=1)


def fatal(robot):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_killed_worker_keeps_no_lock_of_the_bars():
    in_a_bar([])  # Workers that are forked now share what locks there are.
    with WorkerPool(1, "fork") as pool, pytest.raises(BrokenProcessPool):
        pool.submit(killed_at_the_bar).result(timeout=PATIENCE)
    with WorkerPool(1, "fork") as pool:
        assert pool.submit(in_a_bar, range(3)).result(timeout=PATIENCE) == [0, 1, 2]


def in_a_bar(iterable):
    return list(progress(iterable))


def killed_at_the_bar():
    with progress().get_lock():
        os.kill(os.getpid(), signal.SIGKILL)


def test_an_interrupt_waits_for_no_chunk_in_hand():
    done, before = (
        compute_chunks(time.sleep, enumerate([0.0, 600.0, 600.0, 600.0]), None, workers=2),
        time.monotonic(),
    )
    assert next(done) == (0, None)
    done.close()
    assert time.monotonic() - before < 300


@pytest.mark.parametrize("start_method", ["fork", "spawn"])
def test_a_job_that_hangs_can_be_killed(start_method):
    pool = WorkerPool(1, start_method)
    assert pool.submit(abs, -1).result() == 1
    hanging = pool.submit(time.sleep, 600.0)
    with pytest.raises(TimeoutError):
        hanging.result(timeout=0.05)
    pool.kill()
    with pytest.raises(BrokenProcessPool):
        hanging.result(timeout=PATIENCE)
