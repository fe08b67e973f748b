"""URDF with a block for ROS 2's ros2_control: joints, limits and the robot's own parameters.

The tree is that of `urdf`, without ROS 1 transmissions. Its hardware is a mock by default, which
loads without any driver; a five-bar's own system interface finds the parameters it needs.
"""

from __future__ import annotations

import re
from typing import Any
from xml.sax.saxutils import quoteattr

from ..base.units import METRES
from ..models.geometry import Pose
from ..models.parameter_units import units_of
from ..paths.machine import Machine
from .urdf import urdf

PLUGIN = "mock_components/GenericSystem"
BLOCK = """\
  <ros2_control name={name} type="system">
    <hardware>
      <plugin>{plugin}</plugin>
{parameters}    </hardware>
{joints}  </ros2_control>
</robot>
"""
TRANSMISSION = re.compile(r"  <transmission .*?</transmission>\n", re.DOTALL)


def ros2_control(machine: Machine, name: str, start: Pose, plugin: str | None = None) -> str:
    """Return the URDF of a machine, with its ros2_control block.

    plugin: its hardware, by default a mock. Parameters: the lengths, m, or all of a biglide's;
    working1, working2, assembly of `start`; offset, ratio of each motor; tool_leg, tool_along,
    tool_across where there is a tool.
    """
    text = TRANSMISSION.sub("", urdf(machine.robot, name, start))
    text = text.removesuffix("</robot>\n")
    limits: Any = machine.constraints
    words = machine.robot.words
    own = machine.robot.parameters
    parameters = {key: value for key, value in own.items() if units_of(key) is METRES}
    parameters |= {f"working{k}": int(mode) for k, mode in enumerate(start.working, 1)}
    parameters["assembly"] = int(start.assembly)
    for key in ("offset", "ratio"):
        parameters |= {f"{key}{k}": v for k, v in enumerate(getattr(machine, key), 1)}
    if machine.tool is not None:
        tool = machine.tool
        parameters |= {"tool_leg": tool.leg, "tool_along": tool.along, "tool_across": tool.across}
    joints = []
    for k, joint in enumerate(words.joints):
        position = (limits.joints or (None, None))[k]
        speed = limits.joint_speed and limits.joint_speed[k]
        effort = limits.torque and limits.torque[k]
        joints.append(
            f"    <joint name={quoteattr(joint)}>\n"
            + _command("position", position)
            + _command("velocity", speed and (-speed, speed))
            + _command("effort", effort and (-effort, effort))
            + _states("position", "velocity", "effort")
            + "    </joint>\n"
        )
    for joint in words.passive:
        passive = _states("position", "velocity")
        joints.append(f"    <joint name={quoteattr(joint)}>\n{passive}    </joint>\n")
    lines = []
    for key, value in parameters.items():
        lines.append(f"      <param name={quoteattr(key)}>{value!r}</param>\n")
    return text + BLOCK.format(
        name=quoteattr(name),
        plugin=plugin or PLUGIN,
        parameters="".join(lines),
        joints="".join(joints),
    )


def _command(name, limits):
    if not limits:
        return f'      <command_interface name="{name}"/>\n'
    low, high = limits
    return (
        f'      <command_interface name="{name}">\n'
        f'        <param name="min">{low!r}</param>\n'
        f'        <param name="max">{high!r}</param>\n'
        "      </command_interface>\n"
    )


def _states(*names):
    return "".join(f'      <state_interface name="{name}"/>\n' for name in names)
