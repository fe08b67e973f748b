"""The robot of a script that is marked: it is simulated here, while the script is confined
elsewhere.
"""

from pathlib import Path

import numpy as np

from . import tracking as tasks
from .clock import STEP
from .world import World

KINDS = ("five_bar", "biglide")
FOREVER = 1e6  # s; the end is checked here, where no KeyboardInterrupt is wanted
OWN = {"parallel_robot": "_lab_parallel_robot", "plot_tools": "_lab_plot_tools", "rclpy": "rclpy"}


def confined_program():
    """Return the program of the confined process, and the modules beside it: name -> text."""
    folder = Path(__file__).parent
    modules = {}
    for name, own in OWN.items():
        text = (folder / f"{name}.py").read_text(encoding="utf-8")
        text = text.replace("from . import world as place", "import _lab_world as place")
        modules[own] = text.replace("from . import rclpy", "import rclpy")
    return (folder / "_confined.py").read_text(encoding="utf-8"), modules | {"_lab_world": ""}


class _Clock:
    """The script has a clock of its own."""

    def tick(self):
        pass


class MarkedRobot:
    """Answers the commands of a confined script for so many seconds of simulated time.

    trouble: why it ended before, "" if it did not.
    """

    def __init__(self, until):
        self.steps = round(until / STEP)
        self.world = World(FOREVER, _Clock(), False, None)
        self.trouble = ""

    def answer(self, row):
        """Return the state after a command, (20,) numbers in a list; None where the time is
        over.
        """
        world = self.world
        try:
            command, left, right = row
            if command == 0:
                world.make(KINDS[int(left)])
            elif world.kind is None or world.steps >= self.steps:
                return None
            elif command == 1:
                world.step((left, right))
            else:
                world.reset()
        except (ArithmeticError, TypeError, ValueError, RuntimeError, IndexError) as error:
            self.trouble = self.trouble or str(error)
            return None
        efforts = world.efforts[-1] if world.efforts else np.zeros(2)
        return [np.concatenate([*world.state, efforts]).tolist()]

    def run(self):
        """Return the motion, None where there was none."""
        return self.world.run()

    def tracking(self, task):
        """Return (the tracking error in a task, ""), or (None, why there is none)."""
        try:
            return tasks.tracking(task, self.world.kind, self.run()), ""
        except ValueError as error:
            return None, str(error)
