"""The four bars as the state of every pose: regular wherever a robot can be, but with all its bars parallel."""

import casadi
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import fivebar as fb
from fivebar.models.charts import BarAngles
from fivebar.models.four_joints import bars_of, bars_rates, closed, loop_gap
from fivebar.models.parameters import parameters_of

from ..conftest import UNEQUAL

AMORO, BIGLIDE = fb.FiveBar(), fb.Biglide()
CHANGE_POINT = fb.FiveBar(
    0.1, 0.2, 0.15, 0.1, 0.05
)  # l11 + l12 - l21 - l22 = d: all bars can lie along the base
CORNER = (0.0, float(np.sqrt(0.18**2 - 0.059**2)))  # both legs straight
modes = st.sampled_from([(-1, -1), (-1, 1), (1, -1), (1, 1)])
rate = st.floats(-3, 3)


def accelerations(rates, tau):
    return np.array(BarAngles().accelerations(fb.forward_dynamics(rates, tau)))


def singular_poses():
    """Bars of poses in which the two-coordinate charts end: Types 1, 2 and 3, a leg folded on its base, a corner."""
    home = fb.igm(AMORO, CORNER)
    yield "corner", np.array(bars_of(fb.Rates(home, (0.0, 0.0), (0.0, 0.0)))[0])
    x, y = -0.059, 0.0  # the left base joint: that leg is folded, its proximal bar anywhere
    drive = AMORO.drives[1]
    dyad = drive.close((x, y), AMORO.l22, -1)
    q2, phi2 = (np.arctan2(*unit[::-1]) for unit in (dyad.first, dyad.last))
    for q1 in (0.3, 1.7, -2.0):
        yield "fold", np.array([q1, q1 + np.pi, q2, phi2])
    yield "Type 3", np.array([phi2 + np.pi, phi2, q2, phi2])


@pytest.mark.parametrize("name, a", list(singular_poses()))
def test_accelerations_stay_finite_and_close_the_loop_twice_differentiated(name, a):
    a, a_dot, rates = closed(AMORO, tuple(a), (0.7, -0.4, 0.2, 0.9))
    assert np.hypot(*loop_gap(rates.pose)) < 1e-16
    a_ddot = accelerations(rates, (0.02, -0.01))
    assert np.isfinite(a_ddot).all() and np.abs(a_ddot).max() < 1e4
    # The loop as a function of time, a + a' t + a'' t^2 / 2, opens with t^3 only.
    gaps = [moved_gap(AMORO, a, a_dot, a_ddot, t) for t in (1e-2, 1e-3)]
    assert gaps[0] < 1e-4 and gaps[1] < gaps[0] * 2e-3


def moved_gap(robot, a, a_dot, a_ddot, t):
    moved = tuple(float(x + v * t + w * t * t / 2) for x, v, w in zip(a, a_dot, a_ddot))
    return np.hypot(*loop_gap(bars_rates(robot, moved, (0.0,) * 4).pose))


@given(
    st.sampled_from([AMORO, UNEQUAL, BIGLIDE]),
    st.floats(-0.2, 0.2),
    st.floats(-0.2, 0.3),
    modes,
    rate,
    rate,
    rate,
)
def test_the_same_motion_as_in_the_end_effectors_coordinates(
    robot, x, y, working, x_dot, y_dot, push
):
    pose = fb.igm(robot, (x, y), working, unreachable="nan")
    assume(np.isfinite(pose.q).all() and min(abs(s) for s in (*pose.sines, pose.det_A)) > 0.05)
    known = fb.ikm(pose, (x_dot, y_dot))
    a, a_dot = bars_of(known)
    rates = bars_rates(robot, a, a_dot)
    assert rates.pose.xi == pytest.approx(pose.xi, abs=1e-14) and rates.xi_dot == pytest.approx(
        (x_dot, y_dot), abs=1e-11
    )
    assert (rates.pose.working == working).all() and rates.pose.assembly == pose.assembly
    expected = fb.forward_dynamics(known, (push, -push))
    found = fb.forward_dynamics(rates, (push, -push))
    scale = 1 + np.abs(expected.q_ddot).max()
    assert found.q_ddot == pytest.approx(expected.q_ddot, abs=1e-9 * scale)
    assert found.q_passive_ddot == pytest.approx(expected.q_passive_ddot, abs=1e-8 * scale)


def test_one_step_closes_the_loop_to_rounding_and_moves_least():
    pose = fb.igm(UNEQUAL, (0.02, 0.15))
    a, a_dot = (np.array(each) for each in bars_of(fb.ikm(pose, (0.3, -0.2))))
    rng = np.random.default_rng(1)
    for _ in range(50):
        off, off_dot = a + rng.normal(scale=1e-8, size=4), a_dot + rng.normal(scale=1e-8, size=4)
        found, rates_found, rates = closed(UNEQUAL, tuple(off), tuple(off_dot))
        assert np.hypot(*loop_gap(rates.pose)) <= 2e-16
        # Least: the change has no part along the two directions in which a closed loop can turn.
        columns = np.array(list(columns_of(UNEQUAL, found)))
        free = np.linalg.svd(columns.T)[2][2:]
        assert np.abs(free @ (np.array(found) - off)).max() < 1e-14
        assert np.abs(columns.T @ np.array(rates_found)).max() < 1e-9  # as good as differences are
        x, y = rates.pose.u2[1]
        assert rates.pose.elbows[1] + UNEQUAL.l22 * np.array([x, y]) == pytest.approx(
            rates.pose.xi, abs=3e-16
        )
        q2, turn2 = rates_found[2:]
        c, s = np.cos(found[2]), np.sin(found[2])
        velocity = UNEQUAL.l21 * q2 * np.array([-s, c]) + UNEQUAL.l22 * turn2 * np.array([-y, x])
        assert velocity == pytest.approx(rates.xi_dot, abs=5e-16)


def columns_of(robot, a):
    """By differences of the gap, independent of what `closed` uses."""
    h = 1e-6
    for k in range(4):
        ends = []
        for side in (h, -h):
            moved = list(a)
            moved[k] += side
            ends.append(np.array(loop_gap(bars_rates(robot, tuple(moved), (0.0,) * 4).pose)))
        yield (ends[0] - ends[1]) / (2 * h)


def test_arrays_and_symbols_say_the_same_as_floats():
    pose = fb.igm(UNEQUAL, (0.02, 0.15))
    a, a_dot = bars_of(fb.ikm(pose, (0.3, -0.2)))
    one = bars_rates(UNEQUAL, a, a_dot)
    columns = [np.full(3, value) for value in (*a, *a_dot)]
    batch = bars_rates(UNEQUAL, tuple(columns[:4]), tuple(columns[4:]))
    assert (batch.pose.xi == one.pose.xi).all() and (batch.q_passive_dot == one.q_passive_dot).all()
    state, tau = casadi.SX.sym("state", 8), casadi.SX.sym("tau", 2)
    parts = [state[k] for k in range(8)]
    acc = BarAngles().accelerations(
        fb.forward_dynamics(bars_rates(UNEQUAL, parts[:4], parts[4:]), tau)
    )
    call = casadi.Function("f", [state, tau], [casadi.vertcat(*acc)])
    assert call([*a, *a_dot], [0.1, 0.2]).full().ravel() == pytest.approx(
        accelerations(one, (0.1, 0.2)), rel=1e-13
    )


def test_four_parallel_bars_are_what_only_a_change_point_robot_can_do():
    a = np.array([0.0, 0.0, 0.0, 0.0])
    rates = bars_rates(CHANGE_POINT, tuple(a), (0.1, 0.2, 0.3, 0.4))
    assert np.hypot(*loop_gap(rates.pose)) < 1e-16
    with pytest.raises(fb.SingularityError, match="both distal bars are parallel"):
        fb.forward_dynamics(rates, (0.0, 0.0))


def test_robots_with_symbols_as_parameters():
    """A compiled function of the robot itself: models, dynamics and reach margin, equal to those of the numbers."""
    for robot, q in ((UNEQUAL, (0.2, -0.1)), (BIGLIDE, (0.05, -0.02))):
        symbols = casadi.SX.sym("p", len(parameters_of(robot)))
        names = robot.parameters
        unknown = type(robot)(**{name: symbols[k] for k, name in enumerate(names)})
        xi = fb.dgm(robot, q).xi
        at, push = casadi.SX.sym("at", 2), casadi.SX.sym("push", 2)
        direct = fb.dkm(fb.dgm(unknown, at), push)
        M, c = fb.dynamic_model(direct)
        inverse = fb.igm(unknown, at)
        call = casadi.Function(
            "f",
            [symbols, at, push],
            [direct.pose.xi, M, c, fb.forward_dynamics(direct, push).q_ddot],
        )
        back = casadi.Function("g", [symbols, at], [inverse.q, inverse.reach_margin])
        known = fb.dkm(fb.dgm(robot, q), (0.4, -0.3))
        M, c = fb.dynamic_model(known)
        expected = known.pose.xi, M, c, fb.forward_dynamics(known, (0.4, -0.3)).q_ddot
        for ours, theirs in zip(call(parameters_of(robot), q, (0.4, -0.3)), expected):
            assert ours.full().squeeze() == pytest.approx(theirs, rel=1e-12, abs=1e-14)
        found, margin = back(parameters_of(robot), xi)
        assert found.full().ravel() == pytest.approx(q, abs=1e-13)
        assert float(margin) == pytest.approx(float(fb.igm(robot, xi).reach_margin), rel=1e-12)
    with pytest.raises(ValueError, match="l11 must be a number, not"):
        fb.FiveBar(l11="long")
