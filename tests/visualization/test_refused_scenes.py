"""Scenes that cannot be drawn, and what is said of them."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar import linkages
from fivebar.visualization import view
from fivebar.visualization.view.frames import choose

from .conftest import ROBOT


def test_names_are_known_and_fit_the_motion(run):
    study = linkages.study(linkages.SliderCrank(0.1, 0.3))
    free = replace(run, xi_ref=None)
    for motion, show, message in [
        (
            run,
            ["trace", "sparkle"],
            "nothing named 'sparkle' can be shown; the known names are trace, reference, loci",
        ),
        (study, ["loci"], "a slider-crank, guide held has no 'loci' to show"),
        (free, "reference", "no reference, so no 'reference'"),
    ]:
        with pytest.raises(ValueError, match=message):
            view.scene(getattr(motion, "linkage", ROBOT), motion, show)
    with pytest.raises(ValueError, match="another robot"):
        view.scene(fb.FiveBar(d=0.1), run)
    with pytest.raises(ValueError, match="names has 1 texts for 2 motions"):
        view.scene(ROBOT, run, second=run, names=["one"])
    with pytest.raises(TypeError, match="a reference needs the robot that follows it, not None"):
        view.strip(fb.line((0.05, 0.1), (0.0, 0.1), 1.0))
    with pytest.raises(
        TypeError, match="needs a Run, a Plan or other reference, or a Study, not ndarray"
    ):
        view.scene(ROBOT, run.xi)


@pytest.mark.parametrize(
    ("t", "numbers", "message"),
    [
        ([], np.zeros((0, 2)), "has 0 samples: a motion needs at least 2"),
        ([0.0], np.zeros((1, 2)), "has 1 samples: a motion needs at least 2"),
        ([0, 1, np.nan], np.zeros((3, 2)), r"t\[2\] is nan, not finite"),
        ([0, 1, 1], np.zeros((3, 2)), r"t\[2\] = 1.0 is not after t\[1\] = 1.0"),
        ([0, 1, 2], np.zeros((2, 2)), "t has 3 samples and the motion 2"),
        ([0, 1, 2], np.full((3, 2), np.nan), "all 3 samples are not numbers: nothing can be drawn"),
    ],
)
def test_motions_that_cannot_be_drawn(t, numbers, message):
    with pytest.raises(ValueError, match=message):
        choose(t, numbers)
