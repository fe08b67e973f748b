"""MuJoCo's MJCF: the opened tree, its tips tied by a constraint, motors at the drives."""

from __future__ import annotations

from textwrap import indent
from typing import TYPE_CHECKING

from .bodies import angles_of, legs_of

if TYPE_CHECKING:
    from ..models.geometry import Pose
    from ..models.robots import Biglide, FiveBar

ABOUT = """\
{title}, by fivebar: m, kg, s, rad.
Joints {names}, their coordinates those of the robot; motors at
{motors}. Their bodies move as the robot's base parameters do; single masses are a choice that
does not show.
The loop is closed by an equality, which in MuJoCo is a stiff spring: solref = (time constant,
damping ratio), here four time steps; solimp = 0.9999, the most there is, leaves to accelerations
1e-4 of what would open the loop.
With this integrator and motor torques set by a callback at its every stage, 2 s of the lab's robot
end with a gap of 1e-9 m and errors of 4e-9 rad in steps of 1 ms; with torques held over the step
2e-6 rad; by Euler's method 1e-4 rad.
For less, divide time step and solref's first number by two: a quarter of the errors.
"""
COULOMB = """\
Dry friction is as soft: a drive that would stand within that time constant is braked less.
"""
TEXT = """\
<mujoco model="{model}">
  <!--
{about}  -->
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{step!r}" gravity="{gx!r} {gy!r} 0" integrator="RK4" iterations="50"
    tolerance="0">
    <flag contact="disable"/>
  </option>
  <worldbody>
{legs}  </worldbody>
  <equality>
    <connect body1="{bars[0]}" body2="{bars[1]}" anchor="{reach!r} 0 0"
      solref="{constant!r} 1" solimp="0.9999 0.9999 0.001"/>
  </equality>
  <actuator>
{motors}  </actuator>
</mujoco>
"""
LEG = """\
    <body name="{leg.names[0]}" pos="{leg.base!r} {foot!r} 0" euler="0 0 {turn!r}">
      <joint name="{leg.names[2]}" {kind} ref="{q!r}"{friction}/>
      <inertial {first}/>
      <geom type="{shape}" size="{size}" rgba="{colour}" mass="0"/>
      <body name="{leg.names[1]}" pos="{leg.crank!r} 0 0" euler="0 0 {passive!r}">
        <joint name="{leg.names[3]}" type="hinge" axis="0 0 1" ref="{passive!r}"{slack}/>
        <inertial {second}/>
        <geom type="capsule" size="{thin!r}" fromto="0 0 0 {leg.distal!r} 0 0" rgba="{colour}"
          mass="0"/>
        <site name="tip{leg.number}" pos="{leg.distal!r} 0 0" size="{thin!r}"/>
      </body>
    </body>
"""
INERTIAL = (
    'pos="{0.x!r} {0.y!r} 0" mass="{0.mass!r}"'
    ' diaginertia="{0.inertia!r} {0.inertia!r} {0.inertia!r}"'
)
MOTOR = '    <motor name="{joint}" joint="{joint}" gear="1"/>\n'
LEAST = 1e-15
COLOURS = "0 0.447 0.698 1", "0.835 0.369 0 1"  # left, right


def mjcf(robot: FiveBar | Biglide, name: str, start: Pose, step: float = 0.001) -> str:
    """Return the robot as MJCF, its joints' coordinates those of the robot; loaded it stands in the
    pose start, closed.

    step: s, the time step; the constraint's time constant is four of them.
    """
    legs = legs_of(robot)
    gx, gy = robot.gravity
    for leg in legs:
        for part, body in zip(leg.names, (leg.drive, leg.bar)):
            if min(body.mass, body.inertia) < LEAST:
                raise ValueError(
                    f"MuJoCo takes no body below {LEAST:g} kg or kg m^2, and {part} would be {body}"
                )
    joints = ", ".join(name for leg in legs for name in leg.names[2:])
    motors = " and ".join(leg.names[2] for leg in legs)
    friction = COULOMB if any(leg.coulomb for leg in legs) else ""
    about = (
        ABOUT.format(title=robot.words.title.capitalize(), names=joints, motors=motors) + friction
    )
    return TEXT.format(
        model=name,
        about=indent(about, "    "),
        step=step,
        constant=4 * step,
        gx=gx,
        gy=gy,
        legs="".join(_leg(leg, *angles, 4 * step) for leg, angles in zip(legs, angles_of(start))),
        bars=[leg.names[1] for leg in legs],
        reach=legs[0].distal,
        motors="".join(MOTOR.format(joint=leg.names[2]) for leg in legs),
    )


def _leg(leg, q, passive, constant):
    thin = leg.distal / 40
    if leg.proximal is None:
        turn, foot = 0.0, q
        kind = 'type="slide" axis="0 1 0"'
        shape = "box"
        size = f"{2 * thin!r} {3 * thin!r} {thin!r}"
    else:
        turn, foot = q, 0.0
        kind = 'type="hinge" axis="0 0 1"'
        shape = f'capsule" fromto="0 0 0 {leg.proximal!r} 0 0'
        size = repr(1.5 * thin)
    return LEG.format(
        leg=leg,
        q=q,
        passive=passive,
        foot=foot,
        turn=turn,
        kind=kind,
        thin=thin,
        shape=shape,
        size=size,
        colour=COLOURS[leg.number - 1],
        first=INERTIAL.format(leg.drive),
        second=INERTIAL.format(leg.bar),
        friction=_dynamics(leg.viscous[0], leg.coulomb, constant),
        slack=_dynamics(leg.viscous[1], 0.0, constant),
    )


def _dynamics(viscous, coulomb, constant):
    soft = (
        f'frictionloss="{coulomb!r}" solreffriction="{constant!r} 1" solimpfriction="0.9999 0.9999'
        ' 0.001"'
    )
    return f' damping="{viscous!r}"' * bool(viscous) + f"\n        {soft}" * bool(coulomb)
