"""A tool on a distal bar: its map to joint C, and all that leads it along a path."""

import json
from functools import partial
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from mpmath import iv, mp, mpf

import fivebar as fb
from fivebar.cli import main
from fivebar.paths.certificates import checker
from fivebar.paths.machine import machine_of
from fivebar.paths.placing.with_tool import largest_upright, tool_regions
from fivebar.paths.tool import MountedTool

NAMED = {
    name: machine_of(fb.ROBOTS[name].robot, fb.ROBOTS[name].tables)
    for name in ("plotclock", "reprapfirmware")
}
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
    assert "not proved" in checker.check(tmp_path / "other.json")


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


def test_placing_finds_the_clearance_it_says():
    """Against the exact loci that the tool sees, sampled densely."""
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    path = fb.path(SQUARE, deviation=2e-4)
    placed = fb.place(robot, path, tool=tool, working=MODES, turn=0.0)
    assert placed.path.tool.working == MODES
    points = placed.path.drawn(np.linspace(0, placed.path.length, 400))[0]
    loci = np.concatenate([locus.points for locus in tool.loci(robot, MODES)])
    loci = loci[np.isfinite(loci).all(axis=1)]
    nearest = np.linalg.norm(points[:, None] - loci, axis=-1).min()
    assert nearest == pytest.approx(placed.clearance, abs=1.2e-3)
    assert nearest > placed.clearance - 1e-5
    assert fb.check_path(robot, placed.path.at_unit_speed, MODES).singularity_free
    with pytest.raises(ValueError, match="largest scale found to fit"):
        fb.place(robot, path, tool=tool, working=MODES, turn=0.0, scale=9.0)


def test_the_largest_scale_keeps_the_clearance_and_a_larger_one_does_not():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    path = fb.path(SQUARE, deviation=2e-4)
    asked = dict(tool=tool, working=MODES, turn=0.0, constraints=fb.Constraints(clearance=4e-3))
    placed = fb.place(robot, path, scale=None, **asked)
    points = placed.path.drawn(np.linspace(0, placed.path.length, 400))[0]
    assert np.ptp(points, axis=0) == pytest.approx(
        placed.scale * np.ptp(path(np.linspace(0, path.length, 400))[0], axis=0), rel=1e-9
    )
    loci = np.concatenate([locus.points for locus in tool.loci(robot, MODES)])
    loci = loci[np.isfinite(loci).all(axis=1)]
    nearest = np.linalg.norm(points[:, None] - loci, axis=-1).min()
    assert nearest > 4e-3 - 1e-5 and placed.clearance < 4e-3 + 1e-4
    with pytest.raises(ValueError, match="does not fit at scale"):
        fb.place(robot, path, scale=1.03 * placed.scale, **asked)


def test_regions_of_a_tool_in_the_joint_are_the_aspects():
    robot = fb.FiveBar()
    regions = tool_regions(fb.Tool(1), robot, (-1, -1))
    areas = [aspect.area for aspect in fb.aspects(robot) if aspect.working == (-1, -1)]
    got = [region.area for region in regions[:2]]
    np.testing.assert_allclose(got, sorted(areas)[::-1][:2], rtol=5e-3)


def test_loci_are_where_the_joint_is_singular():
    tool, robot = PLOTCLOCK.tool, PLOTCLOCK.robot
    for locus in tool.loci(robot, MODES):
        if locus.kind == "folded tool":
            continue
        points = locus.points[np.isfinite(locus.points).all(axis=1)][5:-5:7]
        for point in points:
            mounted = MountedTool(tool, robot, MODES)
            c = mounted.joint(point + 1e-9)
            if np.isnan(c).any():
                continue
            pose = fb.igm(robot, c, MODES, unreachable="nan")
            if np.isnan(pose.q).any():
                continue
            sines = np.abs([*pose.sines, pose.det_A])
            assert sines.min() < 2e-3


def test_a_machine_with_a_tool_comes_back(tmp_path):
    PLOTCLOCK.save(tmp_path / "robot.toml")
    assert fb.load_machine(tmp_path / "robot.toml") == PLOTCLOCK
    (tmp_path / "robot.toml").write_text("[tool]\nleg = 1\nup = 2", encoding="utf-8")
    with pytest.raises(ValueError, match="no up in the table tool"):
        fb.load_machine(tmp_path / "robot.toml")


def test_the_map_of_a_tool(tmp_path, capsys):
    assert main(["map", "--robot", "plotclock", "--out", str(tmp_path / "map.png")]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:2] == ["1", "+-"]
    assert (tmp_path / "map.png").stat().st_size > 10000
    assert main(["map", "--robot", "plotclock", "--det-A", "0.1"]) == 2


@pytest.mark.parametrize("seed", range(4))
def test_the_largest_upright_box_is_that_of_all_boxes(seed):
    """Of each pair of columns and of rows on a small grid, with spots in the way."""
    rng = np.random.default_rng(seed)
    free = rng.uniform(size=(9, 12)) < 0.9
    size, step, low = np.array([0.03, 0.05]), 0.01, np.array([0.1, -0.2])
    asked = []

    def at(points):
        asked.append(points)
        return np.arange(len(points))

    region = SimpleNamespace(clearance=np.where(free, 0.0, -1.0), step=step, low=low, at=at)
    scale, middle = largest_upright(region, size, 0.0)
    largest = max(
        min((b - a) / size[0], (d - c) / size[1]) * step
        for a, b in combinations(range(9), 2)
        for c, d in combinations(range(12), 2)
        if free[a : b + 1, c : d + 1].all()
    )
    assert scale == pytest.approx(largest, rel=1e-9) and (middle == asked[0][-1]).all()
    first, last = np.rint(((middle + np.outer((-1, 1), scale * size / 2)) - low) / step * 2) / 2
    inside = free[
        int(np.ceil(first[0])) : int(last[0]) + 1, int(np.ceil(first[1])) : int(last[1]) + 1
    ]
    assert inside.size and inside.all()
    none = SimpleNamespace(clearance=np.full((4, 4), -1.0), step=step, low=low, at=at)
    assert largest_upright(none, size, 0.0)[0] == 0.0
