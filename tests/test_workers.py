"""Pools that several threads end, and what executors of other packages raise when their cluster goes away."""

import signal
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Barrier
from types import ModuleType

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.workers import WorkerPool, WorkersDied, compute_chunks, first_done

CASCADE = "def cascade(result):\n    typ, exc, tb = result\n    raise exc.with_traceback(tb)\n"


class Cluster:
    """An executor whose futures end as those of distributed do when the cluster goes away."""

    def __init__(self, lost):
        self.lost = lost
        self.count = 0

    def submit(self, compute, chunk):
        future = Future()
        self.count += 1
        try:
            if self.count > 2:
                self.lost(compute, chunk)
            future.set_result(compute(chunk))
        except Exception as error:
            future.set_exception(error)
        return future

    def shutdown(self):
        """Nothing is to be closed."""


def cascade(compute, chunk):
    """A result that arrives while its future is cancelled, in the module that takes it for an exception."""
    module = ModuleType("distributed.cfexecutor")
    exec(CASCADE, module.__dict__)
    module.cascade((0, np.zeros(3), None))


def own(compute, chunk):
    raise AttributeError("'numpy.ndarray' object has no attribute 'length'")


def test_whatever_a_lost_cluster_raises_the_workers_died():
    done = []
    with pytest.raises(WorkersDied, match=r"gave up chunk \d.*with_traceback"):
        done.extend(compute_chunks(abs, enumerate([-1.0] * 5), Cluster(cascade)))
    assert not done or set(done) <= {(0, 1.0), (1, 1.0)}


def test_an_error_of_the_work_is_its_own():
    with pytest.raises(AttributeError, match="no attribute 'length'"):
        list(compute_chunks(abs, enumerate([-1.0] * 5), Cluster(own)))


def test_a_sweep_on_a_lost_cluster_keeps_what_was_done(tmp_path):
    designs = {"l1": [0.1 + k / 100 for k in range(4)]}
    out = tmp_path / "out"
    with pytest.raises(RuntimeError, match="goes on from there"):
        fb.sweep("bars", designs, executor=Cluster(cascade), out=out, chunk=1)
    assert len(list(out.glob("chunk-*.npz"))) == 2
    assert fb.sweep("bars", designs, out=out, chunk=1).count == 4


class SlowToLoad:
    """An argument that takes long to arrive in a worker, as modules that it loads do."""

    def __reduce__(self):
        return time.sleep, (60.0,)


def test_a_worker_that_still_loads_is_killed_at_once():
    pool = WorkerPool(1, "spawn", abs, (SlowToLoad(),))
    pool.submit(abs, -1)
    time.sleep(0.5)
    before = time.monotonic()
    pool.kill()
    assert time.monotonic() - before < 10


def test_threads_may_kill_one_pool_at_the_same_time():
    """The grader's main thread does on Ctrl-C, and so does each thread that waits for a result."""
    for _ in range(30):
        pool = WorkerPool(1, "fork")
        pool.submit(time.sleep, 60.0)
        barrier = Barrier(4)

        def kill(_, pool=pool, barrier=barrier):
            barrier.wait()
            pool.kill()

        with ThreadPoolExecutor(4) as threads:
            list(threads.map(kill, range(4)))


def test_an_interrupt_that_another_thread_receives_ends_the_wait():
    """A busy machine gives Ctrl-C at a moment in which it does not end the wait for a lock."""
    threading.Timer(0.2, lambda: signal.pthread_kill(threading.get_ident(), signal.SIGINT)).start()
    before = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        first_done([Future()])
    assert time.monotonic() - before < 10
