"""Exported texts in their simulators: mass matrix and bias of the opened tree, accelerations of the closed loop.

Coordinates are (drive, passive joint) of the left leg, then of the right, as in the files.
"""

import numpy as np

DRIVES = [0, 2]


def spread(tau):
    """Efforts of the four joints."""
    return np.array([tau[0], 0.0, tau[1], 0.0])


class InMujoco:
    """MJCF, or the tree of a URDF."""

    def __init__(self, text):
        import mujoco

        self.lib, self.model = mujoco, mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)

    def set(self, q, v, tau=(0.0, 0.0)):
        self.data.qpos[:], self.data.qvel[:] = q, v
        if self.model.nu:
            self.data.ctrl[:] = tau
        self.lib.mj_forward(self.model, self.data)

    def mass(self, q):
        self.set(q, np.zeros(4))
        columns = []
        for unit in np.eye(4):
            column = np.zeros(4)
            self.lib.mj_mulM(self.model, self.data, column, unit)
            columns.append(column)
        return np.array(columns)

    def bias(self, q, v):
        """With viscous friction, as in all of them; dry friction is a constraint here, and nothing elsewhere."""
        self.set(q, v)
        return self.data.qfrc_bias - self.data.qfrc_passive

    def closed(self, q, v, tau):
        """Accelerations, and by how much MuJoCo says itself that its constraint gives way: R of f = ... - R f."""
        self.set(q, v, tau)
        tie = self.data.efc_type == self.lib.mjtConstraint.mjCNSTR_EQUALITY
        jacobian = np.reshape(self.data.efc_J, (-1, 4))[tie]
        soft = (self.data.efc_R * self.data.efc_force)[tie]
        return self.data.qacc.copy(), jacobian, soft, self.data.efc_aref[tie]


class InPinocchio:
    def __init__(self, text, gravity=(0.0, 0.0)):
        import pinocchio as pin

        self.pin, self.model = pin, pin.buildModelFromXML(text)
        self.model.gravity.linear[:] = (*gravity, 0.0)
        frames = [self.model.frames[self.model.getFrameId(name)] for name in ("tip1", "tip2")]
        ends = [each for frame in frames for each in (frame.parentJoint, frame.placement)]
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        self.loop, self.loops = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        self.loop.append(
            pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, self.model, *ends, world)
        )
        self.loops.append(self.loop[0].createData())
        self.data = self.model.createData()
        pin.initConstraintDynamics(self.model, self.data, self.loop, self.loops)
        self.settings = pin.ProximalSettings(1e-14, 1e-8, 20)

    def place(self, q):
        """A joint without limits is (cos, sin) here."""
        return self.pin.integrate(
            self.model, self.pin.neutral(self.model), np.asarray(q, dtype=float)
        )

    def mass(self, q):
        found = self.pin.crba(self.model, self.data, self.place(q))
        return np.triu(found) + np.triu(found, 1).T

    def bias(self, q, v):
        return (
            self.pin.nonLinearEffects(self.model, self.data, self.place(q), v)
            + self.model.damping * v
        )

    def closed(self, q, v, efforts):
        """Under the efforts (4,) of all joints, friction included: it applies none itself."""
        found = self.pin.constraintDynamics(
            self.model,
            self.data,
            self.place(q),
            np.array(v),
            efforts,
            self.loop,
            self.loops,
            self.settings,
        )
        return found.copy()


class InDrake:
    """kind: the end of a file's name. step: s, of the discrete plant that knows constraints."""

    def __init__(self, text, kind, gravity=(0.0, 0.0), step=1e-4):
        import logging

        from pydrake.multibody.parsing import Parser
        from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant

        logging.getLogger("drake").setLevel(logging.ERROR)  # of what is for others in the files
        self.step, self.plant = step, MultibodyPlant(step)
        Parser(self.plant).AddModelsFromString(text, kind)
        self.plant.mutable_gravity_field().set_gravity_vector([*gravity, 0.0])
        self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
        self.plant.Finalize()
        self.context = self.plant.CreateDefaultContext()

    def mass(self, q):
        self.plant.SetPositions(self.context, q)
        return self.plant.CalcMassMatrix(self.context)

    def bias(self, q, v):
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        gravity = self.plant.CalcGravityGeneralizedForces(self.context)
        joints = [self.plant.get_joint(index) for index in self.plant.GetJointIndices()]
        damping = [joint.default_damping_vector()[0] for joint in joints if joint.num_velocities()]
        return self.plant.CalcBiasTerm(self.context) - gravity + damping * np.array(v)

    def moved(self, q, v, torque, count):
        """(q, v) after so many steps from (q, v) under torque (t)."""
        from pydrake.systems.analysis import Simulator

        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        port = self.plant.get_actuation_input_port()
        simulator = Simulator(self.plant, self.context)
        self.context.SetTime(0.0)
        for k in range(count):
            port.FixValue(self.context, torque((k + 0.5) * self.step))
            simulator.AdvanceTo((k + 1) * self.step)
        return self.plant.GetPositions(self.context), self.plant.GetVelocities(self.context)

    def closed(self, q, v, tau):
        """The mean acceleration over one step."""
        return (self.moved(q, v, lambda t: tau, 1)[1] - v) / self.step
