"""Linkages on floats, batches and CasADi symbols."""

import casadi
import numpy as np
import pytest

from fivebar.linkages import GRAVITY, REPAIRED, FiveBarLinkage, driving_torque, move
from tests.conftest import UNEQUAL

from .test_exact import CASES, FOUR_BAR

LINKAGES = [case[0] for case in CASES] + [
    FiveBarLinkage(UNEQUAL, (1, 3)),
    FiveBarLinkage(UNEQUAL, (2, 4)),
]


def outputs(motion):
    """Everything a motion knows but torques."""
    for name in motion.points:
        yield from (motion.position(name), motion.velocity(name), motion.acceleration(name))
    for name in motion.links:
        yield from (motion.angle(name), motion.rate(name), motion.angular_acceleration(name))
    for name in motion.coordinates:
        yield from motion.coordinate(name)
    yield motion.transmission_angle()


@pytest.mark.every(3)
@pytest.mark.parametrize("linkage", LINKAGES, ids=lambda x: x.title)
@pytest.mark.parametrize("symbol", [casadi.SX, casadi.MX], ids=["SX", "MX"])
def test_floats_batches_and_casadi_agree(linkage, symbol):
    two = isinstance(linkage, FiveBarLinkage)
    case = next((case for case in CASES if case[0] is linkage), None)
    q = (
        np.array([[linkage.home[k] + x for k in linkage.motors] for x in (0.0, 0.05)])
        if two
        else np.array(case[2][:2])
    )
    branch = linkage.usual_branch if two else case[1][0]
    q_dot, q_ddot = (q * 0 + 1.3, q * 0 - 0.7) if two else (1.3, -0.7)
    batch = move(linkage, q, q_dot, q_ddot, branch)
    s = symbol.sym("q", *((2, 1) if two else (1, 1)))
    given = (casadi.DM([1.3, 1.3]), casadi.DM([-0.7, -0.7])) if two else (1.3, -0.7)
    made = list(outputs(move(linkage, s, *given, branch)))
    function = casadi.Function("f", [s], [symbol(x) for x in made])
    for k, angle in enumerate(q):
        one = move(
            linkage,
            angle if two else float(angle),
            *((q_dot[k], q_ddot[k]) if two else (1.3, -0.7)),
            branch,
        )
        for single, many, symbolic in zip(outputs(one), outputs(batch), function(angle)):
            assert np.shape(many) == (2, *np.shape(single))
            assert single == pytest.approx(many[k], rel=1e-13, abs=1e-14)
            assert np.array(symbolic).ravel() == pytest.approx(
                np.ravel(single), rel=1e-9, abs=1e-12
            )


def test_torque_by_casadi():
    q = casadi.SX.sym("q")
    torque = driving_torque(move(REPAIRED, q, 2.0), {"E": (0.0, 1e5)}, GRAVITY)
    value = casadi.Function("f", [q], [torque])(0.7)
    assert float(value) == pytest.approx(
        driving_torque(move(REPAIRED, 0.7, 2.0), {"E": (0.0, 1e5)}, GRAVITY), rel=1e-9
    )


def test_batches_of_any_shape_and_batches_of_branches():
    q = np.linspace(0, 6, 12).reshape(3, 4)
    branch = np.where(q > 3, 1, -1)
    motion = move(FOUR_BAR, q, branch=branch)
    assert motion.position("M").shape == (3, 4, 2) and motion.rate("crank").shape == (3, 4)
    for k in ((0, 1), (2, 3)):
        single = move(FOUR_BAR, float(q[k]), branch=int(branch[k]))
        assert motion.acceleration("M")[k] == pytest.approx(single.acceleration("M"), rel=1e-13)
    assert move(FOUR_BAR, np.zeros((0,))).position("M").shape == (0, 2)
