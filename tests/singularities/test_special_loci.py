"""Loci of special robots: equal bars, coaxial motors, kites, and one without Type 2."""

import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity
from tests.helpers import DATA

REFERENCE = json.loads((DATA / "workspace.json").read_text("utf-8"))


def test_self_motion_circles_of_the_amoro_robot():
    circles = [p for p in singularity_loci(fb.FiveBar()).task if p.kind == "self-motion"]
    reference = REFERENCE["self_motion_circles"]
    height, radius = float(reference["centre"][1].removeprefix("+-")), float(reference["radius"])
    for locus in circles:
        distance = [np.hypot(locus.points[:, 0], locus.points[:, 1] - y) for y in (height, -height)]
        assert min(np.abs(d - radius).max() for d in distance) < 1e-16
    length = sum(np.linalg.norm(np.diff(p.points, axis=0), axis=1).sum() for p in circles)
    assert length == pytest.approx(4 * np.pi * radius, rel=1e-4)


@pytest.mark.parametrize("robot", (fb.FiveBar(), fb.FiveBar(d=0.05), fb.FiveBar(d=0.15)))
def test_polar_formula_of_equal_bars(robot):
    d, length = robot.d, robot.l11
    for locus in singularity_loci(robot).task:
        if locus.kind == "stretched":
            x, y = locus.points.T
            phi = np.arctan2(y, x)
            root = 2 * d * np.sin(phi) * np.sqrt(4 * length**2 - (d * np.cos(phi)) ** 2)
            square = [(d**2 * np.cos(2 * phi) + sign * root) / 4 for sign in (1, -1)]
            assert np.min(np.abs(np.array(square) - (x * x + y * y)), axis=0).max() < 1e-15


def test_a_robot_without_type_2():
    loci = singularity_loci(fb.ROBOTS["hoang-2015"].robot)
    assert all(p.type == Singularity.SERIAL for p in loci.task + loci.joint)
    assert len(loci.task) == 8 and len(loci.type3.xi) == 0


def test_folded_leg_of_equal_bars_is_a_point():
    points = [p for p in singularity_loci(fb.FiveBar()).task if p.kind.endswith("folded")]
    assert [p.points.tolist() for p in points] == [[[-0.059, 0]], [[0.059, 0]]]
    assert [p.kind for p in points] == ["left folded", "right folded"]


def test_coaxial_robot_with_equal_legs():
    """Both legs coincide in two modes: singular everywhere, which is no curve."""
    robot = fb.ROBOTS["liu-2006-e"].robot
    loci = singularity_loci(robot)
    assert set(loci.everywhere) == {(1, 1), (-1, -1)}
    assert not any(p.kind == "self-motion" for p in loci.task)
    points = np.random.default_rng(4).uniform(-2, 2, (100, 2))
    assert np.abs(fb.igm(robot, points, (1, 1), unreachable="nan").det_A).max() < 1e-15
    assert singularity_loci(fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0)).everywhere == ()


def test_parts_that_a_kite_leaves_free():
    """l11 = l12 + l22, d = l21: with the right elbow on the left base joint all bars but one turn in line about it."""
    pieces = [p for p in singularity_loci(fb.FiveBar(0.3, 0.1, 0.2, 0.2, 0.2)).task if p.type == 3]
    assert pieces and all(p.kind == "stretched" for p in pieces)
    for p in pieces:
        np.testing.assert_allclose(np.hypot(p.points[:, 0] + 0.1, p.points[:, 1]), 0.2, rtol=1e-14)
        assert {m[1] for m in p.working} != {1, -1} and {m[0] for m in p.working} == {1, -1}
