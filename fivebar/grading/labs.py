"""Finds a lab's folder by its short name: in a folder of one's own, in a clone, in the installed
package.
"""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from unittest.mock import patch

import numpy as np

from ..base.errors import UsageError
from ..models.robots import FiveBar, Robot
from .exercise import Exercise
from .intake.students_robots import with_constants
from .robots import parameters_of

PACKAGE = Path(__file__).parents[1]
SHIPPED = PACKAGE / "_labs"  # in a clone a link to labs/, which a wheel holds itself


@dataclass(frozen=True)
class Lab:
    """A folder with test_lab.py and, for `ask`, exercises.py."""

    folder: Path

    @property
    def name(self) -> str:
        return self.folder.name

    @property
    def tests(self) -> Path:
        return self.folder / "test_lab.py"

    def exercises(self) -> dict[str, Exercise]:
        """Return name -> Exercise, from EXERCISES of exercises.py; none where there is no such
        file.
        """
        return {exercise.name: exercise for exercise in self._content().get("EXERCISES", ())}

    def robot(self) -> Robot:
        """Return the robot that all have who got none of their own: ROBOT of exercises.py, else the
        default five-bar.
        """
        return self._content().get("ROBOT", FiveBar())

    def also(self) -> tuple[dict, ...]:
        """Return numbers that are right in place of the robot's own: ALSO of exercises.py."""
        return self._content().get("ALSO", ())

    def constants(self) -> dict[str, tuple[str, ...]]:
        """Return the file's name for a number -> the robot's: CONSTANTS of exercises.py; none where
        both are the same.
        """
        return self._content().get("CONSTANTS", {})

    def uses(self) -> dict[str, tuple[str, ...]]:
        """Return a function -> those that it may call, whose mistakes it need not pay for: USES of
        exercises.py.
        """
        return self._content().get("USES", {})

    def file(self) -> str:
        """Return the name that the lab gives the file to hand in: FILE of exercises.py, "" where
        any name will do.
        """
        return self._content().get("FILE", "")

    def family(self) -> list[Lab]:
        """Return the labs whose files come in one hand-in, this one first where it is the main one.

        WITH of the main lab's exercises.py names the others, PART_OF of theirs the main one.
        """
        main = Lab(self.folder.parent / self._content().get("PART_OF", self.name))
        return [main, *(Lab(self.folder.parent / name) for name in main._content().get("WITH", ()))]

    def with_others(self) -> list[Lab]:
        """Return this lab and, where it is the main one of its family, the others."""
        family = self.family()
        return family if family[0] == self else [self]

    @property
    def hides_robot(self) -> bool:
        """Whether the numbers of a student's robot are what he is to find."""
        return "HAND_OUT" in self._content()

    def files_for(self, robot: Robot, draw: np.random.Generator) -> dict[str, str] | None:
        """Return {name: text} of what a student gets beside student.py about a robot whose numbers
        he is
        to find: HAND_OUT of exercises.py; None where the robot's numbers stand in student.py.

        """
        make = self._content().get("HAND_OUT")
        return None if make is None else make(robot, draw)

    def template(self, robot: Robot | None = None) -> str:
        """Return the student.py to fill in, "" where the lab has none.

        robot: a student's own, whose numbers then stand in it.
        """
        path = self.folder / "student.py"
        if not path.is_file():
            return ""
        source = path.read_text(encoding="utf-8")
        return source if robot is None else with_constants(source, robot)

    def hints_from(self) -> str:
        """Return the day from which students are told why, HINTS_FROM of exercises.py, "" where
        there is none.
        """
        return str(self._content().get("HINTS_FROM", ""))

    def spots_from(self) -> int | None:
        """Return the wrong try at home from which the line and the change are told that give right
        answers: SPOTS_FROM of exercises.py, 2 where there is none; None: never, in a grading as
        well.
        """
        return self._content().get("SPOTS_FROM", 2)

    def _content(self):
        path = self.folder / "exercises.py"
        if not path.exists():
            return {}
        stamp = path.stat().st_mtime_ns
        if _LOADED.get(path, (None,))[0] != stamp:
            _LOADED[path] = stamp, _loaded(path)
        return _LOADED[path][1]

    def hash(self) -> str:
        """Return sHA-256 over the lab's programs: results of another one are not comparable."""
        digest = hashlib.sha256()
        for path in sorted(self.folder.glob("*.py")):
            content = path.read_bytes()
            digest.update(f"{path.name}\0{len(content)}\0".encode() + content)
        return digest.hexdigest()


_LOADED: dict = {}


def _loaded(path):
    """Return what exercises.py defines. What it imports from its own folder is the lab's alone."""
    module = ModuleType(f"exercises of {path.parent.name}")
    module.__file__ = str(path)
    before = {*sys.modules}
    sys.modules[module.__name__] = module  # where a dataclass looks for its names
    try:
        with (
            patch.object(sys, "path", [str(path.parent), *sys.path]),
            patch.object(sys, "dont_write_bytecode", True),
        ):
            exec(compile(path.read_bytes(), path, "exec"), vars(module))
    finally:
        for name in {
            module.__name__,
            *(beside.stem for beside in path.parent.glob("*.py")),
        } - before:
            sys.modules.pop(name, None)
    robot = getattr(module, "ROBOT", FiveBar())
    if isinstance(robot, type) or not parameters_of(robot):
        raise UsageError(
            f"{path}: ROBOT must be an object of a dataclass or a NamedTuple that has numbers, such"
            f" as lengths, or one of fivebar's robots and linkages, not {robot!r:.80}"
        )
    return vars(module)


def known_labs(folder: str | Path | None = None) -> list[Lab]:
    """Return all labs: of `folder`, which may be a lab itself, else the shipped ones."""
    if folder is not None and not Path(folder).is_dir():
        raise UsageError(f"--labs: no folder {str(folder)!r}")
    place = SHIPPED if folder is None else Path(folder)
    found = [path.parent for path in (*place.glob("test_lab.py"), *place.glob("*/test_lab.py"))]
    found.sort(key=lambda path: (not path.name.startswith("lab"), path))
    return [Lab(path.resolve()) for path in found]


def find_lab(name: str, folder: str | Path | None = None) -> Lab:
    """Return the lab called `name`: lab1_geometry, lab1 or 1."""
    labs = known_labs(folder)
    wanted = {name, f"lab{name}"}
    for lab in labs:
        if wanted & {lab.name, lab.name.split("_")[0]}:
            return lab
    names = ", ".join(lab.name for lab in labs) or "none"
    where = "" if folder is None else f" in {folder}"
    raise UsageError(f"no lab {name!r}; the known ones{where} are: {names}")
