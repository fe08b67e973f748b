"""Each number of an exported file stands at its own joint: friction, interfaces, limits, and the lines of C."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

import fivebar as fb
from fivebar.exporters.bodies import legs_of

RUBBING = fb.FiveBar(fv1=0.1, fv2=0.2, fv12=0.3, fv22=0.4, fs1=0.5, fs2=0.6)
FRICTION = {"q11": (0.1, 0.5), "q12": (0.3, 0.0), "q21": (0.2, 0.6), "q22": (0.4, 0.0)}
SLIDING = fb.Biglide(fv1=0.1, fs2=0.6)
SLIDING_FRICTION = {"q1": (0.1, 0.0), "phi1": (0.0, 0.0), "q2": (0.0, 0.6), "phi2": (0.0, 0.0)}


def friction_of(joint):
    """Damping and dry friction of a joint of URDF, SDF or MJCF."""
    found = joint.find(".//dynamics")
    if found is None:
        return float(joint.get("damping", 0)), float(joint.get("frictionloss", 0))
    values = [found.get(name) or found.findtext(name) for name in ("damping", "friction")]
    return tuple(map(float, values))


@pytest.mark.parametrize("format", ["urdf", "sdf", "mjcf", "ros2_control"])
@pytest.mark.parametrize(
    "robot, expected", [(RUBBING, FRICTION), (SLIDING, SLIDING_FRICTION)], ids=["bars", "feet"]
)
def test_each_joint_has_its_own_friction(robot, expected, format):
    root = ElementTree.fromstring(fb.export(robot, format))
    block = root.find("ros2_control")
    if block is not None:
        root.remove(block)
    found = {}
    for joint in root.iter("joint"):
        if joint.get("name") in expected:
            found.setdefault(joint.get("name"), friction_of(joint))
    assert found == expected


def interfaces(joint, kind):
    return {
        each.get("name"): [float(limit.text) for limit in each]
        for each in joint.findall(f"{kind}_interface")
    }


@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("robot", [fb.FiveBar(l11=0.1), fb.Biglide()], ids=["bars", "feet"])
def test_ros2_control_has_the_interfaces_and_limits_of_each_joint(robot, limited):
    limits = dict(torque=(0.5, 0.7), joint_speed=(3.0, 4.0), joints=[None, (-0.1, 0.2)])
    constraints = fb.Constraints(**limits if limited else {})
    machine = fb.Machine(robot, (0.1, 0.2), (1.0, -1.5), constraints=constraints)
    pose = fb.dgm(robot, (0.1, 0.1))
    text = fb.export(machine, "ros2_control", start=pose, plugin="my/System")
    block = ElementTree.fromstring(text).find("ros2_control")
    assert block.findtext("hardware/plugin") == "my/System"
    values = {each.get("name"): float(each.text) for each in block.findall("hardware/param")}
    lengths = ("l11", "l12", "l21", "l22", "d") if robot.turns else ("l1", "l2", "d")
    assert values == {
        **{name: getattr(robot, name) for name in lengths},
        **{"working1": pose.working[0], "working2": pose.working[1], "assembly": pose.assembly},
        **{"offset1": 0.1, "offset2": 0.2, "ratio1": 1.0, "ratio2": -1.5},
    }
    joints = {each.get("name"): each for each in block.findall("joint")}
    assert list(joints) == [*robot.words.joints, *robot.words.passive]
    for k, name in enumerate(robot.words.joints):
        ranges = [[], [-0.1, 0.2]][k], [-3.0 - k, 3.0 + k], [[-0.5, 0.5], [-0.7, 0.7]][k]
        commands = dict(zip(("position", "velocity", "effort"), ranges))
        expected = commands if limited else dict.fromkeys(commands, [])
        assert interfaces(joints[name], "command") == expected
        assert list(interfaces(joints[name], "state")) == ["position", "velocity", "effort"]
    for name in robot.words.passive:
        assert not interfaces(joints[name], "command")
        assert list(interfaces(joints[name], "state")) == ["position", "velocity"]


def test_ros2_control_tells_the_tool():
    machine = fb.Machine(fb.FiveBar(), tool=fb.Tool(2, 0.01, -0.02))
    text = fb.export(machine, "ros2_control")
    found = re.findall(r'<param name="tool_(\w+)">(\S+)</param>', text)
    assert found == [("leg", "2"), ("along", "0.01"), ("across", "-0.02")]


def reprapfirmware(low, high):
    limits = fb.Constraints(joints=[(math.radians(low), math.radians(high)), None])
    return fb.export(fb.Machine(fb.FiveBar(), constraints=limits), "reprapfirmware")


@pytest.mark.parametrize(
    "low, high",
    [(200, 300), (1, 360), (0, 359.9), (-359.9, -1), (-180, 179), (-10, 349), (-350, -320)],
)
def test_joint_limits_within_a_turn_are_written(low, high):
    found = re.search(r" C(\S+)", reprapfirmware(low, high))[1]
    assert [float(value) for value in found.split(":")] == pytest.approx([low, high, -90, 269])


@pytest.mark.parametrize(
    "low, high", [(-180, 180), (0, 360), (10, 360.5), (350, 361), (-360.5, -10), (-361, -350)]
)
def test_joint_limits_that_the_firmware_cannot_compare_are_refused(low, high):
    with pytest.raises(ValueError) as caught:
        reprapfirmware(low, high)
    assert str(caught.value).startswith(
        f"reprapfirmware: joint limits from {low:g} to {high:g} degrees: it compares angles from 0"
    )


def test_steps_and_directions_are_those_of_each_motor():
    machine = fb.Machine(fb.FiveBar(), ratio=(0.2, -0.1))
    lines = fb.export(machine, "reprapfirmware", steps_per_turn=3600).splitlines()
    assert lines[0] == "; by fivebar, for config.g before M671; assembly mode -1"
    assert lines[2] == "M92 X50 Y100 ; steps per degree"
    assert [line.split(";")[0].strip() for line in lines[3:]] == ["M569 P0 S1", "M569 P1 S0"]


@pytest.mark.parametrize(
    "robot", [fb.FiveBar(), RUBBING, fb.Biglide()], ids=["bars", "dry", "feet"]
)
def test_the_head_of_c_says_what_is_of_this_robot(robot):
    text = fb.export(robot, "c", name="arm")
    head = " ".join(text.partition("*/")[0].replace("\n *", " ").split())
    words = robot.words
    for piece in (
        f"{words.title.capitalize()}, by fivebar: l1",
        f"Units: m, kg, s, {'rad' if robot.turns else 'N, rad'}. All",
        f"drives' coordinates ({', '.join(words.joints)}), {words.unit}, {words.unit}/s,",
        f"q_passive {', '.join(words.passive)}, rad in (-pi, pi]",
        f"tau drives' {words.effort}s, {words.effort_unit} ",
        f"which of the two places of each leg's {words.pivots} ",
        "but 0 of arm_computed_torque, which a motor might get.",
    ):
        assert piece in head, piece
    dry = (
        "Coulomb friction is fs sign(q_dot), 0 of a drive that stands; of arm_computed_torque it is"
    )
    assert (dry in head) == (robot is RUBBING)
    assert text.count("ARM_H") == 3 and text.endswith("#endif /* ARM_H */\n")


def test_long_lines_of_c_go_on_under_their_first_word():
    lines = fb.export(fb.FiveBar(), "c").splitlines()
    seen = set()
    for first, second in zip(lines, lines[1:]):
        for start in ("static inline int ", "    fivebar_real w0"):
            if first.startswith(start) and first.endswith(","):
                column = first.index("(") + 1 if "(" in first else first.index("w0")
                assert re.match(r" *", second).end() == column
                seen.add(start)
    assert len(seen) == 2


@pytest.mark.parametrize("sign", [1, -1])
def test_masses_and_inertias_are_positive_down_to_the_least_mass(sign):
    """Also where the centre of mass of a distal bar lies beside it."""
    robot = fb.FiveBar(m=10.0, zz12=-0.001, my12=sign * 0.01, zz22=-0.0012, my22=-0.005 * sign)
    with pytest.raises(ValueError) as caught:
        legs_of(replace(robot, m=0.0))
    least = float(re.search(r"must be above (\S+) kg,", str(caught.value))[1])
    for share in (1.0001, 1.1, 3.0, 100.0):
        for leg, my in zip(legs_of(replace(robot, m=share * least)), (robot.my12, robot.my22)):
            for body in (leg.drive, leg.bar):
                assert body.mass > 0 and body.inertia > 0
            assert leg.bar.mass * leg.bar.y == pytest.approx(my)


def test_the_right_joint_may_be_limited_where_the_left_is_not():
    limits = fb.Constraints(joints=[None, (0.0, 1.0)])
    text = fb.export(fb.Machine(fb.FiveBar(), constraints=limits), "reprapfirmware")
    found = re.search(r" C(\S+)", text)[1]
    assert [float(value) for value in found.split(":")] == pytest.approx([-90, 269, 0, 57.29578])


@pytest.mark.parametrize(
    "robot", [fb.FiveBar(l11=0.1, l22=0.12), fb.Biglide()], ids=["bars", "feet"]
)
@pytest.mark.parametrize("format", ["mjcf", "urdf", "sdf"])
def test_bars_are_drawn_thin_and_as_long_as_they_are(robot, format):
    text = fb.export(robot, format)
    if format == "mjcf":
        sizes = [
            (geom.get("size"), geom.get("fromto"))
            for geom in ElementTree.fromstring(text).iter("geom")
        ]
        boxes = []
        for size, ends in sizes:
            sides = [2 * float(side) for side in size.split()]
            boxes.append([float(ends.split()[3]), sides[0]] if ends else sides)
    else:
        found = re.findall(r'<box size="([^"]*)"|<size>([^<]*)</size>', text)
        boxes = [[float(side) for side in (one or other).split()] for one, other in found]
    assert len(boxes) == 4
    drives, bars = boxes[::2], boxes[1::2]
    for bar, drive, length, k in zip(bars, drives, robot.distal, (0, 1)):
        thin = length / 20
        assert bar[0] == length and bar[1:] == pytest.approx([thin] * len(bar[1:]))
        if robot.turns:
            assert drive[0] == robot.drives[k].length and drive[1] == pytest.approx(1.5 * thin)
        else:
            assert drive == pytest.approx([2 * thin, 3 * thin, thin])


@pytest.mark.parametrize("robot", [fb.FiveBar(0.1, 0.12, 0.08, 0.15, 0.11), fb.Biglide(0.3, 0.25)])
def test_bars_are_drawn_from_joint_to_joint_in_sdf(robot):
    root = ElementTree.fromstring(fb.export(robot, "sdf"))
    for k, leg in enumerate(legs_of(robot)):
        lengths = {leg.names[0]: leg.crank, leg.names[1]: robot.distal[k]}
        for name, length in lengths.items():
            visual = root.find(f".//visual[@name='{name}']")
            middle = [float(word) for word in visual.findtext("pose").split()]
            assert middle == [length / 2, 0, 0, 0, 0, 0]
            if length:
                assert float(visual.findtext(".//size").split()[0]) == length
