"""What a tracker solves in a sample: its derivatives, its QP and the check of it, against independent solvers."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.optimize import lsq_linear

import fivebar as fb
from fivebar.control.prediction import JOINTS, SIZE, Model
from fivebar.control.qp import QP, Condenser, Status, optimality, riccati, stage_lengths
from fivebar.models.four_joints import bars_of, bars_rates


def start_in(robot, xi=(0.03, 0.09), xi_dot=(0.05, -0.08)):
    a, a_dot = bars_of(fb.ikm(fb.igm(robot, xi), xi_dot))
    return np.array([*a, *a_dot])


def test_prediction_is_the_plant_and_of_second_order(robot):
    state = start_in(robot)
    tau, errors = np.array([0.01, -0.02]), []
    for h in (0.02, 0.01):
        after = Model(robot, (h, h), False).step(state, tau, 0.0)[0].tolist()
        rates = bars_rates(robot, tuple(after[:4]), tuple(after[4:]))
        run = fb.simulate(
            robot,
            lambda *_: tau,
            start=fb.ikm(fb.igm(robot, (0.03, 0.09)), (0.05, -0.08)),
            duration=h,
            control_period=h,
            step=h / 20,
        )
        errors.append(
            np.linalg.norm(
                np.array(rates._xi_dot) - fb.dkm(fb.dgm(robot, run.q[-1]), run.q_dot[-1]).xi_dot
            )
        )
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3, abs=0.2)  # of one step


@pytest.mark.parametrize("elbows", [False, True])
def test_condensed_gradient_is_the_cost_s(robot, elbows):
    """H v + g at the predicted motion: the derivative of the nonlinear cost, but for the midpoint's inexact slopes."""
    lengths = (1e-3, 1e-3, 2e-3, 3e-3)
    N, scale, weights = len(lengths), 0.05, (1e4, 10.0, 100.0)
    model = Model(robot, lengths, False)
    condense = Condenser(lengths, *weights, scale, SIZE)
    state, levers = start_in(robot), np.array([0.09, 0.1])
    rng = np.random.default_rng(3)
    guess, previous = rng.normal(size=2 * N), rng.normal(size=2)
    target = np.array([0.03, 0.09, 0.05, -0.08]) + 1e-3 * rng.normal(size=(N + 1, 4))
    terminal = np.kron(riccati(lengths[0], *weights[:2]), np.eye(2))

    def predict(v):
        states, AB, motion, C = (
            a.copy() for a in model.rollout(state, scale * v.reshape(N, 2), 0.0)
        )
        return (
            motion,
            AB.reshape(N, SIZE, SIZE + 2),
            C.reshape(N, 4, SIZE),
            (states[:, JOINTS] - 0.3) * levers,
        )

    now = model.look(state)[0].copy() - target[0]

    def cost(v):
        motion, _, _, arcs = predict(v)
        e = motion - target[1:]
        share = np.array(lengths) / lengths[0]
        acceleration = np.diff(np.vstack([now, e])[:, 2:], axis=0) / np.array(lengths)[:, None]
        total = (share[:-1] * np.sum((weights[0] * e[:-1, :2]) ** 2, axis=1)).sum() + e[
            -1
        ] @ terminal @ e[-1]
        total += (share * np.sum((weights[1] * acceleration) ** 2, axis=1)).sum()
        total += (share * np.sum((weights[0] * arcs) ** 2, axis=1)).sum() * elbows
        change = np.diff(np.vstack([previous, v.reshape(N, 2)]), axis=0)
        return 0.5 * (total + np.sum((weights[2] * scale * change) ** 2))

    motion, AB, C, arcs = predict(guess)
    H, g = condense(
        now,
        motion - target[1:],
        AB,
        C,
        previous,
        guess,
        (arcs, JOINTS, levers[None]) if elbows else None,
    )
    steps = 1e-3 * np.eye(2 * N)
    central = np.array([(cost(guess + s) - cost(guess - s)) / 2e-3 for s in steps])
    np.testing.assert_allclose(H @ guess + g, central, rtol=0, atol=1e-3 * np.abs(central).max())
    assert np.linalg.eigvalsh(H).min() > 0


def test_terminal_cost_solves_the_riccati_equation():
    h, position, acceleration = 0.01, 1e4, 10.0
    A, B = np.array([[1, h], [0, 1]]), np.array([[h * h / 2], [h]])
    expected = solve_discrete_are(A, B, np.diag([position**2, 0]), np.array([[acceleration**2]]))
    np.testing.assert_allclose(riccati(h, position, acceleration), expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("horizon", "period", "seconds"), [(20, 0.01, 1.0), (20, 0.01, 0.2), (2, 0.1, 3.0)]
)
def test_stages_cover_the_horizon(horizon, period, seconds):
    lengths = stage_lengths(horizon, period, seconds)
    assert len(lengths) == horizon and lengths[0] == period and (np.diff(lengths) >= 0).all()
    assert sum(lengths) == pytest.approx(seconds, rel=1e-9)


def test_stages_are_never_too_long_to_predict_unless_asked():
    assert max(stage_lengths(20, 0.001)) == pytest.approx(0.14)
    assert sum(stage_lengths(20, 0.01)) == pytest.approx(1.0)
    assert stage_lengths(200, 0.01) == pytest.approx((0.01,) * 200)


def random_qp(seed, n=12):
    rng = np.random.default_rng(seed)
    R, r = rng.normal(size=(2 * n, n)), rng.normal(size=2 * n)
    return R, r, R.T @ R, R.T @ r, np.full(n, -0.1), np.full(n, 0.1), np.zeros((0, n)), np.zeros(0)


@pytest.mark.parametrize("seed", range(5))
def test_solution_is_an_independent_solver_s(seed):
    R, r, H, g, low, high, rows, upper = random_qp(seed)
    v, iterations, status = QP(12, 0)(H, g, rows, upper, low, high)
    assert status == Status.SOLVED
    np.testing.assert_allclose(v, lsq_linear(R, -r, (low, high), method="bvls").x, atol=1e-9)
    assert iterations == 1 + np.sum(np.abs(np.abs(v) - 0.1) < 1e-12) > 1


def test_check_accepts_rows_in_force():
    _, _, H, g, low, high, _, _ = random_qp(1)
    rows, upper = np.ones((2, 12)), np.array([-0.3, 5.0])
    qp = QP(12, 2)
    v, _, status = qp(H, g, rows, upper, low, high)
    assert status == Status.SOLVED and rows[0] @ v == pytest.approx(-0.3)
    forces = qp.call.outputs[2]
    assert optimality(H, g, rows, upper, low, high, v, forces) < 1e-10 < 1e-3 < forces[0]
    assert optimality(H, g, rows, upper, low, high, v, 0 * forces) > 1e-3


@pytest.mark.parametrize("corrupt", ["moved", "outside", "nan", "huge", "stale"])
def test_check_catches_a_corrupted_solution(corrupt):
    *_, H, g, low, high, rows, upper = random_qp(0)
    qp = QP(12, 0)
    call = qp.call

    class Corrupted:
        stats = call.stats

        def __call__(self, *arguments):
            results = call(*arguments)
            if corrupt == "stale":
                return call(*random_qp(9)[2:4], *arguments[2:])
            values = {
                "moved": results[0][3] * 0.99 + 1e-3,
                "outside": 0.2,
                "nan": np.nan,
                "huge": 1e308,
            }
            results[0][3] = values[corrupt]
            return results

    assert qp(H, g, rows, upper, low, high)[2] == Status.SOLVED
    qp.call = Corrupted()
    assert qp(H, g, rows, upper, low, high)[2] == Status.CHECK_FAILED


def test_infeasible_problem_is_reported():
    _, _, H, g, low, high, _, _ = random_qp(2)
    rows = np.ones((1, 12))
    assert QP(12, 1)(H, g, rows, np.array([-100.0]), low, high)[2] in (
        Status.QP_FAILED,
        Status.CHECK_FAILED,
    )
