"""Progress bars: on a terminal only; a pipe or a log gets none, and workers write none."""

from __future__ import annotations

from collections.abc import Iterable
from multiprocessing import parent_process
from threading import RLock
from typing import Any

from tqdm import tqdm


class _Bar(tqdm):
    monitor_interval = 0  # No thread that watches bars: IPOPT's time limit counts all threads.
    nrows: int | None

    def display(self, *arguments: Any, **options: Any) -> bool:
        if self.nrows == -1:  # A terminal that does not know its size, on which tqdm shows nothing.
            self.dynamic_ncols = self.ncols = self.nrows = None
        return super().display(*arguments, **options)


# tqdm's own lock is shared with workers: one that is killed while it holds it stops all bars.
_Bar.set_lock(RLock())


def progress(iterable: Iterable | None = None, **options: Any) -> tqdm:
    """Return tqdm(iterable, **options), which writes nothing where stderr is no terminal or in a
    worker process.
    """
    is_worker = parent_process() is not None  # several workers would tear each other's bars
    return _Bar(iterable, disable=is_worker or None, dynamic_ncols=True, **options)
