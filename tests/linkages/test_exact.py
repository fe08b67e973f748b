"""Linkages against positions written independently and differentiated with 50 digits, and across backends."""

import itertools

import mpmath
import numpy as np
import pytest

import fivebar as fb
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
from tests.conftest import UNEQUAL

REL = 1e-12
FOUR_BAR = FourBar(0.3, 0.1, 0.25, 0.2, point=(0.16, 0.08), base=(0.02, -0.01), tilt=0.3)
# A double-rocker too, and every inversion of the slider-crank, with angles inside the range of each.
CASES = [
    (FOUR_BAR, (1, -1), (0.2, 1.7, 3.3, 5.9)),
    (FourBar(0.2, 0.25, 0.1, 0.22), (1, -1), (0.55, 0.7)),
    (SliderCrank(0.05, 0.15, 0.02), (1, -1), (0.2, 1.7, 3.3, 5.9)),
    (SliderCrank(0.05, 0.15, -0.03, "crank"), (1, -1), (0.2, 1.7, 3.3, 5.9)),
    (SliderCrank(0.05, 0.15, 0.02, "rod"), (1, -1), (0.2, 1.7, 3.3, 5.9)),
    (SliderCrank(0.05, 0.15, 0.02, "slider"), (1, -1), (-0.4, 0.1, 3.2)),
    (REPAIRED, ((-1, -1), (1, -1), (-1, 1)), (0.2, 1.7, 3.3, 5.9)),
    (PRINTED, ((-1, -1), (1, 1)), (1.1, 3.3, 5.0)),
]


def exact_points(linkage, branch):
    """{point: f(q) -> complex mpf}, {link: f(q) -> angle}: by the law of cosines, not by the package's formulas."""
    mp = mpmath.mpf
    turn = mpmath.expj

    def apex(p, r, r1, r2, side):
        z = r - p
        d = abs(z)
        return p + r1 * turn(
            mpmath.arg(z) + side * mpmath.acos((d * d + r1 * r1 - r2 * r2) / (2 * d * r1))
        )

    def between(p, r):
        return lambda q: mpmath.arg(r(q) - p(q))

    if isinstance(linkage, FourBar):
        g, a, b, c = map(mp, linkage.sides)
        base = mpmath.mpc(*linkage.base)
        foot = base + g * turn(mp(linkage.tilt))
        at_b = lambda q: base + a * turn(q)
        at_c = lambda q: apex(at_b(q), foot, b, c, branch)
        along, across = map(mp, linkage.point or (linkage.coupler / 2, 0))
        at_m = lambda q: at_b(q) + (along + 1j * across) * (at_c(q) - at_b(q)) / b  # noqa: E731
        return {"B": at_b, "C": at_c, "M": at_m}, {
            "coupler": between(at_b, at_c),
            "rocker": between(lambda q: foot, at_c),
        }
    if isinstance(linkage, SliderCrank):
        r, l, e = mp(linkage.crank), mp(linkage.rod), mp(linkage.offset)  # noqa: E741
        if linkage.held == "guide":
            at_a = lambda q: r * turn(q)
            at_b = lambda q: (  # noqa: E731
                r * mpmath.cos(q)
                + branch * mpmath.sqrt(l**2 - (e - r * mpmath.sin(q)) ** 2)
                + 1j * e
            )
            return {"A": at_a, "B": at_b}, {"rod": between(at_a, at_b)}
        if linkage.held == "slider":
            at_a = lambda q: l * turn(q)
            at_o = lambda q: (  # noqa: E731
                l * mpmath.cos(q)
                + branch * mpmath.sqrt(r**2 - (e + l * mpmath.sin(q)) ** 2)
                - 1j * e
            )
            return {"A": at_a, "O": at_o}, {"crank": between(at_a, at_o)}
        if linkage.held == "crank":
            at_o, at_b = (lambda q: mp(0)), (lambda q: r + l * turn(q))
        else:
            at_o, at_b = (lambda q: r * turn(q)), (lambda q: l)

        def guide(q):
            z = at_b(q) - at_o(q)
            return mpmath.arg(z / mpmath.mpc(branch * mpmath.sqrt(abs(z) ** 2 - e**2), e))

        length = r + l + abs(e)
        at_h = lambda q: at_o(q) + (length + 1j * e) * turn(guide(q))
        return {"O": at_o, "B": at_b, "H": at_h}, {"guide": guide}
    l2, l3, l4, l5, l11 = (mp(getattr(linkage, name)) for name in ("l2", "l3", "l4", "l5", "l11"))
    foot = l11 * turn(mp(linkage.theta11))
    at_b = lambda q: l2 * turn(q)
    at_c = lambda q: apex(at_b(q), foot, l3, l4, branch[0])

    def at_e(q):
        c = at_c(q)
        return foot.real + 1j * (
            c.imag + branch[1] * mpmath.sqrt(l5**2 - (c.real - foot.real) ** 2)
        )

    return {"B": at_b, "C": at_c, "E": at_e}, {
        "coupler": between(at_b, at_c),
        "rocker": between(lambda q: foot, at_c),
        "bar": between(at_c, at_e),
    }


def derivatives(f, q):
    """Value, first and second derivative by q."""
    return [f(q), mpmath.diff(f, q), mpmath.diff(f, q, 2)]


@pytest.mark.parametrize("linkage, branches, angles", CASES)
def test_against_fifty_digits(linkage, branches, angles):
    with mpmath.workdps(50):
        for branch, q in itertools.product(branches, angles):
            motion = move(linkage, q, branch=branch)
            points, links = exact_points(linkage, branch)
            for name, f in points.items():
                expected = derivatives(f, mpmath.mpf(q))
                for got, want in zip(
                    (motion.position, motion.velocity, motion.acceleration), expected
                ):
                    scale = max(abs(complex(x)) for x in expected)
                    assert complex(*got(name)) == pytest.approx(
                        complex(want), rel=REL, abs=REL * scale
                    ), (name, q, branch)
            for name, f in links.items():
                expected = derivatives(f, mpmath.mpf(q))
                for got, want in zip(
                    (motion.angle, motion.rate, motion.angular_acceleration), expected
                ):
                    scale = max(abs(float(x)) for x in expected)
                    assert got(name) == pytest.approx(float(want), rel=REL, abs=REL * scale), (
                        name,
                        q,
                        branch,
                    )


def slide_from_guide(linkage, branch):
    """Coordinate of B along the guide, from O: f(q)."""
    points, links = exact_points(linkage, branch)
    o, b = (points.get(name, lambda q: mpmath.mpf(0)) for name in "OB")
    turn = links.get("guide", lambda q: mpmath.mpf(0))
    return lambda q: mpmath.re((b(q) - o(q)) * mpmath.expj(-turn(q)))


@pytest.mark.parametrize("held", ["guide", "crank", "rod", "slider"])
def test_inversions_are_one_chain(held):
    """Seen from its guide, every inversion is the slider-crank with the guide held; the slide is the same."""
    linkage = SliderCrank(0.05, 0.15, 0.02, held)
    for branch, q in itertools.product((1, -1), np.linspace(-0.4, 0.15, 5)):
        motion = move(linkage, q, branch=branch)
        guide = motion.angle("guide") if "guide" in motion.links else 0.0
        o, a, b = (complex(*motion.position(name)) for name in "OAB")
        arm, way = (a - o) * np.exp(-1j * guide), (b - o) * np.exp(-1j * guide)
        assert way.imag == pytest.approx(0.02, rel=1e-12) and abs(arm) == pytest.approx(
            0.05, rel=1e-12
        )
        assert abs(way - arm) == pytest.approx(0.15, rel=1e-12)
        slide, rate, acceleration = motion.coordinate("slide")
        assert slide == pytest.approx(way.real, rel=1e-12)
        same = move(
            SliderCrank(0.05, 0.15, 0.02),
            float(np.angle(arm)),
            branch=1 if way.real > arm.real else -1,
        )
        assert same.coordinate("slide")[0] == pytest.approx(slide, rel=1e-11)
        with mpmath.workdps(50):  # the rates of the slide are those of this coordinate
            _, v, acc = derivatives(slide_from_guide(linkage, branch), mpmath.mpf(q))
        assert (rate, acceleration) == pytest.approx((float(v), float(acc)), rel=1e-11)


def test_inversions_of_the_four_bar_are_one_chain():
    four_bar = FourBar(0.2, 0.06, 0.16, 0.14)
    motion = move(four_bar, 0.9)
    a, b, c, d = (motion.position(name) for name in "ABCD")
    diagonals = np.hypot(*(c - a)), np.hypot(*(d - b))
    heading = np.angle(
        complex(*(c - b)) / complex(*(a - b))
    )  # the new crank from the new ground B -> A ...
    for sign in (1, -1):  # ... mirrored, as the inverted one counts from A to D
        inverted = move(four_bar.inversion("crank"), sign * heading, branch=1)
        p = [inverted.position(name) for name in "ABCD"]
        found = np.hypot(*(p[2] - p[0])), np.hypot(*(p[3] - p[1]))
        if found == pytest.approx(diagonals[::-1], rel=1e-12):
            break
    else:
        pytest.fail(f"{found} are not the diagonals {diagonals}")
    assert four_bar.inversion("ground") == four_bar
    assert four_bar.inversion("coupler").sides == (0.16, 0.14, 0.2, 0.06)


@pytest.mark.parametrize("robot", [fb.FiveBar(), UNEQUAL], ids=["amoro", "unequal"])
@pytest.mark.parametrize("motors", list(itertools.combinations(range(1, 6), 2)))
def test_five_bar_with_motors_at_other_joints(robot, motors):
    """The robot's own models give all joints; driven by any two of them the five-bar must move as it did."""
    rng = np.random.default_rng(11)
    q = rng.uniform(-np.pi, np.pi, (3000, 2))
    assembly = rng.choice([-1, 1], 3000)
    pose = fb.dgm(robot, q, assembly, unreachable="nan")
    good = (np.abs(np.stack([*pose.sines, pose.det_A])) > 0.1).all(axis=0)
    q_dot, q_ddot = rng.normal(size=(2, good.sum(), 2))
    q, rates = q[good], fb.dkm(fb.dgm(robot, q[good], assembly[good]), q_dot)
    acc = fb.dkm2(rates, q_ddot)
    joints = []
    for own, passive in (
        (q, rates.pose.q_passive),
        (q_dot, rates.q_passive_dot),
        (q_ddot, acc.q_passive_ddot),
    ):
        third = own[:, 1] + passive[:, 1] - own[:, 0] - passive[:, 0]
        joints.append(
            np.stack([own[:, 0], passive[:, 0], third, passive[:, 1], own[:, 1]], axis=-1)
        )
    given = [x[:, [k - 1 for k in motors]] for x in joints]
    linkage = FiveBarLinkage(robot, motors)
    branch = np.sign(linkage._flatness(rates.pose)).astype(int)
    regular = np.abs(linkage._flatness(rates.pose)) > 0.02
    assert regular.sum() > 100 and len(set(branch)) == 2
    motion = move(linkage, *given, branch=branch)
    for got, expected, bound in (
        (motion.position("joint 3"), rates.pose.xi, 1e-13),
        (motion.position("joint 2"), rates.pose.elbows[:, 0], 1e-13),
        (motion.velocity("joint 3"), rates.xi_dot, 1e-12),
        (motion.rate("link 1"), q_dot[:, 0], 1e-11),
        (motion.rate("link 3"), q_dot[:, 1] + rates.q_passive_dot[:, 1], 1e-11),
        (motion.acceleration("joint 3"), acc.xi_ddot, 1e-10),
        (motion.angular_acceleration("link 1"), q_ddot[:, 0], 1e-9),
    ):
        error = np.abs(got - expected)[regular] / (1 + np.abs(expected[regular]))
        assert error.max() < bound


def test_press_inertia_and_potential_against_fifty_digits():
    with mpmath.workdps(50):
        points, links = exact_points(REPAIRED, (-1, -1))
        foot = REPAIRED.l11 * mpmath.expj(mpmath.mpf(REPAIRED.theta11))
        ends = {
            "2": (lambda q: 0, points["B"]),
            "3": (points["B"], points["C"]),
            "4": (lambda q: foot, points["C"]),
        }
        ends |= {"5": (points["C"], points["E"]), "6": (points["E"], points["E"])}
        angle = {"3": links["coupler"], "4": links["rocker"], "5": links["bar"]}

        def inertia(q):
            total = mpmath.mpf(0)
            for k, (a, b) in ends.items():
                slope = mpmath.diff(lambda x, a=a, b=b: (a(x) + b(x)) / 2, q)
                total += getattr(REPAIRED, f"m{k}") * abs(slope) ** 2
                if k in angle:
                    total += getattr(REPAIRED, f"j{k}") * mpmath.diff(angle[k], q) ** 2
            return total

        def energy(q):
            return -sum(
                9.81 * getattr(REPAIRED, f"m{k}") * mpmath.re(a(q) + b(q)) / 2
                for k, (a, b) in ends.items()
            )

        for q in (0.3, 2.0, 4.4):
            motion = move(REPAIRED, q)
            for got, f in (
                (equivalent_inertia(motion), inertia),
                (potential(motion, GRAVITY), energy),
            ):
                assert got == pytest.approx(
                    [float(f(mpmath.mpf(q))), float(mpmath.diff(f, q))], rel=REL
                )


@pytest.mark.parametrize("held", ["guide", "crank", "rod", "slider"])
def test_power_balance_of_the_slider_crank(held):
    """The motor's power is what the energies gain and the load takes; energies from poses, slopes by differences."""
    bodies = dict(
        crank_body=Body(1.2, 0.003),
        rod_body=Body(0.8, 0.004, (0.05, 0.01)),
        slider_body=Body(0.5, 0.001),
        guide_body=Body(0.7, 0.002, (0.1, 0.02)),
    )
    linkage, gravity, h = SliderCrank(0.05, 0.15, 0.02, held, **bodies), (0.3, -9.81), 1e-5
    free = {"guide": "B", "crank": "B", "rod": "O", "slider": "O"}[held]

    def energies(t):
        motion = move(linkage, 0.05 + 2 * t + 1.5 * t * t, 2 + 3 * t, 3.0)
        energy = 0.0
        for name in motion.links:
            link = motion.chain.links[name]
            start = next(p for p in motion.points if motion.chain.points[p] is link.origin)
            arm = complex(*(link.body.centre or (link.length / 2, 0.0))) * np.exp(
                1j * motion.angle(name)
            )
            v = complex(*motion.velocity(start)) + 1j * motion.rate(name) * arm
            at = complex(*motion.position(start)) + arm
            energy += (
                0.5 * link.body.mass * abs(v) ** 2
                + 0.5 * link.body.inertia * motion.rate(name) ** 2
            )
            energy -= link.body.mass * np.dot(gravity, (at.real, at.imag))
        return energy, motion

    for t in (0.0, 0.02):
        _, motion = energies(t)
        torque = driving_torque(motion, {free: (20.0, -5.0)}, gravity)
        slope = (energies(t + h)[0] - energies(t - h)[0]) / (2 * h)
        load = motion.velocity(free) @ (20.0, -5.0)
        assert torque * motion.q_dot == pytest.approx(slope - load, rel=1e-7)
