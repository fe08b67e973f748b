"""Processes that a test has started, and what they started."""

from pathlib import Path


def descendants(pid):
    """pid -> command line of the processes below one, from /proc/*/stat, whose fourth field is the parent."""
    parents = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(path.parent.name)] = int(
                path.read_text("utf-8").rpartition(")")[2].split()[1]
            )
        except OSError:
            continue  # it has ended
    found, new = {}, {pid}
    while new:
        new = {child for child, parent in parents.items() if parent in new}
        for child in new:
            try:
                found[child] = Path(f"/proc/{child}/cmdline").read_bytes()
            except OSError:
                pass
    return found
