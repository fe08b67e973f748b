"""The five-bar in Exudyn: rigid bodies and revolute joints, and stiff springs as distal bars; in
`fivebar[peers]`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .motions import DURATION, ROBOT
from .mujoco_pinocchio import joints, legs_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from .motions import DrivenMotion

# Stiffness of a distal bar, N/m -> (explicit integrator, steps, damping ratio), as DRAKE_BUSHINGS.
EXUDYN_SPRINGS = {
    1e3: ("RK44", 63, 0.01),
    3e3: ("RK44", 110, 0.01),
    1e4: ("RK44", 200, 0.01),
    3e4: ("RK44", 346, 0.01),
    1e5: ("RK44", 632, 0.01),
    3e5: ("RK44", 1095, 0.01),
    1e6: ("RK44", 2000, 0.01),
    3e6: ("RK44", 3464, 0.01),
    1e7: ("RK44", 6325, 0.01),
    3e7: ("RK44", 10954, 0.01),
    1e8: ("RK44", 20000, 0.01),
    3e8: ("RK44", 34641, 0.01),
    1e9: ("RK44", 63246, 0.01),
    3e9: ("RK44", 109545, 0.01),
    1e10: ("RK44", 200000, 0.01),
}


def _settings(count):
    import exudyn

    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = count, DURATION
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    return settings


def exudyn_as_it_comes(motion: DrivenMotion, count: int) -> tuple[Callable, None]:
    """Four rigid bodies, five revolute joints, torques by Python functions; its default, the
    generalized alpha.
    """
    import exudyn
    from exudyn import itemInterface as item

    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(item.ObjectGround())
    (q, w), nodes, tips = joints(motion.begin()), [], []

    def body(place, angle, velocity, rate, mass, inertia):
        nodes.append(
            system.AddNode(
                item.NodeRigidBody2D(
                    referenceCoordinates=[*place, angle], initialVelocities=[*velocity, rate]
                )
            )
        )
        return system.AddObject(
            item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=nodes[-1])
        )

    def joint(*places):
        markers = [
            system.AddMarker(item.MarkerBodyPosition(bodyNumber=n, localPosition=[x, 0, 0]))
            for n, x in places
        ]
        system.AddObject(item.ObjectJointRevolute2D(markerNumbers=markers))

    for k, (base, l1, l2, zz) in enumerate(legs_of(ROBOT)):
        angles, rates = np.cumsum(q[2 * k : 2 * k + 2]), np.cumsum(w[2 * k : 2 * k + 2])
        arms = np.array([l1, l2]) * np.exp(1j * angles)
        end, end_rate = base + arms.sum(), (1j * rates * arms).sum()
        proximal = body(
            (base, 0.0), angles[0], (0.0, 0.0), rates[0], 1.0, zz
        )  # at its pivot: the mass is at rest
        distal = body(
            (end.real, end.imag),
            angles[1],
            (end_rate.real, end_rate.imag),
            rates[1],
            ROBOT.m / 2,
            1e-13,
        )
        joint((ground, base), (proximal, 0.0))
        joint((proximal, l1), (distal, -l2))
        tips.append((distal, 0.0))

        def torque(_, t, __, k=k):
            return [0.0, 0.0, float(motion.torque(t)[k])]

        where = system.AddMarker(item.MarkerBodyRigid(bodyNumber=proximal))
        system.AddLoad(
            item.LoadTorqueVector(
                markerNumber=where, loadVector=[0, 0, 1], loadVectorUserFunction=torque
            )
        )
    joint(*tips)
    system.Assemble()
    settings = _settings(count)

    def run():
        container.GetSystem(0).SolveDynamic(settings)
        (_, _, q1), (x1, y1, _), (_, _, q2), (x2, y2, _) = (
            np.add(
                system.GetNodeOutput(n, exudyn.OutputVariableType.Coordinates),
                system.GetNode(n)["referenceCoordinates"],
            )
            for n in nodes
        )
        return np.array([q1, q2]), np.hypot(x2 - x1, y2 - y1)

    return run, None


def exudyn_springs(
    motion: DrivenMotion, stiffness: float, settings: tuple[str, int, float] | None = None
) -> tuple[Callable, None]:
    """Two turning inertias and a mass, springs for distal bars; an explicit integrator and the
    torque in its C++.

    settings: (integrator, steps, damping ratio), else the shipped ones.
    """
    import exudyn
    from exudyn import itemInterface as item
    from exudyn.advancedUtilities import CreateSymbolicUserFunction

    solver, count, ratio = settings or EXUDYN_SPRINGS[stiffness]
    container, start = exudyn.SystemContainer(), motion.begin()
    system = container.AddSystem()
    tip = system.AddNode(
        item.NodePoint2D(
            referenceCoordinates=list(start.pose.xi), initialVelocities=list(start.xi_dot)
        )
    )
    system.AddObject(item.ObjectMassPoint2D(mass=ROBOT.m, nodeNumber=tip))
    end, nodes, waves = system.AddMarker(item.MarkerNodePosition(nodeNumber=tip)), [tip], []
    damping = 2 * ratio * np.sqrt(stiffness * ROBOT.m)

    def wave(mbs, t, load):
        return exudyn.symbolic.cos(6.283185307179586 * t) * load

    legs = zip(
        legs_of(ROBOT), start.pose.q, start.q_dot, motion.torque(0.0)
    )  # torque: times cos 2 pi t
    for (base, l1, l2, zz), q, w, amplitude in legs:
        node = system.AddNode(
            item.Node1D(referenceCoordinates=[0.0], initialCoordinates=[q], initialVelocities=[w])
        )
        arm = system.AddObject(
            item.ObjectRotationalMass1D(inertia=zz, nodeNumber=node, referencePosition=[base, 0, 0])
        )
        elbow = system.AddMarker(item.MarkerBodyPosition(bodyNumber=arm, localPosition=[l1, 0, 0]))
        system.AddObject(
            item.ObjectConnectorSpringDamper(
                markerNumbers=[elbow, end], referenceLength=l2, stiffness=stiffness, damping=damping
            )
        )
        where = system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
        load = system.AddLoad(
            item.LoadCoordinate(markerNumber=where, load=amplitude, loadUserFunction=wave)
        )
        waves.append(CreateSymbolicUserFunction(system, wave, "loadUserFunction", load))
        system.SetLoadParameter(load, "loadUserFunction", waves[-1])
        nodes.append(node)
    system.Assemble()
    system.variables["waves"] = waves  # which it does not own otherwise
    options = _settings(count)
    options.timeIntegration.automaticStepSize = False
    options.timeIntegration.explicit.computeEndOfStepAccelerations = False
    scheme = getattr(exudyn.DynamicSolverType, solver)

    def run():
        container.GetSystem(0).SolveDynamic(options, solverType=scheme)
        xi, q1, q2 = (system.GetNodeOutput(n, exudyn.OutputVariableType.Coordinates) for n in nodes)
        return np.array([q1, q2]), np.add(xi, start.pose.xi)

    return run, None
