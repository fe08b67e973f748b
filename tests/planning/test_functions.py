"""Costs and constraints of the user's own in plans: against those of the package, and along the motion."""

import io
import pickle

import casadi
import numpy as np
import pytest
from scipy.integrate import simpson

import fivebar as fb

ROBOT = fb.FiveBar(0.1, 0.11, 0.09, 0.12, 0.08, zz1=0.003, m=0.4)
START, GOAL = (0.06, 0.14), (-0.02, 0.12)
T = np.linspace(0.0, 0.8, 1601)


@pytest.fixture(scope="module")
def plain():
    """The plan of least effort."""
    return fb.plan(ROBOT, START, GOAL, 0.8)


def planned(objective="effort", **options):
    functions = options.pop("functions", {})
    constraints = fb.Constraints(functions=functions, **options.pop("constraints", {}))
    return fb.plan(ROBOT, START, GOAL, 0.8, objective=objective, constraints=constraints, **options)


def effort(motion):
    return casadi.sumsqr(motion.tau)


@pytest.mark.every(3)
@pytest.mark.parametrize("degree", [2, 3, 5])
def test_the_users_own_effort_is_the_package_s(degree):
    collocation = fb.Collocation(degree=degree)
    own = planned(effort, collocation=collocation)
    known = planned(collocation=collocation)
    assert own.objective == pytest.approx(known.objective, rel=1e-3)
    assert np.abs(own(T)[0] - known(T)[0]).max() < 2e-5
    assert own.aims == ("cost",)


@pytest.mark.deep
def test_a_plan_between_poses_has_own_costs_too():
    poses = [fb.igm(ROBOT, point) for point in (START, GOAL)]
    own = fb.plan(ROBOT, *poses, 0.8, objective=effort)
    known = fb.plan(ROBOT, *poses, 0.8)
    assert own.objective == pytest.approx(known.objective, rel=1e-9) and own.working is None


def test_weights_and_functions_are_added(plain):
    """Twice the effort, once by a weight and once by a function, is least where the effort is."""
    both = planned({"effort": 1.0, "own": effort})
    assert both.objective == pytest.approx(2 * plain.objective, rel=1e-6)
    assert np.abs(both(T)[0] - plain(T)[0]).max() < 1e-7
    smooth = planned({"effort": 1.0, "power": lambda m: 10 * casadi.sumsqr(m.tau * m.q_dot)})
    power = [np.mean((plan.torques(T) * plan.joints(T)[1]) ** 2) for plan in (plain, smooth)]
    assert power[1] < 0.9 * power[0]


def test_a_torque_limit_of_the_users_own(plain):
    limit = 0.85 * np.abs(plain.torques(T)).max()
    sides = {f"{k} {sign}": (k, sign) for k in (0, 1) for sign in (-1, 1)}

    def room(k, sign):
        return lambda m: 1 - sign * m.tau[k] / limit

    own = planned(functions={name: room(*side) for name, side in sides.items()})
    known = planned(constraints={"torque": limit})
    assert own.objective == pytest.approx(known.objective, rel=1e-4)
    assert np.abs(own.torques(T)).max() < 1.001 * limit
    assert all(own.violations[name] < 1e-3 for name in sides)


def test_states_bar_forces_and_time(plain):
    """A disc that moves, and the largest force in the bars."""
    centre = plain(0.4)[0]
    speed = np.array([0.0, 0.05])

    def beside(m):
        return casadi.norm_2(m.xi - centre - speed * (m.t - 0.4)) / 0.008 - 1

    forces = np.hypot(*plain.bar_forces(T).T).max()
    plan = planned(functions={"disc": beside})
    assert np.hypot(*(plan(T)[0] - centre - speed * (T[:, None] - 0.4)).T).min() > 0.00798
    light = planned(
        functions={"pull": lambda m: 1 - casadi.sumsqr(m.bar_forces) / (0.9 * forces) ** 2}
    )
    assert np.hypot(*light.bar_forces(T).T).max() < 0.901 * forces


def test_a_plan_with_functions_goes_to_other_processes_and_files():
    plan = planned(lambda m: casadi.sumsqr(m.tau), functions={"up": lambda m: m.xi[1] / 0.01})
    again = pickle.loads(pickle.dumps(plan))
    assert np.array_equal(again(T)[0], plan(T)[0]) and again.violations == plan.violations
    assert "up" in plan.violations and repr(again) == repr(plan)
    file = io.StringIO()
    plan.to_csv(file)
    assert '"functions": ["cost", "up"]' in file.getvalue().splitlines()[0]
    file.seek(0)
    assert np.array_equal(fb.Plan.from_csv(file)(T)[0], plan(T)[0])


SYMBOL = casadi.SX.sym("k")


@pytest.mark.parametrize(
    "function,words",
    [
        (lambda m: m.tau, "'own' of the objective must return one number, not 2"),
        (lambda m: None, "'own' of the objective fails on CasADi's symbols"),
        (
            lambda m: SYMBOL * m.tau[0],
            "depends on the symbol k, which is no quantity of the motion",
        ),
        (lambda m: casadi.sign(m.tau[0]), "is not differentiable, or constant"),
        (lambda m: m.tau[0] if m.tau[0] > 0 else 0, "truth value .* casadi.if_else in place of if"),
        (lambda m: m.torque, "no attribute 'torque'. It gets one argument with t, q, q_dot"),
        (lambda m: casadi.log(m.xi[0] - 0.2), "own is nan on the first guess, at t = 0.0"),
    ],
)
def test_a_function_that_is_none_says_what_is_wrong(function, words):
    with pytest.raises(ValueError, match=words):
        planned({"own": function})


def test_what_cannot_be_kept_is_named(plain):
    with pytest.raises(fb.PlanError, match="infeasible; violated: never by 1"):
        planned(functions={"never": lambda m: -1 - m.tau[0] ** 2})
    with pytest.raises(TypeError, match=r"functions must be \{name: function\}, not 3"):
        fb.Constraints(functions=3)
    with pytest.raises(ValueError, match="the constraint functions is not kept here"):
        fb.check_path(ROBOT, plain, constraints=fb.Constraints(functions={"up": lambda m: m.xi[1]}))
    with pytest.raises(ValueError, match="objective must be of effort, time, jerk, or a function"):
        planned({"comfort": 1.0})


def test_margins_of_symbols_serve_as_constraints():
    """The plain plan leaves |det A| <= 0.63 on its way, the one with the constraint keeps it."""
    ends = (0.05, 0.08), (-0.05, 0.08)

    def room(m):
        return 1 - fb.singularity_margins(fb.igm(ROBOT, m.xi)).parallel / 0.63

    constraints = fb.Constraints(functions={"det A": room})
    largest = []
    for plan in (fb.plan(ROBOT, *ends, 0.8), fb.plan(ROBOT, *ends, 0.8, constraints=constraints)):
        largest.append(fb.igm(ROBOT, plan(T)[0]).det_A.max())
    assert largest[0] > 0.65 and largest[1] < 0.6307


def test_a_cost_that_is_wrong_between_nodes_is_no_plan():
    """Torque costs nothing where a joint stands still: IPOPT put 30 N m between the nodes there.

    The plan said 1.5e-4 where the integral of the cost was 8e-3.
    """
    with pytest.raises(fb.PlanError, match="not accurate: .*nothing bounds the torque") as caught:
        fb.plan(
            fb.FiveBar(),
            (0.09, 0.068),
            (0.0, 0.1),
            1.0,
            objective=lambda m: casadi.sumsqr(m.tau * m.q_dot),
        )
    assert caught.value.plan.error > 1e-3


@pytest.mark.parametrize("degree", [2, 3])
def test_the_objective_of_own_costs_is_their_integral(degree):
    plan = fb.plan(
        fb.FiveBar(),
        (0.09, 0.068),
        (0.0, 0.1),
        1.0,
        objective={"effort": 1.0, "wear": lambda m: 10 * casadi.sumsqr(m.tau * m.q_dot)},
        collocation=fb.Collocation(degree=degree),
    )
    t = np.linspace(0.0, 1.0, 100001)
    tau = plan.torques(t)
    cost = (tau**2 + 10 * (tau * plan.joints(t)[1]) ** 2).sum(axis=1)
    assert plan.objective == pytest.approx(simpson(cost, t), rel=2e-3)
