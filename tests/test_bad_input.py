"""Every refusal says what was wrong, where, and by how much."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb

AMORO = fb.FiveBar()
MASSLESS = fb.FiveBar(zz1=0, zz2=0.002, m=0.5)


@pytest.mark.parametrize(
    "values, message",
    [
        (dict(l11=0), "l11 must be finite and > 0"),
        (dict(l22=-0.1), "l22 must be finite and > 0"),
        (dict(d=-0.1), "d must be finite and >= 0"),
        (dict(m=float("nan")), "m must be finite"),
        (dict(zz1=-1e-9), "zz1 must be finite and >= 0"),
        (dict(l12="long"), "l12 must be a number, not 'long'"),
        (dict(l12=True), "l12 must be finite and > 0"),
        (
            dict(d=0.37),
            r"can never close: d = 0.37 m is longer than l11 \+ l12 \+ l21 \+ l22 = 0.36 m",
        ),
        (
            dict(l12=0.4),
            r"can never close: l12 = 0.4 m is longer than l11 \+ l21 \+ l22 \+ d = 0.388 m",
        ),
    ],
)
def test_robots_that_cannot_be(values, message):
    with pytest.raises(ValueError, match=message):
        fb.FiveBar(**values)


def test_modes_of_any_integer_type_and_casadi_numbers():
    import casadi

    for kind in (np.uint8, np.int64, float, object):
        assert fb.dgm(AMORO, np.zeros((3, 2)), np.ones(3, kind)).xi[0] == pytest.approx(
            [0.09, -0.0679632253501848]
        )
    q = np.zeros((100, 200, 2))
    assert fb.dgm(AMORO, q, np.ones((100, 1), int)).xi.shape == (100, 200, 2)
    assert {type(fb.FiveBar(l11=kind(0.1)).l11) for kind in (casadi.DM, casadi.SX, casadi.MX)} == {
        float
    }
    assert fb.dgm(AMORO, casadi.DM([0, 0])).xi == pytest.approx([0.09, 0.0679632253501848])
    with pytest.raises(fb.UnreachableError):
        fb.igm(AMORO, casadi.DM([1, 1]))


def test_parts_are_loaded_when_named():
    assert fb.amoro.models(AMORO).dgm(0, 0, -1)[0] == pytest.approx(0.09)
    assert callable(fb.plot.singularity_map) and fb.study.__doc__


def test_named_robots_have_a_source():
    assert fb.ROBOTS["amoro"].robot == AMORO
    assert all(named.source for named in fb.ROBOTS.values())
    assert fb.ROBOTS["hoang-2015"].robot.l12 == 0.2


def test_unreachable_names_distance_limit_and_gap():
    with pytest.raises(
        fb.UnreachableError,
        match=r"left leg.*0\.359 m apart.*0\.09 and 0\.09 m allow is 0\.18 m \(gap",
    ) as e:
        fb.igm(AMORO, (0.3, 0.0))
    assert e.value.gap == pytest.approx(0.179)
    with pytest.raises(
        fb.UnreachableError, match="the shortest that bars of 0.2 and 0.07 m allow is 0.13 m"
    ) as e:
        fb.igm(fb.FiveBar(0.2, 0.07, 0.2, 0.07, 0.05), (0.0, 0.0))
    assert e.value.gap == pytest.approx(0.105)
    with pytest.raises(fb.UnreachableError, match="the elbows are 0.298") as e:
        fb.dgm(AMORO, (np.pi, 0.0))
    assert e.value.gap == pytest.approx(0.118)


def test_unreachable_in_a_batch():
    xi = np.full((4, 5, 2), 0.05)
    xi[2, 1] = xi[3, 0] = (1.0, 0.0)
    with pytest.raises(
        fb.UnreachableError, match=r"2 of 20 poses, the first at index \(2, 1\)"
    ) as e:
        fb.igm(AMORO, xi)
    assert e.value.index == (2, 1)
    pose = fb.igm(AMORO, xi, unreachable="nan")
    assert np.isnan(pose.q[2, 1]).all() and np.isfinite(pose.q[0]).all()
    assert pose.assembly[2, 1] == 0 and pose.working[3, 0].tolist() == [0, 0]
    assert pose.reach_margin[2, 1] < 0 < pose.reach_margin[0, 0]
    assert np.isnan(fb.igm(AMORO, (1.0, 0.0), unreachable="nan").q).all()
    assert np.isnan(fb.dgm(AMORO, (np.pi, 0.0), unreachable="nan").xi).all()


def test_a_stretched_leg_is_reachable_in_spite_of_rounding():
    angles = np.linspace(0, 2 * np.pi, 2000)
    for base, l1, l2 in ((-0.059, 0.09, 0.09), (-0.059, 0.11, 0.14)):
        robot = fb.FiveBar(l1, l2, 1.0, 1.0, 0.118)
        xi = np.stack([base + (l1 + l2) * np.cos(angles), (l1 + l2) * np.sin(angles)], axis=-1)
        assert np.isfinite(fb.igm(robot, xi).q).all()


def test_joints_left_free_are_named():
    with pytest.raises(
        fb.SingularityError, match="the right leg is folded on its base joint: q21 is left free"
    ):
        fb.igm(AMORO, (0.059, 0.0))
    with pytest.raises(
        fb.SingularityError,
        match=r"1 of 2 poses, the first at index \(1,\).*left leg.*q11 is left free",
    ):
        fb.igm(AMORO, [(0.0, 0.1), (-0.059, 0.0)])
    with pytest.raises(fb.SingularityError, match="the elbows coincide: q12 and q22 are left free"):
        fb.dgm(fb.FiveBar(d=0), (0.3, 0.3))
    assert np.isnan(fb.igm(AMORO, (0.059, 0.0), unreachable="nan").q[1])


def test_singular_models_raise_with_type_margin_and_pose():
    # Elbows exactly two bars apart: q11 = pi - q21, cos q21 = (2 l - d) / (2 l).
    q = np.arccos((0.18 - 0.118) / 0.18)
    flat = fb.dgm(AMORO, (np.pi - q, q))
    assert flat.assembly == 0
    for call in (lambda: fb.dkm(flat, (1, 0)), lambda: fb.dynamic_model(fb.ikm(flat, (0, 1)))):
        with pytest.raises(
            fb.SingularityError, match=r"A is singular \(Type 2\): det A = .* at q = .*xi = "
        ) as e:
            call()
        assert abs(e.value.margin) < 1e-14
    with pytest.raises(fb.SingularityError, match="inverse_dynamics: A is singular"):
        fb.inverse_dynamics(fb.ikm2(fb.ikm(flat, (0, 1)), (0, 0)))
    corner = fb.igm(AMORO, (0.0, np.sqrt(0.18**2 - 0.059**2)))
    assert corner.working.tolist() == [0, 0]
    with pytest.raises(fb.SingularityError, match=r"ikm: B is singular \(Type 1\): sin q12"):
        fb.ikm(corner, (1, 0))
    with pytest.raises(
        fb.SingularityError, match=r"in 1 of 2 poses, the first at index \(1,\)"
    ) as e:
        fb.ikm(fb.igm(AMORO, [(0.0, 0.1), corner.xi]), (1, 0))
    assert e.value.index == (1,)


@pytest.mark.parametrize(
    "call, place",
    [
        (lambda: fb.igm(AMORO, (0.3, 0.0)), r"\(gap 0\.179 m\), at xi = \(0\.3, 0\) m$"),
        (
            lambda: fb.igm(AMORO, [(0, 0.1), (0.2, 0.3)]),
            r"index \(1,\).*, at xi = \(0\.2, 0\.3\) m$",
        ),
        (lambda: fb.dgm(AMORO, [(0, 0), (3.0, 0.25)]), r"index \(1,\).*, at q = \(3, 0\.25\) rad$"),
        (lambda: fb.igm(AMORO, (0.059, 0.0)), r"left free .*, at xi = \(0\.059, 0\) m$"),
        (lambda: fb.dgm(fb.FiveBar(d=0), (0.3, 0.3)), r"left free .*, at q = \(0\.3, 0\.3\) rad$"),
        (lambda: fb.dgm(fb.Biglide(), (0.7, 0.0)), r", at q = \(0\.7, 0\) m$"),
        (lambda: fb.igm(fb.Biglide(), (0.7, 0.1)), r", at xi = \(0\.7, 0\.1\) m$"),
    ],
)
def test_what_does_not_close_names_the_pose(call, place):
    with pytest.raises((fb.UnreachableError, fb.SingularityError), match=place):
        call()


def test_what_zero_inertia_and_mass_leave_defined():
    rates = fb.dkm(fb.dgm(MASSLESS, (0.2, -0.1)), (0.7, -1.1))
    M, c = fb.dynamic_model(rates)
    tau = fb.inverse_dynamics(fb.dkm2(rates, (3.0, 2.5)))
    assert M @ (3.0, 2.5) + c == pytest.approx(tau, abs=1e-16)
    with pytest.raises(ValueError, match="forward_dynamics needs zz1 > 0"):
        fb.forward_dynamics(rates, tau)
    free = fb.FiveBar(m=0)
    q = np.arccos((0.18 - 0.118) / 0.18)
    rates = fb.ikm(fb.dgm(free, (np.pi - q, q)), (0, 1))
    assert fb.dynamic_model(rates)[0].tolist() == [[0.002, 0], [0, 0.002]]
    with pytest.raises(
        fb.SingularityError, match=r"forward_dynamics: .* at q = \(1\.9.*\) rad, xi = .* m$"
    ):
        fb.forward_dynamics(rates, (0, 0))
    rates = fb.dkm(fb.dgm(free, (0.2, -0.1)), (0.7, -1.1))
    assert fb.forward_dynamics(rates, (0.002, 0.004)).q_ddot == pytest.approx([1, 2])


@pytest.mark.parametrize(
    "call, message",
    [
        (
            lambda: fb.dgm(AMORO, (1, 2, 3)),
            r"q must have shape \(2,\) or \(\*batch, 2\), not \(3,\)",
        ),
        (lambda: fb.igm(AMORO, 0.1), r"xi must be two numbers in one argument"),
        (lambda: fb.dgm(AMORO, (np.nan, 0)), r"q must be finite, not \(nan, 0.0\)"),
        (
            lambda: fb.igm(AMORO, [[0, 0.1], [np.inf, 0]]),
            r"xi must be finite, but xi\[1, 0\] is inf",
        ),
        (lambda: fb.dgm(AMORO, (0, 0), assembly=0), r"assembly must be \+1 or -1, not 0"),
        (lambda: fb.igm(AMORO, (0, 0.1), working=(1, 2)), r"working must be \+1 or -1, not 2"),
        (
            lambda: fb.igm(AMORO, (0, 0.1), working=1),
            r"two modes in one argument, as \(-1, -1\), not 1",
        ),
        (
            lambda: fb.dgm(AMORO, np.zeros((3, 2)), assembly=[1, 1]),
            r"assembly of shape \(2,\) does not fit.*\(3,\)",
        ),
        (
            lambda: fb.dgm(AMORO, (0, 0), unreachable="ignore"),
            'unreachable must be "raise" or "nan"',
        ),
        (lambda: fb.dkm(fb.dgm(AMORO, (0, 0)), (np.nan, 0)), "q_dot must be finite"),
        (lambda: fb.dgm(AMORO, "ab"), "q must be real numbers of shape"),
        (lambda: fb.dgm(AMORO, [[1], [1, 2]]), "q must be real numbers of shape"),
        (lambda: fb.igm(AMORO, (0.1j, 0)), "xi must be real numbers"),
        (
            lambda: fb.dkm(fb.dgm(AMORO, np.zeros((3, 2))), np.zeros((4, 2))),
            r"q_dot of shape \(4, 2\) does not fit a batch of poses of shape \(3,\)",
        ),
    ],
)
def test_wrong_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_a_run_without_samples_is_not_drawn():
    run = fb.simulate(AMORO, duration=0.01)
    names = "t", "q", "q_dot", "xi", "tau", "energy"
    with pytest.raises(ValueError, match="a run without samples cannot be drawn"):
        replace(run, **{name: getattr(run, name)[:0] for name in names}).plot()


OF_RATES = [
    fb.dynamic_model,
    fb.energy,
    fb.friction_torques,
    lambda r: fb.forward_dynamics(r, (0, 0)),
    lambda r: fb.dkm2(r, (0, 0)),
    lambda r: fb.ikm2(r, (0, 0)),
]


@pytest.mark.parametrize("call", OF_RATES)
def test_what_is_no_rates_is_named(call):
    with pytest.raises(TypeError, match="rates must be Rates, as dkm and ikm give, not 5$"):
        call(5)


@pytest.mark.parametrize("call", [fb.dkm, fb.ikm])
def test_what_is_no_pose_is_named(call):
    with pytest.raises(TypeError, match="pose must be a Pose, as dgm and igm give, not FiveBar"):
        call(AMORO, (0.0, 0.0))
