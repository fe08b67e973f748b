"""Set-ups of firmware: M669 of RepRapFirmware, ros2_control."""

import cmath
import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from tests.helpers.needs import need

RRF = fb.load_machine("reprapfirmware")
PUBLISHED = (
    "M669 K9 X-54:54 Y-170:-170 L2 P129.5:127.5 D182:181 B251.9:144.3 A5:185:-90:360:-90:360"
    " C34:251:-71:146"
)


def words(line):
    return {w[0]: [float(v) for v in w[1:].split(":")] for w in line.split()[1:]}


def test_the_published_line_comes_back():
    text = fb.export(RRF, "reprapfirmware", working=(1, -1), homing_deg=(251.9, 144.3))
    line = next(line for line in text.splitlines() if line.startswith("M669"))
    ours, theirs = words(line), words(PUBLISHED)
    assert ours["D"] == [*theirs["D"], 0, 0]
    for letter in "KXYLPBC":
        assert ours[letter] == theirs[letter]


def firmware_inverse(line, x, y):
    """Angles, degrees, as FiveBarScaraKinematics::getInverse finds them."""
    w = words(line)
    turns = {1: (1, 1), 2: (-1, 1), 4: (-1, -1)}[int(w["L"][0])]
    cant = w["D"][2:]

    def theta(leg, distal, goal):
        base = complex(w["X"][leg], w["Y"][leg])
        proximal = w["P"][leg]
        way = goal - base
        span = abs(way)
        along = (span**2 + proximal**2 - distal**2) / (2 * span)
        height = math.sqrt(proximal**2 - along**2)
        for side in (1, -1):
            elbow = base + way / span * complex(along, side * height)
            turn = ((elbow - base).conjugate() * (goal - base)).imag
            if turn * turns[leg] > 0:
                return elbow, math.degrees(cmath.phase(elbow - base))
        raise AssertionError

    goal = complex(x, y)
    first = 1 if cant[1] else 0
    angles = [0.0, 0.0]
    elbow, angles[first] = theta(first, w["D"][first] + cant[first], goal)
    joint = elbow + (goal - elbow) * w["D"][first] / (w["D"][first] + cant[first])
    angles[1 - first] = theta(1 - first, w["D"][1 - first], joint)[1]
    return angles


@pytest.mark.parametrize("leg", [None, 1, 2])
@pytest.mark.parametrize("working", [(-1, -1), (1, -1), (1, 1)])
def test_the_firmware_turns_as_we_do(leg, working):
    """Its own inverse kinematics on the line we write, with a hotend beyond a joint too."""
    rng = np.random.default_rng(5)
    robot = fb.FiveBar(0.12, 0.17, 0.125, 0.18, 0.1)
    tool = None if leg is None else fb.Tool(leg, 0.03)
    machine = fb.Machine(robot, frame=fb.Placement((0.01, -0.1)), tool=tool)
    line = fb.export(machine, "reprapfirmware", working=working).splitlines()[-1]
    known = 0
    for _ in range(60):
        point = rng.uniform((-0.1, 0.05), (0.1, 0.2))
        try:
            pose = (tool or fb.Tool(1)).pose(robot, point, working)
        except (ValueError, ArithmeticError):
            continue
        known += 1
        x, y = 1e3 * machine.frame(point)
        turns = np.radians(firmware_inverse(line, x, y))
        np.testing.assert_allclose(np.exp(1j * turns), np.exp(1j * pose.q), atol=1e-6)
    assert known > 20


def test_margins_and_steps_are_written():
    limits = fb.Constraints(det_A=0.5, sin=0.5, joints=[(0.0, 2.0), None])
    machine = fb.Machine(fb.FiveBar(), constraints=limits, ratio=(0.2, -0.1))
    text = fb.export(machine, "reprapfirmware", steps_per_turn=3600)
    w = words(text.splitlines()[1])
    np.testing.assert_allclose(w["A"], [30, 150, 210, 330, 210, 330], atol=1e-6)
    assert w["C"] == pytest.approx([0, math.degrees(2), -90, 269], abs=1e-5)
    assert "M92 X50 Y100" in text and "M569 P1 S0" in text


@pytest.mark.parametrize(
    "machine, options, message",
    [
        (fb.Machine(fb.FiveBar()), dict(working=(-1, 1)), "its L3"),
        (fb.Machine(fb.FiveBar(), frame=fb.Placement(turn=0.1)), {}, "frame is turned"),
        (fb.Machine(fb.Biglide()), {}, "reprapfirmware refuses a robot with kind = .biglide."),
        (fb.Machine(fb.FiveBar(), tool=fb.Tool(1, 0.01, 0.01)), {}, "10 mm beside it"),
        (
            fb.Machine(fb.FiveBar(), constraints=fb.Constraints(joints=[(0.5, 6.6), None])),
            {},
            "less than a turn",
        ),
    ],
)
def test_what_m669_cannot_say_is_refused(machine, options, message):
    with pytest.raises(ValueError, match=message):
        fb.export(machine, "reprapfirmware", **options)


def test_ros2_control_is_read_by_parsers():
    limits = fb.Constraints(torque=0.5, joint_speed=3.0, joints=[(-1.0, 2.0), None])
    robot = fb.FiveBar(l11=0.1)
    machine = fb.Machine(robot, (0.1, 0.2), (1.0, -1.0), constraints=limits, tool=fb.Tool(2, 0.01))
    text = fb.export(machine, "ros2_control", name="plotter")
    root = ElementTree.fromstring(text)
    assert not root.findall("transmission")
    block = root.find("ros2_control")
    assert block.get("type") == "system" and block.get("name") == "plotter"
    assert block.find("hardware/plugin").text == "mock_components/GenericSystem"
    values = {p.get("name"): float(p.text) for p in block.findall("hardware/param")}
    assert values["l11"] == 0.1 and values["ratio2"] == -1.0 and values["tool_leg"] == 2
    assert (values["working1"], values["assembly"]) == (-1, -1)
    joints = {joint.get("name"): joint for joint in block.findall("joint")}
    assert (
        set(joints) == {"q11", "q21", "q12", "q22"} <= {j.get("name") for j in root.iter("joint")}
    )
    commands = {c.get("name"): c for c in joints["q11"].findall("command_interface")}
    assert [float(p.text) for p in commands["position"]] == [-1.0, 2.0]
    assert [float(p.text) for p in commands["velocity"]] == [-3.0, 3.0]
    assert not joints["q12"].findall("command_interface")
    plain = fb.export(robot, "urdf")
    assert re.search("<transmission", plain)
    need("Pinocchio")
    import pinocchio

    assert pinocchio.buildModelFromXML(text).nv == 4


def test_the_command_writes_them(tmp_path, capsys):
    options = ["--robot", "reprapfirmware", "--working", "1", "-1"]
    assert main(["export", "--to", "reprapfirmware", *options]) == 0
    assert "M669 K9 X-54:54" in capsys.readouterr().out
    out = tmp_path / "a.urdf"
    assert main(["export", "--to", "ros2_control", "--plugin", "my/System", "--out", str(out)]) == 0
    assert "<plugin>my/System</plugin>" in out.read_text("utf-8")


def config(tmp_path, text, name="config.g"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_the_published_line_is_read_as_the_robot_of_that_name(tmp_path):
    text = f"; my printer\nM92 X50 Y50 ; M669 K3\n{PUBLISHED} S100 T0.2 ; five bars\nM208 X0 S1\n"
    machine = fb.load_machine(config(tmp_path, text))
    assert machine.robot == RRF.robot and machine.frame == RRF.frame
    assert (machine.offset, machine.ratio, machine.tool) == (RRF.offset, RRF.ratio, None)
    assert np.ravel(machine.constraints.joints) == pytest.approx(np.ravel(RRF.constraints.joints))
    # The safer of 5 and -5 degrees from bars in line; the elbows are free.
    assert machine.constraints.det_A == pytest.approx(math.sin(math.radians(5)))
    assert machine.constraints.sin == 0 and machine.measured == ((1, -1, -1),)
    assert fb.load_robot(tmp_path / "config.g") == RRF.robot


@pytest.mark.parametrize("seed", range(12))
def test_what_is_written_is_read_again(tmp_path, seed):
    draw = np.random.default_rng(seed)
    working = [(-1, -1), (1, -1), (1, 1)][seed % 3]
    lengths = draw.uniform(0.06, 0.2, 5).round(5).tolist()
    joints = [tuple(np.radians(sorted(draw.uniform(-170, 170, 2).round(4)))), None]
    limits = fb.Constraints(
        det_A=float(draw.uniform(0, 0.8)),
        sin=float(draw.uniform(0, 0.8)),
        joints=joints[:: draw.choice([-1, 1])] if seed % 4 else None,
    )
    tool = fb.Tool(int(draw.integers(1, 3)), round(draw.uniform(0.01, 0.05), 5))
    degree = math.pi / 180
    machine = fb.Machine(
        fb.FiveBar(*lengths, 0, 0, 0),
        ratio=(degree, degree),
        frame=fb.Placement(draw.uniform(-0.2, 0.2, 2).round(5).tolist()),
        constraints=limits,
        tool=tool if seed % 2 else None,
    )
    text = fb.export(machine, "reprapfirmware", working=working, homing_deg=(90, 20))
    read = fb.load_machine(config(tmp_path, text))
    for own, other in zip(read.robot.parameters.values(), machine.robot.parameters.values()):
        assert own == pytest.approx(other, abs=1e-15)
    assert (read.tool is None) == (machine.tool is None)
    if read.tool:
        assert (read.tool.leg, read.tool.across) == (tool.leg, 0.0)
        assert read.tool.along == pytest.approx(tool.along)
    assert read.frame.shift == pytest.approx(machine.frame.shift) and read.frame.turn == 0
    assert (read.offset, read.ratio) == (machine.offset, pytest.approx(machine.ratio))
    assert read.constraints.det_A == pytest.approx(limits.det_A, abs=2e-8)
    assert read.constraints.sin == pytest.approx(limits.sin, abs=2e-8)
    for own, other in zip(read.constraints.joints or [None] * 2, limits.joints or [None] * 2):
        assert own == (other and pytest.approx(other, abs=2e-8))
    assert read.measured == ((*working, -1),)


@pytest.mark.parametrize("leg", [None, 1, 2])
@pytest.mark.parametrize("mode", [1, 2, 4])
def test_a_machine_with_turned_bases_turns_as_the_firmware_does(tmp_path, leg, mode):
    """By the firmware's own inverse kinematics, from points of its bed to the angles of its drives."""
    cantilevers = [30.0 * (leg == k) for k in (1, 2)]
    line = (
        f"M669 K9 X-40:60 Y-90:-120 L{mode} P120:125 D170:180:{cantilevers[0]:g}:{cantilevers[1]:g}"
        " A0:180:0:360:0:360 C-90:269:-90:269"
    )
    machine = fb.load_machine(config(tmp_path, line))
    assert machine.robot.d == pytest.approx(math.hypot(0.1, 0.03))
    assert machine.constraints.joints is None and machine.constraints.det_A == 0
    ((*working, assembly),) = machine.measured
    assert assembly == -1
    draw, known = np.random.default_rng(7), 0
    for _ in range(60):
        place = draw.uniform((-90, 40), (110, 180))
        xi = machine.frame.inverse(place / 1000)
        try:
            pose = (machine.tool or fb.Tool(1)).pose(machine.robot, xi, tuple(working))
        except (ValueError, ArithmeticError):
            continue
        known += 1
        readings = np.radians(machine.readings(pose.q))
        turns = np.radians(firmware_inverse(line, *place))
        np.testing.assert_allclose(np.exp(1j * readings), np.exp(1j * turns), atol=1e-9)
    assert known > 20


def test_what_the_line_leaves_out_is_as_in_the_firmware(tmp_path):
    machine = fb.load_machine(config(tmp_path, "m669 k9 x-50:50 y0:0 p120:120 d170:170"))
    assert machine.measured == ((-1, -1, -1),)
    assert machine.constraints.det_A == pytest.approx(math.sin(math.radians(15)))
    ranges = np.degrees(machine.constraints.joints).ravel()
    assert ranges == pytest.approx([10, 170, 10, 170])


def test_the_elbow_nearer_to_its_bound_counts(tmp_path):
    line = "M669 K9 X-50:50 Y0:0 L2 P120:120 D170:170 A10:160:25:175:200:350"
    limits = fb.load_machine(config(tmp_path, line)).constraints
    assert math.degrees(math.asin(limits.det_A)) == pytest.approx(20)
    assert math.degrees(math.asin(limits.sin)) == pytest.approx(25)


BARE = "M669 K9 X-50:50 Y0:0 P120:120 D170:170"


@pytest.mark.parametrize(
    "text, words",
    [
        ("G28\nM92 X50", "it has no line M669 K9"),
        (f";{BARE}", "it has no line M669 K9"),
        (BARE.replace("K9", "K4"), "K must be 9"),
        (BARE.replace("Y0:0 ", ""), "Y is missing"),
        (BARE + " L3", "L3 is no working mode of the firmware: 1, 2 or 4"),
        (BARE.replace("170:170", "170:170:5"), "D takes 2 or 4 numbers, not 3"),
        (BARE.replace("170:170", "170:170:5:6"), "two cantilevers"),
        (BARE.replace("P120:120", "P12.0.1:120"), "P12.0.1:120 is no number"),
        (BARE.replace("P120:120", "P{var.l}:120"), "expressions in braces"),
        (BARE + " A95:180:0:360:0:360", "95 to 180 degrees at the hotend"),
        (f"n5 {BARE} A15:165:0:360:15:165 *33", "right elbow.* from 180 to 360 degrees: no pose"),
    ],
)
def test_what_is_wrong_in_a_config_g_is_named(tmp_path, text, words):
    with pytest.raises(ValueError, match=f"config.g: .*{words}"):
        fb.load_machine(config(tmp_path, text))


def test_commands_take_a_config_g(tmp_path, capsys):
    path = config(tmp_path, PUBLISHED)
    assert (
        main(["export", "--robot", str(path), "--format", "reprapfirmware", "--working", "1", "-1"])
        == 0
    )
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("M669"))
    ours, theirs = words(line), words(PUBLISHED)
    assert all(ours[letter] == pytest.approx(theirs[letter]) for letter in "KXYLPC")
