"""Worker processes: run chunks of work in this process, in a pool, or on Dask.

`compute_chunks` is all that a sweep or a search needs. `WorkerPool` is what a caller needs that
sends single jobs and must end one that takes too long::

    pool = WorkerPool(1, start_method="spawn", initializer=prepare, initargs=(settings,))
    future = pool.submit(job, argument)
    try:
        result = future.result(timeout=10)
    except TimeoutError:
        pool.kill()  # the job, too; then make another pool
    except BrokenProcessPool:
        ...  # the job ended its worker
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
import warnings
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import connection, resource_tracker
from typing import Any

from .checks import shown

KILLED = "a worker process was killed (is the machine out of memory?)"
WAKES = 0.5  # s, between two looks of a thread that waits
DESERTED = 40  # looks at a cluster without workers, after which it is given up


class WorkersDied(RuntimeError):
    """The workers, or the cluster, are gone before all work was done."""


def compute_chunks(
    compute: Callable[[Any], Any],
    chunks: Iterator[tuple[int, Any]],
    executor: Executor | None = None,
    workers: int | None = None,
) -> Iterator[tuple[int, Any]]:
    """Yield (number, compute(chunk)) for each (number, chunk), as they are done, in any order.

    Few chunks are handed out at a time. Where the generator is closed early, by Ctrl-C for
    instance, the chunks at work are given up at once.

    Parameters
    ----------
    compute
        Runs on each chunk. Forked workers inherit it; elsewhere it must be possible to pickle it.
    chunks
        Numbers, which may be of any order, and chunks; read only as far as needed.
    executor
        Any executor, such as Dask's; it remains the caller's. None: a pool of `workers`.
    workers
        Processes of the pool; 1 computes in this process; None: one per processor. A pool of
        which a worker is killed is begun anew, and computes the lost chunks again.

    Raises
    ------
    WorkersDied
        The executor is shut down, the cluster is gone, or workers die three times without a chunk
        done in between.
    ValueError
        `compute` cannot be sent to another process.
    """
    if executor is None:
        workers = workers or _processor_count()
        if workers == 1:
            for number, chunk in chunks:
                yield number, compute(chunk)
        else:
            yield from _compute_in_pools(compute, chunks, workers)
    else:
        if isinstance(executor, ProcessPoolExecutor):
            _check_pickles(compute)
        yield from _compute_by(executor, compute, chunks, {})


def first_done(futures: Collection[Future], executor: Executor | None = None) -> set[Future]:
    """Return the futures that are done, at least one.

    Raises WorkersDied where the executor is a cluster that has no worker for a while. It wakes
    again and again: Ctrl-C that another thread receives ends no wait of the main thread.
    """
    deserted = 0
    while not (done := wait(futures, WAKES, FIRST_COMPLETED).done):
        deserted = deserted + 1 if _is_deserted(executor) else 0
        if deserted == DESERTED:
            raise WorkersDied("the cluster has had no worker or no scheduler for a while")
    return done


def check_executor(executor: object) -> None:
    """Raise TypeError unless the argument is an executor or None."""
    if executor is not None and not (hasattr(executor, "submit") and hasattr(executor, "shutdown")):
        raise TypeError(f"executor must be a concurrent.futures.Executor, not {shown(executor)}")


def worker_count(executor: Executor) -> int:
    """Return how many chunks a pool or a cluster computes at a time, 1 where it is not known."""
    client = getattr(executor, "_client", None)
    if client is not None and hasattr(client, "nthreads"):
        return max(1, sum(client.nthreads().values()))
    return getattr(executor, "_max_workers", 1)


@contextmanager
def dask_executor(address: str | None) -> Iterator[Executor | None]:
    """Connect to a Dask cluster, by "tcp://host:8786" or the scheduler's JSON file; None: to
    none.
    """
    if not address:
        yield None
        return
    try:
        from dask.distributed import Client
    except ImportError:
        raise RuntimeError("--dask needs two more packages: pip install dask distributed") from None
    keyword = "scheduler_file" if address.endswith(".json") else "address"
    try:
        client = Client(**{keyword: address}, timeout=10)
    except (OSError, ValueError, TypeError) as error:
        raise RuntimeError(f"--dask {address}: no scheduler answers there ({error})") from None
    try:
        yield client.get_executor()
    finally:
        client.close(timeout=5)


class WorkerPool(ProcessPoolExecutor):
    """A process pool whose workers ignore Ctrl-C, and end at once when it is killed or left.

    They end with this process too, however that ends. Parameters as of ProcessPoolExecutor;
    start_method: "fork", "spawn" or None for the system's own.
    """

    def __init__(
        self,
        workers: int,
        start_method: str | None = None,
        initializer: Callable | None = None,
        initargs: tuple = (),
    ) -> None:
        context = multiprocessing.get_context(start_method)
        self._lock = threading.Lock()
        self._ends = context.Pipe(duplex=False)
        arguments = (self._ends, initializer, initargs)
        super().__init__(workers, context, _start_worker, arguments)

    def submit(self, *args: Any, **kwargs: Any) -> Any:
        # Processes are started here: none begins while another thread kills the pool.
        with without_interrupts(), self._lock, warnings.catch_warnings():
            # JAX warns of every fork, as its threads are not there afterwards: workers use none.
            warnings.filterwarnings("ignore", "os.fork", RuntimeWarning)
            return super().submit(*args, **kwargs)

    def kill(self) -> None:
        """End the workers at once, whatever they compute: their futures raise BrokenProcessPool.

        Several threads may call it.
        """
        with self._lock:  # Executor.shutdown closes a pipe twice where two threads call it.
            for end in self._ends:
                end.close()
            for process in list((self._processes or {}).values()):
                process.kill()  # A worker that still loads its modules does not watch the pipe.
            self.shutdown(cancel_futures=True)

    def __exit__(self, *_: object) -> None:
        self.kill()


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes that do not see Ctrl-C; this one sees it after the block."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # Its start would unblock the signal.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent(pipe: connection.Connection) -> None:
    """Ignore Ctrl-C in this process, and end it when the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end():
        connection.wait([pipe])
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()


def _start_worker(ends, initializer, initargs):
    reader, writer = ends
    writer.close()  # The worker's own copy would keep the pipe open.
    end_with_parent(reader)
    if initializer:
        initializer(*initargs)


def _set_compute(compute):
    global _compute
    _compute = compute


def _compute_one(chunk):
    return _compute(chunk)


def _compute_in_pools(compute, chunks, workers):
    """Compute chunks in a pool, and in another where a worker died."""
    if multiprocessing.get_start_method() != "fork":
        _check_pickles(compute)
    pending, deaths = {}, 0
    while True:
        try:
            with WorkerPool(workers, None, _set_compute, (compute,)) as pool:
                for result in _compute_by(pool, _compute_one, chunks, pending):
                    deaths = 0
                    yield result
            return
        except WorkersDied as error:
            deaths += 1
            if deaths == 3:
                hint = ", ".join(map(str, sorted(pending)[:workers]))
                raise WorkersDied(
                    f"{error}; 3 times without a chunk done in between: the chunks in hand were"
                    f" {hint}"
                ) from None


def _compute_by(executor, compute, chunks, pending):
    """Compute pending chunks, then others; pending: {number: chunk} of those not done."""
    # Two chunks a worker, so that none waits for its next one.
    most = 2 * max(_processor_count(), worker_count(executor))
    futures = {}

    def submit(number, chunk):
        pending[number] = chunk
        try:
            futures[executor.submit(compute, chunk)] = number
        except BrokenProcessPool:
            raise WorkersDied(KILLED) from None
        except RuntimeError as error:
            raise WorkersDied(f"the executor takes no more work: {error}") from None

    def collect():
        # Results first: the error of a chunk that died must not lose those that are done.
        for future in sorted(first_done(futures, executor), key=_has_failed):
            number = futures.pop(future)
            result = _result(future, number)
            del pending[number]
            yield number, result

    try:
        for number, chunk in list(pending.items()):
            submit(number, chunk)
        for number, chunk in chunks:
            submit(number, chunk)
            if len(futures) >= most:
                yield from collect()
        while futures:
            yield from collect()
    finally:
        for future in futures:
            future.cancel()


def _result(future, number):
    try:
        return future.result()
    except BrokenProcessPool:
        raise WorkersDied(KILLED) from None
    except CancelledError:
        raise WorkersDied(f"the executor gave up chunk {number}: its workers are gone") from None
    except Exception as error:
        if not _is_of_cluster(error):
            raise
        raise WorkersDied(f"the executor gave up chunk {number}: {error!r}") from None


def _is_of_cluster(error):
    """Return whether Dask raised it, and not what it computes.

    A cluster that goes away raises errors of any type: a result that comes while its future is
    cancelled is taken for an exception, and an array is none.
    """
    where = [type(error).__module__]
    if error.__traceback__:
        *_, (frame, _) = traceback.walk_tb(error.__traceback__)
        where.append(frame.f_globals.get("__name__", ""))
    return any(name.startswith(("distributed.", "dask.")) for name in where)


def _has_failed(future):
    return future.cancelled() or future.exception() is not None


def _is_deserted(executor):
    client = getattr(executor, "_client", None)
    if client is None:
        return False
    try:
        return client.status != "running" or not client.nthreads()
    except OSError:  # The connection is lost.
        return True


def _processor_count():
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _check_pickles(compute):
    try:
        pickle.dumps(compute)
    except Exception as error:  # Whatever a caller's own object raises when it is pickled.
        raise ValueError(
            f"the function cannot be sent to another process ({error}): write it with def, not"
            " lambda, at the top of a file; or give executor=ThreadPoolExecutor()"
        ) from None
