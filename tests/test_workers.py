"""What executors of other packages raise when their cluster goes away, and what is the work's own error."""

from concurrent.futures import Future
from types import ModuleType

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.workers import WorkersDied, compute_chunks

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
