"""Both bounds of `time_path`: found again closer together they agree, and no motion is above a ceiling."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Line
from fivebar.paths.timing import solve as timing_solve
from fivebar.paths.timing.constraint_rows import PARTS, ConstraintRows, Limits, rows_of
from fivebar.paths.timing.lower_bound import caps
from fivebar.paths.timing.mesh import mesh_of
from tests.helpers.paths_to_time import ROBOTS, random_limits, random_path, used

ACROSS = Path((Line((0.09, 0.06796322), (0.05, 0.0)),))


@pytest.mark.every(3)
@pytest.mark.parametrize("name", ["lab", "all", "across Type 2"])
def test_closer_bounds_lie_between_wide_ones(name):
    robot, torque, centre, width = ROBOTS.get(name, ROBOTS["lab"])
    rng = np.random.default_rng(502)
    path, limits = random_path(rng, centre, width), random_limits(rng, robot, torque)
    if name == "across Type 2":
        path, limits = ACROSS, {"torque": 0.05}
    wide = fb.time_path(robot, path, gap=2e-2, constraints=fb.Constraints(**limits))
    close = fb.time_path(robot, path, gap=2e-4, constraints=fb.Constraints(**limits))
    assert wide.lower_bound <= close.lower_bound * (
        1 + 1e-6
    ) and close.duration <= wide.duration * (1 + 1e-6)
    assert close.lower_bound <= close.duration and close.gap <= 2e-4 < wide.gap
    # s'^2 of the faster motion at the other's nodes, between its own as it moves there.
    passed = np.searchsorted(close.s, wide.s[1:-1], side="right") - 1
    gone = wide.s[1:-1] - close.s[passed]
    length = np.diff(close.s)[passed]
    u0 = np.diff(close.x)[passed] / (2 * length) - close.bent[passed] * length / 2
    x = close.x[passed] + gone * (2 * u0 + close.bent[passed] * gone)
    assert (x <= wide.ceiling[1:-1] * (1 + 1e-9)).all()


@pytest.mark.parametrize("curvature", [-1e4, -1.0, 1e-6, 1e3])
def test_a_parabola_of_squared_speed_is_bent_as_it_is(curvature):
    """The second difference of a parabola is exact on any nodes; where it changes its sign there is none."""
    s = np.cumsum(np.random.default_rng(7).uniform(0.01, 0.3, 30))
    bent = timing_solve._bent(5.0 + 2 * s + curvature * s**2, np.diff(s))
    assert bent == pytest.approx(np.full(29, curvature), rel=1e-3)
    bent = timing_solve._bent(curvature * np.abs(s - s[15]) ** 3 * np.sign(s - s[15]), np.diff(s))
    assert (bent[[14, 15]] == 0).any() and (bent[[0, -1]] != 0).all()


def test_the_work_that_is_done_ends_the_search(monkeypatch):
    monkeypatch.setattr(timing_solve, "LOOKS", 2000)
    monkeypatch.setattr(timing_solve, "WORK", 0)
    path, given = (
        Path((Line((0.09, 0.06796322), (0.0, 0.1)),)),
        {"gap": 1e-7, "constraints": fb.Constraints(torque=0.05)},
    )
    one, again, less = (
        fb.time_path(fb.FiveBar(), path, **given, max_time=most) for most in (60.0, 1e6, 1e-9)
    )
    assert (
        (one.x == again.x).all()
        and one.lower_bound == again.lower_bound
        and used(one, {"torque": 0.05}) <= 1
    )
    assert 1e-7 < one.gap < less.gap and len(less.x) < len(one.x)


def test_rows_are_above_zero_where_the_models_exceed_a_limit():
    """At nodes, of random x and u, by the models' torques, accelerations and speeds."""
    robot, _, centre, width = ROBOTS["all"]
    rng = np.random.default_rng(4)
    mesh = mesh_of(robot, random_path(rng, centre, width), (-1, -1))
    limits = Limits((0.5, 0.6), (2.0, 3.0), (30.0, 40.0), 0.2, 3.0, None, (0.8, 0.7), (9.0, 7.0))
    angles = np.linspace(-np.pi, np.pi, 200, endpoint=False)
    directions = np.repeat(angles[:, None], len(mesh), axis=1)
    s = mesh.path.knots[mesh.stretches.piece] + mesh.stretches.first
    x, u = rng.uniform(0.0, 0.06, len(mesh)), rng.uniform(-4, 4, len(mesh))
    _, xi_s, xi_ss, _ = mesh.path.on(mesh.stretches.piece, mesh.stretches.first)
    rates = fb.ikm(fb.igm(robot, mesh.path(s)[0], (-1, -1)), xi_s * np.sqrt(x)[:, None])
    acc = fb.ikm2(rates, xi_ss * x[:, None] + xi_s * u[:, None])
    tau = fb.inverse_dynamics(acc)
    used = {
        "torque": np.abs(tau) / limits.torque,
        "stall": np.abs(tau / limits.stall + rates.q_dot / limits.no_load),
        "joint_acceleration": np.abs(acc.q_ddot) / limits.joint_acceleration,
        "acceleration": np.linalg.norm(acc.xi_ddot, axis=1)[:, None] / limits.acceleration,
    }
    alone = {
        "joint_speed": (rates.q_dot / limits.joint_speed) ** 2,
        "speed": np.linalg.norm(rates.xi_dot, axis=1)[:, None] ** 2 / limits.speed**2,
    }
    sizes = np.stack([u, x, np.sqrt(x), np.ones(len(mesh))])
    known = (mesh.turns != 0).all(axis=0) & (np.abs(rates.q_dot) > 1e-9).all(axis=1)
    assert known.mean() > 0.9
    for name in (*used, *alone):
        only = Limits(**{name: getattr(limits, name)})
        if name == "stall":
            only = replace(only, no_load=limits.no_load)
        speed = np.full(len(mesh), limits.speed if name == "speed" else np.inf)
        about = mesh.side, mesh.turns, directions, speed
        for inside in (False, True):
            rows = rows_of(mesh.found, only, *about, inside)
            # Of an acceleration alone there are rows of x, too.
            counts = (rows.kind == "speed") == (name in alone)
            value = sum(rows.parts[part][0, counts] * size for part, size in zip(PARTS, sizes))
            if name in ("torque", "stall"):
                assert (rows.kind == "torque").all()
                value = value / np.abs(rates.pose.det_A)
            expected = (used | alone)[name].max(axis=1) - 1
            off = (value.max(axis=0) - expected)[known]
            assert np.abs(off).max() < (2e-3 if name == "acceleration" else 1e-9)


def test_a_path_that_is_proved_impossible_is_told_from_one_that_is_not_found():
    """With gravity, just before rest beyond Type 2, no torque of this size slows the motion that the crossing needs."""
    heavy = fb.FiveBar(gravity=(0.0, -9.81))
    with pytest.raises(
        fb.TimingError, match="no motion along the path keeps these limits"
    ) as caught:
        fb.time_path(heavy, ACROSS, constraints=fb.Constraints(torque=1.0))
    assert caught.value.proved and 0.06 < caught.value.s < ACROSS.length


@pytest.mark.every(3)
@pytest.mark.parametrize("seed", [5, 27, 31])
def test_type_2_is_crossed_under_gravity_at_the_speed_that_it_needs(seed):
    """There the robot cannot be held at rest: it has to pass, and the criterion has a constant part."""
    robot, limits = fb.FiveBar(gravity=(0.0, -3.0)), {"torque": 1.0}
    start, goal = (
        np.array([0.05, 0.03]) + np.random.default_rng(0).uniform(-0.06, 0.06, (seed + 1, 2, 2))
    )[-1]
    motion = fb.time_path(
        robot, Path((Line(tuple(start), tuple(goal)),)), constraints=fb.Constraints(**limits)
    )
    assert motion.crossing.sum() == 1 and motion.gap <= 1e-3 and used(motion, limits, 30) <= 1
    assert fb.check_path(robot, motion).criterion_holds


@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_caps_are_where_no_acceleration_is_feasible(friction):
    """Of random rows a u + b x + v sqrt(x) + c <= 0: looked for on a grid of x, u from each row by itself."""
    rng = np.random.default_rng(7)
    n, count = 400, 4
    parts = {name: np.tile(rng.normal(size=(count, n)), (3, 1, 1)) for name in PARTS}
    parts["c"] = -np.abs(parts["c"])
    parts["v"] *= friction
    nothing = {name: np.zeros((count, n)) for name in PARTS}
    # The tip's rows, by themselves, are left to those of x alone.
    kind = np.array(["torque", "joint", "joint", "tip"])
    largest = caps(ConstraintRows(parts, nothing, nothing, kind))
    assert (largest[0] == largest[1]).all()
    x = np.geomspace(1e-6, 1e6, 4001)
    a, b, v, c = (parts[name][0][..., None] for name in PARTS)
    u = -(b * x + v * np.sqrt(x) + c) / a
    most = np.where(a > 0, u, np.inf).min(axis=0)
    least = np.where(a < 0, u, -np.inf).max(axis=0)
    possible = np.where(most > least, x, 0.0).max(axis=1)
    assert (possible < largest[0] * (1 + 1e-6)).all()
    near = possible > np.minimum(largest[0], x[-1]) * 0.99
    assert near.mean() == 1 if not friction else near.mean() > 0.9
