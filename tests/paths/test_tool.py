"""A tool on a distal bar: its map to joint C, and all that leads it along a path."""

import json
import re
from functools import partial

import numpy as np
import pytest
from mpmath import iv, mp, mpf

import fivebar as fb
from fivebar.cli import main
from fivebar.paths.certificates import checker
from fivebar.paths.placing.tool_regions import tool_regions
from fivebar.paths.tool import MountedTool
from fivebar.singularities.regions import inside
from tests.helpers.browsing import chromium

NAMED = {name: fb.load_machine(name) for name in ("plotclock", "reprapfirmware")}
PLOTCLOCK = NAMED["plotclock"]
MODES = 1, -1
SQUARE = [(-0.02, 0.05), (0.02, 0.05), (0.02, 0.065), (-0.02, 0.065), (-0.02, 0.05)]


def led(points=SQUARE, deviation=2e-4):
    path = fb.path(points, deviation=deviation)
    return PLOTCLOCK.tool.path(PLOTCLOCK.robot, path, MODES)


def component(joint, table, length, start, axis, s):
    """x or y of joint C at s of a path, the tool's place by powers of u."""
    u = (s - start) / length
    x, y = (sum(row[i] * u**n for n, row in enumerate(table)) for i in (0, 1))
    return joint(x, y)[axis]


def exact_joint(robot, tool, working, x, y):
    """C from the tool's place by mpmath, through angles: another formulation."""
    leg = tool.leg - 1
    l1, l2 = (mpf(robot.drives[leg].length), mpf(robot.distal[leg]))
    from_elbow = mp.mpc(l2 + mpf(tool.along), mpf(tool.across))
    r = abs(from_elbow)
    way = mp.mpc(x - mpf(robot.drives[leg].x), y)
    span = abs(way)
    corner = mp.acos((l1**2 + span**2 - r**2) / (2 * l1 * span))
    for side in (working, -working):
        elbow = l1 * mp.expj(mp.arg(way) + side * corner)
        bar = (way - elbow) / from_elbow * l2  # along the distal bar, with its length
        if mp.sign((mp.conj(elbow) * bar).imag) == -working:
            c = elbow + bar
            return c.real + mpf(robot.drives[leg].x), c.imag
    raise AssertionError("not reached")


def random_tools(rng, count):
    """Robots, tools behind, beside and beyond their joints, and poses of them."""
    found = 0
    while found < count:
        bars = rng.uniform(0.05, 0.1, 4)
        try:
            robot = fb.FiveBar(*bars, rng.uniform(0.0, 0.1))
            pose = fb.dgm(robot, rng.uniform(-3, 3, 2), int(rng.choice([-1, 1])))
        except (ValueError, ArithmeticError):
            continue
        tool = fb.Tool(int(rng.integers(1, 3)), *rng.uniform(-0.03, 0.03, 2))
        working = tuple(int(mode) for mode in pose.working)
        if 0 in working or np.abs(pose.sines).min() < 0.6:
            continue
        found += 1
        yield robot, tool, pose, working


def test_its_joint_and_three_derivatives_agree_with_50_digits():
    """On paths of all kinds of pieces, for random robots and tools."""
    rng = np.random.default_rng(30)
    with mp.workdps(50):
        for robot, tool, pose, working in random_tools(rng, 12):
            start = tool.point(pose)
            turn = rng.uniform(0, 6)
            step = 0.002 * np.array([np.cos(turn), np.sin(turn)])
            path = fb.path([start, start + step, start + step + 0.5 * step[::-1]], deviation=1e-4)
            led = tool.path(robot, path, working)
            s = path.length * rng.uniform(0.05, 0.9)
            k = int(np.searchsorted(path.knots, s, side="right")) - 1
            got = np.array(led(s))
            table = [[mpf(float(c)) for c in row] for row in path.pieces[k].coefficients]
            length = mpf(path.pieces[k].length)

            joint = partial(exact_joint, robot, tool, working[tool.leg - 1])
            on_piece = partial(component, joint, table, length, mpf(float(path.knots[k])))
            for axis in (0, 1):
                along = partial(on_piece, axis)
                exact = [mp.diff(along, mpf(float(s)), n) for n in range(4)]
                for n, value in enumerate(exact):
                    size = max(abs(float(each)) for each in exact[: n + 1])
                    size = max(size, float(np.abs(got[n]).max()))
                    assert abs(got[n, axis] - float(value)) < 2e-12 * max(size, 1e-3)


def test_pose_point_and_jacobian_are_inverses():
    rng = np.random.default_rng(1)
    known = 0
    for robot, tool, pose, working in random_tools(rng, 200):
        try:
            back = tool.pose(robot, tool.point(pose), working)
        except fb.UnreachableError:
            continue
        if np.abs(back.xi - pose.xi).max() > 1e-9:
            continue  # beyond the fold of the tool, where another pose of this mode is meant
        known += 1
        x, y = (float(value) for value in tool.point(pose))
        number = checker.Number
        lengths = [number(iv.mpf(float(robot.parameters[n]))) for n in checker.LENGTHS]
        plain = {"leg": tool.leg, "along": tool.along, "across": tool.across}
        place = checker.joint(number(iv.mpf(x)), number(iv.mpf(y)), lengths, plain, working)
        assert abs(float(place[0].value.mid) - pose.xi[0]) < 1e-12
        if abs(pose.det_A) < 0.2:
            continue
        h = 1e-6
        J = np.empty((2, 2))
        for j in (0, 1):
            ends = [
                fb.dgm(robot, pose.q + e, int(pose.assembly))
                for e in h * np.eye(2)[[j, j]] * [[1], [-1]]
            ]
            J[:, j] = (tool.point(ends[0]) - tool.point(ends[1])) / (2 * h)
        np.testing.assert_allclose(tool.jacobian(pose), J, atol=1e-7)
    assert known > 150


@pytest.mark.parametrize("tool", [fb.Tool(1, 0.02, 0.01), fb.Tool(2, -0.03, 0.02)])
def test_derivatives_of_the_joint_in_the_checker(tool):
    """By the tool's place and by all lengths, against differences of itself."""
    values = [0.01, 0.1, 0.09, 0.08, 0.1, 0.09, 0.11]  # x, y, l11, l12, l21, l22, d
    plain = {"leg": tool.leg, "along": tool.along, "across": tool.across}

    def place(at):
        slopes = [[iv.mpf(k == j) for j in range(7)] for k in range(7)]
        x, y, *lengths = map(checker.Number, map(iv.mpf, at), slopes)
        return checker.joint(x, y, lengths, plain, (-1, 1))

    h = 1e-6
    for j in range(7):
        ends = [place(np.array(values) + sign * h * np.eye(7)[j]) for sign in (1, -1)]
        for one, plus, minus in zip(place(values), *ends):
            change = (float(plus.value.mid) - float(minus.value.mid)) / (2 * h)
            assert float(one.slopes[j].mid) == pytest.approx(change, abs=1e-7)


def firmware_angles(x, y):
    """PlotClock's own set_XY, mm from the middle of its motors, before it scales to pulses."""

    def corner(a, b, c):
        return np.arccos((a * a + c * c - b * b) / (2 * a * c))

    c, a1 = np.hypot(x + 12.5, y), np.arctan2(y, x + 12.5)
    left = corner(35, 55.1, c) + a1
    a2 = corner(55.1, 35, c)
    hx = x + 13.2 * np.cos(a1 - a2 + 0.621 + np.pi)
    hy = y + 13.2 * np.sin(a1 - a2 + 0.621 + np.pi)
    c, a1 = np.hypot(hx - 12.5, hy), np.arctan2(hy, hx - 12.5)
    return left, a1 - corner(35, 45, c)


def test_plotclock_turns_as_its_firmware_does():
    rng = np.random.default_rng(2)
    points = np.stack([rng.uniform(-0.03, 0.03, 50), rng.uniform(0.03, 0.07, 50)], axis=-1)
    pose = PLOTCLOCK.tool.pose(PLOTCLOCK.robot, points, MODES)
    angles = np.stack(firmware_angles(*1e3 * points.T), axis=-1)
    np.testing.assert_allclose(np.exp(1j * pose.q), np.exp(1j * angles), atol=1e-13)
    # L1, L2, L3, L4 of the firmware.
    assert PLOTCLOCK.robot.l12 == pytest.approx(0.045, abs=5e-5)
    tip = PLOTCLOCK.tool.point(pose)
    assert np.linalg.norm(tip - pose.elbows[:, 0], axis=1) == pytest.approx(0.0551)
    assert np.linalg.norm(tip - pose.xi, axis=1) == pytest.approx(0.0132)


def test_the_line_m669_homes_in_its_own_working_mode():
    """B251.9:144.3 and L2 of the line are of one pose; C34:251:-71:146 holds around it."""
    machine = NAMED["reprapfirmware"]
    assert machine.angles((180.0, 90.0)) == pytest.approx((np.pi, np.pi / 2))
    pose = fb.dgm(machine.robot, machine.angles((251.9, 144.3)), -1)
    assert pose.working.tolist() == [1, -1]
    bed = fb.igm(machine.robot, machine.frame.inverse((0.05, 0.05)), (1, -1))
    assert min(machine.constraints.clearances(bed).values()) > 0


@pytest.mark.deep
def test_a_motion_keeps_the_limits_of_the_tool():
    path = led()
    limits = fb.Constraints(speed=0.05, acceleration=0.5)
    motion = fb.time_path(PLOTCLOCK.robot, path, constraints=limits, working=MODES)
    assert motion.duration <= 1.001 * motion.lower_bound
    t = np.linspace(0.0, motion.duration, 4001)
    k, gone, speed, push = motion.along(t)
    _, tip_s, tip_ss, _ = path.drawn.on(motion.piece[k], motion.first[k] + gone)
    tip_ddot = tip_ss * speed[:, None] ** 2 + tip_s * push[:, None]
    assert 0.04999 < np.linalg.norm(tip_s * speed[:, None], axis=1).max() <= 0.05
    assert 0.4999 < np.linalg.norm(tip_ddot, axis=1).max() <= 0.5
    # The tool of the motion's poses is on the drawing.
    tip = PLOTCLOCK.tool.point(motion.accelerations(t).rates.pose)
    np.testing.assert_allclose(
        tip, path.drawn.on(motion.piece[k], motion.first[k] + gone)[0], atol=1e-15
    )
    slow = fb.Constraints(speed=0.05, acceleration=0.5, jerk=20.0)
    smooth = fb.path(SQUARE, deviation=2e-4, curvature=True)
    smooth = PLOTCLOCK.tool.path(PLOTCLOCK.robot, smooth, MODES)
    jerky = fb.time_path(PLOTCLOCK.robot, smooth, constraints=slow, working=MODES)
    assert jerky.duration > motion.duration


@pytest.mark.every(2)
@pytest.mark.parametrize("tolerance", [0.0, 1e-4])
def test_a_proof_holds_for_the_tool(tolerance, tmp_path):
    proof = fb.certify(PLOTCLOCK.robot, led(), tolerance, working=MODES)
    assert proof.proved and proof.assembly == -1
    proof.to_json(tmp_path / "proof.json")
    assert checker.check(tmp_path / "proof.json") is None
    claim = json.loads((tmp_path / "proof.json").read_text("utf-8"))
    claim["tool"]["across"] = 0.03  # a tool of another shape
    claim["sha256"] = checker.digest(claim)
    (tmp_path / "other.json").write_text(json.dumps(claim), encoding="utf-8")
    assert "of it: not proved" in checker.check(tmp_path / "other.json")


def test_a_tool_in_the_joint_changes_nothing():
    robot = fb.FiveBar()
    path = fb.path([(0.05, 0.09), (0.09, 0.07)])
    led = fb.Tool(2).path(robot, path)
    s = np.linspace(0, path.length, 9)
    for a, b in zip(led(s), path(s)):
        np.testing.assert_allclose(a, b, atol=1e-12 * max(np.abs(b).max(), 1))
    limits = fb.Constraints(acceleration=1.0)
    one, other = (fb.time_path(robot, each, constraints=limits) for each in (led, path))
    assert one.duration == pytest.approx(other.duration, rel=2e-3)


@pytest.mark.parametrize(
    "points, words",
    [
        ([(-0.02, 0.05), (-0.06, 0.09)], "does not reach"),
        ([(-0.02, 0.05), (-0.02, 0.0)], "does not reach .* 0.0075 m from base joint 1"),
        ([(-0.0125, 0.05), (-0.0125, 0.0205)], "folds over its bar"),
    ],
)
def test_a_path_that_the_tool_does_not_follow_is_refused(points, words):
    with pytest.raises(fb.UnreachableError, match=words):
        led(points)


def test_bad_tools_are_refused():
    robot = fb.FiveBar()
    path = fb.path([(0.05, 0.09), (0.09, 0.07)])
    with pytest.raises(ValueError, match="leg must be"):
        fb.Tool(3)
    with pytest.raises(ValueError, match="on its elbow"):
        fb.Tool(1, -0.09).path(robot, path)
    with pytest.raises(TypeError, match="must be a FiveBar"):
        fb.Tool(1, 0.01).path(fb.Biglide(), path)
    with pytest.raises(fb.UnreachableError, match="does not reach"):
        fb.Tool(1, 0.01).pose(robot, (1.0, 0.0))
    assert np.isnan(fb.Tool(1, 0.01).pose(robot, (1.0, 0.0), unreachable="nan").q).all()
    with pytest.raises(ValueError, match="the path leads a tool"):
        fb.time_path(robot, led(), constraints=fb.Constraints(acceleration=1.0))
    with pytest.raises(ValueError, match="the path leads a tool"):
        fb.certify(robot, led())


def borders(tool, robot):
    """Arcs that bound the regions of a tool in its usual modes."""
    regions = tool_regions(tool, robot, MODES)
    return [arc for region in regions for loop in region.boundary for arc in loop]


@pytest.mark.deep
def test_placing_finds_the_clearance_it_says():
    """Against the exact loci that the tool sees, sampled densely."""
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    path = fb.path(SQUARE, deviation=2e-4)
    placed = fb.place(robot, path, tool=tool, working=MODES, turn=0.0)
    assert placed.path.tool.working == MODES
    points = placed.path.drawn(np.linspace(0, placed.path.length, 400))[0]
    loci = np.concatenate([arc.dense(2e-5) for arc in borders(tool, robot)])
    nearest = np.abs((points @ (1, 1j))[:, None] - loci).min()
    assert nearest == pytest.approx(placed.clearance, abs=2e-5)
    assert nearest > placed.clearance - 1e-9
    assert fb.check_path(robot, placed.path.at_unit_speed, MODES).singularity_free
    with pytest.raises(ValueError, match="largest scale found to fit"):
        fb.place(robot, path, tool=tool, working=MODES, turn=0.0, scale=9.0)


@pytest.mark.deep
def test_the_largest_scale_keeps_the_clearance_and_a_larger_one_does_not():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    path = fb.path(SQUARE, deviation=2e-4)
    asked = dict(tool=tool, working=MODES, turn=0.0, constraints=fb.Constraints(clearance=4e-3))
    placed = fb.place(robot, path, scale=None, **asked)
    points = placed.path.drawn(np.linspace(0, placed.path.length, 400))[0]
    assert np.ptp(points, axis=0) == pytest.approx(
        placed.scale * np.ptp(path(np.linspace(0, path.length, 400))[0], axis=0), rel=1e-9
    )
    arcs = [arc for loop in placed.aspect.boundary for arc in loop]
    border = np.concatenate([arc.dense(2e-4) for arc in arcs])
    nearest = np.abs((points @ (1, 1j))[:, None] - border).min()
    assert nearest > 4e-3 - 1e-5 and placed.clearance < 4e-3 + 1e-4
    with pytest.raises(ValueError, match="does not fit at scale"):
        fb.place(robot, path, scale=1.03 * placed.scale, **asked)


@pytest.mark.deep
def test_a_page_and_strokes_are_placed_for_a_tool():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    page = fb.place(robot, page=(0.04, 0.02), tool=tool, working=MODES)
    assert page.aspect.contains(page.placement(fb.path([(0.02, 0.01), (0.03, 0.01)]))(0.0)[0])
    placed = fb.place(robot, fb.path(SQUARE), tool=tool, working=MODES, strokes=True)
    assert all(part.working == MODES and led.tool for led, part in placed.strokes)


@pytest.mark.deep
def test_no_random_placement_has_more_clearance():
    rng = np.random.default_rng(4)
    drawn = fb.path([(0.0, 0.0), (0.02, 0.0), (0.02, 0.015)])
    for robot, tool, _, working in random_tools(rng, 3):
        placed = fb.place(robot, drawn, tool=tool, working=working)
        points = drawn(np.linspace(0, drawn.length, 40))[0] @ (1, 1j)
        for region in tool_regions(tool, robot, working):
            border = np.concatenate([arc.dense(2e-4) for loop in region.boundary for arc in loop])
            z = points * np.exp(2j * np.pi * rng.uniform(size=(400, 1)))
            z = z + rng.uniform(border.real.min(), border.real.max(), (400, 1))
            z = z + 1j * rng.uniform(border.imag.min(), border.imag.max(), (400, 1))
            held = inside(region.boundary, z.ravel()).reshape(z.shape).all(axis=1)
            nearest = [np.abs(each[:, None] - border).min() for each in z[held]]
            assert max(nearest, default=0.0) < 1.01 * placed.clearance


def test_regions_of_a_tool_in_the_joint_are_the_aspects():
    robot = fb.FiveBar()
    for region, aspect in zip(tool_regions(fb.Tool(1), robot), fb.aspects(robot), strict=True):
        assert (region.working, region.assembly) == (aspect.working, aspect.assembly)
        assert region.area == pytest.approx(aspect.area, rel=1e-11)


def equal_bars(rng, count):
    """Robots with folded legs that end on their base joints, and tools behind, on and beyond."""
    for k in range(count):
        l1, l2, d = rng.uniform(0.05, 0.1, 3)
        along = (-1.4 * l1, 0.02, 0.0, -0.5 * l1)[k % 4]
        across = (0.01, -0.03, 0.0)[k % 3]
        yield fb.FiveBar(l1, l1, l2, l2, d), fb.Tool(1 + k % 2, along, across)


def check_regions(robot, tool, rng):
    """Against the map of single points."""
    regions = tool_regions(tool, robot)
    for mode in {region.working for region in regions}:
        reach = robot.drives[tool.leg - 1].length + MountedTool(tool, robot, mode).reach
        points = rng.uniform(-reach, reach, (800, 2)) + (robot.drives[tool.leg - 1].x, 0)
        pose = tool.pose(robot, points, mode, unreachable="nan")
        margin = np.abs([*pose.sines, pose.det_A]).min(axis=0)
        clear = ~(margin < 1e-6)  # nan is, too
        own = [region for region in regions if region.working == mode]
        held = np.array([region.contains(points) for region in own])
        assembly = np.array([region.assembly for region in own]) @ held
        known = np.where(np.isfinite(pose.det_A), -np.sign(pose.det_A), 0.0)
        np.testing.assert_array_equal(assembly[clear], known[clear])
        assert held.sum(axis=0).max() <= 1
    return regions


@pytest.mark.parametrize("count", [1, pytest.param(16, marks=pytest.mark.deep)])
def test_regions_are_where_the_tool_is_led_without_a_singularity(count):
    """For robots and tools of all kinds."""
    rng = np.random.default_rng(count)
    cases = [(robot, tool) for robot, tool, *_ in random_tools(rng, count)]
    for robot, tool in [*cases, *equal_bars(rng, count)]:
        check_regions(robot, tool, rng)


@pytest.mark.parametrize("leg", [1, 2])
def test_regions_of_a_tool_on_a_coaxial_robot(leg):
    """Both legs are stretched on one circle, and equal bars fold on both base joints at once."""
    rng = np.random.default_rng(leg)
    tool = fb.Tool(leg, 0.02, 0.01)
    for bars in ((0.1, 0.2, 0.1, 0.2), (0.1, 0.2, 0.12, 0.18), (0.1, 0.15, 0.12, 0.2)):
        check_regions(fb.FiveBar(*bars, 0.0), tool, rng)
    for region in check_regions(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.0), fb.Tool(leg, 0.02), rng):
        assert region.area == pytest.approx(np.pi * (0.22**2 - 0.02**2), rel=1e-11)
        assert not region.contains((0.0, 0.0))
    check_regions(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.0), tool, rng)


KEPT = fb.Constraints(det_A=0.3, sin=0.4, half_planes=[(0, 1, 0.04)])


def test_regions_keep_constraints():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    whole = {region.assembly: region for region in tool_regions(tool, robot, MODES)}
    rng = np.random.default_rng(8)
    points = rng.uniform(-0.09, 0.09, (4000, 2))
    pose = tool.pose(robot, points, MODES, unreachable="nan")
    good = fb.Constraints(det_A=0.3, sin=0.4).satisfied(pose)
    regions = tool_regions(tool, robot, MODES, KEPT)
    held = np.array([region.contains(points) for region in regions]).any(axis=0)
    np.testing.assert_array_equal(held, good)
    allowed = np.zeros(len(points), dtype=bool)
    for region in regions:
        at = region.contains(points)
        allowed[at] = region.allowed(points[at] @ (1, 1j))
    np.testing.assert_array_equal(allowed, KEPT.satisfied(pose))
    assert sum(region.area for region in regions) < sum(r.area for r in whole.values())


@pytest.mark.deep
def test_a_placed_tool_keeps_constraints():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    placed = fb.place(
        robot, fb.path([(0.0, 0.0), (0.01, 0.0)]), tool=tool, working=MODES, constraints=KEPT
    )
    s = np.linspace(0, placed.path.length, 200)
    poses = fb.igm(robot, placed.path(s)[0], MODES)
    least = min(clearance.min() for clearance in KEPT.clearances(poses).values())
    assert least > 0


def test_borders_are_where_the_joint_is_singular_or_the_tool_folds():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    kinds = set()
    for arc in borders(tool, robot):
        z, dz = arc.curve(arc.s[2:-2:5])
        beside = z + 1e-9j * dz / np.abs(dz)  # on the left is the region
        points = np.stack([beside.real, beside.imag], axis=1)
        pose = tool.pose(robot, points, MODES)
        u1 = np.stack(pose.legs[tool.leg - 1].direction, axis=1) @ (1, 1j)
        arm = beside - pose.elbows[:, tool.leg - 1] @ (1, 1j)
        fold = np.abs((u1.conj() * arm).imag) / np.abs(arm)
        assert np.min([*np.abs([*pose.sines, pose.det_A]), fold], axis=0).max() < 2e-3
        kinds.add(arc.locus.kind)
    assert len(kinds) >= 5


def test_a_machine_with_a_tool_comes_back(tmp_path):
    PLOTCLOCK.save(tmp_path / "robot.toml")
    assert fb.load_machine(tmp_path / "robot.toml") == PLOTCLOCK
    (tmp_path / "robot.toml").write_text("[tool]\nleg = 1\nup = 2", encoding="utf-8")
    with pytest.raises(ValueError, match="no parameter up of the table tool"):
        fb.load_machine(tmp_path / "robot.toml")


@pytest.mark.deep
def test_the_map_of_a_tool(tmp_path, capsys):
    assert main(["map", "--robot", "plotclock", "--out", str(tmp_path / "map.png")]) == 0
    assert ["1", "++"] in [line.split()[:2] for line in capsys.readouterr().out.splitlines()]
    assert (tmp_path / "map.png").stat().st_size > 10000


@pytest.mark.deep
def test_a_map_of_a_tool_has_the_field_of_its_poses_and_a_page_that_finds_them(tmp_path):
    """What the page computes in a browser is the joint of `MountedTool`."""
    robot, tool = PLOTCLOCK.robot, PLOTCLOCK.tool
    data = fb.singularity_map(robot, tool=tool, shape=(41, 41))
    at = np.stack(np.meshgrid(data.x, data.y), axis=-1)
    for mode, values in zip(data.modes, data.values):
        pose = tool.pose(robot, at, mode, unreachable="nan")
        np.testing.assert_array_equal(values, pose.det_A)
    figure = fb.plot.singularity_map(data)
    assert {"Type 1: a leg in line", "base joint"} <= {
        text.get_text() for text in figure.legends[0].get_texts()
    }
    with pytest.raises(ValueError, match="a tool has places in task space"):
        fb.singularity_map(robot, space="joint", tool=tool)
    data.to_npz(tmp_path / "map.npz")
    with pytest.raises(ValueError, match="the map of a tool is not read back"):
        fb.singularities.maps.Map.from_npz(tmp_path / "map.npz")
    fb.page(data, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text("utf-8")
    content = json.loads(re.search(r'id="content">(.*?)</script>', page)[1])
    words = page[page.index("function jointIn") : page.index("// Where the page begins")]
    program = (
        f"const robot = {json.dumps(content['robot'])}, at = [0, 0];"
        f"const layers = {json.dumps(content['layers'])}; {words}"
        f"const found = layers.map((_, k) => {json.dumps(at.reshape(-1, 2).tolist())}.map(place => {{"
        "[at[0], at[1]] = place; return jointIn(k).map(v => Number.isNaN(v) ? null : v); }));"
        "return found;"
    )
    with chromium("--disable-gpu") as browser:
        run = browser.new_page().evaluate(f"() => {{ {program} }}")
    for mode, found in zip(data.modes, run):
        expected = MountedTool(tool, robot, mode).joint(at.reshape(-1, 2))
        np.testing.assert_allclose(np.array(found, float), expected, rtol=0, atol=1e-15)
