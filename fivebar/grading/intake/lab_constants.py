"""The robot of a file that has the AMORO lab's own names for its numbers: l, d, ZZ1R, ZZ2R, mR, or
l, d, mf, mp.
"""

from __future__ import annotations

from ...models.robots import Robot
from ..robots import with_numbers

# Of the lab's number: 0.002 and 0.002025 kg m^2 are both in its papers, 0.1 m for 0.09 m is an
# error.
ALLOWED = 0.02


def robot_of_file(
    standard: Robot, names: dict[str, tuple[str, ...]], constants: dict[str, float]
) -> tuple[Robot, tuple[str, ...]]:
    """Return the standard robot with the numbers of a file, and sentences on those that are too far
    off to be its own.

    names: the file's name for a number -> the robot's for it; constants: what the file gives them.
    """
    given: dict = {}
    notes: list = []
    for name, own in names.items():
        right, value = getattr(standard, own[0]), constants.get(name)
        if value is None or value == right:
            continue
        if abs(value / right - 1) <= ALLOWED:
            given |= dict.fromkeys(own, value)
        else:
            notes.append(
                f"Your file has {name} = {value:g}, but the lab's robot has {right:g}. Your file is"
                " graded for the lab's robot."
            )
    return with_numbers(standard, given), tuple(notes)
