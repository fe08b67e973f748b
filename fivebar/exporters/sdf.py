"""SDF: the opened tree with Drake's constraint on its tips, or with the loop's own joint, as Gazebo
reads it.
"""

from __future__ import annotations

import math
from textwrap import indent
from typing import TYPE_CHECKING

from .bodies import angles_of, angles_told, legs_of

if TYPE_CHECKING:
    from ..models.geometry import Pose
    from ..models.robots import Biglide, FiveBar

ABOUT = """\
{title}, by fivebar: m, kg, s, rad. Load it as a world (Gazebo) or with Drake's Parser.
{closed}
Gravity is the world's; Drake does not read it: set it to ({gx!r}, {gy!r}, 0) m/s^2.{friction}
Its bodies move as the robot's base parameters do; their single masses are a choice that does not
show in the motion.
"""
CLOSED = {
    "constraint": (
        """\
Its loop is open in SDF's own terms, and closed by drake:ball_constraint: for a MultibodyPlant with
a time step and the contact approximation kLagged. Of order 1: in steps of 1 ms 2 s of the lab's
robot end with errors of 1e-4 rad and a gap of 1e-8 m. Joints' coordinates are the robot's; it
closes for instance at
{angles}."""
    ),
    "joint": (
        """\
Its loop is closed by the joint tip, as Gazebo Classic reads it, and Gazebo where its physics takes
closed chains; Drake takes none. It stands in a closed pose, from which all joints count: the
robot's coordinates are theirs and
{angles}."""
    ),
}
COULOMB = """
Coulomb friction of the drives is in it for Gazebo; Drake does not apply it."""
TEXT = """\
<?xml version="1.0"?>
<!--
{about}-->
<sdf version="1.9" xmlns:drake="http://drake.mit.edu">
  <world name="{model}">
    <gravity>{gx!r} {gy!r} 0</gravity>
    <physics name="step" type="ignored">
      <max_step_size>{step!r}</max_step_size>
      <real_time_factor>1</real_time_factor>
    </physics>
    <model name="{model}">
{legs}{closure}    </model>
  </world>
</sdf>
"""
LEG = """\
      <link name="{leg.names[0]}">
        <pose>{leg.base!r} {foot!r} 0 0 0 {turn!r}</pose>
        <inertial>{first}</inertial>
        <visual name="{leg.names[0]}">
          <pose>{middle!r} 0 0 0 0 0</pose><geometry><box><size>{leg.box}</size></box></geometry>
        </visual>
      </link>
      <link name="{leg.names[1]}">
        <pose>{x!r} {y!r} 0 0 0 {phi!r}</pose>
        <inertial>{second}</inertial>
        <visual name="{leg.names[1]}">
          <pose>{half!r} 0 0 0 0 0</pose>
          <geometry><box><size>{leg.distal!r} {leg.thin!r} {leg.thin!r}</size></box></geometry>
        </visual>
      </link>
      <joint name="{leg.names[2]}" type="{kind}">
        <parent>world</parent><child>{leg.names[0]}</child>
        <axis>
          <xyz expressed_in="__model__">{axis}</xyz>
          <limit><lower>-1e16</lower><upper>1e16</upper><effort>-1</effort></limit>{friction}
        </axis>
      </joint>
      <joint name="{leg.names[3]}" type="revolute">
        <parent>{leg.names[0]}</parent><child>{leg.names[1]}</child>
        <axis>
          <xyz>0 0 1</xyz>
          <limit><lower>-1e16</lower><upper>1e16</upper><effort>0</effort></limit>{slack}
        </axis>
      </joint>
"""
INERTIAL = (
    "<pose>{0.x!r} {0.y!r} 0 0 0 0</pose><mass>{0.mass!r}</mass>"
    "<inertia><ixx>{0.inertia!r}</ixx><iyy>{0.inertia!r}</iyy><izz>{0.inertia!r}</izz>"
    "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>"
)
CONSTRAINT = """\
      <drake:ball_constraint>
        <drake:ball_constraint_body_A>{bars[0]}</drake:ball_constraint_body_A>
        <drake:ball_constraint_p_AP>{lengths[0]!r} 0 0</drake:ball_constraint_p_AP>
        <drake:ball_constraint_body_B>{bars[1]}</drake:ball_constraint_body_B>
        <drake:ball_constraint_p_BQ>{lengths[1]!r} 0 0</drake:ball_constraint_p_BQ>
      </drake:ball_constraint>
"""
JOINT = """\
      <joint name="tip" type="revolute">
        <pose>{lengths[1]!r} 0 0 0 0 0</pose>
        <parent>{bars[0]}</parent><child>{bars[1]}</child>
        <axis>
          <xyz>0 0 1</xyz>
          <limit><lower>-1e16</lower><upper>1e16</upper><effort>0</effort></limit>
        </axis>
      </joint>
"""
CLOSURES = {"constraint": CONSTRAINT, "joint": JOINT}


def sdf(
    robot: FiveBar | Biglide,
    name: str,
    start: Pose,
    closure: str = "constraint",
    step: float = 0.001,
) -> str:
    """Return the robot as an SDF world. closure: "constraint" for Drake, joints counted as the
    robot's; "joint" for Gazebo.

    start: the pose in which a world with the loop's joint begins, from which its joints count, and
    which is told otherwise. step: s, of the world's physics.
    """
    legs, joined = legs_of(robot), closure == "joint"
    gx, gy = robot.gravity
    angles = angles_told(legs, start)
    about = ABOUT.format(
        title=robot.words.title.capitalize(),
        closed=CLOSED[closure].format(angles=angles),
        gx=gx,
        gy=gy,
        friction=COULOMB if any(leg.coulomb for leg in legs) else "",
    )
    lengths, bars = [leg.distal for leg in legs], [leg.names[1] for leg in legs]
    return TEXT.format(
        model=name,
        gx=gx,
        gy=gy,
        step=step,
        about=indent(about, "  "),
        legs="".join(
            _leg(leg, *(own if joined else (0.0, 0.0))) for leg, own in zip(legs, angles_of(start))
        ),
        closure=CLOSURES[closure].format(bars=bars, lengths=lengths),
    )


def _leg(leg, q, passive):
    turns = leg.proximal is not None
    turn, foot = (q, 0.0) if turns else (0.0, q)
    return LEG.format(
        leg=leg,
        foot=foot,
        turn=turn,
        x=leg.base + leg.crank * math.cos(turn),
        y=foot + leg.crank * math.sin(turn),
        phi=turn + passive,
        middle=leg.crank / 2,
        half=leg.distal / 2,
        kind="revolute" if turns else "prismatic",
        axis="0 0 1" if turns else "0 1 0",
        first=INERTIAL.format(leg.drive),
        second=INERTIAL.format(leg.bar),
        friction=_dynamics(leg.viscous[0], leg.coulomb),
        slack=_dynamics(leg.viscous[1], 0.0),
    )


def _dynamics(viscous, coulomb):
    if not (viscous or coulomb):
        return ""
    return f"<dynamics><damping>{viscous!r}</damping><friction>{coulomb!r}</friction></dynamics>"
