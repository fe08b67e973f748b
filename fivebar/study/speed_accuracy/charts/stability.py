"""Sampled computed torque over the plane of its gains: growth of a disturbance, gain of noise;
simulated and exact.
"""

from __future__ import annotations

import time

import numpy as np

from ....models.robots import FiveBar
from ...pitfalls.sampled import exact_noise_gain, growth, noise_gain, spectral_radius
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel

ROBOT = FiveBar()
SIDES = {
    "growth": 29,
    "noise": 15,
}  # points of a side; odd, so that every other point is a chessboard
WINDOWS = {0: (4.5, 2.45), 1: (0.3, 1.1)}  # Kp h^2 and Kd h up to these, by samples of delay
NEVER = 1e9  # for the gain of noise where nothing is stable
PROBLEMS = {
    "growth-0": ("no delay: growth per sample", 0, growth, spectral_radius),
    "growth-1": ("one sample of delay: growth per sample", 1, growth, spectral_radius),
    "noise-0": ("no delay: gain of measurement noise", 0, noise_gain, exact_noise_gain),
    "noise-1": ("one sample of delay: gain of measurement noise", 1, noise_gain, exact_noise_gain),
}


def gains(problem: str, index: int) -> tuple[float, float]:
    """(Kp h^2, Kd h) of a point, in the middle of a cell of the problem's grid."""
    size, side = WINDOWS[PROBLEMS[problem][1]], side_of(problem)
    return tuple(float(high * (k + 0.5) / side) for high, k in zip(size, divmod(int(index), side)))


def side_of(problem: str) -> int:
    return SIDES[problem.split("-")[0]]


def simulated(problem: str, index: int) -> Attempt:
    """prepare: one run at one pair of gains, whose time is that of its only call."""
    _, delay, measure, exact = PROBLEMS[problem]
    p, q = gains(problem, index)
    spent = []

    def call():
        before = time.perf_counter()
        value = measure(ROBOT, p, q, delay)
        spent.append(time.perf_counter() - before)
        return value

    def judge(value):
        true = exact(p, q, delay)
        if np.isinf(value):
            raise Failed("grows" if np.isinf(true) else "grows where it should not")
        return {
            "p": p,
            "q": q,
            "value": value,
            "exact": min(true, NEVER),
            "radius": spectral_radius(p, q, delay),
        }

    return Attempt(call, judge, times=lambda: np.array(spent))


def chart() -> Chart:
    knobs = {problem: tuple(range(side_of(problem) ** 2)) for problem in PROBLEMS}
    return Chart(
        name="stability",
        title=(
            "Which gains of sampled computed torque hold the robot: simulated (colour) over exact"
            " (lines)"
        ),
        reading=(
            "Each point of the plane is a pair of gains, h the period, 10 ms. Above: how a"
            " disturbance of 1e-7 rad on the simulated robot grows or shrinks from sample to"
            " sample; black line: where the exact factor is 1, dashed inside of it: 0.5 and 0.8."
            " Below: how much of the measurement's noise comes out in the angles; lines: exact"
            " gains; crosses: it does not hold."
        ),
        problems={problem: words[0] for problem, words in PROBLEMS.items()},
        methods=(Method("simulated robot", OURS, simulated, knobs),),
        panels=tuple(
            tuple(Panel(f"{kind}-{d}", PROBLEMS[f"{kind}-{d}"][0], y="value") for d in (0, 1))
            for kind in ("growth", "noise")
        ),
        picture="gain_maps",
    )
