"""What is wrong is named, whatever it is; and nothing depends on the size of the robot or the drawing."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.blend import blended
from fivebar.paths.curve import Path
from fivebar.paths.fit import Bezier, Ellipse, fitted
from fivebar.paths.pieces import Arc, Line, Polynomial
from fivebar.paths.placing.tool_regions import tool_regions
from fivebar.paths.setpoints import setpoints
from fivebar.paths.timing.constraint_rows import Limits
from fivebar.paths.timing.jerk import refuse_kinks
from fivebar.paths.timing.mesh import mesh_of
from fivebar.paths.timing.solve import refined
from fivebar.paths.tool import MountedTool
from fivebar.planning.trajectory import Trajectory

ROBOT = fb.FiveBar()
CORNER = fb.path([(0.05, 0.09), (0.04, 0.09), (0.04, 0.1)])
MOTION = fb.line((0.05, 0.09), (0.04, 0.1), 1.0)
LIMITS = fb.Constraints(torque=0.1)


def rows(**options):
    return setpoints(ROBOT, MOTION, 10.0).for_drives(**options)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: blended(CORNER, -1.0), "blended: deviation must"),
        (lambda: blended(CORNER, 1e-3, "no"), "blended: curvature must"),
        (lambda: Line((0, "x"), (1, 1)), "Line: start must"),
        (lambda: Line((0, 0), (1, np.nan)), "Line: end must"),
        (lambda: Line((0, 0), (1e300, 1e300)), "Line: (its length|end)"),
        (lambda: Arc((0,), 1, 0, 1), "Arc: centre must"),
        (lambda: Arc((0, 0), 0, 0, 1), "Arc: radius must"),
        (lambda: Arc((0, 0), 1, "a", 1), "Arc: angle0 must"),
        (lambda: Arc((0, 0), 1, 0, np.inf), "Arc: angle1 must"),
        (lambda: Polynomial([(0, 0), (1, 1)], -1), "Polynomial: length must"),
        (lambda: Polynomial([(0, 0), (1, np.nan)], 1), "Polynomial: coefficients"),
        (lambda: fb.Placement(shift=(1, 2, 3)), "Placement: shift must"),
        (lambda: fb.Placement(turn="left"), "Placement: turn must"),
        (lambda: fb.Placement(scale=-1), "Placement: scale must"),
        (lambda: fb.Placement()(np.nan), "Placement: points"),
        (
            lambda: fb.Placement()((1.0, 2.0, 3.0)),
            r"Placement: points must be \(\*batch, 2\), not \(3,\)",
        ),
        (lambda: fb.Tool(0), "Tool: leg must"),
        (lambda: fb.Tool(1, "x"), "Tool: along must"),
        (lambda: fb.Tool(1, 0, np.nan), "Tool: across must"),
        (lambda: fb.Tool(1).path(ROBOT, [1, 2]), "Tool: path must"),
        (lambda: fb.Tool(1).path(ROBOT, CORNER, (1, 2)), "Tool: working must"),
        (lambda: fb.Tool(1).pose(ROBOT, (0, 0.1), (1,)), "Tool: working must"),
        (
            lambda: fb.Tool(1).pose(ROBOT, (0, 0.1, 0)),
            r"Tool: point must be \(\*batch, 2\), not \(3,\)",
        ),
        (lambda: fb.Tool(1).path(fb.Biglide(), CORNER), "Tool: robot must"),
        (lambda: fb.Machine(1), "Machine: robot must"),
        (lambda: fb.Machine(ROBOT, offset=1), "Machine: offset must"),
        (lambda: fb.Machine(ROBOT, ratio=(1, "a")), "Machine: ratio must"),
        (lambda: fb.Machine(ROBOT, frame=1), "Machine: frame must"),
        (lambda: fb.Machine(ROBOT, constraints=1), "Machine: constraints must"),
        (lambda: fb.Machine(ROBOT, tool=1), "Machine: tool must"),
        (lambda: fb.Machine(ROBOT, measured=1), "Machine: measured must"),
        (lambda: fb.Machine(ROBOT).scale("feet"), "unit must"),
        (lambda: fb.Machine(ROBOT).scale("counts", -1), "counts per turn must"),
        (lambda: rows(drive=-5), "for_drives: drive must"),
        (lambda: rows(drive="servo"), "for_drives: drive must"),
        (lambda: rows(drive="odrive", zero=3), "for_drives: zero must"),
        (lambda: setpoints(ROBOT, MOTION, 10.0).to_csv(io.StringIO(), "grad"), "angles must"),
        (lambda: setpoints(ROBOT, MOTION, -1.0), "rate must"),
        (lambda: fb.time_path(ROBOT, CORNER, constraints=LIMITS, gap=2.0), "gap must"),
        (lambda: fb.time_path(ROBOT, CORNER, constraints=LIMITS, max_time=0), "max_time must"),
        (lambda: fb.time_path(ROBOT, CORNER, -1.0, constraints=LIMITS), "duration must"),
        (lambda: fb.place(ROBOT, page=(1, 2, 3)), "place: page must"),
        (lambda: fb.place(ROBOT, page=(0, 1)), "place: page's width must"),
        (lambda: fb.place(ROBOT, page=(1, -1)), "place: page's height must"),
        (lambda: fb.place(ROBOT, CORNER, turn=np.inf), "turn must"),
        (lambda: fb.place(ROBOT, CORNER, scale=0), "scale must"),
        (lambda: Path(CORNER.pieces, dwells={"a": 1}), "Path: s of dwells must"),
        (lambda: Path(CORNER.pieces, tool=1), "Path: tool must"),
    ],
)
def test_a_wrong_argument_is_named_first(call, words):
    with pytest.raises((ValueError, TypeError), match=f"^{words}"):
        call()


def test_certificates_name_wrong_arguments():
    for given, words in (
        ((1, CORNER), "robot must"),
        ((ROBOT, 1), "(certify: )?path must"),
        ((ROBOT, CORNER, -1.0), "(certify: )?tolerances of l11 must"),
        ((ROBOT, CORNER, {"d": -1.0}), "(certify: )?tolerances of d must"),
        (
            (ROBOT, CORNER, {"l": 1.0}),
            "(certify: )?tolerances of l: known are l11, l12, l21, l22, d",
        ),
        ((ROBOT, CORNER, 0.09), "(certify: )?tolerances of 0.09 m leave nothing of l11 = 0.09 m"),
        ((ROBOT, CORNER, 0.0, 1), "(certify: )?constraints must"),
        ((ROBOT, CORNER, 0.0, None, (1, 0)), "(certify: )?working must"),
    ):
        with pytest.raises((ValueError, TypeError), match=f"^{words}"):
            fb.certify(*given)


def test_a_tool_in_words():
    tool = fb.Tool(1, 0.02, -0.01)
    assert repr(tool) == "<Tool: on the distal bar of leg 1, 0.02 m along it, -0.01 m to its left>"
    with pytest.raises(fb.UnreachableError) as refused:
        tool.pose(ROBOT, (1.0, 0.2))
    distance, reach = np.hypot(1.059, 0.2), 0.09 + np.hypot(0.11, 0.01)
    assert str(refused.value) == (
        f"Tool: the tool does not reach (1, 0.2) m: {distance:.6g} m from base joint 1, where from"
        f" {reach - 0.18:.6g} to {reach:.6g} m can be reached"
    )
    assert refused.value.gap == pytest.approx(distance - reach)
    with pytest.raises(fb.UnreachableError, match=r"^Tool: the tool at \(-0.05, 0.02\) m folds"):
        tool.pose(ROBOT, (-0.05, 0.02))
    points = np.array([(0.0, 0.1), (0.01, 0.1), (0.0, 0.3)])
    with pytest.raises(fb.UnreachableError, match=r"does not reach \(0, 0.3\) m") as refused:
        tool.pose(ROBOT, points)
    assert refused.value.index == (2,)


def test_a_point_out_of_the_tools_reach_is_named_as_the_caller_wrote_it():
    """In the measuring frame, here turned by a right angle, of which the tool knows nothing."""
    frame = fb.Placement((0.5, -0.25), np.pi / 2)
    machine = fb.Machine(ROBOT, frame=frame, tool=fb.Tool(1, 0.01))
    points = [(0.4, -0.15), (1.5, 0.125)]  # the first one is reached: (0.1, 0.1) for the robot
    path = fb.path(points)
    where = r"the tool does not reach \(1.5, 0.125\) m: "
    for call in (
        lambda: machine.joint(points[1]),
        lambda: machine.led(fb.line(points[1], points[1], 1.0), (-1, -1)),
        lambda: fb.check_path(machine, fb.path([points[1], points[0]])),
        lambda: fb.certify(machine, fb.path([points[1], points[0]])),
        lambda: fb.time_path(machine, fb.path([points[1], points[0]])),
    ):
        with pytest.raises(fb.UnreachableError, match=where):
            call()
    with pytest.raises(fb.UnreachableError, match=r"s = \d\.\d+ m of the path the tool"):
        fb.check_path(machine, path)
    own = frame.inverse(points[1])
    with pytest.raises(fb.UnreachableError, match=rf"reach \({own[0]:g}, {own[1]:g}\) m: "):
        machine.tool.pose(ROBOT, own)


def test_a_motion_that_a_tool_loses_for_a_moment_is_refused():
    """Out of reach for half a hundredth of its time."""

    def motion(t):
        far = 0.3 * np.exp(-(((np.asarray(t) - 0.733) / 0.002) ** 2))
        xi = np.stack([0 * far, 0.1 + far], axis=-1)
        return np.concatenate([xi, 0 * xi, 0 * xi], axis=-1)

    with pytest.raises(fb.UnreachableError, match="^Tool: at t = 0.73.* s the tool does not reach"):
        fb.Tool(1, 0.01).path(ROBOT, Trajectory(0.0, 1.0, motion))


@pytest.mark.parametrize("bar", [1e-3, 1.0, 1e3])
def test_a_tool_on_its_elbow_is_refused_whatever_the_size(bar):
    robot = fb.FiveBar(bar, bar, bar, bar, bar)
    with pytest.raises(ValueError, match="put it on its elbow"):
        MountedTool(fb.Tool(1, -bar, 5e-10 * bar), robot, (1, 1))
    assert MountedTool(fb.Tool(1, -bar, 2e-9 * bar), robot, (1, 1)).reach == 2e-9 * bar


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_curves_are_fitted_and_blended_alike_in_all_sizes(size):
    beziers = np.array([[0, 1j, 2 + 1j, 2], [0, 2 + 1j, 0 + 1j, 2], [0, 0, 1 + 1j, 1 + 1j]])
    ellipses = [Ellipse(1j, 2.0 + 0j, 1j, 0.0, 5.0), Ellipse(0j, 1.0 + 1j, 0.1j, 1.0, -1.0)]
    for plain in ([Bezier(control) for control in beziers], ellipses):
        one = fitted(plain, 1e-4)
        other = fitted([curve.moved(0j, size) for curve in plain], size * 1e-4)
        assert [len(each) for each in one] == [len(each) for each in other]
        for small, large in zip(sum(one, []), sum(other, [])):
            np.testing.assert_allclose(
                large.coefficients, size * small.coefficients, rtol=1e-9, atol=1e-12 * size
            )
    path = Path(
        (
            Line((0, 0), (1, 0)),
            Line((1, 0), (1, 2)),
            Arc((0, 2), 1, 0, 2),
            Line((math.cos(2), 2 + math.sin(2)), (-3, 0)),
        )
    )
    for curvature in (False, True):
        one = blended(path, 0.01, curvature)
        other = blended(fb.Placement(scale=size)(path), 0.01 * size, curvature)
        assert len(one.pieces) == len(other.pieces) and len(one.stops) == len(other.stops)
        np.testing.assert_allclose(other.knots, size * one.knots, rtol=1e-9)


def scaled(robot, size):
    lengths = {name: size * getattr(robot, name) for name in ("l11", "l12", "l21", "l22", "d")}
    return replace(robot, **lengths, zz1=robot.zz1 * size**2, zz2=robot.zz2 * size**2)


@pytest.mark.parametrize("size", [2.0**7])
def test_paths_are_timed_alike_in_all_sizes(size):
    """Torques grow with the square of the size where masses stay."""
    path = fb.path([Line((0.09, 0.068), (0.05, 0.0))])
    times = []
    for k in (1.0, size):
        robot = scaled(replace(ROBOT, fs1=0.01 * k**2), k)
        mesh = mesh_of(robot, fb.Placement(scale=k)(path), (-1, -1))
        limits = Limits((0.1 * k**2, 0.12 * k**2))
        mesh, found = refined(mesh, limits, 0.05, math.inf)
        times.append((len(mesh), mesh.crossing.sum(), found.time.sum()))
    assert times[0] == pytest.approx(times[1], rel=1e-5)


@pytest.mark.parametrize("size", [2.0**7])
def test_kinks_and_regions_are_alike_in_all_sizes(size):
    arc = Arc((0.0, 0.02), 0.02, -math.pi / 2, 0.0)
    for radius in (0.02 * (1 + 1e-5), 0.02 * (1 + 1e-8)):
        after = Arc((0.02 - radius, 0.02), radius, 0.0, 1.0)
        path = fb.Placement(scale=size)(Path((arc, after)))
        if radius > 0.02 * (1 + 1e-7):
            with pytest.raises(ValueError, match="curvature does not jump"):
                refuse_kinks(path)
        else:
            refuse_kinks(path)
    one = tool_regions(fb.Tool(1, 0.02, 0.01), ROBOT, (-1, -1))
    tool = fb.Tool(1, 0.02 * size, 0.01 * size)
    other = tool_regions(tool, scaled(ROBOT, size), (-1, -1))
    assert [part.area for part in other] == pytest.approx([size**2 * part.area for part in one])


def test_a_hold_without_limits_is_several_times_what_carries_the_robot():
    from fivebar.paths.timing.time_path import AMPLE, _ample

    robot = replace(ROBOT, gravity=(0.0, -100.0))
    mesh = mesh_of(robot, CORNER, (-1, -1))
    pose = fb.igm(robot, CORNER(np.array([stop.s for stop in CORNER.stops]))[0], (-1, -1))
    still = fb.inverse_dynamics(fb.ikm2(fb.ikm(pose, 0 * pose.xi), 0 * pose.xi))
    long = _ample(mesh, Limits(), 100.0)
    assert long.torque == pytest.approx([1 + AMPLE * np.abs(still).max()] * 2) and AMPLE >= 2
    plain = mesh_of(ROBOT, CORNER, (-1, -1))
    assert _ample(plain, Limits(), 100.0).torque == (1.0, 1.0)
    quick = _ample(plain, Limits(), 0.05)
    found = refined(plain, quick, 0.5, math.inf)[1].time.sum()
    assert 0.005 < found < 0.025
    limited = _ample(plain, Limits(speed=0.1), 0.05)  # more torque does not make it faster
    assert 0.2 < refined(plain, limited, 0.5, math.inf)[1].time.sum() < 0.25
