"""Times of crossings against a run a hundred times finer, whose sines' zeros are found by interpolation alone."""

import numpy as np
import pytest
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq

import fivebar as fb
from fivebar.simulation.events import Cubic, _bracketed, crossings, may_cross, there_and_back, zero

ROBOT = fb.FiveBar()
COARSE = 5e-3


def sines_of(run):
    """sin q12, sin q22, det A (n, 3) along a run, by its joints and end-effector: geometry and no model of ours."""
    found, bases = [], ((-ROBOT.d / 2, 0.0), (ROBOT.d / 2, 0.0))
    for k, (base, l1, l2) in enumerate(zip(bases, (ROBOT.l11, ROBOT.l21), (ROBOT.l12, ROBOT.l22))):
        first = np.stack([np.cos(run.q[:, k]), np.sin(run.q[:, k])], axis=1)
        second = (run.xi - base - l1 * first) / l2
        found.append((first, second))
    (a, b), (c, d) = found
    return np.stack(
        [u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] for u, v in ((a, b), (c, d), (b, d))], axis=1
    )


def zeros(t, values):
    """Where sampled values change sign, by the polynomial of degree 9 through the ten samples around each."""
    found = []
    for k in np.flatnonzero(values[1:] * values[:-1] < 0):
        first = min(max(k - 4, 0), len(t) - 10)
        part = slice(first, first + 10)
        polynomial = KroghInterpolator(t[part] - t[k], values[part])
        found.append(
            t[k] + brentq(lambda x, p=polynomial: float(p(x)), 0.0, t[k + 1] - t[k], xtol=1e-15)
        )
    return found


def free(xi, working, xi_dot, duration, step):
    start = fb.ikm(fb.igm(ROBOT, xi, working), xi_dot)
    return fb.simulate(ROBOT, start=start, duration=duration, step=step)


@pytest.mark.parametrize(
    "xi, working, xi_dot",
    [((0.01, 0.12), (1, -1), (0.02, -0.3)), ((0.05, 0.1), (-1, -1), (-0.5, -0.4))],
)
def test_event_times_to_1e_12_s(xi, working, xi_dot):
    fine, coarse = (
        free(xi, working, xi_dot, 1.0, COARSE / 100),
        free(xi, working, xi_dot, 1.0, COARSE),
    )
    sines = sines_of(fine)
    for k, name in enumerate(ROBOT.words.sines):
        exact = zeros(fine.t, sines[:, k])
        own = [event.t for event in coarse.events if event.margin == name]
        assert len(own) == len(exact)
        assert own == pytest.approx(exact, abs=1e-12)
    assert len(coarse.events) >= 2


def turning(column, apart, through=True):
    """Rates of a free motion at whose start a sine turns around, `apart` / 2 s after and before it is 0.

    through False: as far on this side of 0 as it would be beyond.
    """

    def pose_at(sine):
        if (
            column == 2
        ):  # along a line in task space det A goes through 0, along one in joint space the others do
            x = brentq(lambda x: fb.igm(ROBOT, (x, 0.05)).det_A - sine, -0.09, -0.085)
            return fb.igm(ROBOT, (x, 0.05))
        q = [2.5, 0.5]
        low, high = (0.65, 0.72) if column == 0 else (2.35, 2.42)

        def pose(angle):
            q[column] = angle
            return fb.dgm(ROBOT, q)

        return pose(brentq(lambda angle: pose(angle).sines[column] - sine, low, high))

    def rates_at(sine):
        pose, give = pose_at(sine), fb.dkm if column < 2 else fb.ikm
        slopes = [give(pose, unit).margin_rates[column] for unit in ((1.0, 0.0), (0.0, 1.0))]
        size = (3.0 if column < 2 else 0.3) / np.hypot(*slopes)
        return give(pose, (size * slopes[1], -size * slopes[0]))  # the sine's own rate is 0

    guess = rates_at(1e-4)
    ahead = fb.simulate(ROBOT, start=guess, duration=1e-4, step=1e-5)
    bend = np.polyfit(ahead.t, sines_of(ahead)[:, column], 2)[0]
    return rates_at((-bend if through else bend) * (apart / 2) ** 2)


def reversed_rates(pose, q_dot):
    return fb.dkm(fb.dgm(ROBOT, pose.q, int(pose.assembly)), -q_dot)


def half_a_step_before(middle):
    back = fb.simulate(
        ROBOT,
        start=reversed_rates(middle.pose, middle.q_dot),
        duration=COARSE / 2,
        step=COARSE / 100,
    )
    assembly = int(-np.sign(sines_of(back)[-1, 2]))
    return fb.dkm(fb.dgm(ROBOT, back.q[-1], assembly), -back.q_dot[-1])


@pytest.mark.parametrize("column", [0, 1, 2])
@pytest.mark.parametrize("method", [None, "dop8"])
def test_what_turns_around_before_0_is_no_crossing(column, method):
    start = half_a_step_before(turning(column, 0.1 * COARSE, through=False))
    run, fine = (
        fb.simulate(
            ROBOT,
            start=start,
            duration=COARSE,
            step=COARSE / n,
            integrator=fb.Integrator(method=method),
        )
        for n in (1, 100)
    )
    sine = np.abs(sines_of(fine)[:, column])
    assert sine.min() < 0.02 * min(sine[0], sine[-1]) and run.events == fine.events == ()


@pytest.mark.parametrize("column", [0, 1, 2])
def test_there_and_back_within_one_step(column):
    """A sine passes 0 to and fro in the middle of a step of 5 ms, whose ends have one sign."""
    start = half_a_step_before(turning(column, 0.3 * COARSE))
    coarse, fine = (
        fb.simulate(ROBOT, start=start, duration=4 * COARSE, step=COARSE / n) for n in (1, 100)
    )
    exact = [t for t in zeros(fine.t, sines_of(fine)[:, column]) if t < COARSE]
    assert len(exact) == 2 and 0.2 * COARSE < exact[1] - exact[0] < 0.4 * COARSE
    ends = sines_of(coarse)[:2, column]
    assert ends[0] * ends[1] > 0
    own = [
        event
        for event in coarse.events
        if event.margin == ROBOT.words.sines[column] and event.t < COARSE
    ]
    assert [event.t for event in own] == pytest.approx(exact, abs=1e-11)
    assert own[0].before == own[1].after != own[0].after
    # By fixed steps they are those of the cubic through a step's ends; in compiled loops too.
    options = dict(duration=4 * COARSE, step=COARSE, integrator=fb.Integrator("dop8"))
    fixed = fb.simulate(ROBOT, start=start, **options)
    assert [event[1:] for event in fixed.events[:2]] == [event[1:] for event in own]
    assert [event.t for event in fixed.events[:2]] == pytest.approx(exact, abs=0.02 * COARSE)
    idle, still = fb.PD(ROBOT, 0.0, 0.0), fb.line((0.0, 0.1), (0.0, 0.1), 1.0)
    (many,) = fb.simulate_many([ROBOT], idle, still, [start], control_period=COARSE, **options)
    assert [event.t for event in many.events] == pytest.approx(
        [event.t for event in fixed.events], abs=1e-9
    )


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("third", [-0.9, -20.0, 1.6, 30.0])
@pytest.mark.parametrize("low, high", [(0.1, 0.2), (0.3, 0.8), (0.62, 0.63)])
def test_cubics_of_known_zeros_and_motions_beside_them(low, high, third, side):
    cubic = np.polynomial.Polynomial.fromroots([low, high, third])
    cubic *= side / cubic(0)
    assert (
        cubic.deriv()(0) * side < 0 < cubic.deriv()(1) * side
    )  # the step's ends alone tell that it may turn
    own = Cubic.through(*([float(p(s)) for s in (0.0, 1.0)] for p in (cubic, cubic.deriv())))
    assert own == pytest.approx(tuple(cubic.coef), rel=1e-12, abs=1e-12)
    assert there_and_back(own, None) == pytest.approx((low, high), abs=1e-12)
    middle = (low + high) / 2
    assert zero(own, None, 0.0, middle) == pytest.approx(low, abs=1e-12)
    assert zero(own, None, middle, 1.0) == pytest.approx(high, abs=1e-12)
    # A motion of another shape between the same ends: its own zeros, of which the cubic's are guesses.
    bump = (
        0.3
        * cubic(middle)
        * np.polynomial.Polynomial([0, 0, 1, -2, 1])
        * np.polynomial.Polynomial([0.7, 1.0])
    )
    motion = cubic + bump
    exact = sorted(z.real for z in motion.roots() if abs(z.imag) < 1e-9 and 0 < z.real < 1)
    assert len(exact) == 2 and abs(exact[0] - low) > 1e-6
    found = there_and_back(own, lambda s: (motion(s), motion.deriv()(s)))
    assert found == pytest.approx(exact, abs=5e-12)
    # What turns just before 0 does not cross, by the cubic nor by the motion.
    lifted = cubic - 1.01 * min(cubic(np.linspace(low, high, 400)) * side) * side
    own = Cubic(*lifted.coef.tolist())
    assert there_and_back(own, None) == ()
    assert there_and_back(own, lambda s: (lifted(s), lifted.deriv()(s))) == ()


@pytest.mark.parametrize("low, high", [(0.3, 0.301), (0.5, 0.5002), (0.7, 0.71)])
def test_a_motion_that_hardly_dips_below_0(low, high):
    """The motion's own rate finds the place between the zeros."""
    motion = np.polynomial.Polynomial.fromroots([low, high]) * np.polynomial.Polynomial(
        [1.0, 0.4, 0.7, -0.3]
    )
    own = Cubic.through(*([float(p(s)) for s in (0.0, 1.0)] for p in (motion, motion.deriv())))
    found = there_and_back(own, lambda s: (motion(s), motion.deriv()(s)))
    assert found == pytest.approx((low, high), abs=1e-14 / (high - low))


@pytest.mark.parametrize("step", [0.1, 0.5, 2.0])
def test_crossings_do_not_depend_on_the_rows(step):
    """28 crossings in 2 s, several of them between two rows."""
    start = fb.dkm(fb.igm(ROBOT, (0.09, 0.068)), (20.0, 10.0))
    few, many = (
        fb.simulate(ROBOT, start=start, duration=2.0, step=each).events for each in (step, 1e-4)
    )
    assert len(many) == 28 and len(few) == 28
    for own, exact in zip(few, many):
        assert own[1:] == exact[1:] and own.t == pytest.approx(exact.t, abs=1e-12)
    # The sines of the many rows change their signs as often: geometry alone.
    rows = fb.simulate(ROBOT, start=start, duration=2.0, step=1e-4)
    assert (np.diff(np.sign(sines_of(rows)), axis=0) != 0).sum() == 28


def test_crossings_of_given_sines():
    """Sines that are known functions of time: every zero, in order, with the signs just before and just after."""
    turns, shifts = np.array([7.0, 5.0, 11.0]), np.array([0.4, -1.3, 2.0])

    def look(t):
        t = np.asarray(t)[..., None]
        return 0.3 * np.sin(turns * t + shifts), 0.3 * turns * np.cos(turns * t + shifts)

    t = np.linspace(0.0, 2.0, 41)
    margins, rates = look(t)
    exact = sorted(
        (z, k)
        for k in range(3)
        for n in range(-3, 9)
        if 0 < (z := (n * np.pi - shifts[k]) / turns[k]) < t[-1]
    )
    for motion, error in ((None, 1e-5), (look, 1e-13)):
        events = crossings(ROBOT, t, margins, rates, motion)
        assert [event.t for event in events] == pytest.approx([z for z, _ in exact], abs=error)
        for event, (z, k) in zip(events, exact):
            assert event.margin == ROBOT.words.sines[k] and event.type.name == (
                "PARALLEL" if k == 2 else "SERIAL"
            )
            assert event.before == tuple(-np.sign(look(z - 1e-6)[0])) and event.after == tuple(
                -np.sign(look(z + 1e-6)[0])
            )
    assert len(exact) == 14
    # On a row a zero is crossed once, after it; a motion that begins there or ends there has not crossed it.
    z, k = exact[4]
    margins, rates = look(t - t[8] + z)
    margins[8, k] = 0.0
    for first, last, own in ((7, 10, {exact[4]}), (8, 11, set()), (6, 9, set())):
        wanted = sorted(
            own
            | {
                each
                for each in exact
                if t[first] < each[0] - z + t[8] < t[last - 1] and each != (z, k)
            }
        )
        part = slice(first, last)
        events = crossings(ROBOT, t[part], margins[part], rates[part])
        assert [event.margin for event in events] == [
            ROBOT.words.sines[column] for _, column in wanted
        ]
        assert [event.t for event in events] == pytest.approx(
            [when - z + t[8] for when, _ in wanted], abs=1e-5
        )
        for event, (when, column) in zip(events, wanted):
            assert (
                event.after == tuple(-np.sign(look(when + 1e-6)[0]))
                and event.before[column] == -event.after[column]
            )
    batch = np.stack([look(t[k : k + 2])[0] for k in range(40)])
    slopes = np.stack([look(t[k : k + 2])[1] for k in range(40)])
    crossed = np.array([any(t[k] < z <= t[k + 1] for z, _ in exact) for k in range(40)])
    assert (may_cross(batch, slopes) >= crossed).all() and may_cross(
        batch, slopes
    ).sum() == crossed.sum()
    assert may_cross(batch[~crossed], slopes[~crossed]).sum() == 0


@pytest.mark.parametrize("place", [0.5, 0.25])
def test_a_zero_whose_slope_is_0(place):
    cubic = Cubic(-(place**3), 3 * place**2, -3 * place, 1.0)
    # The cubic itself is rounding as near as this.
    assert zero(cubic, None) == pytest.approx(place, abs=1e-5)
    look = lambda s: ((s - place) ** 3, 3 * (s - place) ** 2)
    assert zero(cubic, look) == pytest.approx(place, abs=1e-5)


def test_an_end_that_is_0_but_for_rounding_is_the_zero():
    assert _bracketed(lambda s: s + 1e-18, 0.0, 1.0) == 0.0
    assert _bracketed(lambda s: s - 1.0 - 1e-18, 0.0, 1.0) == 1.0
