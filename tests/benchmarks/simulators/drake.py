"""The five-bar in Drake: its own discrete solver, a stiff bushing, constrained by hand; in
`fivebar[peers]`.

Drake's continuous plants have no constraints (nor does its CENIC integrator), so that the ways to
order above 1 are a bushing between the tips, whose stiffness is the accuracy, and Lagrange
multipliers of the user's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .motions import DURATION, ROBOT
from .mujoco_pinocchio import joints, legs_of, runge_kutta

if TYPE_CHECKING:
    from collections.abc import Callable

    from .motions import DrivenMotion

# Stiffness of the bushing, N/m -> (integrator, steps, damping ratio): the fewest evaluations that
# come within a quarter of the errors that the stiffness leaves on both motions, by `python -m
# tests.benchmarks.peers`.
DRAKE_BUSHINGS = {
    1e3: ("runge_kutta3", 71, 0.2),
    3e3: ("runge_kutta3", 123, 0.2),
    1e4: ("runge_kutta3", 225, 0.4),
    3e4: ("runge_kutta3", 390, 0.4),
    1e5: ("runge_kutta3", 712, 0.4),
    3e5: ("runge_kutta3", 1232, 0.4),
    1e6: ("runge_kutta3", 2250, 0.4),
    3e6: ("runge_kutta3", 3897, 0.4),
    1e7: ("runge_kutta3", 7115, 0.4),
    3e7: ("runge_kutta3", 12324, 0.4),
}
HALF = ROBOT.m / 2  # kg at each tip


def plant_of(step: float, bushing: tuple[float, float] | None = None, ball: bool = False) -> tuple:
    """Finalized MultibodyPlant, continuous if step is 0, and frames of its tips; bushing: (N/m,
    damping ratio).
    """
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    from pydrake.multibody.tree import (
        FixedOffsetFrame,
        LinearBushingRollPitchYaw,
        RevoluteJoint,
        SpatialInertia,
        UnitInertia,
    )

    plant = MultibodyPlant(step)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))

    def at(name, frame, x):
        return plant.AddFrame(FixedOffsetFrame(name, frame, RigidTransform([x, 0, 0])))

    tips = []
    for k, (base, l1, l2, zz) in enumerate(legs_of(ROBOT)):
        proximal = plant.AddRigidBody(
            f"proximal{k}", SpatialInertia(1.0, np.zeros(3), UnitInertia(zz, zz, zz))
        )
        point = UnitInertia(0.0, l2 * l2, l2 * l2)
        distal = plant.AddRigidBody(f"distal{k}", SpatialInertia(HALF, [l2, 0, 0], point))
        for name, frame, body in (
            (f"q{k}", at(f"base{k}", plant.world_frame(), base), proximal),
            (f"passive{k}", at(f"elbow{k}", proximal.body_frame(), l1), distal),
        ):
            joint = plant.AddJoint(RevoluteJoint(name, frame, body.body_frame(), [0, 0, 1], 0.0))
            if body is proximal:
                plant.AddJointActuator(name, joint)
        tips.append(at(f"tip{k}", distal.body_frame(), l2))
    if bushing:
        stiffness, ratio = bushing
        damping = 2 * ratio * np.sqrt(stiffness * HALF / 2)  # of half against half
        push, drag = [stiffness, stiffness, 0], [damping, damping, 0]
        plant.AddForceElement(
            LinearBushingRollPitchYaw(*tips, np.zeros(3), np.zeros(3), push, drag)
        )
    if ball:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
        ends = [
            point
            for tip, (_, _, l2, _) in zip(tips, legs_of(ROBOT))
            for point in (tip.body(), [l2, 0, 0])
        ]
        plant.AddBallConstraint(*ends)
    plant.Finalize()
    return plant, tips


def _simulated(motion, plant, prepare):
    """call () -> final joints of a plant under the motion's torques, which Drake's own source
    evaluates.
    """
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import Sine

    builder = DiagramBuilder()
    builder.AddSystem(plant)
    amplitude, both = np.array(motion.torque(0.0)), np.ones(2)  # times cos 2 pi t
    source = builder.AddSystem(Sine(amplitude, 2 * np.pi * both, np.pi / 2 * both, True))
    builder.Connect(source.get_output_port(0), plant.get_actuation_input_port())
    simulator = Simulator(builder.Build())
    prepare(simulator)
    whole = simulator.get_mutable_context()
    context, start = (
        plant.GetMyMutableContextFromRoot(whole),
        np.concatenate(joints(motion.begin())),
    )

    def run():
        whole.SetTime(0.0)
        plant.SetPositionsAndVelocities(context, start)
        simulator.Initialize()
        simulator.AdvanceTo(DURATION)
        return plant.GetPositions(context).copy()

    return run


def drake_as_it_comes(motion: DrivenMotion, count: int) -> tuple[Callable, None]:
    """A discrete plant with a ball constraint, as its documentation has it for closed loops: order
    1, torque held.
    """
    return (
        _simulated(motion, plant_of(DURATION / count, ball=True)[0], lambda simulator: None),
        None,
    )


def drake_bushing(
    motion: DrivenMotion, stiffness: float, settings: tuple[str, int, float] | None = None
) -> tuple[Callable, None]:
    """A continuous plant with a stiff bushing; settings: (integrator, steps, damping ratio), else
    the shipped ones.
    """
    from pydrake.systems.analysis import ResetIntegratorFromFlags

    scheme, count, ratio = settings or DRAKE_BUSHINGS[stiffness]

    def prepare(simulator):
        ResetIntegratorFromFlags(simulator, scheme, DURATION / count).set_fixed_step_mode(True)

    return _simulated(motion, plant_of(0.0, (stiffness, ratio))[0], prepare), None


def drake_by_hand(motion: DrivenMotion, count: int) -> tuple[Callable, Callable]:
    """A continuous plant's mass matrix, bias and Jacobian of tip against tip, order 8 and
    multipliers in Python.
    """
    from pydrake.multibody.tree import JacobianWrtVariable

    plant, (first, second) = plant_of(0.0)
    context, world, zero = plant.CreateDefaultContext(), plant.world_frame(), np.zeros(3)
    velocities, h = JacobianWrtVariable.kV, DURATION / count
    torque, right = np.zeros(4), np.zeros(6)
    matrix = np.zeros((6, 6))

    def terms(q, v):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        tips = velocities, second, zero, first, world
        return (
            plant.CalcMassMatrix(context),
            plant.CalcBiasTerm(context),
            plant.CalcJacobianTranslationalVelocity(context, *tips),
            plant.CalcBiasTranslationalAcceleration(context, *tips),
        )

    def acceleration(t, q, v):
        mass, bias, jacobian, drift = terms(q, v)
        torque[0], torque[2] = motion.torque(t)
        matrix[:4, :4], matrix[4:, :4], matrix[:4, 4:] = mass, jacobian[:2], jacobian[:2].T
        right[:4], right[4:] = torque - bias, -drift[:2, 0]
        return np.linalg.solve(matrix, right)[:4]

    start = joints(motion.begin())

    def run():
        return runge_kutta("dop8", acceleration, count, h, *start)

    def step_only():
        for _ in range(12 * count):
            terms(*start)

    return run, step_only
