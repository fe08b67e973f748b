"""The lab's ten functions, called as its students call them."""

import inspect

import numpy as np
import pytest

import fivebar as fb
from fivebar import amoro

SIGNATURES = {
    "dgm": "q11, q21, assembly_mode",
    "igm": "x, y, gamma1, gamma2",
    "dgm_passive": "q11, q21, assembly_mode",
    "dkm": "q11, q12, q21, q22, q11D, q21D",
    "ikm": "q11, q12, q21, q22, xD, yD",
    "dkm_passive": "q11, q12, q21, q22, q11D, q21D, xD, yD",
    "dkm2": "q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD",
    "ikm2": "q11, q12, q21, q22, q11D, q12D, q21D, q22D, xDD, yDD",
    "dkm2_passive": "q11, q12, q21, q22, q11D, q12D, q21D, q22D, q11DD, q21DD, xDD, yDD",
    "dynamic_model": "q11, q12, q21, q22, q11D, q12D, q21D, q22D",
}


def test_exactly_the_labs_signatures():
    lab = amoro.models(fb.FiveBar())
    assert {
        name: ", ".join(inspect.signature(f).parameters) for name, f in vars(lab).items()
    } == SIGNATURES


def test_the_chain_of_a_lab_session(robot, reachable):
    lab = amoro.models(robot)
    for xi, working in zip(*(array[:20].tolist() for array in reachable)):
        pose = fb.igm(robot, xi, tuple(working))
        rates = fb.ikm(pose, (0.2, -0.1))
        acc = fb.forward_dynamics(rates, (0.01, 0.02))
        q11, q21 = lab.igm(*xi, *working)
        assembly = int(pose.assembly)
        assert lab.dgm(q11, q21, assembly) == pytest.approx(xi, abs=1e-13)
        q12, q22 = lab.dgm_passive(q11, q21, assembly)
        joints = q11, q12, q21, q22
        q11D, q21D = lab.ikm(*joints, 0.2, -0.1)
        assert lab.dkm(*joints, q11D, q21D) == pytest.approx((0.2, -0.1), abs=1e-12)
        q12D, q22D = lab.dkm_passive(*joints, q11D, q21D, 0.2, -0.1)
        assert (q12D, q22D) == pytest.approx(rates.q_passive_dot, rel=1e-10, abs=1e-11)
        motion = *joints, q11D, q12D, q21D, q22D
        assert lab.dkm2(*motion, *acc.q_ddot) == pytest.approx(acc.xi_ddot, rel=1e-8, abs=1e-9)
        assert lab.ikm2(*motion, *acc.xi_ddot) == pytest.approx(acc.q_ddot, rel=1e-8, abs=1e-9)
        passive = lab.dkm2_passive(*motion, *acc.q_ddot, *acc.xi_ddot)
        assert passive == pytest.approx(acc.q_passive_ddot, rel=1e-8, abs=1e-8)
        M, c = lab.dynamic_model(*motion)
        assert (M.shape, c.shape) == ((2, 2), (2,))
        assert M @ acc.q_ddot + c == pytest.approx([0.01, 0.02], abs=1e-9)
        assert all(
            type(value) is float
            for value in (*lab.dgm(q11, q21, assembly), *lab.dkm(*joints, q11D, q21D))
        )


def test_numpy_scalars_and_errors():
    lab = amoro.models(fb.FiveBar())
    assert lab.dgm(np.float64(0), np.array(0.0), -1) == pytest.approx((0.09, 0.06796322535018479))
    with pytest.raises(fb.UnreachableError):
        lab.igm(1.0, 0.0, -1, -1)
    with pytest.raises(fb.SingularityError, match="Type 2"):
        lab.dkm(0.3, 0.4, 0.5, 0.2, 1.0, 1.0)  # q11 + q12 = q21 + q22
