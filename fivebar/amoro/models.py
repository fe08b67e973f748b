"""The functions of the AMORO lab as thin calls into the package."""

from types import SimpleNamespace

from ..base.backend import HUGE
from ..base.checks import modes, number
from ..base.robot_uses import robot_for
from ..models.dynamics import dynamic_model
from ..models.four_joints import four_joint_pose, four_joint_rates
from ..models.geometry import dgm, igm
from ..models.kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2

mode = modes(1)


def checked(**given):
    """The numbers by their names, as floats; ValueError, with its name, for what is not finite."""
    return tuple(
        v if type(v) is float and -HUGE < v < HUGE else number(v, name) for name, v in given.items()
    )


def models(robot):
    """Return the ten functions of the AMORO lab, with the lab's own signatures.

    dgm, igm, dgm_passive, dkm, ikm, dkm_passive, dkm2, ikm2, dkm2_passive, dynamic_model. D and DD
    mark first and second derivatives; the passive joints are arguments, too.

    Parameters
    ----------
    robot : FiveBar or Biglide

    Returns
    -------
    SimpleNamespace
        Functions of floats that return tuples of floats; dynamic_model returns arrays M (2, 2) and
        c (2,). They raise the errors of the package's functions of the same names.

    Examples
    --------
    >>> import fivebar as fb
    >>> lab = fb.amoro.models(fb.FiveBar())
    >>> x, y = lab.dgm(0.0, 0.0, -1)
    >>> print(f"{x:.3f} {y:.5f}")
    0.090 0.06796
    """

    robot = robot_for("fb.amoro.models")(robot, "robot")

    def floats(*values):
        return tuple(float(value) for value in values)

    def pose(q11, q12, q21, q22):
        q11, q12, q21, q22 = checked(q11=q11, q12=q12, q21=q21, q22=q22)
        return four_joint_pose(robot, (q11, q21), (q12, q22))

    def rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
        q11D, q12D, q21D, q22D = checked(q11D=q11D, q12D=q12D, q21D=q21D, q22D=q22D)
        return four_joint_rates(pose(q11, q12, q21, q22), (q11D, q21D), (q12D, q22D))

    def lab_dgm(q11, q21, assembly_mode):
        return floats(
            *dgm(robot, checked(q11=q11, q21=q21), mode(assembly_mode, "assembly_mode")).xi
        )

    def lab_igm(x, y, gamma1, gamma2):
        return floats(
            *igm(robot, checked(x=x, y=y), (mode(gamma1, "gamma1"), mode(gamma2, "gamma2"))).q
        )

    def dgm_passive(q11, q21, assembly_mode):
        return floats(
            *dgm(robot, checked(q11=q11, q21=q21), mode(assembly_mode, "assembly_mode")).q_passive
        )

    def lab_dkm(q11, q12, q21, q22, q11D, q21D):
        return floats(*dkm(pose(q11, q12, q21, q22), checked(q11D=q11D, q21D=q21D)).xi_dot)

    def lab_ikm(q11, q12, q21, q22, xD, yD):
        return floats(*ikm(pose(q11, q12, q21, q22), checked(xD=xD, yD=yD)).q_dot)

    def dkm_passive(q11, q12, q21, q22, q11D, q21D, xD, yD):
        q_dot, xi_dot = checked(q11D=q11D, q21D=q21D), checked(xD=xD, yD=yD)
        return floats(*Rates(pose(q11, q12, q21, q22), q_dot, xi_dot).q_passive_dot)

    def lab_dkm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD):
        return floats(
            *dkm2(
                rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D), checked(q11DD=q11DD, q21DD=q21DD)
            ).xi_ddot
        )

    def lab_ikm2(q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD):
        return floats(
            *ikm2(
                rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D), checked(xDD=xDD, yDD=yDD)
            ).q_ddot
        )

    def dkm2_passive(q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD):
        motion = rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D)
        q_ddot, xi_ddot = checked(q11DD=q11DD, q21DD=q21DD), checked(xDD=xDD, yDD=yDD)
        return floats(*Accelerations(motion, q_ddot, xi_ddot).q_passive_ddot)

    def lab_dynamic_model(q11, q12, q21, q22, q11D, q12D, q21D, q22D):
        return dynamic_model(rates(q11, q12, q21, q22, q11D, q12D, q21D, q22D))

    return SimpleNamespace(
        dgm=lab_dgm,
        igm=lab_igm,
        dgm_passive=dgm_passive,
        dkm=lab_dkm,
        ikm=lab_ikm,
        dkm_passive=dkm_passive,
        dkm2=lab_dkm2,
        ikm2=lab_ikm2,
        dkm2_passive=dkm2_passive,
        dynamic_model=lab_dynamic_model,
    )
