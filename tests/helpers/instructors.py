"""Packs what is for instructors only: the course's page, solutions of all labs, answers to the notebooks' exercises.

`python -m tests.helpers.instructors instructors.zip`
"""

import sys
import zipfile
from pathlib import Path

from . import DATA, LABS


def contents():
    """Name in the package -> file."""
    found = {"course.md": LABS / "course.md"}
    for kind, pattern in (("solutions", "*.py"), ("answers", "*.md")):
        for path in sorted((DATA / kind).rglob(pattern)):
            found[str(Path(kind, path.relative_to(DATA / kind)))] = path
    return found


def pack(out):
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, path in contents().items():
            archive.write(path, name)
    return len(contents())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("python -m tests.helpers.instructors OUT.zip")
    print(f"{pack(sys.argv[1])} files in {sys.argv[1]}")
