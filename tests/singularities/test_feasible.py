"""What constraints and loads leave of the aspects, against points of the plane."""

import itertools
import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.constraints.disc import bounded_by
from fivebar.constraints.feasible import feasible_parts
from fivebar.constraints.load import Load
from fivebar.paths.placing.tool_regions import tool_regions
from fivebar.singularities.aspects import aspects

ROBOT = fb.FiveBar(0.09, 0.1, 0.085, 0.11, 0.118)
MODES = tuple(itertools.product((1, -1), repeat=2))
CASES = {
    "joints": (fb.Constraints(joints=((0.2, 2.5), (0.0, 2.8))), None),
    "half-planes": (fb.Constraints(half_planes=[(0, 1, 0.03), (1, 1, -0.05)]), None),
    "margins": (fb.Constraints(det_A=0.3, sin=0.2, half_planes=[(0, 1, 0.03)]), None),
    "load": (fb.Constraints(), Load((0.5, -5.0), (0.3, 0.4))),
    "links": (fb.Constraints(collisions=fb.LinkCollisions(widths=0.012, posts=0.005)), None),
}


def parts_of(robot, constraints, load=None):
    found = []
    for part in aspects(robot):
        found += feasible_parts(bounded_by(part, constraints, load))
    return found


def holds(robot, points, working, constraints, load):
    """By igm and the constraints alone; the load by virtual work, without a Jacobian."""
    pose = fb.igm(robot, points, working, unreachable="nan")
    found = constraints.satisfied(pose)
    if load is None:
        return found
    step = 1e-7
    for leg in (0, 1):
        moved = np.nan_to_num(pose.q, nan=1.0) + step * np.eye(2)[leg]
        ends = []
        for assembly in (1, -1):
            other = fb.dgm(robot, moved, assembly, unreachable="nan")
            ends.append(np.where((pose.assembly == assembly)[:, None], other.xi, 0))
        work = (sum(ends) - points) @ load.force / step
        found &= np.abs(work) <= load.torque[leg]
    return found


@pytest.mark.every(6)
@pytest.mark.parametrize("name", CASES)
def test_areas_are_those_of_points_that_hold(name):
    constraints, load = CASES[name]
    parts = parts_of(ROBOT, constraints, load)
    side, n = 0.44, 500
    steps = side * ((np.arange(n) + 0.5) / n - 0.5)
    points = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rng = np.random.default_rng(0)
    for working in MODES:
        own = [part for part in parts if part.working == working]
        expected = holds(ROBOT, points, working, constraints, load).mean() * side**2
        area = sum(part.area for part in own)
        error = sum(part.area_error for part in own)
        border = sum(
            np.abs(np.diff(arc.z)).sum() for p in own for loop in p.boundary for arc in loop
        )
        # Of a grid each border cell is right or wrong by chance.
        assert abs(area - expected) < error + 0.1 * border * side / n + 1e-7
        at = rng.uniform(-side / 2, side / 2, (400, 2))
        inside = np.any([part.contains(at) for part in own], axis=0) if own else np.zeros(400, bool)
        assert (
            inside != holds(ROBOT, at, working, constraints, load)
        ).sum() <= 400 * error / side**2 + 1


def test_the_area_of_a_region_in_an_aspect_is_the_polygons():
    corners = [(-0.03, 0.06), (0.03, 0.05), (0.02, 0.11), (0.0, 0.07)]
    (part,) = [
        part
        for part in parts_of(fb.FiveBar(), fb.Constraints(region=corners))
        if part.working == (-1, -1)
    ]
    x, y = np.transpose(corners)
    area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    assert part.area == pytest.approx(area, abs=1e-9) and part.area_error < 1e-7


@pytest.mark.deep
def test_discs_and_rectangles_of_parts_are_those_of_the_aspect_with_constraints():
    constraints = fb.Constraints(joints=((0.2, 2.5), (0.0, 2.8)), half_planes=[(0, 1, 0.03)])
    aspect = fb.aspect(fb.FiveBar(), 9)
    parts = feasible_parts(bounded_by(aspect, constraints))
    disc = max(fb.largest_disc(part).radius for part in parts)
    assert disc == pytest.approx(fb.largest_disc(aspect, constraints).radius, rel=1e-7)
    rectangle = max(fb.largest_rectangle(part).area for part in parts)
    expected = fb.largest_rectangle(aspect, constraints).area
    assert rectangle == pytest.approx(expected, rel=2e-3)


def test_a_load_is_held_with_the_weight_of_the_bars():
    bars = {name: fb.Link(0.2) for name in ("11", "12", "21", "22")}
    heavy = fb.FiveBar.from_links(0.1, 0.12, 0.1, 0.12, 0.08, bars, gravity=(0.0, -9.81))
    light = fb.FiveBar(0.1, 0.12, 0.1, 0.12, 0.08)
    pose = fb.igm(light, (0.02, 0.15), (1, -1))
    held = Load((1.0, -2.0), (1, 1)).torques(pose)
    np.testing.assert_allclose(held, -pose.J.T @ (1.0, -2.0), rtol=1e-12)
    with_weight = Load((1.0, -2.0), (1, 1)).torques(fb.igm(heavy, (0.02, 0.15), (1, -1)))

    def height(q):
        xi = fb.dgm(heavy, q, int(pose.assembly))
        middles = [0.5 * (base + elbow) for base, elbow in zip(BASES, xi.elbows)]
        middles += [0.5 * (elbow + xi.xi) for elbow in xi.elbows]
        return 0.2 * 9.81 * sum(middle[1] for middle in middles)

    slope = [(height(pose.q + h) - height(pose.q - h)) / 2e-6 for h in 1e-6 * np.eye(2)]
    np.testing.assert_allclose(with_weight - held, slope, rtol=1e-6)


def test_the_load_of_an_upright_robot_has_regions_where_nodes_are_singular():
    """The grid on which the curves are traced has nodes on Type 1."""
    robot, load = fb.FiveBar(gravity=(0.0, -9.81)), Load((0.0, -5.0), (0.5, 0.5))
    parts = parts_of(robot, fb.Constraints(), load)
    at = np.random.default_rng(1).uniform(-0.24, 0.24, (300, 2))
    pose = fb.igm(robot, at, (-1, -1), unreachable="nan")
    reached = np.isfinite(pose.q).all(axis=1)
    inside = np.any([part.contains(at[reached]) for part in parts if part.working == (-1, -1)], 0)
    pose = fb.igm(robot, at[reached], (-1, -1))
    needed = fb.gravity_torques(pose) - np.einsum("nji,j->ni", pose.J, load.force)
    held = (np.abs(needed) <= load.torque).all(axis=1)
    assert 10 < held.sum() < 250
    assert (inside != held).mean() < 0.01


BASES = np.array([(-0.04, 0.0), (0.04, 0.0)])


@pytest.mark.deep
def test_of_a_tool_a_load_and_joints_leave_regions():
    tool = fb.Tool(1, 0.02, 0.01)
    joints = fb.Constraints(joints=((0.2, 2.5), (0.0, 2.8)))
    load = Load((0.0, -3.0), (0.3, 0.3), tool.jacobian)
    rng = np.random.default_rng(1)
    for base in tool_regions(tool, ROBOT, (1, -1), joints, load)[:1]:
        at = rng.uniform(-0.2, 0.2, (2000, 2))
        at = at[base.contains(at)]
        parts = feasible_parts(base)
        inside = np.any([part.contains(at) for part in parts], axis=0)
        pose = tool.pose(ROBOT, at, (1, -1))
        torque = np.abs(np.einsum("nij,i->nj", tool.jacobian(pose), load.force)).max(axis=1)
        assert (inside != (joints.satisfied(pose) & (torque <= 0.3))).sum() <= 3
        assert 20 < inside.sum() < len(at)


@pytest.mark.deep
def test_the_map_of_a_robot_with_constraints(tmp_path, capsys):
    robot = tmp_path / "servos.toml"
    limits = fb.Constraints(joints=((0.2, 2.5), (0.0, 2.8)), clearance=0.002, torque=0.3)
    fb.Machine(fb.FiveBar(), constraints=limits).save(robot)
    words = ["map", "--robot", str(robot), "--nodes", "21", "--out", str(tmp_path / "map.png")]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    expected = parts_of(fb.FiveBar(), fb.Constraints(joints=limits.joints))
    areas = sorted(region["area_m2"] for region in found["regions"])
    np.testing.assert_allclose(areas, sorted(part.area for part in expected), atol=1e-9)
    disc = found["largest_disc"]
    own = fb.largest_disc(fb.aspect(fb.FiveBar(), 3), replace_torque(limits))
    assert disc["radius_m"] >= own.radius * (1 - 1e-7)
    assert min(found["largest_rectangle"]["rectangle_m"]) > disc["radius_m"]
    assert main([*words, "--load", "0", "-5"]) == 0
    printed = capsys.readouterr().out
    assert "largest disc: radius" in printed and "largest rectangle in it:" in printed


def test_a_load_needs_the_torque_of_the_motors(capsys):
    assert main(["map", "--load", "0", "-5"]) == 2
    assert "--load needs the motors' torque" in capsys.readouterr().err


def replace_torque(limits):
    return fb.Constraints(joints=limits.joints, clearance=limits.clearance)


# Borders that end where a leg is in line, touch the circle of a folded leg in their middle, are
# chords, or begin on the base joint of a leg of equal bars.
TOOLS = {
    "touching": (
        (0.08, 0.1, 0.1, 0.1, 0.09),
        fb.Tool(1, 0.04),
        fb.Constraints(half_planes=[(0, 1, 0.02)], det_A=0.1),
    ),
    "at the base joint": (
        (0.09, 0.09, 0.09, 0.09, 0.118),
        fb.Tool(2, 0.0, -0.03),
        fb.Constraints(joints=((0, 3.14159), (0, 3.14159))),
    ),
    "chords": (
        (0.119, 0.108, 0.083, 0.123, 0.08),
        fb.Tool(2, -0.034, 0.037),
        fb.Constraints(
            joints=((0.2, 1.8), (-3.0, 0.7)),
            half_planes=[(0, 1, 0.02)],
            collisions=fb.LinkCollisions(widths=0.01),
        ),
    ),
}


@pytest.mark.every(3)
@pytest.mark.parametrize("name", TOOLS)
def test_areas_of_a_tool_are_those_of_points_that_hold(name):
    (*bars, d), tool, constraints = TOOLS[name]
    robot = fb.FiveBar(*bars, d=d)
    working = (1, 1) if name == "chords" else (1, -1)
    parts = [
        part
        for region in tool_regions(tool, robot, working, constraints)
        for part in feasible_parts(region)
    ]
    side, n = 0.6, 300
    steps = side * ((np.arange(n) + 0.5) / n - 0.5)
    points = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    pose = tool.pose(robot, points, working, unreachable="nan")
    expected = constraints.satisfied(pose).mean() * side**2
    arcs = [arc for part in parts for loop in part.boundary for arc in loop]
    border = sum(np.abs(np.diff(arc.z)).sum() for arc in arcs)
    error = sum(part.area_error for part in parts)
    assert sum(part.area for part in parts) == pytest.approx(
        expected, abs=error + 0.1 * border * side / n
    )
