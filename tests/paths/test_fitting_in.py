"""A drawing put into an aspect lies in it, with its margin, and what does not fit is told its largest scale."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.pieces import Arc
from fivebar.paths.placing.fitting_in import bounds, fitted_in
from fivebar.paths.setpoints import setpoints
from fivebar.paths.strokes import outlines, runs

ROBOT = fb.FiveBar()
PATH = fb.path([[(0, 0), (0.06, 0.01), (0.05, 0.04)], [(0.01, 0.03), (0.02, 0.05)]], deviation=1e-4)


def points(path):
    return path(np.linspace(0, path.length, 2001))[0]


def test_bounds_hold_arcs_and_curves():
    path = fb.path([Arc((0, 0), 0.1, 0.3, 4.0)])
    found, seen = bounds(path), points(path)
    np.testing.assert_allclose(found, [seen.min(axis=0), seen.max(axis=0)], atol=1e-6)
    found, seen = bounds(PATH), points(PATH)
    assert (found[0] <= seen.min(axis=0) + 1e-15).all() and (
        found[1] >= seen.max(axis=0) - 1e-15
    ).all()


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"turn": 1.0},
        {"scale": None, "constraints": fb.Constraints(clearance=0.02), "working": (1, 1)},
        {"working": (1, -1)},
    ],
)
def test_what_is_placed_lies_in_its_aspect(options):
    fit = fitted_in(ROBOT, PATH, **options)
    placed = fit.placement(PATH)
    seen = points(placed)
    assert fit.aspect.contains(seen).all() and fit.aspect.working == options.get(
        "working", fit.aspect.working
    )
    check = fb.check_path(ROBOT, placed.at_unit_speed, fit.aspect.working)
    assert check.singularity_free
    margin = options["constraints"].clearance if "constraints" in options else 0.005
    distance = fb.locus_distance(ROBOT, seen[::50], working=fit.aspect.working)[0]
    assert distance.min() >= margin * (1 - 1e-6)
    if "scale" in options:
        assert fit.placement.scale == pytest.approx(fit.scale) and distance.min() < 2 * margin
    elif not options:  # the lab's own modes hold it, and the legs do not cross there
        assert fit.aspect.working == (-1, -1) and seen[:, 1].min() > 0


def test_a_drawing_larger_than_any_aspect_is_told_its_scale():
    robot = fb.ROBOTS["haply"].robot
    with pytest.raises(
        ValueError, match="599.. x 500 mm is larger than any upright rectangle"
    ) as refused:
        fitted_in(robot, PATH, scale=10.0)
    scale = float(re.search(r"with scale ([\d.]+)$", str(refused.value))[1])
    assert fitted_in(robot, PATH, scale=scale).scale >= scale
    with pytest.raises(ValueError, match="keeps a clearance of 1 m"):
        fitted_in(ROBOT, PATH, constraints=fb.Constraints(clearance=1.0), working=(1, 1))


@pytest.mark.every(3)
@pytest.mark.parametrize("name", ["haply", "amoro", "iri-vertical"])
def test_the_largest_drawing_touches_its_margin_on_all_sides(name):
    """A slightly larger one in the same place does not keep the margin: so the shape is used."""
    robot = fb.ROBOTS[name].robot
    wide = fb.path([(0, 0), (0.1, 0), (0.1, 0.02), (0, 0.02), (0, 0)])
    fit = fitted_in(robot, wide, scale=None)
    box = bounds(fit.placement(wide))
    margin = {}
    for factor in (1.0, 1.02):
        corners = box.mean(axis=0) + factor * (points(fit.placement(wide)) - box.mean(axis=0))
        margin[factor] = fb.locus_distance(robot, corners, working=fit.aspect.working)[0].min()
    assert margin[1.02] < 0.005 <= margin[1.0] * (1 + 1e-6)


@pytest.mark.deep
def test_measured_modes_come_first_and_others_where_it_does_not_fit_there():
    machine = fb.Machine(ROBOT, measured=[(1, -1, -1)])
    for measured, modes in (((), (-1, -1)), (machine.measured, (1, -1))):
        assert fitted_in(ROBOT, PATH, measured=measured).aspect.working == modes
        assert fitted_in(ROBOT, PATH, scale=None, measured=measured).aspect.working == modes
    most = fitted_in(ROBOT, PATH, scale=None, measured=machine.measured).scale
    larger = fitted_in(ROBOT, PATH, scale=1.01 * most, measured=machine.measured)
    assert larger.aspect.working != (1, -1)


def test_strokes():
    first, second = outlines(PATH)
    np.testing.assert_allclose([first[0], first[-1]], [(0, 0), (0.05, 0.04)], atol=1e-15)
    np.testing.assert_allclose([second[0], second[-1]], [(0.01, 0.03), (0.02, 0.05)], atol=1e-15)
    down = np.array([0, 1, 1, 0, 0, 1], bool)
    assert [(s.start, s.stop) for s in runs(down)] == [(1, 3), (5, 6)]


def test_setpoints_are_those_of_the_motion(tmp_path):
    motion = fb.line((0.0, 0.1), (0.05, 0.12), 0.9995)
    table = setpoints(ROBOT, motion, 100.0, (1, -1))
    assert len(table.t) == 101 and table.t[-1] == 1.0
    for row, xi in ((0, (0.0, 0.1)), (-1, (0.05, 0.12))):
        np.testing.assert_allclose(table.q[row], fb.igm(ROBOT, xi, (1, -1)).q, atol=1e-15)
        assert np.abs(table.q_dot[row]).max() < 1e-14
    np.testing.assert_allclose(
        np.gradient(table.q, table.t, axis=0)[2:-2], table.q_dot[2:-2], atol=2e-3
    )
    table.to_csv(tmp_path / "deg.csv", "deg")
    rows = np.loadtxt(tmp_path / "deg.csv", delimiter=",", skiprows=2)
    np.testing.assert_allclose(
        np.radians(rows[:, 3:7]), np.hstack([table.q, table.q_dot]), atol=1e-15
    )
    whole = setpoints(ROBOT, fb.line((0.0, 0.1), (0.05, 0.12), 1.0), 100.0)
    assert len(whole.t) == 101 and whole.t[-1] == 1.0
    around = setpoints(ROBOT, fb.circle((0.0, 0.0), 0.12, 1.0), 1000.0, (-1, 1))
    assert (
        np.abs(np.diff(around.q, axis=0)).max() < 0.1
    )  # continuous, where igm's angles jump by a turn
    with pytest.raises(ValueError, match="at most 1e"):
        setpoints(ROBOT, motion, 1e9)
    slides = setpoints(fb.Biglide(), fb.line((0, 0.2), (0.05, 0.25), 1.0), 50.0)
    with pytest.raises(ValueError, match="no angles"):
        slides.to_csv(tmp_path / "x.csv", "deg")
