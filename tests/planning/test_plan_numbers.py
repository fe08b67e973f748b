"""Numbers of plans by other ways: accelerations, defects, files that say what is wrong with them."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.planning.collocation import Scheme
from fivebar.planning.coordinates import bars
from fivebar.planning.problem import OBJECTIVES, Problem, checked_stops
from fivebar.planning.samples import hermite

from ..conftest import UNEQUAL

ROBOT = fb.FiveBar()
START, GOAL = (0.05, 0.12), (-0.03, 0.1)
HEAVY = fb.FiveBar.from_links(
    0.11,
    0.14,
    0.08,
    0.12,
    0.09,
    {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08},
    payload=0.2,
    gravity=(0.0, -9.81),
)
BIGLIDE = fb.Biglide()
ROUGH = fb.Collocation(intervals=4, tolerance=0.5)
PLACE = {BIGLIDE: (0.01, 0.2)}


def problem_of(robot, working):
    weights = dict.fromkeys(OBJECTIVES, 0.0) | {"effort": 1.0}
    stops = checked_stops(START, GOAL, 1.0, [])
    if working is None:
        stops = tuple(({0: np.zeros(4)}, t) for t in (0.0, 1.0))
    return Problem(robot, stops, working, weights, fb.Constraints(), Scheme(3))


def coordinates_of(robot, working, t):
    """A motion of the tip: xi, or the four bars there, at times (n,)."""
    x, y = PLACE.get(robot, START)
    xi = np.stack([x + 0.02 * np.sin(t), y + 0.01 * np.cos(2 * t)], axis=1)
    if working is not None:
        return xi
    return np.array([bars(fb.igm(robot, each)) for each in xi])


@pytest.mark.parametrize("working", [(-1, -1), None])
@pytest.mark.parametrize("robot", [UNEQUAL, HEAVY, BIGLIDE])
def test_accelerations_and_defects_of_a_motion(robot, working):
    """The acceleration is a second difference; torques that are off leave a defect, exact ones none."""
    problem = problem_of(robot, working)
    h = 1e-4
    c = coordinates_of(robot, working, 0.4 + h * np.arange(-2, 3))
    rates = (c[0] - 8 * c[1] + 8 * c[3] - c[4]) / (12 * h)
    bends = (-c[0] + 16 * c[1] - 30 * c[2] + 16 * c[3] - c[4]) / (12 * h * h)
    motion = np.concatenate([c[2], rates, bends])
    acc = problem.accelerations(motion)
    xi = coordinates_of(robot, (-1, -1), np.array([0.4]))[0]
    xi_dot = np.array([0.02 * np.cos(0.4), -0.02 * np.sin(0.8)])
    xi_ddot = np.array([-0.02 * np.sin(0.4), -0.04 * np.cos(0.8)])
    exact = fb.ikm2(fb.ikm(fb.igm(robot, xi), xi_dot), xi_ddot)
    for found, own in (
        (acc.rates.pose.xi, xi),
        (acc.rates.xi_dot, xi_dot),
        (acc.xi_ddot, xi_ddot),
        (acc.rates.q_dot, exact.rates.q_dot),
        (acc.q_ddot, exact.q_ddot),
    ):
        assert found == pytest.approx(own, abs=1e-6)
    tau = fb.inverse_dynamics(exact)
    coordinates = problem.coordinates
    assert coordinates.defect(np.append(motion, tau), acc) < 1e-5
    off = np.array([0.01, -0.02])
    defect = coordinates.defect(np.append(motion, tau + off), acc)
    made = fb.forward_dynamics(acc.rates, tau + off)
    if working is not None:
        pose = acc.rates.pose
        push = np.linalg.solve(pose.B, off) @ pose.A
        assert defect == pytest.approx(np.linalg.norm(push), rel=1e-4)
    else:
        mass = robot.m
        if robot is HEAVY:
            mass = abs(robot.m) + sum(map(abs, robot.inertias)) / robot.l12**2
        wrong = np.abs(made.q_ddot - exact.q_ddot).max()
        assert defect >= mass * max(robot.distal) * wrong * (1 - 1e-4)
        shift = np.linalg.norm(made.xi_ddot - xi_ddot) / min(robot.distal)
        assert defect < 4 * mass * max(robot.distal) * (wrong + shift)


def test_units_of_coordinates():
    """Lengths where something slides, radians where it turns."""
    length = (UNEQUAL.l12 + UNEQUAL.l22) / 2
    slides = problem_of(BIGLIDE, None)
    assert problem_of(UNEQUAL, (-1, -1)).coordinates.units(problem_of(UNEQUAL, None)) == (
        pytest.approx([length] * 2)
    )
    assert problem_of(UNEQUAL, None).coordinates.units(slides) == pytest.approx(
        [slides.length, 1.0] * 2
    )
    turns = problem_of(UNEQUAL, None)
    assert turns.coordinates.units(turns).tolist() == [1.0] * 4


def test_the_error_of_a_plan_is_its_largest_defect_over_its_largest_force():
    plan = fb.plan(ROBOT, START, GOAL, 1.0, collocation=fb.Collocation(intervals=8))
    tau = plan.pieces.tau.copy()
    tau[3] += 0.01
    wrong = replace(plan, pieces=replace(plan.pieces, tau=tau))
    t = plan.pieces.knots[3:5] @ [[0.5], [0.5]]
    pose = plan.accelerations(t).rates.pose
    assert wrong.defects.argmax() == 3
    assert np.delete(wrong.defects, 3) == pytest.approx(np.delete(plan.defects, 3), abs=1e-12)
    expected = np.linalg.norm(np.linalg.solve(pose.B[0], [0.01, 0.01]) @ pose.A[0])
    assert wrong.defects[3] == pytest.approx(expected, rel=0.1)
    fine = np.linspace(0.0, 1.0, 2001)
    force = ROBOT.m * np.linalg.norm(plan(fine)[2], axis=1).max()
    assert wrong.error == pytest.approx(wrong.defects[3] / force, rel=1e-2)


@pytest.fixture(scope="module")
def written():
    plan = fb.plan(ROBOT, START, GOAL, 1.0, collocation=ROUGH)
    file = io.StringIO()
    plan.to_csv(file)
    return plan, file.getvalue().splitlines()


def altered(lines, change):
    """The lines with what the first of them holds changed."""
    begin = lines[0].index("{")
    about = json.loads(lines[0][begin:])
    change(about)
    return [lines[0][:begin] + json.dumps(about), *lines[1:]]


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda about: about.update(method="euler"), "no method euler of degree 3"),
        (lambda about: about.update(degree=8), "no method legendre-gauss of degree 8"),
        (lambda about: about.update(degree=1), "no method legendre-gauss of degree 1"),
        (lambda about: about["knots"].reverse(), "knots"),
        (lambda about: about["begins"][0].__setitem__(0, float("inf")), "begins must be finite"),
        (lambda about: about["knots"].__setitem__(1, 0.2), "the times are not those"),
        (lambda about: about.pop("weights"), "weights"),
    ],
)
def test_a_file_of_another_plan_is_refused(written, change, words):
    lines = altered(written[1], change)
    with pytest.raises(ValueError, match=words):
        fb.Plan.from_csv(io.StringIO("\n".join(lines)))


def test_rows_that_lack_are_counted(written):
    plan, lines = written
    assert len(lines) == 2 + 4 * 3 + 2
    with pytest.raises(ValueError, match="13 rows, its first line needs 14"):
        fb.Plan.from_csv(io.StringIO("\n".join(lines[:-1])))


def test_a_file_keeps_what_the_plan_was_asked_for():
    constraints = fb.Constraints(
        torque=0.5, sin=0.05, collisions=fb.LinkCollisions(0.004, posts=0.005)
    )
    poses = [fb.igm(ROBOT, point) for point in (START, GOAL)]
    settings = fb.Collocation(intervals=4, degree=2, tolerance=0.5)
    for ends in (poses, (START, {0: GOAL, 1: (0.01, 0.0), 2: (0.0, 0.0)})):
        plan = fb.plan(ROBOT, *ends, 1.0, constraints=constraints, collocation=settings)
        file = io.StringIO()
        plan.to_csv(file)
        file.seek(0)
        again = fb.Plan.from_csv(file)
        for name in ("robot", "working", "weights", "constraints"):
            assert getattr(again.problem, name) == getattr(plan.problem, name), name
        for one, other in zip(again.problem.stops, plan.problem.stops, strict=True):
            assert one[1] == other[1] and one[0].keys() == other[0].keys()
            for order, value in one[0].items():
                assert value == pytest.approx(other[0][order], abs=0)
        for name in ("objective", "status", "meshes", "solve_time", "tried", "error"):
            assert getattr(again, name) == getattr(plan, name), name
        t = np.linspace(0.0, 1.0, 101)
        assert np.array_equal(again.motion(t), plan.motion(t))


def test_a_plan_in_words(written):
    plan = written[0]
    assert repr(plan) == (
        f"<Plan: five-bar robot, 1 s, working (-1, -1), effort {plan.objective:.4g}, 4 intervals,"
        " Solve_Succeeded>"
    )
    assert repr(fb.line((0.09, 0.068), (0.05, 0.09), 2.0)) == (
        "<Trajectory: 0 to 2 s, from = (0.09, 0.068) m, to = (0.05, 0.09) m>"
    )


def test_quintics_between_samples_have_their_values_rates_and_accelerations():
    rng = np.random.default_rng(8)
    t = np.cumsum(rng.uniform(0.1, 2.0, 5))
    values = rng.normal(size=(3, 5, 2))
    motion = hermite(t, *values)
    assert motion(t) == pytest.approx(np.concatenate(values, axis=1), abs=1e-12)
    before = motion(t[1:] - 1e-9)
    assert before == pytest.approx(np.concatenate(values, axis=1)[1:], abs=1e-5)
    inner = np.linspace(t[0] + 1e-3, t[-1] - 1e-3, 301)
    h = 1e-5
    slopes = (motion(inner + h) - motion(inner - h))[:, :4] / (2 * h)
    assert slopes == pytest.approx(motion(inner)[:, 2:], rel=1e-4, abs=1e-4)
    exact = np.polynomial.Polynomial(rng.normal(size=6))
    columns = [np.stack([exact.deriv(k)(t), -exact.deriv(k)(t)], axis=1) for k in (1, 2)]
    again = hermite(t, np.stack([exact(t), -exact(t)], axis=1), *columns)
    assert again(inner)[:, 0] == pytest.approx(exact(inner), rel=1e-9)
    assert again(inner)[:, 5] == pytest.approx(-exact.deriv(2)(inner), rel=1e-7, abs=1e-7)


def test_a_file_with_rates_and_accelerations_is_followed_exactly(tmp_path):
    line = fb.line(START, GOAL, 2.0)
    t = np.array([0.0, 0.7, 2.0])
    rows = np.column_stack([t, *line(t)]).tolist()
    head = "t (s),x (m),y (m),x_dot (m/s),y_dot (m/s),x_ddot (m/s2),y_ddot (m/s2)\n"
    text = head + "\n".join(",".join(map(repr, row)) for row in rows)
    path = fb.from_csv(io.StringIO(text))
    fine = np.linspace(0.0, 2.0, 201)
    for found, exact in zip(path(fine), line(fine)):
        assert found == pytest.approx(exact, abs=1e-12)
