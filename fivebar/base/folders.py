"""Folders of results, into which one process at a time writes."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import UsageError
from .tables import is_part

try:
    import fcntl
except ImportError:  # Windows, where two are not told apart
    fcntl = None


class FolderError(ValueError, UsageError):
    """A folder of results that cannot be one, or that another process has."""


@contextmanager
def locked_folder(folder: Path, what: str, parts: tuple[str, ...] = ()) -> Iterator[None]:
    """Make a folder, keep out of it all others who do the same, and clear away what a killed one
    began to write.

    what: is done there, as "sweep"; parts: folders in it that are made and cleared too. FolderError
    for what is no folder, or where another process writes; OSError where it is read-only.
    """
    places = [folder, *(folder / name for name in parts)]
    try:
        for place in places:
            place.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY) if fcntl else None
    except NotADirectoryError:
        raise FolderError(f"out: {folder} is not a folder") from None
    except FileExistsError as error:
        raise FolderError(f"out: {error.filename} is a file, not a folder") from None
    except ValueError as error:  # letters that no name may have
        raise FolderError(f"out: {str(folder)!r}: {error}") from None
    try:
        _lock(handle, f"out: another {what} writes to {folder}: wait for its end, or give another")
        if not os.access(folder, os.W_OK):
            raise PermissionError(errno.EACCES, "the folder is read-only", str(folder))
        for path in (path for place in places for path in place.iterdir() if is_part(path.name)):
            path.unlink()
        yield
    finally:
        if fcntl:
            os.close(handle)


def _lock(handle, words):
    try:
        if fcntl:
            fcntl.flock(
                handle, fcntl.LOCK_EX | fcntl.LOCK_NB
            )  # it goes with the process, however that ends
    except BlockingIOError:
        raise FolderError(words) from None
    except OSError:
        pass  # a file system without locks, as clusters may have: two are not told apart
