"""Who computes: a process pool of our own, or any executor of the standard library's kind, Dask's
unchanged.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from ..base.checks import shown
from ..base.processes import end_with_parent

AHEAD = 2  # chunks per processor, here or there, in hand at a time: what a kill can cost
PATIENCE = 10.0  # s between two looks at a cluster that gives nothing back
TRIES = 2  # times that our own pool is begun anew without a chunk done in between


class ExecutorDied(RuntimeError):
    """Whoever computed is gone."""


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of a Dask cluster, "tcp://host:8786" or the scheduler's file; needs the extra
    `scale`.
    """
    try:
        from dask.distributed import Client
    except ImportError:
        raise RuntimeError("--dask takes two more packages: pip install dask distributed") from None
    try:
        client = Client(
            **({"scheduler_file": address} if address.endswith(".json") else {"address": address}),
            timeout=10,
        )
    except (OSError, ValueError, TypeError) as error:
        raise RuntimeError(f"--dask {address}: no scheduler answers there ({error})") from None
    try:
        yield client.get_executor()
    finally:
        client.close(timeout=5)


def computed(
    compute: Callable,
    tasks: Iterator[tuple[int, Any]],
    executor: Executor | None,
    workers: int | None = None,
) -> Iterator[tuple[int, Any]]:
    """(number, compute(task)) of (number, task), as they come: in any order, few handed out at a
    time.

    executor: None is a pool of our own with so many workers, begun anew where one of them is
        killed.
    """
    if executor is not None:
        yield from _by(executor, compute, tasks, {})
        return
    workers = workers or _processors()
    if workers == 1:
        yield from ((number, compute(task)) for number, task in tasks)
        return
    if multiprocessing.get_start_method() != "fork":
        _must_travel(compute)
    left, fruitless = {}, 0
    while True:
        theirs, leash = multiprocessing.Pipe(duplex=False)
        with ProcessPoolExecutor(
            workers, initializer=_begin, initargs=(compute, theirs, leash)
        ) as pool:
            try:
                for done in _by(pool, _do, tasks, left):
                    fruitless = 0
                    yield done
                return
            except ExecutorDied as error:
                fruitless += 1
                if fruitless > TRIES:
                    hint = f"the chunks in hand were {', '.join(map(str, sorted(left)[:workers]))}"
                    raise ExecutorDied(
                        f"{error}; {fruitless} times without a chunk done in between: {hint}"
                    ) from None
            finally:
                # Else an interrupt would wait for the chunks in hand, and a second one for ever.
                leash.close()
                theirs.close()


def must_execute(executor: Any) -> None:
    """TypeError for what is no executor."""
    if executor is not None and not all(
        callable(getattr(executor, name, None)) for name in ("submit", "shutdown")
    ):
        raise TypeError(f"executor must be a concurrent.futures.Executor, not {shown(executor)}")


def processors(executor: Executor) -> int:
    """How many things a pool or a cluster does at a time; 1 where it does not say."""
    client = getattr(executor, "_client", None)
    if hasattr(client, "nthreads"):
        return max(1, sum(client.nthreads().values()))
    return getattr(executor, "_max_workers", 1)


def _processors():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _must_travel(compute):
    try:
        pickle.dumps(compute)
    except Exception as error:  # whatever somebody's own object raises when it is packed
        raise _unsent(error) from None


def _unsent(error):
    return ValueError(
        f"figure: it cannot be sent to another process ({error}): write it with def, not lambda, at"
        " the top of a file or cell; or give executor=None or ThreadPoolExecutor()"
    )


def _begin(compute, theirs, leash):
    """A worker has its work from its start, inherited where it is forked, and ends when the leash
    is let go.
    """
    global _compute
    _compute = compute
    leash.close()  # its own copy
    end_with_parent(leash=theirs)


def _do(task):
    return _compute(task)


def _by(executor, compute, tasks, left):
    """As `computed`; `left` keeps number -> task of what has been handed out and is not done."""
    ahead = AHEAD * max(_processors(), processors(executor))
    futures = {}

    def hand_out(number, task):
        left[number] = task
        try:
            futures[executor.submit(compute, task)] = number
        except BrokenProcessPool:
            raise ExecutorDied(
                "a worker process was killed (is the machine out of memory?)"
            ) from None
        except RuntimeError as error:  # shut down, or its cluster closed
            raise ExecutorDied(f"the executor takes no more work: {error}") from None

    try:
        for number, task in list(left.items()):
            hand_out(number, task)
        for number, task in tasks:
            hand_out(number, task)
            if len(futures) >= ahead:
                yield from _some(futures, left, executor)
        while futures:
            yield from _some(futures, left, executor)
    finally:
        for future in futures:
            future.cancel()


def _some(futures, left, executor):
    waited = 0
    while not (done := wait(futures, PATIENCE, FIRST_COMPLETED).done):
        waited = waited + 1 if _deserted(executor) else 0
        if waited == 2:
            raise ExecutorDied("the cluster has had no worker or no scheduler for a while")
    # What is done first, so that one that died takes nothing along.
    for future in sorted(
        done, key=lambda each: (each.cancelled() or each.exception() is not None, futures[each])
    ):
        number = futures.pop(future)
        try:
            result = future.result()
        except BrokenProcessPool:
            raise ExecutorDied(
                "a worker process was killed (is the machine out of memory?)"
            ) from None
        except CancelledError:
            raise ExecutorDied(
                f"the executor gave up chunk {number}: its workers or its scheduler are gone"
            ) from None
        except Exception as error:
            if type(error).__module__.startswith(("distributed", "dask")):
                raise ExecutorDied(
                    f"the executor gave up chunk {number}: {type(error).__name__}: {error}"
                ) from None
            if isinstance(error, pickle.PicklingError) or "pickle" in str(error):
                raise _unsent(error) from None
            raise
        left.pop(number)
        yield number, result


def _deserted(executor):
    """Whether a Dask cluster has nobody to compute: it would wait for ever for somebody to come."""
    client = getattr(executor, "_client", None)
    if client is None or not hasattr(client, "nthreads"):
        return False
    try:
        return client.status != "running" or not client.nthreads()
    except Exception:  # whatever a lost connection raises
        return True
