"""The five-bar in other simulators: each from a start, under torques, in so many steps; installed
by `fivebar[peers]`.

A motion has begin() (Rates), torque (t -> two N m) and runs for DURATION. MuJoCo has the exported
robot; elsewhere both distal bars carry half of the end-effector's mass at their ends, which the
loop holds together: the same dynamics.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from fivebar.exporters.export import export
from fivebar.simulation.steps import tableau

from .motions import DURATION, ROBOT
from .native import mujoco_loop, pinocchio_loop

if TYPE_CHECKING:
    from collections.abc import Callable

    from fivebar.models.kinematics import Rates
    from fivebar.models.robots import FiveBar

    from .motions import DrivenMotion

# For the trap: both tips tied to a body of 1 mg in place of each other.
LIGHT_BODY = """
<body name="light" pos="{x!r} {y!r} 0"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <inertial pos="0 0 0" mass="1e-6" diaginertia="1e-13 1e-13 1e-13"/>
</body>"""
LIGHT_TIE = (
    '<connect body1="{}" body2="light" anchor="{!r} 0 0" solref="{!r} 1" solimp="0.9999 0.9999'
    ' 0.001"/>'
)
ITS_OWN = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's solref and solimp


def legs_of(robot: FiveBar) -> tuple[tuple, tuple]:
    """Base, proximal and distal length, inertia of each leg."""
    half = robot.d / 2
    return (-half, robot.l11, robot.l12, robot.zz1), (half, robot.l21, robot.l22, robot.zz2)


def joints(rates: Rates) -> tuple[np.ndarray, np.ndarray]:
    """(q11, q12, q21, q22) and their rates: the order of the trees below."""
    q, passive, w, turning = rates.pose.q, rates.pose.q_passive, rates.q_dot, rates.q_passive_dot
    return np.array([q[0], passive[0], q[1], passive[1]]), np.array(
        [w[0], turning[0], w[1], turning[1]]
    )


def read(q: np.ndarray) -> tuple[np.ndarray, float]:
    """Active joints (2,) and how far the two tips are apart, m."""
    tips = [
        base + l1 * np.exp(1j * q[2 * k]) + l2 * np.exp(1j * (q[2 * k] + q[2 * k + 1]))
        for k, (base, l1, l2, _) in enumerate(legs_of(ROBOT))
    ]
    return q[[0, 2]], abs(tips[0] - tips[1])


def mujoco_run(
    motion: DrivenMotion,
    count: int,
    tuned: bool = False,
    held: bool = False,
    light: bool = False,
    in_c: bool = False,
) -> tuple[Callable, None]:
    """call () -> final joints, of the exported robot. tuned: as exported, RK4, torques at every
    stage; else MuJoCo's own settings and Euler's method with the torque set before each step.

    held: RK4 with the torque set before each step; light: both tips tied to a body of 1 mg; in_c:
        loop and torque in C.
    """
    import mujoco

    start, step, by_step = motion.begin().pose, DURATION / count, held or not tuned
    text = export(ROBOT, "mjcf", start=start, step=step)
    if light:
        ends = ("distal1", ROBOT.l12), ("distal2", ROBOT.l22)
        ties = "".join(LIGHT_TIE.format(*end, 4 * step) for end in ends)
        x, y = start.xi.tolist()
        text = re.sub("<connect.*?/>", ties, text, flags=re.DOTALL)
        text = text.replace("</worldbody>", LIGHT_BODY.format(x=x, y=y) + "</worldbody>")
    model = mujoco.MjModel.from_xml_string(text)
    if not tuned:
        model.opt.integrator, model.opt.iterations, model.opt.tolerance = (
            mujoco.mjtIntegrator.mjINT_EULER,
            100,
            1e-8,
        )
        model.eq_solref[:], model.eq_solimp[:] = ITS_OWN
    data = mujoco.MjData(model)
    q, q_dot = joints(motion.begin())

    def reset():
        mujoco.mj_resetData(model, data)
        data.qpos[:4] = q
        data.qvel[:] = (*q_dot, *motion.begin().xi_dot)[: model.nv]

    if in_c:
        reset()
        return mujoco_loop(model, data, motion, (data.qpos, data.qvel), count, by_step), None

    def set_torque(_, data):
        data.ctrl[:] = motion.torque(data.time)

    def run():
        reset()
        mujoco.set_mjcb_control(None if by_step else set_torque)
        try:
            for _ in range(count):
                if by_step:
                    set_torque(model, data)
                mujoco.mj_step(model, data)
        finally:
            mujoco.set_mjcb_control(None)
        return data.qpos[:4].copy()

    return run, None


def pinocchio_native(motion: DrivenMotion, count: int, method: str) -> tuple[Callable, None]:
    """The same by Pinocchio's constraintDynamics: "rk4" or "dop8", the loop in C++."""
    return pinocchio_loop(motion, count, method, joints(motion.begin()), legs_of(ROBOT)), None


def pinocchio_run(motion: DrivenMotion, count: int, method: str) -> tuple[Callable, None]:
    """The same in Python: "semi-implicit Euler" or "dop8"."""
    import pinocchio as pin

    model, tips = pin.Model(), []
    for k, (base, l1, l2, zz) in enumerate(legs_of(ROBOT)):
        first = model.addJoint(0, pin.JointModelRZ(), _at(pin, base), f"q{k}")
        model.appendBodyToJoint(
            first, pin.Inertia(0.0, np.zeros(3), zz * np.eye(3)), pin.SE3.Identity()
        )
        second = model.addJoint(first, pin.JointModelRZ(), _at(pin, l1), f"passive{k}")
        half = pin.Inertia(ROBOT.m / 2, np.array([l2, 0, 0]), np.zeros((3, 3)))
        model.appendBodyToJoint(second, half, pin.SE3.Identity())
        tips += [second, _at(pin, l2)]
    model.gravity.linear[:] = 0
    contact, frame = pin.ContactType.CONTACT_3D, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    constraints, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    constraints.append(pin.RigidConstraintModel(contact, model, *tips, frame))
    datas.append(constraints[0].createData())
    data = model.createData()
    pin.initConstraintDynamics(model, data, constraints, datas)
    settings = pin.ProximalSettings(1e-14, 1e-8, 20)
    torque, h = np.zeros(4), DURATION / count

    def acceleration(t, q, v):
        torque[0], torque[2] = motion.torque(t)
        return pin.constraintDynamics(
            model, data, q, v, torque, constraints, datas, settings
        ).copy()

    start = joints(motion.begin())

    def run():
        if method != "semi-implicit Euler":
            return runge_kutta(method, acceleration, count, h, *start)
        q, v = start
        for k in range(count):
            v = v + h * acceleration(k * h, q, v)
            q = q + h * v
        return q

    return run, None


def _at(pin, x):
    return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))


def runge_kutta(
    method: str, acceleration: Callable, count: int, h: float, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Places after so many steps h of acceleration (t, q, v) from t = 0, by a method of
    `steps.tableau`, in Python.
    """
    a, b, c = tableau(method)
    for k in range(count):
        rates, forces = [], []
        for row, fraction in zip(a, c):
            rate = v + h * sum((w * f for w, f in zip(row, forces) if w), np.zeros(4))
            place = q + h * sum((w * r for w, r in zip(row, rates) if w), np.zeros(4))
            rates.append(rate)
            forces.append(acceleration((k + fraction) * h, place, rate))
        q = q + h * sum(w * r for w, r in zip(b, rates))
        v = v + h * sum(w * f for w, f in zip(b, forces))
    return q
