"""What the live page computes with: one function for every question, the robot's lengths among its
inputs.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from ...base.backend import as_numbers, sqrt
from ...models.charts import BarAngles, halves
from ...models.dyads import cross
from ...models.dynamics import energy, forward_dynamics, gravity_torques
from ...models.four_joints import bars_rates, closed
from ...models.geometry import joint_pose, task_pose
from ...models.kinematics import ikm, solve_a
from ...models.loads import potential
from ...models.parameters import count_of, with_parameters
from ...models.robots import FiveBar
from ...singularities.four_bar_motion import four_bar_directions
from ...singularities.leg_circles import turn_to
from ..functions import named_function, pose_outputs, script
from .mechanisms import mechanisms

LENGTHS = "l11", "l12", "l21", "l22", "d"
INERTIAS = "zz1", "zz2", "m"
BEYOND = (
    "mx11",
    "my11",
    "mx21",
    "my21",
    "zz12",
    "zz22",
    "my12",
    "my22",
    "gravity",
    "fv1",
    "fv2",
    "fv12",
    "fv22",
)
FLAT = ("sense", "fourBarMotion", "inLine", "slope")


@lru_cache(maxsize=1)
def models() -> str:
    """Return all of the page's functions in JavaScript."""
    return script([*_poses(), *_loci(), *_motion(), *mechanisms()[0]], FLAT)


def _symbols(**sizes):
    return [ca.SX.sym(name, size) for name, size in sizes.items()]


def _pairs(*vectors):
    return [(v[0], v[1]) for v in vectors]


def _robot(p):
    return FiveBar(**{name: p[k] for k, name in enumerate(LENGTHS)})


def _poses():
    """igm and dgm; their signs alone, for fields of pixels; what force and speed become at a
    pose.
    """
    p, point, modes, mode, out = _symbols(p=5, point=2, modes=2, mode=1, force=2)
    robot = _robot(p)
    with as_numbers():
        reached = task_pose(robot, *_pairs(point, modes))
        driven = joint_pose(robot, *_pairs(point), mode)
        yield named_function(
            "igm",
            pose_outputs(reached) | {"clear": _clearances(robot, reached.point)},
            point,
            modes,
            p,
        )
        yield named_function("dgm", pose_outputs(driven), point, mode, p)
    bare = task_pose(robot, *_pairs(point, modes))
    yield named_function("sense", {"parallel": bare.det_A}, point, modes, p)
    J = _jacobian(bare)
    yield named_function("gains", {"J": J, "torque": J.T @ out}, point, modes, out, p)


def _clearances(robot, point):
    """Return how far the end-effector is inside the limits of the left and right leg: outer and
    inner of each, m.
    """
    found = []
    for drive, bar in zip(robot.drives, robot.distal):
        span = sqrt(sum(each * each for each in drive.apart(*point)))
        found += [
            limit - span if outer else span - abs(limit) for limit, outer in drive.limits(bar)
        ]
    return ca.vertcat(*found)


def _jacobian(pose):
    """J = A^-1 B: the end-effector's velocity for each motor's rate 1."""
    b1, b2 = pose.b
    columns = [solve_a(pose, along, "gains") for along in ((b1, 0.0 * b2), (0.0 * b1, b2))]
    return ca.horzcat(*(ca.vertcat(*column) for column in columns))


def _loci():
    """Yield four-bars over their parameter, and what a five-bar with these bars in line is."""
    t, sides, span, slack, signs, mirrored = _symbols(
        t=1, sides=4, span=1, slack=4, signs=2, mirrored=1
    )
    with as_numbers():
        directions, _ = four_bar_directions(
            tuple(sides[k] for k in range(4)),
            span,
            ((slack[0], slack[1]), (slack[2], slack[3])),
            *_pairs(signs),
            t,
        )
    (x1, y1), (x2, y2), (x, y) = directions
    flipped = -x2, y2, -x1, y1, x, -y
    found = [
        ca.if_else(mirrored, there, here) for there, here in zip(flipped, (x1, y1, x2, y2, x, y))
    ]
    yield named_function(
        "fourBarMotion", {"directions": ca.vertcat(*found)}, t, sides, span, slack, signs, mirrored
    )

    bars, p = _symbols(bars=8, p=5)
    u11, u12, u21, u22 = ((bars[2 * k], bars[2 * k + 1]) for k in range(4))
    robot = _robot(p)
    (left, right), (l12, _) = robot.drives, robot.distal
    elbow = left.pivot(u11)
    outputs = {
        "x": elbow[0] + l12 * u12[0],
        "y": elbow[1] + l12 * u12[1],
        "q1": left.coordinate(u11),
        "q2": right.coordinate(u21),
        "serial1": left.sine(u11, u12),
        "serial2": right.sine(u21, u22),
        "parallel": cross(u12, u22),
    }
    yield named_function("inLine", outputs, bars, p)

    r, d, radius = _symbols(r=1, d=1, radius=1)
    yield named_function("turnTo", {"angle": turn_to(r, d, radius)}, r, d, radius)


def _motion():
    """Yield the state of all four bars: how it begins, its slope, its closure, its energy."""
    p, point, modes, velocity, state, tau = _symbols(
        p=5, point=2, modes=2, velocity=2, state=8, tau=2
    )
    chart = BarAngles()
    a, a_dot, _ = chart.coordinates(ikm(task_pose(_robot(p), *_pairs(point, modes)), velocity))
    yield named_function("begin", {"state": ca.vertcat(*a, *a_dot)}, point, modes, velocity, p)

    c, c_dot, rates = closed(_robot(p), *halves(state, chart))
    seen = {
        "closed": ca.vertcat(*c, *c_dot),
        "xi": rates.pose.xi,
        "serial": ca.vertcat(*rates.pose.sines),
        "parallel": rates.pose.det_A,
    }
    yield named_function("closeLoop", seen, state, p)

    whole = ca.SX.sym("whole", count_of(FiveBar, BEYOND))
    robot = with_parameters(FiveBar, whole, BEYOND)
    rates = bars_rates(robot, *halves(state, chart))
    accelerations = chart.accelerations(forward_dynamics(rates, tau))
    yield named_function(
        "slope", {"derivative": ca.vertcat(state[4:], *accelerations)}, state, tau, whole
    )
    yield named_function(
        "energies", {"kinetic": energy(rates), "potential": potential(rates.pose)}, state, whole
    )
    yield named_function(
        "holding",
        {"torque": gravity_torques(task_pose(robot, *_pairs(point, modes)))},
        point,
        modes,
        whole,
    )
