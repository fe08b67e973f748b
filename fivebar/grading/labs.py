"""Finds a lab's folder by its short name: in a folder of one's own, in a clone, in the installed package."""

import hashlib
import importlib.util
from dataclasses import dataclass
from pathlib import Path

from ..errors import UsageError
from ..robots import FiveBar

PACKAGE = Path(__file__).parents[1]
SHIPPED = PACKAGE.parent / "labs", PACKAGE / "_labs"  # a clone's, an installed wheel's


@dataclass(frozen=True)
class Lab:
    """A folder with test_lab.py and, for `ask`, exercises.py."""

    folder: Path

    @property
    def name(self):
        return self.folder.name

    @property
    def tests(self):
        return self.folder / "test_lab.py"

    def exercises(self):
        """Name -> Exercise, from exercises.py; none where there is no such file."""
        return exercises_beside(self.tests)

    @property
    def robot(self):
        """The handout's robot, ROBOT in exercises.py; the default five-bar where there is none."""
        return robot_beside(self.tests)

    def hash(self):
        """SHA-256 over the lab's programs: results of another one are not comparable."""
        digest = hashlib.sha256()
        for path in sorted(self.folder.glob("*.py")):
            content = path.read_bytes()
            digest.update(f"{path.name}\0{len(content)}\0".encode() + content)
        return digest.hexdigest()


def exercises_beside(tests):
    """Name -> Exercise of the exercises.py beside a test file."""
    return _beside(tests)[0]


def robot_beside(tests):
    """The handout's robot of the lab that a test file belongs to."""
    return _beside(tests)[1]


def _beside(tests):
    path = Path(tests).with_name("exercises.py")
    if not path.exists():
        return {}, FiveBar()
    stamp = path.stat().st_mtime_ns
    if _LOADED.get(path, (None,))[0] != stamp:
        spec = importlib.util.spec_from_file_location(f"exercises of {path.parent.name}", path)
        module = importlib.util.module_from_spec(spec)
        exec(compile(path.read_bytes(), path, "exec"), module.__dict__)  # no bytecode file is left beside it
        exercises = {exercise.name: exercise for exercise in module.EXERCISES}
        _LOADED[path] = stamp, exercises, getattr(module, "ROBOT", FiveBar())
    return _LOADED[path][1:]


_LOADED = {}


def known_labs(folder=None):
    """All labs: of `folder`, which may be a lab itself, else the shipped ones."""
    if folder is not None and not Path(folder).is_dir():
        raise UsageError(f"--labs: no folder {str(folder)!r}")
    places = SHIPPED if folder is None else (Path(folder),)
    for place in places:
        found = [path.parent for path in (*place.glob("test_lab.py"), *place.glob("*/test_lab.py"))]
        if found:
            return [Lab(path.resolve()) for path in sorted(found)]
    return []


def find_lab(name, folder=None):
    """The lab called `name`, in full or up to its first underscore: lab1 or lab1_geometry."""
    labs = known_labs(folder)
    for lab in labs:
        if name in (lab.name, lab.name.split("_")[0]):
            return lab
    names = ", ".join(lab.name for lab in labs) or "none"
    where = "" if folder is None else f" in {folder}"
    raise UsageError(f"no lab {name!r}; the known ones{where} are: {names}")
