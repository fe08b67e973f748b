"""Friction and gravity one by one: what they take, what holds at rest, and robots of links by their parameters."""

from dataclasses import replace

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.dynamics import (
    bar_force_dynamics,
    bar_forces,
    drives_forces,
    held_by,
    slipping_dynamics,
)
from fivebar.models.loads import dry_friction, lost_power
from fivebar.models.parameters import robot_of
from fivebar.models.sticking import slip_of

from ..helpers.physics_cases import CASES, heavy_biglide, robot_of_case

HEAVY = replace(robot_of_case(CASES[1], elbows=(0.004, 0.007)), fs1=0.4, fs2=0.3)
LIGHT = fb.FiveBar(gravity=(0.6, -9.81), fs1=0.4, fs2=0.3)
ROBOTS = [
    HEAVY,
    LIGHT,
    replace(heavy_biglide()[0], fs1=0.4),
    fb.FiveBar(l12=0.1),
    fb.FiveBar(m=0.0, fv1=0.1, fs2=0.2),
]


def moving(robot, q_dot):
    return fb.dkm(fb.dgm(robot, (0.2, 1.4) if robot.turns else (0.03, -0.02)), q_dot)


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_friction_takes(robot):
    rates = moving(robot, np.array([(1.2, -0.7), (0.0, 0.4)]))
    lost = 0.0
    for k in (0, 1):
        q_dot = rates.q_dot[:, k]
        lost = (
            lost
            + getattr(robot, f"fv{k + 1}") * q_dot**2
            + getattr(robot, f"fs{k + 1}") * np.abs(q_dot)
        )
        if robot.turns:
            lost = lost + getattr(robot, f"fv{k + 1}2") * rates.q_passive_dot[:, k] ** 2
    np.testing.assert_allclose(lost_power(rates), lost, rtol=1e-13, atol=1e-16)
    q_dot = casadi.SX.sym("q_dot", 2)
    one = np.array([1.2, -0.7])
    if robot.physics is not None:
        dry = np.array([robot.fs1, -robot.fs2])
        np.testing.assert_array_equal(dry_friction(robot, one), dry)
        call = casadi.Function(
            "f", [q_dot], [casadi.vertcat(*casadi.vertsplit(dry_friction(robot, q_dot)))]
        )
        np.testing.assert_array_equal(call(one).full().ravel(), dry)
        assert (dry_friction(robot, np.zeros(2)) == 0).all() and not call([0, 0]).full().any()


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("q_dot", [(1.2, -0.7), (0.0, 0.0)])
def test_bar_forces_and_torques_are_those_of_the_motion(robot, q_dot):
    rates, tau = moving(robot, q_dot), (2.0, -3.0)
    acc, forces = fb.forward_dynamics(rates, tau), bar_forces(rates, tau)
    push, torques = bar_force_dynamics(acc, tuple(forces))
    np.testing.assert_allclose(push, (0, 0), atol=1e-10)
    slips = all(acc.q_ddot != 0)
    if slips and any(q_dot):
        np.testing.assert_allclose(torques, tau, atol=1e-10)
        np.testing.assert_allclose(drives_forces(acc, tau), forces, rtol=1e-9, atol=1e-10)
    M, c = fb.dynamic_model(rates)
    if any(q_dot):
        np.testing.assert_allclose(M @ acc.q_ddot + c, tau, atol=1e-10)
    elif robot.physics is not None and robot.physics.has_gravity:
        np.testing.assert_allclose(c, fb.gravity_torques(rates.pose), atol=1e-13)
        assert np.abs(c).max() > 0.1


@pytest.mark.parametrize("robot", ROBOTS[:3])
@pytest.mark.parametrize("stuck", [0, 1])
def test_a_drive_that_sticks_is_held_by_what_its_row_of_the_model_lacks(robot, stuck):
    rates, tau, other = moving(robot, (0.0, 0.0)), (1.5, -2.5), 1 - stuck
    slip = tuple(0.0 if k == stuck else -1.0 for k in (0, 1))
    acc, held = held_by(rates, tau, slip)
    M, c = fb.dynamic_model(rates)  # at rest, without dry friction
    dry = robot.physics.coulomb[other] * slip[other]
    q_ddot = (tau[other] - c[other] - dry) / M[other, other]
    assert acc._q_ddot[stuck] == 0 and acc._q_ddot[other] == pytest.approx(q_ddot, rel=1e-10)
    assert held[stuck] == pytest.approx(tau[stuck] - c[stuck] - M[stuck, other] * q_ddot, rel=1e-9)
    assert held[other] == pytest.approx(0.0, abs=1e-12)
    closure = rates.pose.A @ acc.xi_ddot - rates.pose.B @ acc.q_ddot - rates.d
    assert np.abs(closure).max() < 1e-10


@pytest.mark.parametrize("robot", [replace(HEAVY, fs2=0.0), replace(LIGHT, fs2=0.0)])
def test_a_drive_without_dry_friction_starts_freely_from_rest(robot):
    rates = moving(robot, (1.2, 0.0))
    M, c = fb.dynamic_model(rates)
    np.testing.assert_allclose(
        M @ fb.forward_dynamics(rates, (2.0, -3.0)).q_ddot + c, (2.0, -3.0), atol=1e-11
    )


def test_a_batch_of_torques_at_one_pose_and_of_poses_under_one_torque():
    robot = fb.FiveBar(fs1=0.02, fs2=0.03)
    still = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.0, 0.0))
    tau = np.array([(0.01, 0.0), (0.05, -0.01), (0.05, 0.2), (-0.3, 0.029)])
    found = fb.forward_dynamics(still, tau).q_ddot
    for row, each in zip(found, tau):
        np.testing.assert_array_equal(row, fb.forward_dynamics(still, each).q_ddot)
    assert (
        (found[0] == 0).all()
        and found[1, 1] == 0 < found[1, 0]
        and found[2].all()
        and found[3, 0] < 0
    )
    # Where it needs all of its friction, to hold a drive and to let it slip say the same: it is held.
    for tau, slip in (
        ((0.02, 0.0), (0, 0)),
        ((0.02, -0.03), (0, 0)),
        ((0.02 * (1 + 1e-9), 0.0), (1, 0)),
    ):
        assert slip_of(still, tau, held_by) == slip
    # A drive that moves has one slip only: three choices are tried for the other.
    tried = []
    half = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.0, -1.0))
    slip = slip_of(half, (0.01, 0.0), lambda *given: tried.append(given[2]) or held_by(*given))
    assert slip[1] == -1 and tried == [(0, -1), (1, -1), (-1, -1)]
    q = np.array([(0.2, 0.4), (0.3, 0.1)])
    both = fb.forward_dynamics(fb.dkm(fb.dgm(robot, q), np.zeros((2, 2))), (0.05, -0.01)).q_ddot
    for row, each in zip(both, q):
        one = fb.dkm(fb.dgm(robot, each), (0.0, 0.0))
        np.testing.assert_allclose(row, fb.forward_dynamics(one, (0.05, -0.01)).q_ddot, rtol=1e-14)


@pytest.mark.parametrize(
    "robot, words",
    [
        (
            fb.FiveBar(zz2=0.0, gravity=(0, -9.81)),
            "forward_dynamics needs zz2 > 0, as it divides the torque by it",
        ),
        (fb.FiveBar(zz1=0.0, gravity=(0, -9.81)), "forward_dynamics needs zz1 > 0"),
        (
            fb.FiveBar(m=0.0, fv12=0.01),
            r"forward_dynamics needs m > 0 where elbows rub \(fv12, fv22\)",
        ),
    ],
)
def test_what_forward_dynamics_divides_by(robot, words):
    with pytest.raises(ValueError, match=words):
        fb.forward_dynamics(moving(robot, (0.1, 0.2)), (0.0, 0.0))
    with pytest.raises(ValueError, match="slipping_dynamics needs"):
        slipping_dynamics(moving(robot, (0.1, 0.2)), (0.0, 0.0), None)


GIVEN = dict(l11=0.2, l12=0.15, l21=0.19, l22=0.16, d=0.12, payload=0.5, gravity=(0.0, -9.81))


def test_robots_of_links_by_their_parameters():
    links = {
        "11": {"mass": 1.2, "x": 0.11, "y": 0.01, "inertia_about_centre": 7e-3},
        "12": 0.9,
        "21": {"mass": 1.2, "x": 0.11, "inertia": 0.03},
        "22": {"mass": 0.4},
    }
    robot = robot_of({**GIVEN, "links": links, "viscous": (0.01, 0.02), "coulomb": (0.1, 0.2)})
    whole = {
        "11": fb.Link.about_centre(1.2, 0.11, 0.01, 7e-3),
        "12": 0.9,
        "21": fb.Link(1.2, 0.11, 0.0, 0.03),
        "22": 0.4,
    }
    assert robot == fb.FiveBar.from_links(
        **GIVEN, links=whole, viscous=(0.01, 0.02), coulomb=(0.1, 0.2)
    )
    rotor = {"links": {}, "rotor": np.array([1e-3, 2e-3])}
    assert (robot_of({**GIVEN, **rotor}).zz1, robot_of({**GIVEN, **rotor}).zz2) == (1e-3, 2e-3)
    assert (robot.fv1, robot.fs2, robot.gravity) == (0.01, 0.2, (0.0, -9.81)) and robot.l21 == 0.19


def test_gravity_may_be_a_vector_of_symbols():
    g = casadi.SX.sym("g", 2)
    asked = fb.gravity_torques(fb.dgm(fb.FiveBar(gravity=g, mx11=0.01), (0.2, 1.4)))
    given = fb.gravity_torques(fb.dgm(fb.FiveBar(gravity=(0.6, -9.81), mx11=0.01), (0.2, 1.4)))
    np.testing.assert_allclose(
        casadi.Function("tau", [g], [asked])((0.6, -9.81)).full().ravel(), given, rtol=1e-12
    )
    with pytest.raises((TypeError, ValueError), match="gravity"):
        fb.FiveBar(gravity=casadi.SX.sym("g", 3))


@pytest.mark.parametrize(
    "change, words",
    [
        (
            dict(links={"11": {"mass": 1, "length": 2}}),
            "no parameter length of links.11; the known ones are mass, x, y, inertia",
        ),
        (dict(links={"11": {"x": 1}}), "links.11 needs mass too"),
        (dict(links={"11": {"mass": 1, "inertia_about_centre": 1}}), "links.11 needs x too"),
        (
            dict(links={"11": {"mass": 1, "x": 0, "inertia": 1, "inertia_about_centre": 1}}),
            "no parameter inertia of links.11",
        ),
        (dict(links=5), 'links must be a table of "11", "12", "21" and "22", not 5'),
        (
            dict(colour=5, links={}),
            "no parameter colour of a robot of links; the known ones are l11, l12",
        ),
        (
            dict(rotor=5, links={}),
            r"rotor must be two inertias, or \\(inertia, gear ratio\\) pairs, not 5",
        ),
        (
            dict(rotor=(1, (1, 2, 3)), links={}),
            r"rotor must be an inertia or \\(inertia, gear ratio\\), not \\(1, 2, 3\\)",
        ),
        (dict(rotor=(-1, 1), links={}), "rotor must be"),
        (dict(rotor=(1.2e-6, 20), links={}), "two inertias that are too unlike: a motor and its"),
        (dict(rotor=(1, (1, 0)), links={}), "rotor's gear ratio must be"),
        (dict(payload=-1.0, links={}), "payload must be"),
    ],
)
def test_links_that_cannot_be(change, words):
    with pytest.raises(ValueError, match=words.replace("\\\\", "\\")):
        robot_of({**GIVEN, **change})
    with pytest.raises(ValueError, match="a robot of links needs l11, d too"):
        robot_of({"l12": 1.0, "l21": 1.0, "l22": 1.0, "links": {}})
