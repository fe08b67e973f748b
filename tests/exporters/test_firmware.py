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
    text = fb.export(RRF, "reprapfirmware", working=(1, -1), homing=(251.9, 144.3))
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
    text = fb.export(machine, "reprapfirmware", per_turn=3600)
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
