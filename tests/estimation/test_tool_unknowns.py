"""A pen beside joint C: its place on its bar is calibrated with the robot, against `Tool.point`."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.estimation.calibration.measured_robot import bars_off, sines_at, values_of
from fivebar.estimation.calibration.measured_robot import seen as measured_model
from fivebar.estimation.calibration.sheet import sheet
from tests.helpers.twins import HOME, LAB, LENGTHS, NOMINAL, poses, robot_of, twin

GEOMETRY = (*LENGTHS, "offset1", "offset2")
NAMES = (*GEOMETRY, "along", "across")


def drawn(rng, leg, n=30, sigma=0.0, modes=((-1, -1), (-1, 1), (1, -1), (1, 1))):
    """True values, and what is measured of a tool 12 mm along and 6 mm to the right of its bar."""
    true = twin(rng, LAB, GEOMETRY)
    true |= dict(along=0.012 + 1e-3 * rng.uniform(-1, 1), across=-0.006 + 1e-3 * rng.uniform(-1, 1))
    found = poses(true, n, rng, modes)
    tool = fb.Tool(leg, true["along"], true["across"])
    points = np.array([tool.point(pose) for pose in found]) + sigma * rng.standard_normal((n, 2))
    q = np.array([pose.q for pose in found]) - (true["offset1"], true["offset2"])
    return true, dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])


@pytest.mark.parametrize("leg", [1, 2])
def test_the_model_is_that_of_tools_and_its_derivatives_are_exact(leg):
    rng = np.random.default_rng(leg)
    tool = fb.Tool(leg, 0.013, -0.007)
    own = dict(along=0.013, across=-0.007, tool_leg=leg, x0=0.1, y0=0.2, turn=0.3, scale=1.1)
    p = values_of(NOMINAL, own | dict(offset1=0.1, ratio2=1.01))
    found = poses(twin(rng, NOMINAL, ()), 10, rng)
    q = (np.array([pose.q for pose in found]) - p[5:7]) / p[7:9]
    assembly = np.array([int(pose.assembly) for pose in found])
    xi = np.array([tool.point(pose) for pose in found]) @ (1, 1j)
    z = 0.1 + 0.2j + 1.1 * np.exp(0.3j) * xi
    points, jacobian = measured_model(p, q, assembly)
    assert points @ (1, 1j) == pytest.approx(z, abs=1e-15)
    assert bars_off(p, q, points)[0] == pytest.approx(0.0, abs=1e-15)
    signs = np.array([(*pose.working, pose.assembly) for pose in found])
    assert (-np.sign(sines_at(p, q, points)) == signs).all()
    off = points + 3e-3 * rng.standard_normal(points.shape)
    by_legs = bars_off(p, q, off)[1]
    for k in range(15):
        step = 1e-6 * (np.arange(16) == k)
        ends = [measured_model(p + way * step, q, assembly)[0] for way in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(jacobian[:, :, k], abs=1e-8)
        ends = [bars_off(p + way * step, q, off)[0] for way in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(by_legs[:, :, k], abs=1e-8)


@pytest.mark.parametrize("leg", [1, 2])
def test_exact_points_tell_the_robot_and_the_tool(leg, tmp_path):
    true, data = drawn(np.random.default_rng(leg), leg)
    found = fb.calibrate(LAB, data, NAMES, tool=fb.Tool(leg))
    assert found.values == pytest.approx({name: true[name] for name in NAMES}, abs=1e-11)
    assert found.indistinguishable == () and found.rms < 1e-13
    assert found.machine.tool == fb.Tool(leg, found.values["along"], found.values["across"])
    found.to_json(tmp_path / "found.json")
    again = fb.Calibration.from_json(tmp_path / "found.json")
    assert again.values == found.values and again.machine == found.machine


def covered(seeds):
    inside = []
    for seed in seeds:
        leg = 1 + seed % 2
        true, data = drawn(np.random.default_rng(seed), leg, sigma=1e-4)
        found = fb.calibrate(LAB, data, NAMES, tool=fb.Tool(leg, 0.012, -0.006), sigma=1e-4)
        intervals = found.intervals().items()
        inside.append([low <= true[name] <= high for name, (low, high) in intervals])
    return np.mean(inside, axis=0)


def test_intervals_hold_the_true_values():
    assert covered(range(12)).mean() > 0.85


@pytest.mark.deep
def test_intervals_hold_the_true_values_in_950_of_1000_sets():
    """Each of the nine shares has a standard deviation of 0.7 %."""
    share = covered(range(1000))
    assert (np.abs(share - 0.95) < 0.028).all() and abs(share.mean() - 0.95) < 0.01


def test_a_known_tool_and_one_known_beforehand():
    true, data = drawn(np.random.default_rng(5), 1, 12, 1e-4)
    at = {name: true[name] for name in ("along", "across")}
    known = fb.calibrate(LAB, data, GEOMETRY, tool=fb.Tool(1, **at), sigma=1e-4)
    assert known.fits and known.machine.tool == fb.Tool(1, **at)
    tool = fb.Tool(1, true["along"] + 1e-4, true["across"])
    priors = {"along": 2e-4, "across": 2e-4}
    found = fb.calibrate(LAB, data, NAMES, tool=tool, sigma=1e-4, priors=priors)
    free = fb.calibrate(LAB, data, NAMES, tool=tool, sigma=1e-4)
    assert known.sd["l12"] < found.sd["l12"] < free.sd["l12"]
    with pytest.raises(ValueError, match="along, across: which distal bar carries the tool"):
        fb.calibrate(LAB, data, NAMES)


def test_a_tool_that_is_not_told_apart_is_named():
    """By a ruler's distances in one mode, over a few points, the frame is free and the tool with it."""
    true, data = drawn(np.random.default_rng(6), 1, 30)
    unknown = ("x0", "y0", "along", "across")
    one = {name: column[:1] for name, column in data.items()}
    noted = one | {"assembly": [1]}
    pose = fb.dgm(robot_of(true), (one["q1"][0] + true["offset1"], one["q2"][0] + true["offset2"]))
    noted["assembly"] = [int(pose.assembly)]
    at = {name: true[name] for name in ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")}
    sides = []
    for side in (-1, 1):
        result = fb.calibrate(
            LAB, one | {"assembly": [side]}, unknown, start=at, tool=fb.Tool(1), sigma=1e-4
        )
        sides.append(" ".join(result.indistinguishable))
    assert all("along" in words and "x0" in words for words in sides)


def test_poses_and_tolerances_of_a_tool():
    tool = fb.Tool(2, 0.012, -0.006)
    where = fb.measurement_poses(LAB, 8, NAMES, tool=tool)
    assert np.isfinite(list(where.sd(1e-4).values())).all() and set(where.sd(1e-4)) == set(NAMES)
    pose = fb.igm(LAB, (0.0, 0.1))
    errors = fb.tip_error(LAB, {"l12": 1e-4, "along": 2e-4}, pose, tool=tool)
    longer = fb.FiveBar(LAB.l11, LAB.l12 + 1e-7, LAB.l21, LAB.l22, LAB.d)
    moved = tool.point(fb.dgm(longer, pose.q)) - tool.point(pose)
    assert errors.jacobian[0, :, 0] == pytest.approx(moved / 1e-7, abs=1e-5)
    assert np.linalg.norm(errors.jacobian[0, :, 1]) == pytest.approx(1.0)


@pytest.mark.deep
def test_the_sheet_is_drawn_by_the_pen():
    machine = fb.Machine(LAB, tool=fb.Tool(1, 0.012, -0.006))
    test = sheet(machine, "A5")
    for q, cross in zip(test.readings, test.crosses):
        ends = [machine.tool.point(fb.dgm(LAB, q, assembly)) for assembly in (-1, 1)]
        assert min(np.linalg.norm(end - cross) for end in ends) < 1e-12


def test_the_command_takes_the_tool_of_the_file_or_its_leg(tmp_path, capsys):
    true, data = drawn(np.random.default_rng(3), 2, 20, 1e-5, HOME)
    table = tmp_path / "measured.csv"
    columns = np.column_stack([data[name] for name in ("q1", "q2", "x", "y")])
    np.savetxt(table, columns, delimiter=",", header="q1,q2,x,y", comments="")
    words = ["calibrate", str(table), "--unknown", "along", "across", "offset1", "offset2"]
    assert main([*words, "--tool-leg", "2"]) == 0
    assert "along    mm" in capsys.readouterr().out
    assert main(words) == 1
    assert "--tool-leg" in capsys.readouterr().err
    fb.Machine(LAB, tool=fb.Tool(2, 0.012, -0.006)).save(tmp_path / "robot.toml")
    out = ["--robot", str(tmp_path / "robot.toml"), "--out", str(tmp_path / "out")]
    assert main([*words, *out]) == 0
    tool = fb.load_machine(tmp_path / "out" / "robot.toml").tool
    assert tool.leg == 2 and tool.along == pytest.approx(true["along"], abs=2e-3)
