"""Where the script's windows go: pictures named after it."""

import os
from pathlib import Path

start = Path.cwd()  # a script may go elsewhere
folder, stem = start, "script"
written: list[str] = []  # paths from where the run began, in order


def picture(name):
    """Return the path of a new picture."""
    path = folder / f"{stem}_{name}.png"
    written.append(os.path.relpath(path, start))
    return path
