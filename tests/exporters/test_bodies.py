"""Bodies of an exported robot: ones that can exist, grouped again they are the robot's parameters, and none where none
can be."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.exporters.bodies import legs_of


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
    with pytest.raises(
        ValueError, match="asks for masses, and this robot has none: give it zz1, zz2, m"
    ):
        legs_of(fb.ROBOTS["hoang-2015"].robot)
    with pytest.raises(ValueError, match="leg 1 of this robot.* zz1"):
        legs_of(fb.FiveBar(zz1=0))
    with pytest.raises(ValueError, match="leg 2 of this robot.* zz2"):
        legs_of(fb.FiveBar(zz2=0))
    with pytest.raises(ValueError, match="m = 0 kg must be above 0 kg"):
        legs_of(fb.FiveBar(m=0))
    for robot in (fb.FiveBar(m=1e-9), fb.FiveBar(zz1=1e-12)):
        assert all(body.mass > 0 for leg in legs_of(robot) for body in (leg.drive, leg.bar))
    import casadi

    with pytest.raises(ValueError, match="symbols as parameters"):
        legs_of(replace(fb.FiveBar(), m=casadi.SX.sym("m")))


def possible(robot):
    """Whether some masses of the bars, with some shares of the end-effector, leave positive masses and inertias."""
    shares, allowed = np.linspace(-3, 3, 1201) * abs(robot.m), []
    for k, (drive, bar, z) in enumerate(zip(robot.drives, robot.distal, robot.inertias)):
        j, my = (robot.zz12, robot.my12) if k == 0 else (robot.zz22, robot.my22)
        share = shares[:, None] if k == 0 else robot.m - shares[:, None]
        mass = np.geomspace(1e-4, 1e3, 2001)
        left = z - (mass - share) * drive.length**2
        own = j + share * bar**2 - (share**2 * bar**2 + my**2) / mass
        allowed.append(((left > 0) & (own > 0)).any(axis=1))
    return (allowed[0] & allowed[1]).any()


@pytest.mark.deep
def test_bodies_are_found_wherever_there_are_any():
    rng, found = np.random.default_rng(6), []
    for _ in range(60):
        robot = fb.FiveBar(
            *rng.uniform(0.05, 0.2, 4),
            0.05,
            *10 ** rng.uniform(-4, -2, 2),
            10 ** rng.uniform(-2, 0),
            *rng.normal(size=4) * 0.1,
            *rng.normal(size=2) * 2e-3,
            *rng.normal(size=2) * 0.01,
        )
        try:
            values = grouped(robot)
        except ValueError as error:
            assert "no bodies of positive mass move as" in str(error)
            assert not possible(robot)
            found.append(False)
        else:
            for name, value in values.items():
                assert value == pytest.approx(getattr(robot, name), rel=1e-11, abs=1e-13), name
            assert all(
                body.mass > 0 < body.inertia
                for leg in legs_of(robot)
                for body in (leg.drive, leg.bar)
            )
            found.append(True)
    assert 10 < sum(found) < 50


def test_what_is_asked_for_is_the_least():
    robot = fb.FiveBar(m=0.3, zz12=-0.001, my12=0.01, zz22=-0.0012)
    k1, k2 = robot.zz1 / robot.l11**2, robot.zz2 / robot.l21**2
    least = (0.01**2 + k1 * 0.001) / (k1 * 0.09**2 - 0.001) + k2 * 0.0012 / (k2 * 0.09**2 - 0.0012)
    assert possible(replace(robot, m=least * 1.05)) and not possible(replace(robot, m=least * 0.95))
    legs_of(replace(robot, m=least * (1 + 1e-9)))
    with pytest.raises(ValueError, match=f"must be above {least:.6g} kg"):
        legs_of(replace(robot, m=least * (1 - 1e-9)))
    with pytest.raises(ValueError, match="leg 1 of this robot.* -0.001 kg"):
        legs_of(replace(robot, zz12=-0.003))
