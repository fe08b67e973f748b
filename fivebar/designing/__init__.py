"""Figures of merit, sweeps over designs, and the best of them."""

from .designs import Designs, grid, sample, triangle
from .figures import FIGURES, Figure
from .sweeps import Sweep
from .task import MOTORS, Motor, Task

__all__ = ["FIGURES", "MOTORS", "Designs", "Figure", "Motor", "Sweep", "Task", "grid", "sample", "triangle"]
