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
except ImportError:  # Windows has no locks of this kind
    fcntl = None  # type: ignore[assignment]


class FolderError(ValueError, UsageError):
    """A path that can be no folder of results, or a folder that another process writes to."""


@contextmanager
def locked_folder(folder: Path, what: str = "", parts: tuple[str, ...] = ()) -> Iterator[None]:
    """Make a folder, lock it, and remove the files that a killed process left half-written.

    Parameters
    ----------
    folder : Path
    what : str
        The work of which another run may hold the folder, as "sweep". "": files are only written
        there, and this run waits until the other has written its own.
    parts : tuple of str
        Folders in it that are made and cleared, too.

    Raises
    ------
    FolderError
        The path is no folder, or another process writes there.
    OSError
        The folder is read-only.
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
        _lock(
            handle,
            f"out: another {what} writes to {folder}: wait for its end, or give another",
            wait=not what,
        )
        if not os.access(folder, os.W_OK):
            raise PermissionError(errno.EACCES, "the folder is read-only", str(folder))
        for place in places:
            for path in list(place.iterdir()):
                if is_part(path.name):
                    path.unlink()
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _lock(handle, message, wait):
    """Lock an open folder until the process ends, however that ends."""
    try:
        if fcntl:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        raise FolderError(message) from None
    except OSError:
        pass  # File systems of clusters may have no locks.
