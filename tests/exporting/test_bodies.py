"""Bodies of an exported robot: ones that can exist, grouped again they are the robot's parameters, and none where none
can be."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.exporting.bodies import legs_of


def grouped(robot):
    """The base parameters of the bodies, by the masses that a rigid bar puts on its two ends."""
    found = {"m": 0.0}
    for leg in legs_of(robot):
        (m1, x1, y1, j1), (m2, x2, y2, j2) = leg.drive, leg.bar
        share = m2 * x2 / leg.distal
        found["m"] += share
        second = "zz{}2" if robot.turns else "zz{}"
        found[second.format(leg.number)] = j2 + m2 * (x2**2 + y2**2) - m2 * x2 * leg.distal
        found[("my{}2" if robot.turns else "my{}").format(leg.number)] = m2 * y2
        if robot.turns:
            found[f"zz{leg.number}"] = j1 + m1 * (x1**2 + y1**2) + (m2 - share) * leg.proximal**2
            found[f"mx{leg.number}1"] = m1 * x1 + (m2 - share) * leg.proximal
            found[f"my{leg.number}1"] = m1 * y1
        else:
            found[f"mf{leg.number}"] = m1 + m2 - share
    return found


def robots(count=200):
    rng = np.random.default_rng(5)
    for _ in range(count):
        lengths = rng.uniform(0.05, 0.2, 5)
        yield fb.FiveBar(*lengths[:4], lengths[4] / 2, *10 ** rng.uniform(-6, 0, 3))
        yield fb.Biglide(*lengths[:2] + 0.1, lengths[4], *10 ** rng.uniform(-3, 1, 3))


def test_bodies_exist_and_are_the_robot():
    for robot in robots():
        for name, value in grouped(robot).items():
            assert value == pytest.approx(getattr(robot, name, 0.0), rel=1e-12, abs=1e-13), name
        for leg in legs_of(robot):
            for body in (leg.drive, leg.bar):
                assert body.mass > 0 and body.inertia > 0


def test_a_robot_without_masses_has_none():
    with pytest.raises(ValueError, match="leg 1 of this robot: with zz1 = 0"):
        legs_of(fb.ROBOTS["hoang-2015"].robot)
    with pytest.raises(ValueError, match="leg 2 of this robot: with zz2 = 0"):
        legs_of(fb.FiveBar(zz2=0))
    with pytest.raises(ValueError, match="m = 0 kg must be above 0 kg"):
        legs_of(fb.FiveBar(m=0))
    for robot in (fb.FiveBar(m=1e-9), fb.FiveBar(zz1=1e-12)):
        assert all(body.mass > 0 for leg in legs_of(robot) for body in (leg.drive, leg.bar))
    import casadi

    with pytest.raises(ValueError, match="symbols as parameters"):
        legs_of(replace(fb.FiveBar(), m=casadi.SX.sym("m")))
