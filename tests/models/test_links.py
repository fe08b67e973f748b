"""Bars as they are built, grouped; parameters as a list; named robots; and what no body can have, refused by name."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.parameters import count_of, names_of, parameters_of, with_parameters

from ..helpers.physics_cases import CASES, robot_of_case


def test_a_uniform_bar_is_known_by_its_mass():
    bar, m = 0.3, 0.8
    by_mass = fb.FiveBar.from_links(bar, bar, bar, bar, 0.1, {"11": m, "12": m})
    links = {
        "11": fb.Link(m, bar / 2, 0, m * bar**2 / 3),
        "12": fb.Link.about_centre(m, bar / 2, 0, m * bar**2 / 12),
    }
    in_full = fb.FiveBar.from_links(bar, bar, bar, bar, 0.1, links)
    for name, value in in_full.parameters.items():
        assert getattr(by_mass, name) == pytest.approx(value, rel=1e-12), name
    assert by_mass.zz12 == pytest.approx(-m * bar * bar / 6)
    assert by_mass.zz1 == pytest.approx(
        m * bar * bar / 3 + m / 2 * bar * bar
    ) and by_mass.m == pytest.approx(m / 2)
    geared = fb.FiveBar.from_links(bar, bar, bar, bar, 0.1, {"11": m}, rotor=((1e-5, 20), 0.001))
    assert geared.zz1 == pytest.approx(m * bar * bar / 3 + 400e-5) and geared.zz2 == 0.001


@pytest.mark.parametrize(
    "make, words",
    [
        (
            lambda: fb.Link(1.0, 0.1, 0.0, 0.009),
            r"inertia = 0.009 .* less than mass \(x\^2 \+ y\^2\) = 0.01",
        ),
        (lambda: fb.Link(1.0, inertia=0.01), "needs x"),
        (
            lambda: fb.Link.about_centre(1.0, 0.1, 0.0, -1e-3),
            "inertia about its centre of mass must be finite and >= 0",
        ),
        (lambda: fb.Link(-1.0), "a link's mass must be"),
        (lambda: fb.Link(1.0, np.inf), "a link's x must be finite"),
        (
            lambda: fb.FiveBar.from_links(0.1, 0.1, 0.1, 0.1, 0.1, {"13": 1.0}),
            'links must be a table of "11"',
        ),
        (
            lambda: fb.FiveBar.from_links(0.1, 0.1, 0.1, 0.1, 0.1, {"12": "heavy"}),
            r'links\["12"\]: a link\'s mass',
        ),
        (
            lambda: fb.FiveBar.from_links(0.1, 0.1, 0.1, 0.1, 0.1, {}, coulomb=(-1, 0)),
            "coulomb must be",
        ),
        (lambda: fb.FiveBar(gravity=9.81), "gravity must be two finite numbers"),
        (lambda: fb.FiveBar(gravity=(0, np.nan)), "gravity must be two finite numbers"),
        (lambda: fb.FiveBar(zz1=0, fs1=0.1), "fs1 = 0.1 is the friction of a drive, but zz1 = 0"),
        (lambda: fb.FiveBar(m=-0.1), "m must be"),
        (lambda: fb.FiveBar(fv1=-0.1), "fv1 must be"),
        (lambda: fb.FiveBar(zz12=1e40), "the size of zz12"),
    ],
)
def test_what_no_body_can_have_is_named(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize(
    "model", [lambda r: fb.inverse_dynamics(fb.dkm2(r, (1.0, 1.0))), fb.dynamic_model]
)
def test_gravity_on_a_robot_without_mass_is_refused_by_name(model):
    robot = fb.FiveBar(m=0, zz1=0.001, zz2=0.001, gravity=(0, -9.81))
    with pytest.raises(
        ValueError,
        match=r"gravity = \(0.0, -9.81\) m/s² pulls at nothing: m, mx11, my11, mx21, my21 are 0",
    ):
        model(fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.0, 0.0)))


def test_inertias_of_no_bodies_are_refused_where_they_show():
    robot = fb.FiveBar(zz12=-1.0)
    with pytest.raises(ValueError, match="kinetic energy"):
        fb.forward_dynamics(fb.dkm(fb.dgm(robot, (0.2, 0.4)), (0.1, 0.0)), (0.0, 0.0))


def test_parameters_come_and_go_as_a_list():
    robot = robot_of_case(CASES[1])
    names = names_of([robot])
    assert "gravity" in names and "fv12" not in names and names_of([fb.FiveBar()]) == ()
    values = parameters_of(robot, names)
    assert len(values) == count_of(fb.FiveBar, names)
    assert with_parameters(fb.FiveBar, values, names) == robot
    assert eval(repr(robot), {"FiveBar": fb.FiveBar}) == robot
    assert (
        repr(fb.FiveBar())
        == "FiveBar(l11=0.09, l12=0.09, l21=0.09, l22=0.09, d=0.118, zz1=0.002, zz2=0.002, m=0.5)"
    )
    assert hash(robot) == hash(replace(robot))


def test_named_robots_are_their_sources():
    assert fb.ROBOTS["iri-vertical"].robot == robot_of_case(CASES[0])
    leg = fb.ROBOTS["minitaur-leg"].robot
    pose = fb.dgm(leg, (2.4, 0.7), 1)
    assert leg.d == 0 and fb.igm(leg, pose.xi, pose.working).q == pytest.approx((2.4, 0.7))
    testbed = fb.ROBOTS["motkin"].robot
    assert (testbed.l11, testbed.l22, testbed.d, testbed.m) == (0.06, 0.1, 0.1, 0.0)
