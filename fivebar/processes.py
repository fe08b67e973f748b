"""Processes that this one starts."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import threading
from multiprocessing.connection import Connection, wait


def end_with_parent(room: str | None = None, leash: Connection | None = None) -> None:
    """Said by a process of `multiprocessing`: that it ends when who started it is killed, and not by Ctrl-C.

    The pipe or queue that it reads would tell it late, or never. room: a folder to take along; leash: a pipe whose
    other end, when it is closed, ends the process too, whatever it is at.
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
