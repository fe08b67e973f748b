"""The ten functions that a script here tries: those of the file named on its command line, or fivebar's own."""

import sys
from importlib import import_module
from pathlib import Path

import fivebar as fb
from fivebar.amoro import models


def chosen_models(arguments):
    """(name of the robot, its functions); arguments: [script, robot, file], the last two may be left out."""
    robot = arguments[1] if len(arguments) > 1 else "five_bar"
    if len(arguments) > 2:
        file = Path(arguments[2]).resolve()
        sys.path.insert(0, str(file.parent))
        return robot, import_module(file.stem)
    return robot, models(fb.Biglide() if robot == "biglide" else fb.FiveBar())
