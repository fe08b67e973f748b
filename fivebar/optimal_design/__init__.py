"""Figures of merit, sweeps over designs, and the best of them."""

from .designs import Designs, grid, sample, triangle
from .figures import FIGURES, Figure
from .results import Design, Front
from .sweeps import Sweep
from .task import Task

__all__ = [
    "FIGURES",
    "Design",
    "Designs",
    "Figure",
    "Front",
    "Sweep",
    "Task",
    "grid",
    "sample",
    "triangle",
]
