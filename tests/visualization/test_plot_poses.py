"""Pictures of poses: bars where the model has them, one scale, refusals."""

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
MODES = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def drawn(axes):
    """The legs, each base, elbow, end-effector in mm, as drawn: bar by bar from the base, no two of a colour."""
    lines = [line for line in axes.lines if line.get_linewidth() == 3]
    assert len({line.get_color() for line in lines}) == len(lines)
    bars = [np.stack(line.get_data(), axis=-1) for line in lines]
    first = [bar for bar in bars if not any(np.allclose(bar[0], other[1]) for other in bars)]
    return [
        np.concatenate(
            [
                bar,
                *(
                    other[1:]
                    for other in bars
                    if np.allclose(other[0], bar[1]) and other is not bar
                ),
            ]
        )
        for bar in sorted(first, key=lambda bar: bar[0, 0])
    ]


def test_bars_are_where_they_should_be(tmp_path):
    pose = fb.igm(ROBOT, np.tile((0.05, 0.09), (4, 1)), MODES)
    figure = fb.plot.pose(pose)
    assert len(figure.axes) == 4
    for axes, mode in zip(figure.axes, MODES):
        for points, base, bars in zip(drawn(axes), (-59.0, 59.0), ((90.0, 90.0), (90.0, 90.0))):
            assert points[0] == pytest.approx((base, 0.0)) and points[2] == pytest.approx(
                (50.0, 90.0)
            )
            assert np.linalg.norm(np.diff(points, axis=0), axis=1) == pytest.approx(bars)
        assert f"({mode[0]:+d}, {mode[1]:+d})".replace("-", "−") in axes.get_title()
    assert len({axes.get_xlim() + axes.get_ylim() for axes in figure.axes}) == 1
    figure.savefig(tmp_path / "poses.png")


def test_a_list_of_poses_with_titles():
    figure = fb.plot.pose(
        [fb.dgm(ROBOT, (0.0, 0.0)), fb.dgm(ROBOT, (0.0, 0.0), 1), fb.dgm(ROBOT, [(0.1, 0.2)] * 3)],
        "abcde",
    )
    assert [axes.get_title() for axes in figure.axes] == list("abcde")


def test_a_biglide_stands_on_its_guides():
    figure = fb.plot.pose(fb.dgm(fb.Biglide(), (0.1, -0.05)))
    left, right = drawn(figure.axes[0])
    assert left[0] == pytest.approx((-200.0, 100.0)) and right[0] == pytest.approx((200.0, -50.0))
    assert {line.get_xdata()[0] for line in figure.axes[0].lines if line.get_linewidth() == 6} == {
        -200.0,
        200.0,
    }


@pytest.mark.parametrize(
    "poses, titles, message",
    [
        (fb.dgm(ROBOT, (2.8, 0.3), unreachable="nan"), None, "does not close"),
        (fb.dgm(ROBOT, (0.0, 0.0)), ["a", "b"], "2 titles for 1 poses"),
        ([], None, "no pose"),
    ],
)
def test_what_cannot_be_drawn(poses, titles, message):
    with pytest.raises(ValueError, match=message):
        fb.plot.pose(poses, titles)


@pytest.mark.parametrize("robot", [ROBOT, fb.Biglide()], ids=["five-bar", "biglide"])
def test_ellipses_are_of_the_velocities_and_forces_of_the_pose(robot):
    """Velocities by finite differences; forces by their power, tau . q', at these velocities."""
    pose = fb.igm(
        robot, [(0.05, 0.19), (0.0, 0.16)] if robot is not ROBOT else [(0.05, 0.09), (0.0, 0.1)]
    )
    angles, step = np.linspace(0, 2 * np.pi, 181), 1e-6
    units = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    ends = {}
    for kind in ("velocity", "force"):
        figure = fb.plot.pose(pose, ellipse=kind)
        words = {
            "velocity": f"m/s for 1 {robot.words.unit}/s",
            "force": f"N for 1 {robot.words.effort_unit}",
        }
        assert all(axes.get_title().endswith(f" {words[kind]}") for axes in figure.axes)
        curves = [axes.lines[-1].get_xydata() for axes in figure.axes]
        ends[kind] = np.array(curves) - 1e3 * pose.xi[:, None]
        longest = [float(axes.get_title().split(" up to ")[1].split()[0]) for axes in figure.axes]
        sizes = np.linalg.norm(ends[kind], axis=-1).max(axis=-1)
        assert longest[0] / longest[1] == pytest.approx(sizes[0] / sizes[1], rel=0.01)
        ends[kind] *= longest[0] / sizes[0]
    moved = [fb.dgm(robot, pose.q[k] + step * units, pose.assembly[k]).xi for k in range(2)]
    found = (np.array(moved) - pose.xi[:, None]) / step
    np.testing.assert_allclose(ends["velocity"], found, rtol=0.01, atol=0.01 * np.abs(found).max())
    power = ends["force"] @ ends["velocity"].swapaxes(-1, -2)
    np.testing.assert_allclose(power, np.tile(units @ units.T, (2, 1, 1)), atol=0.02)


def test_an_ellipse_without_an_end_is_refused():
    folded = fb.dgm(ROBOT, fb.igm(ROBOT, (0.05, 0.09)).q[[0, 0]])
    straight = fb.igm(ROBOT, (-0.059 + 0.18 * np.cos(1.0), 0.18 * np.sin(1.0)))
    with pytest.raises(fb.SingularityError, match="the force has no bound: pose 1 is of Type 1"):
        fb.plot.pose([folded, straight], ellipse="force")
    with pytest.raises(ValueError, match="ellipse"):
        fb.plot.pose(folded, ellipse="round")
