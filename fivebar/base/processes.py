"""Processes that this one starts."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait


@contextmanager
def without_interrupts() -> Iterator[None]:
    """What is started meanwhile hears no Ctrl-C from its first moment on; who starts it hears it
    after.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # which would unblock it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_with_parent(room: str | None = None, leash: Connection | None = None) -> None:
    """Said by a process of `multiprocessing`: that it ends when who started it is killed, and not
    by Ctrl-C.

    The pipe or queue that it reads would tell it late, or never. room: a folder to take along;
    leash: a pipe whose other end, when it is closed, ends the process too, whatever it is at.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    ends = [end for end in (parent and parent.sentinel, leash) if end is not None]
    if ends:
        threading.Thread(target=_end_after, args=(ends, room), daemon=True).start()


def _end_after(ends, room):
    wait(ends)
    if room:
        shutil.rmtree(room, ignore_errors=True)
    os._exit(1)
