"""`time_path` against a collocation of the same paths, written here: IPOPT, with the bar forces as unknowns.

Unknown are x = s'^2 at the nodes and both bar forces lambda at the middles of the intervals; there m xi'' = A^T lambda
and tau = Z q'' + B^T lambda, with s'' = x_s / 2, all of the place from the models. The time is the trapezoidal one,
exact where s'' is even. Nothing is divided by det A, so that Type 2 is a place like others. With friction each elbow
bears a moment M against its rate phi' - q': the massless bar l then pushes across itself too, by -M / l (no virtual
work where it alone turns), and the drive turns against fv q', fs sign(q') and -M as well.

Where a path crosses Type 2 almost along the bars, the criterion's s'^2 = -(a / b) s'' binds in a layer of |a / a_s|,
down to 1e-12 m. Intervals longer than that pass it too fast, with torques far above the limit between their middles,
and in less time than the lower bound; on intervals that end as short as the layer the time is between both bounds.
"""

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line
from tests.helpers.paths_to_time import almost_along_the_bars, bezier

ROBOT = fb.FiveBar()
RUBBING = fb.FiveBar(fv1=3e-3, fv2=2e-3, fs1=2e-3, fs2=1e-3, fv12=1e-3, fv22=2e-3)
HOME = (0.09, 0.06796322)
CASES = {  # name -> (robot, path, crossings of Type 2)
    "line": (ROBOT, Path((Line(HOME, (0.0, 0.1)),)), 0),
    "arc": (ROBOT, Path((Arc((0.0, 0.13), 0.02, 0.3, 6.5),)), 0),
    "line across Type 2": (ROBOT, Path((Line(HOME, (0.05, 0.0)),)), 1),
    "arc across Type 2, with friction": (RUBBING, Path((Arc((0.05, 0.03), 0.04, 1.2, -1.5),)), 1),
    "curve across Type 2": (
        ROBOT,
        Path((bezier([(0.02, 0.06), (-0.03, 0.03), (-0.06, 0.02), (-0.04, -0.05)], 0.13),)),
        1,
    ),
}


def of_the_place(robot, path, s):
    """xi_s, xi_ss, q_s, q_ss, u_12, u_22, B's diagonal, phi_s - q_s, l cos(phi - q) of both legs at s (n,), (n, 18)."""
    xi, xi_s, xi_ss, _ = path(s)
    rates = fb.ikm(fb.igm(robot, xi), xi_s)
    bend = fb.ikm2(rates, xi_ss)
    pose = rates.pose
    A, B = pose.A, pose.B
    elbows = rates.q_passive_dot, np.cos(pose.q_passive) * [robot.l11, robot.l21]
    return np.hstack(
        [xi_s, xi_ss, rates.q_dot, bend.q_ddot, A.reshape(-1, 4), B[:, 0, :1], B[:, 1, 1:], *elbows]
    )


def by_collocation(robot, path, limit, edges):
    """(the least time of the motion discretised at s = edges (n + 1,), s; its x there)."""
    h, count = np.diff(edges), len(edges) - 1
    tx, ty, nx, ny, q1, q2, p1, p2, x1, y1, x2, y2, b1, b2, e1, e2, c1, c2 = of_the_place(
        robot, path, (edges[1:] + edges[:-1]) / 2
    ).T
    x, first, second = (
        ca.SX.sym(name, n) for name, n in (("x", count + 1), ("first", count), ("second", count))
    )
    u, mean = (x[1:] - x[:-1]) / (2 * h), (x[1:] + x[:-1]) / 2
    speed = ca.sqrt(mean)
    force_x, force_y = (robot.m * (t * u + n * mean) for t, n in ((tx, nx), (ty, ny)))
    moment_1, moment_2 = robot.fv12 * e1 * speed, robot.fv22 * e2 * speed
    across_1, across_2 = -moment_1 / robot.l12, -moment_2 / robot.l22
    tau_1 = robot.zz1 * (q1 * u + p1 * mean) + b1 * first + c1 * across_1 - moment_1
    tau_2 = robot.zz2 * (q2 * u + p2 * mean) + b2 * second + c2 * across_2 - moment_2
    tau_1 += robot.fv1 * q1 * speed + robot.fs1 * np.sign(q1)
    tau_2 += robot.fv2 * q2 * speed + robot.fs2 * np.sign(q2)
    balance = ca.vertcat(
        force_x - x1 * first - x2 * second + y1 * across_1 + y2 * across_2,
        force_y - y1 * first - y2 * second - x1 * across_1 - x2 * across_2,
    )
    time = ca.sum1(2 * h / (ca.sqrt(x[1:]) + ca.sqrt(x[:-1])))
    problem = {
        "x": ca.vertcat(x, first, second),
        "f": time,
        "g": ca.vertcat(balance, tau_1 / limit, tau_2 / limit),
    }
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.tol": 1e-9}
    solver = ca.nlpsol("timing", "ipopt", problem, options)
    rest, most = 1e-12, np.ones(count + 1)
    most[[0, -1]] = rest
    free, none, one = np.full(2 * count, 1e3), np.zeros(2 * count), np.ones(2 * count)
    found = solver(
        x0=np.concatenate([np.full(count + 1, 1e-3), none]),
        lbx=np.concatenate([np.full(count + 1, rest), -free]),
        ubx=np.concatenate([most, free]),
        lbg=np.concatenate([none, -one]),
        ubg=np.concatenate([none, one]),
    )
    assert solver.stats()["success"], solver.stats()["return_status"]
    return float(found["f"]), np.array(found["x"])[: count + 1, 0]


@pytest.mark.deep
@pytest.mark.parametrize("name", CASES)
def test_a_collocation_of_the_same_path_takes_the_same_time(name):
    robot, path, crossings = CASES[name]
    motion = fb.time_path(robot, path, constraints=fb.Constraints(torque=0.05))
    assert motion.crossing.sum() == crossings
    least, _ = by_collocation(robot, path, 0.05, np.linspace(0.0, path.length, 2001))
    assert abs(motion.duration / least - 1) < 1e-3 and abs(motion.lower_bound / least - 1) < 1e-3


@pytest.mark.deep
def test_no_motion_that_keeps_its_limits_beside_type_2_is_below_the_lower_bound():
    path, limit = almost_along_the_bars(1e-4), 0.05
    motion = fb.time_path(ROBOT, path, constraints=fb.Constraints(torque=limit))
    coarse, fine = np.linspace(0.0, path.length, 1001), motion.s
    blind, x = by_collocation(ROBOT, path, limit, coarse)
    assert blind < 0.995 * motion.lower_bound
    # That motion between its nodes: s'' is even on each interval.
    share = np.linspace(0.05, 0.95, 19)[:, None]
    s, u = coarse[:-1] + share * np.diff(coarse), np.diff(x) / (2 * np.diff(coarse))
    xi, xi_s, xi_ss, _ = path(s)
    square = (x[:-1] + share * np.diff(x))[..., None]
    rates = fb.ikm(fb.igm(ROBOT, xi), xi_s * np.sqrt(square))
    tau = np.abs(fb.inverse_dynamics(fb.ikm2(rates, xi_ss * square + xi_s * u[:, None])))
    assert tau.max() > 5 * limit and motion.crossing.sum() == 1
    least, _ = by_collocation(
        ROBOT,
        path,
        limit,
        np.interp(np.arange(0, len(fine) - 0.5, 0.5), np.arange(len(fine)), fine),
    )
    assert motion.lower_bound < least < motion.duration and motion.gap < 1e-3
