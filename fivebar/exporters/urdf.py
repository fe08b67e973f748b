"""URDF: the opened tree, which is all that URDF can say, and how Pinocchio, Drake and MuJoCo close
it.
"""

from __future__ import annotations

from textwrap import indent
from typing import TYPE_CHECKING

from .bodies import angles_told, legs_of

if TYPE_CHECKING:
    from ..models.geometry import Pose
    from ..models.robots import Biglide, FiveBar

ABOUT = """\
{title}, by fivebar: m, kg, s, rad.
URDF has no loops: this is the robot opened at its end-effector, and what uses it closes it again,
link tip1 on tip2.
  Pinocchio  a RigidConstraintModel(CONTACT_3D, ...) between the frames tip1 and tip2, and
             constraintDynamics: exact. A joint that turns without limits is (cos, sin) there:
             integrate(model, neutral(model), angles) makes it.
  Drake      reads drake:ball_constraint, for a MultibodyPlant with a time step and the contact
             approximation kLagged. Of order 1: in steps of 1 ms 2 s of the lab's robot end with
             errors of 1e-4 rad and a gap of 1e-8 m.
  PyBullet   URDF_USE_INERTIA_FROM_FILE, and a JOINT_POINT2POINT between {bars[0]} and {bars[1]},
             whose points count from the bars' centres of mass. Of order 1.
  MuJoCo     loads the tree alone: for the loop use the MJCF file.
It closes for instance at {angles}.
Gravity is the simulator's: set it to ({gx!r}, {gy!r}, 0) m/s^2.{friction}
Its bodies move as the robot's base parameters do; their single masses are a choice that does not
show in the motion.
"""
COULOMB = """
Coulomb friction is only written down in it: neither Pinocchio nor Drake applies it."""
TEXT = """\
<?xml version="1.0"?>
<!--
{about}-->
<robot name="{model}" xmlns:drake="http://drake.mit.edu">
  <link name="world"/>
{legs}  <drake:ball_constraint>
    <drake:ball_constraint_body_A name="{bars[0]}"/>
    <drake:ball_constraint_body_B name="{bars[1]}"/>
    <drake:ball_constraint_p_AP value="{lengths[0]!r} 0 0"/>
    <drake:ball_constraint_p_BQ value="{lengths[1]!r} 0 0"/>
  </drake:ball_constraint>
</robot>
"""
LEG = """\
  <link name="{leg.names[0]}">
    <inertial>{first}</inertial>
    <visual><origin xyz="{middle!r} 0 0"/><geometry><box size="{leg.box}"/></geometry></visual>
  </link>
  <link name="{leg.names[1]}">
    <inertial>{second}</inertial>
    <visual>
      <origin xyz="{half!r} 0 0"/>\
<geometry><box size="{leg.distal!r} {leg.thin!r} {leg.thin!r}"/></geometry>
    </visual>
  </link>
  <link name="tip{leg.number}">{nothing}</link>
  <joint name="{leg.names[2]}" {kind}
    <parent link="world"/><child link="{leg.names[0]}"/><origin xyz="{leg.base!r} 0 0"/>{friction}
  </joint>
  <joint name="{leg.names[3]}" type="continuous">
    <parent link="{leg.names[0]}"/><child link="{leg.names[1]}"/><origin xyz="{leg.crank!r} 0 0"/>
    <axis xyz="0 0 1"/>{slack}
  </joint>
  <joint name="tip{leg.number}_fixed" type="fixed">
    <parent link="{leg.names[1]}"/><child link="tip{leg.number}"/><origin xyz="{leg.distal!r} 0 0"/>
  </joint>
  <transmission name="{leg.names[2]}">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="{leg.names[2]}"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>
    <actuator name="{leg.names[2]}"><mechanicalReduction>1</mechanicalReduction></actuator>
  </transmission>
"""
# Written down, as some readers give a link without masses 1 kg.
NOTHING = (
    '<inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0"'
    ' iyz="0"/></inertial>'
)
INERTIAL = (
    '<origin xyz="{0.x!r} {0.y!r} 0"/><mass value="{0.mass!r}"/>'
    '<inertia ixx="{0.inertia!r}" iyy="{0.inertia!r}" izz="{0.inertia!r}"'
    ' ixy="0" ixz="0" iyz="0"/>'
)
CRANK = 'type="continuous"><axis xyz="0 0 1"/>'
# A prismatic joint must have limits, and these guides have no ends.
SLIDER = (
    'type="prismatic"><axis xyz="0 1 0"/><limit lower="-1e9" upper="1e9" effort="1e9"'
    ' velocity="1e9"/>'
)


def urdf(robot: FiveBar | Biglide, name: str, start: Pose) -> str:
    """Return the opened robot as URDF, its joints' coordinates those of the robot; start: the pose
    told in its comment.
    """
    legs = legs_of(robot)
    (gx, gy), bars = robot.gravity, [leg.names[1] for leg in legs]
    about = ABOUT.format(
        title=robot.words.title.capitalize(),
        angles=angles_told(legs, start),
        gx=gx,
        gy=gy,
        bars=bars,
        friction=COULOMB if any(leg.coulomb for leg in legs) else "",
    )
    return TEXT.format(
        model=name,
        about=indent(about, "  "),
        legs="".join(map(_leg, legs)),
        bars=bars,
        lengths=[leg.distal for leg in legs],
    )


def _leg(leg):
    return LEG.format(
        leg=leg,
        middle=leg.crank / 2,
        half=leg.distal / 2,
        nothing=NOTHING,
        kind=CRANK if leg.proximal else SLIDER,
        first=INERTIAL.format(leg.drive),
        second=INERTIAL.format(leg.bar),
        friction=_dynamics(leg.viscous[0], leg.coulomb),
        slack=_dynamics(leg.viscous[1], 0.0),
    )


def _dynamics(viscous, coulomb):
    return (
        f'\n    <dynamics damping="{viscous!r}" friction="{coulomb!r}"/>'
        if viscous or coulomb
        else ""
    )
