"""The models against the source's numbers, and against each other where two of them say the same thing."""

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fivebar as fb
from fivebar.models.dynamics import bar_forces, drives_forces

from ..conftest import UNEQUAL

HOME = (0.09, 0.0679632253501847865)


def test_home_of_the_lab(five_bar_numbers):
    home = five_bar_numbers["home"]
    pose = fb.dgm(fb.FiveBar(), (0, 0))
    assert pose.xi == pytest.approx([float(home["x"]), float(home["y"])], rel=4e-16)
    assert pose.q_passive == pytest.approx([float(home["q12"]), float(home["q22"])], rel=4e-16)
    assert (pose.assembly, pose.working.tolist()) == (-1, [-1, -1])
    assert pose.assembly.dtype == pose.working.dtype == np.int8


def test_inverse_dynamics_of_the_reference(five_bar_numbers):
    for case in five_bar_numbers["inverse_dynamics"]:
        q, q_dot, q_ddot, tau = (np.array(case[key], float) for key in ("q", "qd", "qdd", "tau"))
        rates = fb.dkm(fb.dgm(fb.FiveBar(), q, case["assembly"]), q_dot)
        acc = fb.dkm2(rates, q_ddot)
        assert rates.pose.xi == pytest.approx([float(case["x"]), float(case["y"])], abs=1e-16)
        assert fb.inverse_dynamics(acc) == pytest.approx(tau, abs=2e-17)
        M, c = fb.dynamic_model(rates)
        assert M @ q_ddot + c == pytest.approx(tau, abs=2e-17)
        assert fb.forward_dynamics(rates, tau).q_ddot == pytest.approx(q_ddot, rel=1e-14)


def test_lab_task_1_of_the_reference(five_bar_numbers):
    reference = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
    for sample in five_bar_numbers["lab_task_1"]["samples"]:
        if sample["params"] != "zz0.002":
            continue
        xi, xi_dot, xi_ddot = reference(float(sample["t"]))
        acc = fb.ikm2(fb.ikm(fb.igm(fb.FiveBar(), xi), xi_dot), xi_ddot)
        expected = {key: np.array(sample[key], float) for key in ("p", "q", "qd", "qdd", "tau")}
        assert xi == pytest.approx(expected["p"], abs=3e-17)
        assert acc.rates.pose.q == pytest.approx(expected["q"], abs=1e-15)
        assert acc.rates.q_dot == pytest.approx(expected["qd"], abs=4e-15)
        assert acc.q_ddot == pytest.approx(expected["qdd"], abs=4e-14)
        assert fb.inverse_dynamics(acc) == pytest.approx(expected["tau"], abs=1e-16)
        assert np.linalg.det(acc.rates.pose.A) == pytest.approx(float(sample["detA"]), abs=1e-15)


def test_forced_motion_of_the_reference(five_bar_numbers):
    from scipy.integrate import solve_ivp

    robot, end = fb.FiveBar(), five_bar_numbers["forced_motion"]

    def slope(t, s):
        tau = np.array([0.02, -0.016]) * np.cos(2 * np.pi * t)
        return [*s[2:], *fb.forward_dynamics(fb.dkm(fb.dgm(robot, s[:2]), s[2:]), tau).q_ddot]

    last = solve_ivp(slope, (0, 2), np.zeros(4), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    assert last == pytest.approx(
        [float(end[key]) for key in ("q11", "q21", "q11_dot", "q21_dot")], abs=1e-11
    )


def test_dynamics_of_the_compliant_crossing(five_bar_numbers):
    case = five_bar_numbers["compliant_crossing"]
    p0, ps, pf, vs, at_crossing = (
        np.array(case[key], float) for key in ("p0", "ps", "pf", "vs", "as_")
    )
    rest = {1: (0, 0), 2: (0, 0)}
    path = fb.polynomial(
        [(0, {0: p0, **rest}), (2, {0: ps, 1: vs, 2: at_crossing}), (4, {0: pf, **rest})]
    )
    for sample in case["tau_at"]:
        xi, xi_dot, xi_ddot = path(float(sample["t"]))
        acc = fb.ikm2(fb.ikm(fb.igm(fb.FiveBar(), xi), xi_dot), xi_ddot)
        assert fb.inverse_dynamics(acc) == pytest.approx(np.array(sample["tau"], float), abs=1e-15)


def test_round_trips_and_modes(robot, reachable):
    xi, working = reachable
    pose = fb.igm(robot, xi, working)
    assert (pose.working == working).all()
    back = fb.dgm(robot, pose.q, pose.assembly)
    np.testing.assert_allclose(back.xi, xi, atol=2e-14)
    np.testing.assert_allclose(back.q_passive, pose.q_passive, atol=2e-13)
    assert (back.working == working).all() and (back.assembly == pose.assembly).all()
    np.testing.assert_allclose(
        np.linalg.norm(pose.elbows - xi[:, None], axis=2), [robot.distal] * len(xi), atol=1e-16
    )


def test_first_order_is_the_slope_of_geometry(robot, reachable):
    """Against a complex-free central difference of dgm, and A xi' = B q'."""
    xi, working = reachable
    pose = fb.igm(robot, xi, working)
    q_dot = np.random.default_rng(1).normal(size=xi.shape)
    rates = fb.dkm(pose, q_dot)
    h = 1e-6
    ahead, behind = (fb.dgm(robot, pose.q + s * h * q_dot, pose.assembly) for s in (1, -1))
    scale = np.abs(rates.xi_dot).max(axis=1, keepdims=True) + 1
    np.testing.assert_allclose(
        (ahead.xi - behind.xi) / (2 * h) / scale, rates.xi_dot / scale, atol=1e-6
    )
    turn = np.angle(np.exp(1j * (ahead.q_passive - behind.q_passive)))
    np.testing.assert_allclose(turn / (2 * h) / 40, rates.q_passive_dot / 40, atol=1e-6)
    left, right = (
        np.einsum("nij,nj->ni", pose.A, rates.xi_dot),
        np.einsum("nij,nj->ni", pose.B, q_dot),
    )
    np.testing.assert_allclose(left, right, atol=1e-14)
    np.testing.assert_allclose(fb.ikm(pose, rates.xi_dot).q_dot, q_dot, atol=1e-12)


def test_second_order_is_the_slope_of_the_first(robot, reachable):
    xi, working = reachable
    pose = fb.igm(robot, xi, working)
    rng = np.random.default_rng(2)
    q_dot, q_ddot, h = rng.normal(size=xi.shape), rng.normal(size=xi.shape), 1e-6

    def rates_at(t):
        there = fb.dgm(robot, pose.q + t * q_dot + t**2 / 2 * q_ddot, pose.assembly)
        return fb.dkm(there, q_dot + t * q_ddot)

    acc = fb.dkm2(rates_at(0.0), q_ddot)
    ahead, behind = rates_at(h), rates_at(-h)
    for name in ("xi", "q_passive"):
        slope = (getattr(ahead, f"{name}_dot") - getattr(behind, f"{name}_dot")) / (2 * h)
        exact = getattr(acc, f"{name}_ddot")
        scale = np.abs(exact).max(axis=1, keepdims=True) + 1
        np.testing.assert_allclose(slope / scale, exact / scale, atol=1e-5)
    np.testing.assert_allclose(fb.ikm2(acc.rates, acc.xi_ddot).q_ddot, q_ddot, atol=1e-10)
    left = np.einsum("nij,nj->ni", acc.rates.pose.A, acc.xi_ddot)
    right = np.einsum("nij,nj->ni", acc.rates.pose.B, q_ddot) + acc.rates.d
    np.testing.assert_allclose(left, right, atol=1e-12)


@pytest.mark.parametrize("own", [fb.FiveBar(), UNEQUAL, fb.Biglide()])
def test_a_motion_given_in_task_space_or_at_the_joints_turns_the_bars_alike(own):
    """From x'' by the law of cosines or the guide, from q'' by the projection: two formulations of one motion."""
    draw = np.random.default_rng(5)
    span = (0.25, 0.25) if own.turns else (0.2, 1.0)
    xi = draw.uniform(-1, 1, (400, 2)) * span
    pose = fb.igm(own, xi, draw.choice([-1, 1], (400, 2)), unreachable="nan")
    pose = fb.igm(
        own,
        *(
            (each[np.abs([*pose.sines, pose.det_A]).min(axis=0) > 0.2])
            for each in (xi, pose.working)
        ),
    )
    given = fb.ikm2(fb.ikm(pose, draw.normal(size=pose.xi.shape)), draw.normal(size=pose.xi.shape))
    joints = fb.dkm2(fb.dkm(fb.dgm(own, pose.q, pose.assembly), given.rates.q_dot), given.q_ddot)
    assert len(pose.q) > 50
    np.testing.assert_allclose(
        given.rates.q_passive_dot, joints.rates.q_passive_dot, rtol=1e-9, atol=1e-9
    )
    np.testing.assert_allclose(given.q_passive_ddot, joints.q_passive_ddot, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(given.phi_ddot, joints.phi_ddot, rtol=1e-8, atol=1e-8)


def test_dynamics_agree_with_each_other(robot, reachable):
    xi, working = reachable
    rng = np.random.default_rng(3)
    rates = fb.dkm(fb.igm(robot, xi, working), rng.normal(size=xi.shape))
    M, c = fb.dynamic_model(rates)
    q_ddot = rng.normal(size=xi.shape)
    tau = fb.inverse_dynamics(fb.dkm2(rates, q_ddot))
    scale = np.abs(tau).max(axis=1, keepdims=True)
    np.testing.assert_allclose(
        (np.einsum("nij,nj->ni", M, q_ddot) + c) / scale, tau / scale, atol=1e-12
    )
    np.testing.assert_allclose(fb.forward_dynamics(rates, tau).q_ddot, q_ddot, atol=1e-10)
    kinetic = np.einsum("ni,nij,nj->n", rates.q_dot, M, rates.q_dot) / 2
    np.testing.assert_allclose(fb.energy(rates) / kinetic, 1.0, atol=1e-12)
    acc = fb.forward_dynamics(rates, tau)
    power = (
        robot.zz1 * acc.q_ddot[:, 0] * rates.q_dot[:, 0]
        + robot.zz2 * acc.q_ddot[:, 1] * rates.q_dot[:, 1]
    )
    power += robot.m * np.sum(acc.xi_ddot * rates.xi_dot, axis=1)
    np.testing.assert_allclose(
        power, np.sum(tau * rates.q_dot, axis=1), atol=1e-12 * np.abs(power).max()
    )


@pytest.mark.every(3)
@pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
@pytest.mark.parametrize("model", ["dgm", "igm"])
def test_casadi_symbols_give_the_same_numbers(robot, reachable, kind, model):
    xi, working = (array[:40] for array in reachable)
    numbers = fb.igm(robot, xi, working)
    for mode in {tuple(w) for w in working.tolist()} if model == "igm" else {-1, 1}:
        position, speed, push = (kind.sym(name, 2) for name in ("position", "speed", "push"))
        if model == "igm":
            chosen = (working == mode).all(axis=1)
            rates = fb.ikm(fb.igm(robot, position, working=mode), speed)
            inputs = numbers.xi[chosen]
        else:
            chosen = numbers.assembly == mode
            rates = fb.dkm(fb.dgm(robot, position, assembly=mode), speed)
            inputs = numbers.q[chosen]
        M, c = fb.dynamic_model(rates)
        acc = fb.forward_dynamics(rates, push)
        pose = rates.pose
        parts = [
            pose.q,
            pose.xi,
            pose.q_passive,
            pose.A,
            pose.B,
            pose.elbows,
            pose.reach_margin,
            pose.assembly,
        ]
        parts += [
            pose.working,
            rates.q_dot,
            rates.xi_dot,
            rates.q_passive_dot,
            rates.d,
            M,
            c,
            fb.energy(rates),
        ]
        parts += [acc.q_ddot, acc.xi_ddot, acc.q_passive_ddot, fb.inverse_dynamics(acc)]
        parts += [fb.dkm2(rates, push).xi_ddot, fb.ikm2(rates, push).q_ddot]
        function = casadi.Function(
            "all", [position, speed, push], [casadi.reshape(part.T, -1, 1) for part in parts]
        )
        for row in inputs:
            given = fb.dgm(robot, row, mode) if model == "dgm" else fb.igm(robot, row, mode)
            rates = fb.dkm(given, (0.3, -0.2)) if model == "dgm" else fb.ikm(given, (0.3, -0.2))
            M, c = fb.dynamic_model(rates)
            acc = fb.forward_dynamics(rates, (0.01, 0.02))
            pose = rates.pose
            expected = [
                pose.q,
                pose.xi,
                pose.q_passive,
                pose.A,
                pose.B,
                pose.elbows,
                pose.reach_margin,
                pose.assembly,
            ]
            expected += [
                pose.working,
                rates.q_dot,
                rates.xi_dot,
                rates.q_passive_dot,
                rates.d,
                M,
                c,
                fb.energy(rates),
            ]
            expected += [acc.q_ddot, acc.xi_ddot, acc.q_passive_ddot, fb.inverse_dynamics(acc)]
            expected += [fb.dkm2(rates, (0.01, 0.02)).xi_ddot, fb.ikm2(rates, (0.01, 0.02)).q_ddot]
            for symbolic, number in zip(function(row, (0.3, -0.2), (0.01, 0.02)), expected):
                number = np.ravel(number)
                np.testing.assert_allclose(
                    symbolic.full().ravel(), number, atol=1e-12 * max(1.0, np.abs(number).max())
                )


def test_one_pose_and_a_batch_agree(robot, reachable):
    xi, working = (array[:24] for array in reachable)
    batch = fb.igm(robot, xi.reshape(4, 6, 2), working.reshape(4, 6, 2))
    rates = fb.ikm(batch, (0.1, -0.3))
    acc = fb.forward_dynamics(rates, (0.01, 0.02))
    for k in range(24):
        at = divmod(k, 6)
        one = fb.ikm(fb.igm(robot, tuple(xi[k]), tuple(working[k])), (0.1, -0.3))
        one_acc = fb.forward_dynamics(one, (0.01, 0.02))
        for name in (
            "q",
            "xi",
            "q_passive",
            "A",
            "B",
            "elbows",
            "assembly",
            "working",
            "reach_margin",
        ):
            np.testing.assert_allclose(
                getattr(batch, name)[at], getattr(one.pose, name), atol=1e-14
            )
        np.testing.assert_allclose(rates.q_dot[at], one.q_dot, rtol=1e-12)
        np.testing.assert_allclose(acc.xi_ddot[at], one_acc.xi_ddot, rtol=1e-10, atol=1e-12)


lengths = st.floats(0.02, 2.0)


@given(
    lengths,
    lengths,
    lengths,
    lengths,
    st.just(0.0) | st.floats(1e-12, 2.0),
    st.floats(-7, 7),
    st.floats(-7, 7),
    st.sampled_from([-1, 1]),
)
def test_every_pose_closes_its_loops(l11, l12, l21, l22, d, q11, q21, assembly):
    try:
        robot = fb.FiveBar(l11, l12, l21, l22, d)
        pose = fb.dgm(robot, (q11, q21), assembly)
    except (ValueError, fb.SingularityError):
        return
    residual = np.abs(np.linalg.norm(pose.elbows - pose.xi, axis=1) - robot.distal)
    assert residual.max() <= 4 * np.finfo(float).eps * (l11 + l12 + l21 + l22 + d)
    assert np.all((-np.pi < pose.q_passive) & (pose.q_passive <= np.pi))
    assert pose.reach_margin >= -1e-15


@given(st.floats(-2, 0.4), st.floats(-4, 0.7), st.floats(-10, -1), st.booleans())
def test_forward_dynamics_is_regular_next_to_every_singularity(x, y, exponent, type_2):
    """M q'' + c loses digits as 1 / det A^2 near Type 2; the bar-force form keeps the power balance to rounding."""
    robot, gap = fb.FiveBar(), 10.0**exponent
    if type_2:  # elbows almost 2 l apart
        q = np.arccos(np.clip((0.18 - gap - 0.118) / 0.18, -1, 1))
        pose = fb.dgm(robot, (np.pi - q, q))
    else:  # the left leg almost in line
        pose = fb.igm(robot, (-0.059 + (0.18 - gap) * np.cos(0.6), (0.18 - gap) * np.sin(0.6)))
    rates = fb.dkm(pose, (x, y)) if not type_2 else fb.ikm(pose, (x / 10, y / 10))
    acc = fb.forward_dynamics(rates, (0.01, -0.02))
    gained = robot.zz1 * acc.q_ddot[0] * rates.q_dot[0] + robot.zz2 * acc.q_ddot[1] * rates.q_dot[1]
    gained += robot.m * acc.xi_ddot @ rates.xi_dot
    spent = 0.01 * rates.q_dot[0] - 0.02 * rates.q_dot[1]
    turned = (
        np.abs(acc.q_ddot * rates.q_dot).sum() * 0.002
        + 0.5 * np.abs(acc.xi_ddot * rates.xi_dot).sum()
    )
    assert gained == pytest.approx(spent, abs=1e-9 * turned + 1e-15)
    closure = pose.A @ acc.xi_ddot - pose.B @ acc.q_ddot - rates.d
    assert np.abs(closure).max() <= 1e-12 * (1 + np.abs(acc.q_ddot).max() + np.abs(rates.d).max())


def test_forward_dynamics_on_the_singularities():
    robot = fb.FiveBar()
    # Type 2, reached through igm: on the circle of self-motion about (0, -0.06796...) where the elbows coincide.
    xi = (0.09 * np.cos(2.0), -HOME[1] + 0.09 * np.sin(2.0))
    modes = [(a, b) for a in (-1, 1) for b in (-1, 1)]
    pose = next(p for p in (fb.igm(robot, xi, w) for w in modes) if abs(p.det_A) < 1e-9)
    assert np.isfinite(fb.forward_dynamics(fb.ikm(pose, (0.1, 0.2)), (0.01, 0.02)).xi_ddot).all()
    # Type 1, reached through dgm: the left leg stretched.
    stretched = fb.igm(robot, (-0.059 + 0.18 * np.cos(0.6), 0.18 * np.sin(0.6)))
    pose = fb.dgm(robot, stretched.q, stretched.assembly)
    acc = fb.forward_dynamics(fb.dkm(pose, (0.0, 0.0)), (0.01, 0.02))
    assert acc.q_ddot[0] == pytest.approx(0.01 / 0.002, rel=1e-6)


def test_bar_forces_move_the_end_effector_and_are_the_drives_word_on_them(robot, reachable):
    xi, working = reachable
    rates = fb.ikm(fb.igm(robot, xi, working), np.random.default_rng(3).normal(size=xi.shape))
    tau = np.random.default_rng(4).normal(size=xi.shape)
    forces, acc = bar_forces(rates, tau), fb.forward_dynamics(rates, tau)
    push = np.einsum("nij,ni->nj", rates.pose.A, forces)
    assert np.abs(push - robot.m * acc.xi_ddot).max() <= 1e-12 * np.abs(push).max()
    left, right = drives_forces(acc, tuple(tau.T))
    assert np.abs(np.stack([left, right], -1) - forces).max() <= 1e-9 * np.abs(forces).max()
