"""What is not named costs nothing: with the new parameters left at 0 the lab's model is the one of before they came.

tests/data/rung0.json holds what the package gave before: instructions of compiled functions, and numbers to the last
bit (of Python floats, whose arithmetic the platform does not choose).
"""

import json
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.control.laws import ComputedTorque
from fivebar.models.charts import CHARTS
from fivebar.models.dynamics import bar_forces
from fivebar.simulation import loops, steps
from fivebar.simulation.simulate import Grid
from fivebar.study.speed_accuracy.charts.fixed_steps import slope_function

BEFORE = json.loads((Path(__file__).parents[1] / "data" / "rung0.json").read_text("utf-8"))
ROBOTS = {"five-bar": fb.FiveBar(l12=0.1, l22=0.11), "biglide": fb.Biglide()}
PAIRS = [
    "q>xi",
    "xi>q,q_passive",
    "q,q_dot>M,c",
    "q,q_dot>energy",
    "xi,xi_dot>M,c",
    "q,q_dot,q_ddot>tau",
    "xi,xi_dot,xi_ddot>tau",
    "q,q_dot,tau>q_ddot,xi_ddot",
    "xi,xi_dot,tau>q_ddot,q_passive_ddot",
]


def count_of(robot, pair):
    inputs, outputs = (side.split(",") for side in pair.split(">"))
    return fb.compile(robot, inputs, outputs).n_instructions()


def counts(robot):
    found = {pair: count_of(robot, pair) for pair in PAIRS}
    found |= {name: slope_function(robot, chart).n_instructions() for name, chart in CHARTS.items()}
    found["step of any length"] = steps.free_step(type(robot)).n_instructions()
    law = ComputedTorque(robot, 100.0, 20.0)
    grid = Grid(steps=6, step=0.001, block=2)
    loop = loops.LoopModel(
        type(robot), (), law, CHARTS["auto"], "rk4", grid, 3, None, fb.Measurement()
    )
    found["loop of many robots"] = loops._function(loop).expand().n_instructions()
    return found


def numbers(robot):
    slides = not robot.turns
    q, q_dot = ((0.03, -0.02), (0.3, -0.2)) if slides else ((0.2, 0.4), (1.3, -0.7))
    rates = fb.dkm(fb.dgm(robot, q), q_dot)
    M, c = fb.dynamic_model(rates)
    forward = fb.forward_dynamics(rates, (0.4, -0.3))
    found = [
        M,
        c,
        fb.inverse_dynamics(fb.dkm2(rates, (2.0, -3.0))),
        forward.q_ddot,
        forward.xi_ddot,
        fb.energy(rates),
    ]
    found.append(bar_forces(rates, (0.4, -0.3)))
    return [float(x).hex() for each in found for x in np.ravel(each)]


@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_are_those_of_before_to_the_last_bit(name):
    assert numbers(ROBOTS[name]) == BEFORE[name]["numbers"]


@pytest.mark.parametrize("name", ROBOTS)
def test_functions_have_not_one_instruction_more(name):
    assert counts(ROBOTS[name]) == BEFORE[name]["counts"]
