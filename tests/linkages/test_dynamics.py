"""Driving torques against Newton and Euler: every body free, joints as constraint forces, one linear system."""

import cmath
import math

import numpy as np
import pytest

from fivebar import UnreachableError
from fivebar.linkages import (
    GRAVITY,
    PRINTED,
    REPAIRED,
    Body,
    FiveBarLinkage,
    FourBar,
    SliderCrank,
    driving_torque,
    equivalent_inertia,
    move,
    potential,
)

GROUND = None


def solve(bodies, joints, guided, driven, q_dot, q_ddot, forces, gravity):
    """The driving torque: bodies {name: (mass, inertia, centre)}, joints (name or GROUND, name, point), complex points.

    guided: (name, unit vector across its guide), a body that does not turn; forces {name: complex}, at the centres.
    """
    names = list(bodies)
    rows, gamma_of, rate_of = [], [], []

    def columns(name, point):
        """The velocity of a body's point as two rows of the constraint matrix, and the arm."""
        block = np.zeros((2, 3 * len(names)))
        if name is GROUND:
            return block, 0j
        k, arm = 3 * names.index(name), point - bodies[name][2]
        block[:, k : k + 3] = [[1, 0, -arm.imag], [0, 1, arm.real]]
        return block, arm

    for a, b, point in joints:
        (left, arm_a), (right, arm_b) = columns(a, point), columns(b, point)
        rows += list(left - right)
        rate_of += [0.0, 0.0]
        gamma_of += [(a, arm_a, b, arm_b, part) for part in ("real", "imag")]
    if guided:
        name, across = guided
        k = 3 * names.index(name)
        for row in ((across.real, across.imag, 0.0), (0.0, 0.0, 1.0)):
            rows.append(np.zeros(3 * len(names)))
            rows[-1][k : k + 3] = row
            rate_of.append(0.0)
            gamma_of.append(None)
    rows.append(np.zeros(3 * len(names)))
    rows[-1][3 * names.index(driven) + 2] = 1.0
    J = np.array(rows)
    rate = np.linalg.solve(J, np.array([*rate_of, q_dot]))
    omega = {name: rate[3 * k + 2] for k, name in enumerate(names)} | {GROUND: 0.0}
    gamma = [
        0.0 if g is None else getattr(omega[g[0]] ** 2 * g[1] - omega[g[2]] ** 2 * g[3], g[4])
        for g in gamma_of
    ]
    M = np.diag([x for mass, inertia, _ in bodies.values() for x in (mass, mass, inertia)])
    F = np.zeros(len(M))
    for k, (name, (mass, _, _)) in enumerate(bodies.items()):
        force = forces.get(name, 0j) + mass * complex(*gravity)
        F[3 * k : 3 * k + 2] = force.real, force.imag
    system = np.block([[M, -J.T], [J, np.zeros_like(M)]])
    return np.linalg.solve(system, np.concatenate([F, gamma, [q_ddot]]))[-1]


def apex(p, r, r1, r2, side):
    z = r - p
    return p + r1 * cmath.exp(
        1j * (cmath.phase(z) + side * math.acos((abs(z) ** 2 + r1**2 - r2**2) / (2 * abs(z) * r1)))
    )


def press_torque(press, q, q_dot, q_ddot, load, gravity):
    d = cmath.rect(press.l11, press.theta11)
    b = cmath.rect(press.l2, q)
    c = apex(b, d, press.l3, press.l4, -1)
    e = complex(d.real, c.imag - math.sqrt(press.l5**2 - (c.real - d.real) ** 2))
    ends = {"2": (0j, b), "3": (b, c), "4": (d, c), "5": (c, e), "6": (e, e)}
    bodies = {
        k: (getattr(press, f"m{k}"), getattr(press, f"j{k}", 0.0), (start + end) / 2)
        for k, (start, end) in ends.items()
    }
    # The crank's inertia and the slider's do not count here, but a body without one makes the system singular.
    bodies["6"] = (press.m6, 1.0, e)
    joints = [
        (GROUND, "2", 0j),
        ("2", "3", b),
        ("3", "4", c),
        ("4", GROUND, d),
        ("4", "5", c),
        ("5", "6", e),
    ]
    return solve(bodies, joints, ("6", 1 + 0j), "2", q_dot, q_ddot, {"6": 1j * load}, gravity)


@pytest.mark.parametrize("gravity", [(0.0, 0.0), GRAVITY], ids=["no gravity", "gravity"])
@pytest.mark.parametrize("load", [0.0, 1e5], ids=["free", "100 kN"])
@pytest.mark.parametrize(
    "press, low, high", [(REPAIRED, 0.0, 6.28), (PRINTED, 0.9, 5.8)], ids=["repaired", "printed"]
)
def test_press_torque_against_newton_and_euler(press, low, high, load, gravity):
    q, q_dot, q_ddot = np.linspace(low, high, 60), 2.0943951023931953, 0.7
    torque = driving_torque(move(press, q, q_dot, q_ddot), {"E": (0.0, load)}, gravity)
    expected = np.array([press_torque(press, x, q_dot, q_ddot, load, gravity) for x in q])
    # Relative at each angle, and to a thousandth of the peak where the torque passes zero.
    assert torque == pytest.approx(expected, rel=1e-9, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("branch", [1, -1])
def test_four_bar_torque_against_newton_and_euler(branch):
    bodies = (Body(0.4, 0.002, (0.03, 0.01)), Body(0.9, 0.005, (0.1, -0.04)), Body(0.6, 0.003))
    linkage = FourBar(0.3, 0.1, 0.25, 0.2, (0.1, -0.04), (0.02, -0.01), 0.3, *bodies)
    a = complex(*linkage.base)
    d = a + cmath.rect(0.3, 0.3)
    for q in np.linspace(0, 6, 17):
        b = a + cmath.rect(0.1, q)
        c = apex(b, d, 0.25, 0.2, branch)
        arms = {"crank": (a, b - a), "coupler": (b, c - b), "rocker": (d, c - d)}
        centres = [complex(*(body.centre or (0.1, 0.0))) for body in bodies]
        named = {
            name: (body.mass, body.inertia, start + centre * arm / abs(arm))
            for (name, (start, arm)), body, centre in zip(arms.items(), bodies, centres)
        }
        joints = [
            (GROUND, "crank", a),
            ("crank", "coupler", b),
            ("coupler", "rocker", c),
            ("rocker", GROUND, d),
        ]
        expected = solve(named, joints, None, "crank", 3.0, -1.1, {"coupler": 4 - 7j}, (1.0, -9.81))
        motion = move(linkage, float(q), 3.0, -1.1, branch)
        # M is the coupler's centre of mass, where the load is.
        assert driving_torque(motion, {"M": (4.0, -7.0)}, (1.0, -9.81)) == pytest.approx(
            expected, rel=1e-9, abs=1e-12
        )


def test_slider_crank_torque_against_newton_and_euler():
    linkage = SliderCrank(
        0.05,
        0.15,
        0.02,
        crank_body=Body(1.2, 0.003),
        rod_body=Body(0.8, 0.004),
        slider_body=Body(0.5, 0.0),
    )
    for q in np.linspace(0, 6, 17):
        a = cmath.rect(0.05, q)
        b = complex(a.real + math.sqrt(0.15**2 - (0.02 - a.imag) ** 2), 0.02)
        named = {
            "crank": (1.2, 0.003, a / 2),
            "rod": (0.8, 0.004, (a + b) / 2),
            "slider": (0.5, 1.0, b),
        }
        joints = [(GROUND, "crank", 0j), ("crank", "rod", a), ("rod", "slider", b)]
        expected = solve(
            named, joints, ("slider", 1j), "crank", 3.0, -1.1, {"slider": -40 + 9j}, (0.0, -9.81)
        )
        got = driving_torque(move(linkage, float(q), 3.0, -1.1), {"B": (-40.0, 9.0)}, (0.0, -9.81))
        assert got == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_lagrange_form_of_the_press():
    """J q'' + J' q'^2 / 2 + U' - Q = M2, each term by itself (six-bar paper, eq. 38)."""
    q = np.linspace(0, 6, 50)
    motion = move(REPAIRED, q, 2.0, -3.0)
    (inertia, slope), (_, weight) = equivalent_inertia(motion), potential(motion, GRAVITY)
    lift = move(REPAIRED, q).velocity("E")[:, 1]
    torque = driving_torque(motion, {"E": (0.0, 1e5)}, GRAVITY)
    assert torque == pytest.approx(
        inertia * -3.0 + 0.5 * slope * 4.0 + weight - 1e5 * lift, rel=1e-12
    )
    assert (inertia > 0).all()
    static = driving_torque(move(REPAIRED, q, 0.0), {"E": (0.0, 1e5)}, GRAVITY)
    assert static == pytest.approx(weight - 1e5 * lift, rel=1e-12)


def test_large_batches_in_stretches():
    """A large batch is solved a stretch at a time, with speeds, loads and branches of its own shape."""
    rng, shape = np.random.default_rng(8), (3, 5, 1200)
    q, q_dot, load = rng.uniform(0, 6, shape), rng.normal(size=shape), rng.normal(size=shape[1:])
    whole = driving_torque(move(REPAIRED, q, q_dot, -0.4), {"E": (0.0, load)}, GRAVITY)
    rows = [
        driving_torque(move(REPAIRED, q[k], q_dot[k], -0.4), {"E": (0.0, load)}, GRAVITY)
        for k in range(3)
    ]
    assert whole.shape == shape and np.array_equal(whole, rows)
    four_bar, branch = (
        FourBar(0.3, 0.1, 0.25, 0.2, coupler_body=Body(1.0, 0.01)),
        rng.choice([1, -1], shape),
    )
    whole = driving_torque(move(four_bar, q, branch=branch))
    rows = [driving_torque(move(four_bar, q[k], branch=branch[k])) for k in range(3)]
    assert np.array_equal(whole, rows)
    assert (
        driving_torque(move(FourBar(0.3, 0.1, 0.25, 0.2), q)).shape == shape
    )  # no masses, no torque
    q[2, 4, 1100] = 0.0
    with pytest.raises(
        UnreachableError, match=r"1 of 18000 poses, the first at index \(2, 4, 1100\)"
    ):
        move(PRINTED, np.where(q == 0, 0.0, 2.0))


def test_what_has_no_torque():
    linkage = FiveBarLinkage()
    motion = move(linkage, [linkage.home[1], linkage.home[5]])
    with pytest.raises(ValueError, match="one drive"):
        driving_torque(motion)
    with pytest.raises(ValueError, match="no point 'X'; the known ones are A, B, C, D, M"):
        driving_torque(move(FourBar(0.2, 0.06, 0.16, 0.14), 0.0), {"X": (1.0, 0.0)})


@pytest.mark.parametrize(
    "q, force, shapes",
    [
        ([0.1, 0.2], (np.ones(3), 0.0), r"\(3,\) does not fit a motion of shape \(2,\)"),
        (0.1, (0.0, np.ones(2)), r"\(2,\) does not fit a motion of shape \(\)"),
        (np.linspace(0.0, 1.0, 10_000), (np.ones(3), 0.0), r"\(3,\) .* shape \(10000,\)"),
    ],
)
def test_loads_of_another_shape_than_the_motion_are_refused(q, force, shapes):
    motion = move(FourBar(0.2, 0.06, 0.16, 0.14), q)
    with pytest.raises(ValueError, match=rf"^load\['C'\] of shape {shapes}"):
        driving_torque(motion, {"B": (1.0, 2.0), "C": force})
