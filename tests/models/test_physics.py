"""Gravity, heavy bars, friction: against full bodies that are not grouped, of 40 digits and of our own."""

from dataclasses import replace

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.dynamics import bar_forces
from fivebar.models.four_joints import bars_of, bars_rates, closed
from fivebar.models.physics import smoothed

from ..helpers.physics_cases import (
    CASES,
    ELBOWS,
    bodies_of_case,
    heavy_biglide,
    numbers,
    robot_of_case,
)

ROWS = [(case, row) for case in CASES for row in case["rows"]]


@pytest.mark.parametrize("case, row", ROWS)
def test_accelerations_and_energy_of_full_bodies_to_rounding(case, row):
    robot = robot_of_case(case)
    q, q_dot, tau, q_ddot, xi_ddot = (
        np.array(numbers(row[k])) for k in ("q", "q_dot", "tau", "q_ddot", "xi_ddot")
    )
    rates = fb.dkm(fb.dgm(robot, q, int(row["assembly"])), q_dot)
    acc = fb.forward_dynamics(rates, tau)
    np.testing.assert_allclose(acc.q_ddot, q_ddot, rtol=0, atol=1e-12 * np.abs(q_ddot).max())
    np.testing.assert_allclose(acc.xi_ddot, xi_ddot, rtol=0, atol=1e-12 * np.abs(xi_ddot).max())
    np.testing.assert_allclose(fb.energy(rates), float(row["kinetic"]), rtol=1e-12)
    np.testing.assert_allclose(fb.inverse_dynamics(acc), tau, rtol=0, atol=1e-12 * 10)
    M, c = fb.dynamic_model(rates)
    np.testing.assert_allclose(M @ acc.q_ddot + c, tau, rtol=0, atol=1e-12 * 10)
    np.testing.assert_allclose(q_dot @ M @ q_dot / 2, fb.energy(rates), rtol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_batches_and_symbols_give_what_floats_do(case):
    robot, rows = robot_of_case(case), [row for row in case["rows"] if int(row["assembly"]) == -1]
    q, q_dot, tau = (np.array([numbers(row[k]) for row in rows]) for k in ("q", "q_dot", "tau"))
    acc = fb.forward_dynamics(fb.dkm(fb.dgm(robot, q, -1), q_dot), tau)
    M, c = fb.dynamic_model(acc.rates)
    compiled = fb.compile(robot, ["q", "q_dot", "tau"], ["q_ddot", "xi_ddot", "M", "c", "energy"])
    symbols = [casadi.MX.sym(name, 2) for name in "abc"]
    late = fb.forward_dynamics(fb.dkm(fb.dgm(robot, symbols[0], -1), symbols[1]), symbols[2]).q_ddot
    late = casadi.Function("late", symbols, [late])
    for k in range(len(rows)):
        one = fb.forward_dynamics(fb.dkm(fb.dgm(robot, q[k], -1), q_dot[k]), tau[k])
        for name, value in zip(
            ("q_ddot", "xi_ddot", "M", "c", "energy"),
            (one.q_ddot, one.xi_ddot, *fb.dynamic_model(one.rates), fb.energy(one.rates)),
        ):
            same = {"M": M, "c": c, "energy": fb.energy(acc.rates)}.get(
                name, getattr(acc, name, None)
            )[k]
            np.testing.assert_allclose(same, value, rtol=1e-11, atol=1e-11)
            found = compiled(q=q[k], q_dot=q_dot[k], tau=tau[k])[name].full()
            np.testing.assert_allclose(
                found.reshape(np.shape(value)), value, rtol=1e-11, atol=1e-11
            )
        np.testing.assert_allclose(
            late(q[k], q_dot[k], tau[k]).full().ravel(), one.q_ddot, rtol=1e-11, atol=1e-11
        )


def random_motions(robot, count, seed=3):
    """States of the four bars anywhere, singular ones among them, closed."""
    draw = np.random.default_rng(seed)
    while count:
        xi = draw.uniform(-0.3, 0.3, 2)
        pose = fb.igm(robot, xi, draw.choice([-1, 1], 2), unreachable="nan")
        if not np.isfinite(pose.q).all():
            continue
        a, _ = bars_of(fb.Rates(pose, (0.0, 0.0), (0.0, 0.0)))
        yield closed(robot, a, tuple(draw.normal(0, 3, 4)))
        count -= 1


def type_2_motions(robot, count):
    """States with det A = 0 to rounding, from the crossings of the exact locus."""
    points = [
        p
        for curve in fb.singularity_loci(robot).task
        if curve.type == fb.Singularity.PARALLEL
        for p in curve.points
    ]
    draw, found = np.random.default_rng(5), 0
    for k in draw.permutation(len(points)):
        for modes in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            pose = fb.igm(robot, points[k], modes, unreachable="nan")
            if (
                np.isfinite(pose.q).all()
                and abs(pose.det_A) < 1e-9
                and min(map(abs, pose.sines)) > 0.1
            ):
                yield closed(
                    robot,
                    bars_of(fb.Rates(pose, (0.0, 0.0), (0.0, 0.0)))[0],
                    tuple(draw.normal(0, 2, 4)),
                )
                found += 1
        if found >= count:
            return
    raise AssertionError("no Type 2 found")


def compare(robot, bodies, motions, tolerance):
    for a, a_dot, rates in motions:
        tau = (0.7, -0.4)
        q_ddot, xi_ddot = bodies.accelerations(a, a_dot, tau)
        acc = fb.forward_dynamics(rates, tau)
        scale = max(np.abs(q_ddot).max(), np.abs(xi_ddot).max())
        np.testing.assert_allclose(acc.q_ddot, q_ddot, rtol=0, atol=tolerance * scale)
        np.testing.assert_allclose(acc.xi_ddot, xi_ddot, rtol=0, atol=tolerance * scale)
        np.testing.assert_allclose(
            fb.energy(rates), bodies.kinetic(a, a_dot), rtol=1e-12, atol=1e-14
        )


@pytest.mark.parametrize("case", CASES)
def test_everywhere_and_with_friction_in_the_elbows_as_full_bodies(case):
    robot = robot_of_case(case, elbows=ELBOWS)
    compare(robot, bodies_of_case(case, ELBOWS), random_motions(robot, 40), 1e-10)


@pytest.mark.parametrize("case", CASES[:3])
def test_on_type_2_as_regular_as_full_bodies(case):
    robot = robot_of_case(case)
    compare(robot, bodies_of_case(case), type_2_motions(robot, 12), 1e-10)


def test_a_biglide_of_heavy_bars_as_full_bodies():
    robot, bodies = heavy_biglide()
    compare(robot, bodies, random_motions(robot, 40), 1e-10)
    for _, _, rates in random_motions(robot, 10):
        if abs(rates.pose.det_A) > 0.1:
            M, c = fb.dynamic_model(rates)
            acc = fb.forward_dynamics(rates, (0.7, -0.4))
            np.testing.assert_allclose(M @ acc.q_ddot + c, (0.7, -0.4), atol=1e-9)


@pytest.mark.parametrize("robot", [robot_of_case(CASES[1]), heavy_biglide()[0]])
def test_potential_is_that_of_the_bodies_and_what_holds_the_robot(robot):
    bodies = bodies_of_case(CASES[1]) if isinstance(robot, fb.FiveBar) else heavy_biglide()[1]
    offsets = []
    for a, _, rates in random_motions(robot, 20):
        offsets.append(fb.potential(rates.pose) - bodies.energy(a, (0, 0, 0, 0)))
        if abs(rates.pose.det_A) < 0.5:
            continue
        q, step = np.array([float(each) for each in a[::2]]), 2e-6
        mode = int(np.sign(-rates.pose.det_A))
        slope = [
            (fb.potential(fb.dgm(robot, q + e, mode)) - fb.potential(fb.dgm(robot, q - e, mode)))
            / (2 * step)
            for e in step * np.eye(2)
        ]
        np.testing.assert_allclose(
            fb.gravity_torques(fb.dgm(robot, q, mode)), slope, rtol=1e-6, atol=1e-6
        )
    assert np.ptp(offsets) < 1e-13  # but for a constant


def test_each_rung_costs_what_it_names():
    """Instructions of forward dynamics, rung by rung: no rung is free, none costs the other."""
    lab = fb.FiveBar()
    rungs = {
        "lab": lab,
        "viscous": replace(lab, fv1=0.01, fv2=0.01),
        "gravity": replace(lab, gravity=(0, -9.81)),
        "moments": replace(lab, gravity=(0, -9.81), mx11=0.02, mx21=0.02),
        "heavy": replace(lab, zz12=-1e-4, zz22=-1e-4),
    }
    count = {
        k: fb.compile(r, ["q", "q_dot", "tau"], ["q_ddot"]).n_instructions()
        for k, r in rungs.items()
    }
    assert (
        count["lab"] < min(count["viscous"], count["gravity"])
        and count["gravity"] < count["moments"] < count["heavy"]
    )
    assert count["moments"] < 1.1 * count["lab"] and count["heavy"] < 2.7 * count["lab"]
    # A first moment that no gravity pulls at moves with its bar, in zz1: it costs nothing.
    same = fb.compile(replace(lab, mx11=0.02), ["q", "q_dot", "tau"], ["q_ddot"]).n_instructions()
    assert same == count["lab"]


def test_loads_by_name_in_a_compiled_function():
    robot = robot_of_case(CASES[1])
    names = ["gravity_torques", "potential", "friction_torques"]
    call = fb.compile(robot, ["q", "q_dot"], names)
    rates = fb.dkm(fb.dgm(robot, (0.2, 1.4)), (1.2, -0.7))
    found = [each.full().ravel() for each in call((0.2, 1.4), (1.2, -0.7))]
    for value, own in zip(
        found,
        (fb.gravity_torques(rates.pose), fb.potential(rates.pose), fb.friction_torques(rates)),
    ):
        np.testing.assert_allclose(value, np.ravel(own), rtol=1e-12)
    # By name, c is what is left of the motion's own bias: without gravity, friction and speed there is none.
    M, c = fb.dynamic_model(rates)
    quiet = replace(robot, gravity=(0, 0), fv1=0, fv2=0, fs1=0, fs2=0)
    bias = fb.dynamic_model(fb.dkm(fb.dgm(quiet, (0.2, 1.4)), (1.2, -0.7)))[1]
    np.testing.assert_allclose(
        c, bias + fb.gravity_torques(rates.pose) + fb.friction_torques(rates), rtol=1e-10
    )


def test_the_two_ways_agree_where_both_apply():
    """An inertia of nearly nothing goes the long way, and gives what the bar forces give."""
    lab = fb.FiveBar(gravity=(0.3, -9.81), fv1=0.01)
    for _, _, rates in random_motions(lab, 30):
        heavy = bars_rates(replace(lab, zz12=1e-30), *bars_of(rates))
        one, other = (fb.forward_dynamics(each, (0.3, 0.2)) for each in (rates, heavy))
        np.testing.assert_allclose(
            one.q_ddot, other.q_ddot, rtol=1e-9, atol=1e-9 * np.abs(one.q_ddot).max()
        )
        first, second = (bar_forces(each, (0.3, 0.2)) for each in (rates, heavy))
        np.testing.assert_allclose(first, second, rtol=1e-8, atol=1e-9 * np.abs(first).max())


def test_at_rest_friction_holds_what_it_can():
    robot = fb.FiveBar(fs1=0.02, fs2=0.03)
    still = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.0, 0.0))
    assert np.all(fb.forward_dynamics(still, (0.01, -0.029)).q_ddot == 0)
    free, lab = fb.forward_dynamics(still, (0.05, -0.01)), replace(robot, fs1=0, fs2=0)
    assert free.q_ddot[0] > 0 and free.q_ddot[1] == 0
    # The one that moves is pushed by what is left of its torque, the other by what holds it: solve for that.
    M, _ = fb.dynamic_model(fb.dkm(fb.dgm(lab, (0.2, 0.4)), (0.0, 0.0)))
    assert free.q_ddot[0] == pytest.approx((0.05 - 0.02) / M[0, 0], rel=1e-12)
    batch = fb.dkm(
        fb.dgm(robot, np.tile((0.2, 0.4), (3, 1))), np.array([(0.0, 0.0), (0.0, 0.0), (1.0, 0.0)])
    )
    both = fb.forward_dynamics(batch, np.array([(0.01, -0.029), (0.05, -0.01), (0.0, 0.0)])).q_ddot
    np.testing.assert_array_equal(both[0], 0)
    np.testing.assert_allclose(both[1], free.q_ddot, rtol=1e-12)
    assert both[2, 0] < 0


def test_smoothed_friction_differs_by_half_the_square_of_the_rates_ratio():
    robot = fb.FiveBar(fs1=0.02, fs2=0.03)
    assert smoothed(fb.FiveBar(fv1=1.0), 0.1) == fb.FiveBar(fv1=1.0)
    rates = fb.dkm(fb.dgm(robot, (0.2, 0.4)), (2.0, -1.0))
    soft = fb.dkm(fb.dgm(smoothed(robot, 0.05), (0.2, 0.4)), (2.0, -1.0))
    less = (fb.friction_torques(rates) - fb.friction_torques(soft)) / fb.friction_torques(rates)
    np.testing.assert_allclose(less, 0.5 * (0.05 / np.array([2.0, 1.0])) ** 2, rtol=1e-2)


@pytest.mark.parametrize("rate", [0.0, 0.01, -3.0])
def test_smoothed_friction_is_smooth_in_forward_dynamics_of_numbers_too(rate):
    """Under their inverse dynamics drives move as they did: a drive that is slow or stands is not held."""
    soft = smoothed(fb.FiveBar(fs1=0.2, fs2=0.1, gravity=(0.0, -9.81)), 0.05)
    rates = fb.dkm(fb.dgm(soft, (0.2, 0.4)), (rate, 1.0))
    moving = fb.dkm2(rates, (2.0, -3.0))
    found = fb.forward_dynamics(rates, fb.inverse_dynamics(moving))
    np.testing.assert_allclose(found.q_ddot, moving.q_ddot, rtol=1e-10)


def test_bar_forces_carry_the_end_effector_and_turn_the_cranks():
    """A^T lambda = m (xi'' - g) and Z q'' + B lambda = tau - friction, for random motions upright."""
    robot, draw = fb.FiveBar(gravity=(0.7, -9.81), fv1=0.01, fv2=0.02), np.random.default_rng(4)
    rates = fb.dkm(fb.dgm(robot, draw.uniform(-0.5, 0.5, (40, 2))), draw.uniform(-3, 3, (40, 2)))
    tau = draw.uniform(-0.3, 0.3, (40, 2))
    acc, forces = fb.forward_dynamics(rates, tau), bar_forces(rates, tau)
    A, B = rates.pose.A, rates.pose.B
    weight = robot.m * (acc.xi_ddot - np.array(robot.gravity))
    np.testing.assert_allclose(np.einsum("nij,ni->nj", A, forces), weight, atol=1e-11)
    turning = (
        tau
        - np.array((robot.fv1, robot.fv2)) * rates.q_dot
        - np.array((robot.zz1, robot.zz2)) * acc.q_ddot
    )
    np.testing.assert_allclose(np.einsum("nij,nj->ni", B, forces), turning, atol=1e-11)
    np.testing.assert_allclose(
        np.linalg.solve(np.swapaxes(A, 1, 2), weight[..., None])[..., 0], forces, atol=1e-9
    )


def test_a_robot_that_moves_no_mass_has_the_motors_inertia_alone():
    robot = fb.FiveBar(m=0, fv1=0.01, fv2=0.02)
    rates = fb.dkm(fb.dgm(robot, (0.2, -0.1)), (0.7, -1.1))
    M, c = fb.dynamic_model(rates)
    assert M.tolist() == [[robot.zz1, 0.0], [0.0, robot.zz2]]
    assert c == pytest.approx([0.01 * 0.7, -0.02 * 1.1])
    plain = fb.dkm(fb.dgm(fb.FiveBar(m=0), (0.2, -0.1)), (0.7, -1.1))
    assert fb.dynamic_model(plain)[1].tolist() == [0.0, 0.0]
