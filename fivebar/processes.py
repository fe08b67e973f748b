"""Processes that this one starts."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import threading
from multiprocessing.connection import wait


def end_with_parent(room: str | None = None) -> None:
    """Said by a process of `multiprocessing`: that it ends when who started it is killed, and not by Ctrl-C.

    The pipe or queue that it reads would tell it late, or never. room: a folder to take along.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_after, args=(parent, room), daemon=True).start()


def _end_after(parent, room):
    wait([parent.sentinel])
    if room:
        shutil.rmtree(room, ignore_errors=True)
    os._exit(1)
