"""A robot as it is built: its file comes back, and its readings and frame are used by commands."""

import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fivebar as fb
from fivebar.cli import main
from fivebar.paths.setpoints import setpoints
from tests.helpers.twins import LAB, measured, robot_of, twin

CONSTRAINTS = fb.Constraints(
    torque=(0.1, 0.2),
    joints=(None, (-1.0, 2.0)),
    half_planes=[(0.0, 1.0, 0.01)],
    region=[(-0.1, 0.0), (0.1, 0.0), (0.0, 0.15)],
    det_A=0.1,
    collisions=fb.LinkCollisions(widths=0.01, layers=(1, 2, 1, 2)),
)
FRAME = fb.Placement((0.2, -0.1), 0.4, 1.01)
MACHINES = [
    fb.Machine(LAB),
    fb.Machine(LAB, (0.1, -0.2), (1.01, -2 * math.pi / 4096), FRAME, CONSTRAINTS),
    fb.Machine(fb.Biglide(), (0.01, 0.0), frame=FRAME),
    fb.Machine(LAB, measured=[(1, -1, -1), (-1, -1, 1)]),
    fb.Machine(LAB, constraints=fb.Constraints(motors=(fb.Motor(2.0, 5.0), fb.Motor(3.0, 6.0, 2)))),
    fb.Machine(LAB, ratio=(1.0, -1.0), tool=fb.Tool(2, 0.01, -0.02)),
]


@pytest.mark.parametrize("machine", MACHINES, ids=repr)
def test_a_saved_machine_comes_back(machine, tmp_path):
    machine.save(tmp_path / "robot.toml")
    again = fb.load_machine(tmp_path / "robot.toml")
    # Half planes and region of a file are in the measuring frame: they come back up to rounding.
    for name in ("half_planes", "region"):
        given = getattr(machine.constraints, name)
        assert np.allclose(getattr(again.constraints, name) or (), given or (), rtol=0, atol=1e-15)
    own = {name: getattr(machine.constraints, name) for name in ("half_planes", "region")}
    assert replace(again, constraints=replace(again.constraints, **own)) == machine
    assert fb.load_robot(tmp_path / "robot.toml") == machine.robot


def test_constraints_on_poses_alone_and_comments_of_a_file(tmp_path):
    machine = fb.Machine(LAB, constraints=CONSTRAINTS)
    poses = machine.on_poses
    assert poses.torque is None and poses.joints == CONSTRAINTS.joints
    assert poses.region == CONSTRAINTS.region and poses.det_A == 0.1
    machine.save(tmp_path / "robot.toml", {"l11": 1e-4}, ("first line", "second"))
    lines = (tmp_path / "robot.toml").read_text("utf-8").splitlines()
    assert lines[:2] == ["# first line", "# second"]
    assert "0.0001" in next(line for line in lines if line.startswith("l11"))


def test_readings_of_a_biglide_have_a_unit(tmp_path):
    (tmp_path / "robot.toml").write_text(
        'l1 = 0.3\nd = 0.4\nmf1 = 1\n[readings]\nratio = ["1 mm", -0.0254]\n'
    )
    assert fb.load_machine(tmp_path / "robot.toml").ratio == (0.001, -0.0254)


numbers = st.floats(-10, 10)


@settings(max_examples=20)
@given(
    st.tuples(numbers, numbers), st.floats(0.01, 2), st.tuples(numbers, numbers), numbers, numbers
)
def test_readings_and_frame_are_inverted(offset, ratio, shift, turn, angle):
    machine = fb.Machine(LAB, offset, (ratio, -ratio), fb.Placement(shift, turn, ratio))
    q = np.array([[angle, 1.0], [0.0, -angle]])
    np.testing.assert_allclose(machine.angles(machine.readings(q)), q, rtol=0, atol=1e-13)
    np.testing.assert_allclose(machine.frame.inverse(machine.frame(q)), q, rtol=0, atol=1e-11)
    assert machine.angles([[0.0, 0.0]])[0] == pytest.approx(offset)


@pytest.mark.parametrize(
    "text, words",
    [
        (
            "[readings]\noffset1 = 1",
            "no parameter offset1 of the table readings; the known ones are offset, ratio",
        ),
        ("[readings]\nratio = [0, 1]", "ratio must not be 0"),
        ("[readings]\noffset = 'x'", "offset: 'x' is not a number"),
        ("[frame]\nscale = -1", "scale must be finite and > 0"),
        ("[constraints]\ntorque = -1", "torque must be"),
        (
            "[constraints]\ncollisions = {width = 1}",
            "no parameter width of the table constraints.collisions",
        ),
        ("[motor]\ntorque = 1", "there is no table motor"),
        ("[measured]\nmodes = [[1, -1]]", "measured modes must be three signs"),
        (
            "[measured]\nmode = 1",
            "no parameter mode of the table measured; the known ones are modes",
        ),
        ("readings = 3", "readings must be a table of offset, ratio"),
    ],
)
def test_what_is_no_machine_is_refused(text, words, tmp_path):
    path = tmp_path / "robot.toml"
    head, tables = ("", text) if "[" in text[:1] else (text + "\n", "")
    path.write_text(f'{head}kind = "five-bar"\n{tables}\n', "utf-8")
    with pytest.raises(ValueError, match=f"robot.toml: .*({words})"):
        fb.load_machine(path)


def write_data(path, data):
    rows = zip(*data.values())
    lines = [",".join(data), *(",".join(map(repr, map(float, row))) for row in rows)]
    path.write_text("\n".join(lines) + "\n", "utf-8")


def test_units_of_readings():
    machine = fb.Machine(LAB)
    for unit, per_turn, turn in (("deg", None, 360), ("turns", None, 1), ("counts", 4096, 4096)):
        assert machine.scale(unit, per_turn) * 2 * math.pi == pytest.approx(turn, rel=1e-15)
    assert machine.scale("rad") == 1.0
    with pytest.raises(ValueError, match="^unit must be one of rad, "):
        machine.scale("grad")


@pytest.mark.deep
def test_a_calibrated_robot_draws_where_it_is_told(tmp_path, capsys):
    """Measured to 20 um; then the robot as it is built does what `setpoints.csv` says."""
    rng = np.random.default_rng(4)
    names = ("l11", "l12", "l21", "l22", "offset1", "offset2", "x0", "y0", "turn")
    true = twin(rng, LAB, names, spread=3.0)
    data = measured(true, 60, rng, 2e-5, ((-1, -1),))
    write_data(tmp_path / "measured.csv", data)
    out = ["--out", str(tmp_path / "cal")]
    assert main(["calibrate", str(tmp_path / "measured.csv"), "--unknown", *names, *out]) == 0
    (tmp_path / "square.csv").write_text("x,y\n0,0\n0.02,0\n0.02,0.02\n0,0.02\n0,0\n", "utf-8")
    calibrated = str(tmp_path / "cal" / "robot.toml")
    drawn = ["draw", str(tmp_path / "square.csv"), "--at", "0.05", "0.1", "--json"]
    drawn += ["--rate", "100", "--period", "0.02"]
    capsys.readouterr()
    figures = {}
    for name, robot in (("used", ["--robot", calibrated]), ("not", [])):
        assert main([*drawn, "--out", str(tmp_path / name), *robot]) == 0
        figures[name] = json.loads(capsys.readouterr().out)
    assert figures["used"]["middle"] == pytest.approx((0.05, 0.1), abs=1e-12)
    errors = {}
    for name in figures:
        table = np.genfromtxt(
            tmp_path / name / "setpoints.csv", delimiter=",", names=True, skip_header=1
        )
        angles = table["q1"] * true["ratio1"] + true["offset1"], table["q2"] + true["offset2"]
        xi = fb.dgm(robot_of(true), np.stack(angles, axis=-1)).xi @ (1, 1j)
        tip = true["x0"] + 1j * true["y0"] + np.exp(1j * true["turn"]) * xi
        errors[name] = np.abs(tip - (table["x"] + 1j * table["y"])).max()
    assert errors["used"] < 1e-4 < 1e-3 < errors["not"]
    # A calibration that goes on from there has nothing to mend.
    assert main(["calibrate", str(tmp_path / "measured.csv"), "--robot", calibrated, *out]) == 0
    again = fb.load_machine(tmp_path / "cal" / "robot.toml")
    assert again.frame.shift == pytest.approx((true["x0"], true["y0"]), abs=1e-4)


@pytest.mark.deep
def test_draw_goes_where_the_robot_was_calibrated_and_says_where_not(tmp_path, capsys):
    """The true robot follows setpoints.csv: in other modes it is several times off."""
    rng = np.random.default_rng(11)
    drawn = fb.FiveBar(0.12, 0.16, 0.12, 0.16, 0.1)
    names = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")
    true = twin(rng, drawn, names, spread=1.0)
    poses = fb.igm(drawn, rng.uniform((-0.06, 0.14), (0.06, 0.2), (14, 2)), (1, -1))
    told = poses.q - [true["offset1"], true["offset2"]]
    xi = fb.dgm(robot_of(true), poses.q, poses.assembly).xi + rng.normal(0, 2e-4, (14, 2))
    data = {"q1": told[:, 0], "q2": told[:, 1], "x": xi[:, 0], "y": xi[:, 1]}
    write_data(tmp_path / "measured.csv", data | {"working1": [1] * 14, "working2": [-1] * 14})
    drawn.save(tmp_path / "drawn.toml")
    out = ["--robot", str(tmp_path / "drawn.toml"), "--out", str(tmp_path / "cal")]
    assert main(["calibrate", str(tmp_path / "measured.csv"), *out]) == 0
    calibrated = tmp_path / "cal" / "robot.toml"
    assert fb.load_machine(calibrated).measured == ((1, -1, -1),)
    (tmp_path / "square.csv").write_text("x,y\n0,0\n0.02,0\n0.02,0.02\n0,0.02\n0,0\n", "utf-8")
    command = ["draw", str(tmp_path / "square.csv"), "--json", "--robot", str(calibrated)]
    command += ["--rate", "100", "--period", "0.02"]
    error = {}
    for name, options in (
        ("first", []),
        ("at", ["--at", "0", "0.16"]),
        ("other", ["--working", "-1", "-1"]),
    ):
        capsys.readouterr()
        assert main([*command, *options, "--out", str(tmp_path / name)]) == 0
        said = capsys.readouterr()
        figures = json.loads(said.out)
        assert figures["measured_modes"] == (name != "other")
        assert ("it was calibrated in working modes +1 -1" in said.err) == (name == "other")
        assert figures["working"] == ([1, -1] if name != "other" else [-1, -1])
        table = np.genfromtxt(
            tmp_path / name / "setpoints.csv", delimiter=",", names=True, skip_header=1
        )
        q = np.stack([table["q1"] + true["offset1"], table["q2"] + true["offset2"]], axis=-1)
        xi = fb.dgm(robot_of(true), q).xi  # assembly -1 in all three
        error[name] = np.hypot(xi[:, 0] - table["x"], xi[:, 1] - table["y"]).max()
    assert 2 * max(error["first"], error["at"]) < error["other"]


BUILT = fb.Machine(
    fb.FiveBar(0.09, 0.12, 0.09, 0.12, 0.08),
    frame=fb.Placement((0.15, 0.02), 0.3, 1.02),
    tool=fb.Tool(1, 0.01, 0.004),
    constraints=fb.Constraints(acceleration=1.0, torque=2.0, det_A=0.2),
)


def test_functions_lead_the_tool_of_a_machine_in_its_frame():
    """As by hand; and the tool is where the path says, in the measuring frame."""
    modes = (1, -1)
    path = fb.path([(0.11, 0.17), (0.12, 0.17), (0.12, 0.18)])
    by_hand = BUILT.tool.path(BUILT.robot, BUILT.frame.inverse(path), modes)
    limits = fb.Constraints(acceleration=1.0, torque=2.0, det_A=0.2)
    timed = fb.time_path(BUILT, path, working=modes)
    assert (
        timed.duration
        == fb.time_path(BUILT.robot, by_hand, constraints=limits, working=modes).duration
    )
    t = np.linspace(0.0, timed.duration, 101)
    tip = BUILT.frame(BUILT.tool.point(timed.accelerations(t).rates.pose))
    corners = np.array([(0.11, 0.17), (0.12, 0.17), (0.12, 0.18)])
    ways = [np.abs(tip[:, 1] - 0.17) + np.maximum(tip[:, 0] - 0.12, 0), np.abs(tip[:, 0] - 0.12)]
    assert np.min(ways, axis=0).max() < 1e-12 and abs(tip[[0, -1]] - corners[[0, -1]]).max() < 1e-12
    with pytest.warns(UserWarning, match="fb.check_path leaves out torque, acceleration"):
        checked = fb.check_path(BUILT, path.at_unit_speed, modes)
    assert checked.min_margin == fb.check_path(BUILT.robot, by_hand.at_unit_speed, modes).min_margin
    with pytest.warns(UserWarning, match="fb.certify leaves out"):
        proof = fb.certify(BUILT, path, working=modes)
    assert proof.proved and proof.claim["margin"] == 0.2 and proof.claim["tool"]["along"] == 0.01
    with pytest.raises(ValueError, match="leads a tool already"):
        fb.time_path(BUILT, by_hand, working=modes)
    line = BUILT.led(fb.line((0.11, 0.17), (0.12, 0.17), 2.0), modes)
    tip = BUILT.tool.point(fb.igm(BUILT.robot, line(1.0)[0], modes))
    assert BUILT.frame(tip) == pytest.approx((0.115, 0.17), abs=1e-14)
    assert BUILT.joint((0.115, 0.17), modes) == pytest.approx(line(1.0)[0], abs=1e-14)
    # The rates of a trajectory in a frame, by differences.
    moved = BUILT.frame(fb.circle((0.0, 0.1), 0.02, 1.0))
    h = 1e-5
    middle, speed, acceleration = moved(0.3)
    before, after = moved(0.3 - h), moved(0.3 + h)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(speed, abs=1e-8)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(acceleration, abs=1e-7)
    assert moved(0.0)[0] == pytest.approx(BUILT.frame((0.02, 0.1)), abs=1e-14)


def test_files_of_fivebar_are_led_by_what_their_first_line_says(tmp_path):
    """The same motion in six files, of joint C or of the tool, in either frame."""
    modes = (1, -1)
    robot = BUILT.robot
    led = BUILT.led(fb.line((0.11, 0.17), (0.12, 0.172), 0.3), modes)
    start = fb.ikm(fb.igm(robot, led(0.0)[0], modes), (0.0, 0.0))
    law = fb.ComputedTorque(robot, 100.0, 20.0, modes, start.pose.assembly)
    run = fb.simulate(robot, law, led, start=start)
    table = setpoints(robot, led, 500.0, modes)
    timed = BUILT.led(fb.path([(0.11, 0.17), (0.12, 0.172)]), modes)
    motion = fb.time_path(robot, timed, 0.3, working=modes)
    in_own_frame = replace(BUILT, frame=fb.Placement())
    writers = {
        "run.csv": run.to_csv,
        "timed.csv": motion.to_csv,
        "joint.csv": replace(table, xi=led(table.t)[0], tool=None).to_csv,
        "own.csv": table.to_csv,
        "own_too.csv": lambda file: table.to_csv(file, machine=in_own_frame),
        "measured.csv": lambda file: table.to_csv(file, machine=BUILT),
    }
    ends = led(0.0)[0], led(1.0)[0]
    for name, write in writers.items():
        write(tmp_path / name)
        path = BUILT.led(fb.path(tmp_path / name), modes)
        assert (path.tool is not None) == ("joint" not in name and name[0] in "om"), name
        for xi, s in zip(ends, (0.0, path.length)):
            np.testing.assert_allclose(path(s)[0], xi, atol=3e-4 if name == "run.csv" else 1e-9)
        again = BUILT.led(fb.from_csv(tmp_path / name), modes)
        np.testing.assert_allclose(again(0.0)[0], ends[0], atol=1e-9)
    recorded = fb.TimedPath.from_csv(tmp_path / "measured.csv")
    np.testing.assert_allclose(BUILT.led(recorded, modes)(1.0)[0], ends[1], atol=1e-9)
    # Placed elsewhere they are points of the table again; without their tool they are refused.
    placed = BUILT.frame(fb.path(tmp_path / "run.csv"))
    with pytest.raises(ValueError, match="leads a tool already"):
        BUILT.led(BUILT.led(placed, modes), modes)
    for machine, words in (
        (replace(BUILT, tool=None), "are of a tool, and this robot has no tool"),
        (in_own_frame, "are in a measuring frame, and this robot has none"),
    ):
        with pytest.raises(ValueError, match=words):
            machine.led(fb.path(tmp_path / "measured.csv"), modes)
    broken = io.StringIO("# fivebar setpoints, SI units: {\nt,x,y\n0,0,0\n1,1,1\n")
    with pytest.raises(ValueError, match="line 1: not of a file of setpoints"):
        fb.path(broken)


def test_constraints_of_a_machine_are_left_out_with_a_warning_and_others_refused():
    aspect = fb.aspect(BUILT.robot, 3)
    with pytest.warns(UserWarning, match="fb.largest_disc leaves out torque, acceleration"):
        disc = fb.largest_disc(aspect, constraints=BUILT.constraints)
    assert disc.radius == fb.largest_disc(aspect, constraints=fb.Constraints(det_A=0.2)).radius
    written = replace(BUILT.constraints, jerk=1.0)
    with pytest.raises(ValueError, match="the constraint jerk is not kept here, leave it out"):
        fb.largest_disc(aspect, constraints=written)


def test_certify_and_draw_agree_in_the_measuring_frame(tmp_path, capsys):
    """On the bed (0, 150) mm is 324.5 mm from a motor of this robot, which reaches 311.5 mm."""
    (tmp_path / "bed.csv").write_text("x (mm),y (mm)\n0,150\n5,150\n", "utf-8")
    robot = ["--robot", "reprapfirmware", "--working", "1", "-1"]
    assert main(["certify", str(tmp_path / "bed.csv"), *robot]) == 1
    told = capsys.readouterr()
    assert "in the measuring frame of the robot's file" in told.out
    assert "(l11 + l12)^2 - r1^2 = -0.008292" in told.out  # 0.3115^2 - 0.054^2 - 0.32^2
    out = ["--as-drawn", "--out", str(tmp_path / "draw")]
    assert main(["draw", str(tmp_path / "bed.csv"), *robot, *out]) == 1
    assert "leaves the workspace at (0, 150) mm" in capsys.readouterr().err
    assert main(["certify", str(tmp_path / "bed.csv"), *robot, "--frame", "robot"]) == 0
    assert "in the robot's own frame" in capsys.readouterr().out
    line = ["--from", "0", "0.15", "--to", "0.01", "0.15"]
    assert main(["track", *line, "--duration", "1", *robot]) != 0
    assert main(["plan", *line, *robot]) != 0
