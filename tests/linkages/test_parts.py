"""Centres of links, quantities by name, the panels of a study, and how drives begin and end."""

import math

import numpy as np
import pytest

import fivebar as fb
from fivebar.linkages import (
    REPAIRED,
    Body,
    FiveBarLinkage,
    FourBar,
    SliderCrank,
    crank_range,
    move,
    study,
)
from fivebar.linkages.drives import two_motors
from fivebar.linkages.quantities import evaluate, usual_panels

FOUR_BAR = FourBar(0.2, 0.06, 0.16, 0.14)
TRACED = FourBar(0.2, 0.06, 0.16, 0.14, point=(0.08, 0.06))
HEAVY = Body(0.3, 1e-3)


def place(value):
    return np.array(value, dtype=float)


def centres(chain):
    """Centre of mass of each link, by its name."""
    return {name: place(link.centre.p) for name, link in chain.links.items()}


@pytest.mark.parametrize("held", ["guide", "crank", "rod", "slider"])
def test_links_of_a_slider_crank_have_their_centres_midway(held):
    """A bar's centre is midway between its joints; those of guide and block are on their pins."""
    linkage = SliderCrank(0.05, 0.15, 0.02, held)
    chain = move(linkage, 0.15, 2.0).chain
    o, a, b = (place(chain.points[name].p) for name in "OAB")
    expected = {"crank": (o + a) / 2, "rod": (a + b) / 2, "guide": o, "slider": b}
    found = centres(chain)
    assert set(found) == set(expected) - {held}
    for name, centre in found.items():
        assert centre == pytest.approx(expected[name], abs=1e-15), name


@pytest.mark.parametrize("held", ["ground", "crank", "coupler", "rocker"])
def test_links_of_a_four_bar_have_their_centres_midway(held):
    linkage = FOUR_BAR if held == "ground" else FOUR_BAR.inversion(held)
    chain = move(linkage, 1.2, 2.0).chain
    points = {name: place(chain.points[name].p) for name in chain.points}
    for name, centre in centres(chain).items():
        pairs = [(points[i] + points[j]) / 2 for i, j in chain.bars]
        assert min(np.linalg.norm(centre - middle) for middle in pairs) < 1e-14, name


def test_a_centre_of_ones_own_is_along_and_across_its_link():
    linkage = SliderCrank(0.05, 0.15, 0.02, rod_body=Body(0.3, 0.0, (0.04, -0.01)))
    chain = move(linkage, 0.7, 2.0).chain
    a, b = (place(chain.points[name].p) for name in "AB")
    along = (b - a) / 0.15
    across = np.array([-along[1], along[0]])
    assert centres(chain)["rod"] == pytest.approx(a + 0.04 * along - 0.01 * across)


@pytest.mark.parametrize(
    "name", ["B.angle", "coupler.x", "coupler.position", "B.position", "slide", "torque.x", "M.vz"]
)
def test_a_quantity_that_its_part_does_not_have_is_refused(name):
    with pytest.raises(ValueError, match=f"no quantity '{name}'; the known ones are crank.angle, "):
        evaluate(move(TRACED, 0.7, 2.0), name)


def test_quantities_are_the_motions_own():
    q = np.linspace(0.3, 1.5, 5)
    motion = move(TRACED, q, 2.0, 3.0)
    point = motion.chain.traced
    x, y = motion.position(point).T
    assert evaluate(motion, f"{point}.distance") == pytest.approx(np.hypot(x, y))
    ax, ay = motion.acceleration(point).T
    assert evaluate(motion, f"{point}.total") == pytest.approx(np.hypot(ax, ay))
    assert evaluate(motion, f"{point}.vy").tolist() == motion.velocity(point)[:, 1].tolist()
    assert evaluate(motion, f"{point}.ax").tolist() == ax.tolist()
    assert evaluate(motion, "rocker.rate").tolist() == motion.rate("rocker").tolist()
    slider = move(SliderCrank(0.05, 0.15, 0.02), q, 2.0)
    for k, quantity in enumerate(("position", "velocity", "acceleration")):
        expected = slider.coordinate("slide")[k]
        assert evaluate(slider, f"slide.{quantity}").tolist() == expected.tolist()


def test_panels_of_a_study():
    """A slide's motion; of a point that is named its path; else the links' angles and rates."""
    links = ["crank", "coupler", "rocker"]
    angles, rates, accelerations = (
        [f"{link}.{quantity}" for link in links]
        for quantity in ("angle", "rate", "angular_acceleration")
    )
    assert usual_panels(study(FOUR_BAR, samples=9)) == [angles, rates, accelerations]
    assert usual_panels(study(TRACED, samples=9)) == [
        angles,
        ["M.speed"],
        ["M.tangential", "M.normal"],
    ]
    heavy = FourBar(0.2, 0.06, 0.16, 0.14, crank_body=HEAVY, rocker_body=HEAVY)
    assert usual_panels(study(heavy, samples=9)) == [angles, rates, accelerations, ["torque"]]
    slide = [["slide.position"], ["slide.velocity"], ["slide.acceleration"]]
    assert usual_panels(study(SliderCrank(0.05, 0.15), samples=9)) == slide


@pytest.mark.parametrize("linkage", [FOUR_BAR.inversion("rocker"), FourBar(0.1, 0.12, 0.05, 0.2)])
def test_a_swing_keeps_a_fiftieth_of_its_range_from_the_locks(linkage):
    """A two-hundredth of it, a tenth of a hundredth, where its ends are given."""
    assert not linkage.flats
    run = study(linkage, drive="swing")
    low, high = crank_range(linkage, 1).interval(run.q[0])
    margin = (high - low) / 50
    assert run.q.min() == pytest.approx(low + margin, abs=1e-9)
    assert run.q.max() == pytest.approx(high - margin, abs=1e-6)
    run = study(linkage, drive="swing", between=(low, high))
    assert run.q.min() == pytest.approx(low + margin / 20, abs=1e-9)


@pytest.mark.parametrize(
    "options, error, words",
    [
        ({"between": (0, 1)}, fb.UnreachableError, "cannot swing from 0 to 57.2957795 deg; it may"),
        ({"between": (-0.5, 0.5)}, fb.UnreachableError, "cannot swing from -28.6478898 to"),
        ({"start": 0.0}, fb.UnreachableError, "cannot start at 0 deg; the nearest allowed angle"),
        ({"between": (0.5, 1), "start": 0.6}, ValueError, "or between, not both"),
        (
            {"between": (0.5, 1), "drive": "turn"},
            ValueError,
            'is for the drive "swing", not "turn"',
        ),
    ],
)
def test_a_study_refuses_angles_that_it_would_have_to_change(options, error, words):
    """This crank goes from 22.33 to 66.42 deg, and from -66.42 to -22.33 deg."""
    double_rocker = FourBar(0.2, 0.16, 0.06, 0.14)
    with pytest.raises(error, match=words):
        study(double_rocker, **{"drive": "swing"} | options)
    assert np.ptp(study(double_rocker, drive="swing", between=(0.5, 1)).q) == pytest.approx(0.5)
    assert study(double_rocker, drive="swing", start=-0.6).q.max() < np.radians(-22.33)


def test_two_motors_of_whole_speeds_and_their_lock():
    robot = fb.FiveBar(0.08, 0.09, 0.08, 0.09, 0.1)
    linkage = FiveBarLinkage(robot)
    branch = linkage.usual_branch
    law = two_motors(linkage, "until-lock", (3, 2), 1.0, 101, branch, None)
    assert law.q_dot.dtype == float and (law.q_dot == (3.0, 2.0)).all()
    start = np.array([linkage.home[k] for k in linkage.motors])
    assert law.q[0] == pytest.approx(start) and not law.q_ddot.any()
    angles, seconds = law.lock
    assert np.array(angles) == pytest.approx(start + seconds * np.array([3.0, 2.0]))
    assert law.t[-1] < seconds
    for ahead, closes in ((-1e-9, True), (1e-9, False)):
        q = start + (seconds + ahead) * np.array([3.0, 2.0])
        place = move(linkage, q, branch=branch, unreachable="nan").position("joint 3")
        assert np.isfinite(place).all() == closes
    with pytest.raises(fb.UnreachableError, match=f"lock at .* deg after {seconds:.9g} s") as error:
        two_motors(linkage, "turn", (3, 2), 1.0, 101, branch, None)
    assert math.isnan(error.value.gap)
    with pytest.raises(fb.UnreachableError, match=r"at \[.*\] deg the bars cannot meet") as error:
        two_motors(linkage, "turn", 2.0, 1.0, 101, branch, (math.pi, 0.0))
    assert math.isnan(error.value.gap)


def test_home_is_far_from_a_straight_pair():
    """Of all motor angles in steps of 15 degrees none has passive joints farther from a line."""
    linkage = FiveBarLinkage(fb.FiveBar(0.08, 0.09, 0.1, 0.11, 0.12))
    steps = np.radians(np.arange(-180, 180, 15.0))
    q = np.array([(one, other) for one in steps for other in steps])
    pose = fb.dgm(linkage.robot, q, unreachable="nan")
    left, right = pose.elbows[:, 0], pose.elbows[:, 1]
    sides = [left - pose.xi, right - pose.xi, left - right]
    twice_area = np.abs(sides[0][:, 0] * sides[1][:, 1] - sides[0][:, 1] * sides[1][:, 0])
    flatness = twice_area / sum((side**2).sum(axis=1) for side in sides)
    home = np.array([linkage.home[1], linkage.home[5]])
    own = flatness[np.abs(q - home).max(axis=1) < 1e-9]
    assert own == pytest.approx(np.nanmax(flatness))


def test_points_of_the_press_and_its_centres():
    chain = move(REPAIRED, 1.0, 2.0).chain
    points = {name: place(chain.points[name].p) for name in chain.points}
    for name, centre in centres(chain).items():
        ends = [(points[i] + points[j]) / 2 for i, j in chain.bars] + list(points.values())
        assert min(np.linalg.norm(centre - end) for end in ends) < 1e-13, name
