"""What the exported files say of a robot, by what the robot has."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.exporters.bodies import start_of

ROBOTS = {
    "plain": fb.FiveBar(),
    "dry": fb.FiveBar(fs2=0.02),
    "wet": fb.FiveBar(fv1=0.03, fv22=0.01),
    "biglide": fb.Biglide(),
}
FORMATS = "mjcf", "urdf", "sdf", "c"


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_is_left_empty_and_friction_is_told_where_there_is_some(format, name):
    text = fb.export(ROBOTS[name], format)
    assert not re.search(
        r"\bNone\b|\bnan\b|\{\w*\}", text if format != "c" else text.partition("*/")[0]
    )
    assert bool(re.search("Coulomb friction|Dry friction", text)) == (name == "dry")


@pytest.mark.parametrize("format,words", [("mjcf", ", ".join), ("urdf", None), ("sdf", None)])
@pytest.mark.parametrize("name", ROBOTS)
def test_joints_are_told_by_their_names(format, words, name):
    """And with the coordinates of a pose that closes, where the file has no loop of its own."""
    robot = ROBOTS[name]
    joints = [joint for leg in zip(robot.words.joints, robot.words.passive) for joint in leg]
    about = " ".join(fb.export(robot, format).split())
    if words:
        assert f"Joints {', '.join(joints)}," in about
        return
    pose = fb.dgm(robot, (0.0, 0.0))
    values = np.stack([pose.q, pose.q_passive], axis=1).ravel()
    assert (
        ", ".join(f"{joint} = {value!r}" for joint, value in zip(joints, values.tolist())) in about
    )


def test_the_c_header_names_its_controller():
    assert "0 of fivebar_computed_torque, which a motor might get" in " ".join(
        fb.export(fb.FiveBar(), "c").split()
    )


@pytest.mark.parametrize(
    "robot",
    [
        fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.35),
        fb.FiveBar(0.05, 0.2, 0.05, 0.35, 0.12),
        fb.Biglide(0.2, 0.05, 0.1),
    ],
    ids=["far", "crossed", "biglide"],
)
def test_without_a_pose_at_home_a_regular_one_is_shown(robot):
    """About as far from both kinds of singularities as the best of many random poses."""
    with pytest.raises(fb.UnreachableError):
        fb.dgm(robot, (0.0, 0.0))
    pose = start_of(robot, None)
    wide = np.pi if robot.turns else 0.25
    several = fb.dgm(
        robot, np.random.default_rng(0).uniform(-wide, wide, (20_000, 2)), unreachable="nan"
    )
    margins = np.min(np.abs([several.det_A, *several.sines]), axis=0)
    assert min(abs(pose.det_A), *np.abs(pose.sines)) > 0.9 * np.nanmax(margins)


def test_bodies_far_from_their_axes_weigh_little():
    """First moments of the drives across and along: masses and inertias positive, their moments those of the robot."""
    from fivebar.exporters.bodies import legs_of

    robot = fb.FiveBar(mx11=0.004, my11=-0.003, mx21=-0.002, my21=0.005)
    for leg, mx, my in zip(legs_of(robot), (0.004, -0.002), (-0.003, 0.005)):
        body, bar = leg.drive, leg.bar
        # The distal bar's mass that does not count at the end-effector is carried by the elbow.
        moved = bar.mass * (1 - bar.x / 0.09) * 0.09
        assert body.mass * body.x + moved == pytest.approx(mx, rel=1e-12)
        assert body.mass * body.y == pytest.approx(my, rel=1e-12)
        assert 0 < body.mass < 50 and body.inertia > 0
