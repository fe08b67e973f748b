"""The lab's functions as thin calls into the package: there the passive joints, too, are arguments."""

from types import SimpleNamespace

from ..models.dynamics import dynamic_model
from ..models.four_joints import four_joint_pose, four_joint_rates
from ..models.geometry import dgm, igm
from ..models.kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2


def models(robot):
    """The ten functions of the AMORO lab for `robot`: `models(robot).dgm(q11, q21, assembly_mode)` and so on.

    Floats in, tuples of floats out; dynamic_model gives arrays M (2, 2) and c (2,). D and DD mark first and second
    derivatives. Errors are those of the package's functions of the same names.
    """

    def floats(*values):
        return tuple(float(value) for value in values)

    def pose(q11, q12, q21, q22):
        return four_joint_pose(robot, floats(q11, q21), floats(q12, q22))

    def rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
        return four_joint_rates(pose(q11, q12, q21, q22), floats(q11D, q21D), floats(q12D, q22D))

    def lab_dgm(q11, q21, assembly_mode):
        return floats(*dgm(robot, (q11, q21), assembly_mode).xi)

    def lab_igm(x, y, gamma1, gamma2):
        return floats(*igm(robot, (x, y), (gamma1, gamma2)).q)

    def dgm_passive(q11, q21, assembly_mode):
        return floats(*dgm(robot, (q11, q21), assembly_mode).q_passive)

    def lab_dkm(q11, q12, q21, q22, q11D, q21D):
        return floats(*dkm(pose(q11, q12, q21, q22), (q11D, q21D)).xi_dot)

    def lab_ikm(q11, q12, q21, q22, xD, yD):
        return floats(*ikm(pose(q11, q12, q21, q22), (xD, yD)).q_dot)

    def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
        return floats(*Rates(pose(q11, q12, q21, q22), floats(q11D, q21D), floats(xD, yD)).q_passive_dot)

    def lab_dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
        return floats(*dkm2(rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D), (q11DD, q21DD)).xi_ddot)

    def lab_ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
        return floats(*ikm2(rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D), (xDD, yDD)).q_ddot)

    def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
        motion = rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
        return floats(*Accelerations(motion, floats(q11DD, q21DD), floats(xDD, yDD)).q_passive_ddot)

    def lab_dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
        return dynamic_model(rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D))

    return SimpleNamespace(
        dgm=lab_dgm, igm=lab_igm, dgm_passive=dgm_passive, dkm=lab_dkm, ikm=lab_ikm, dkm_passive=dkm_passive,
        dkm2=lab_dkm2, ikm2=lab_ikm2, dkm2_passive=dkm2_passive, dynamic_model=lab_dynamic_model,
    )  # fmt: skip
