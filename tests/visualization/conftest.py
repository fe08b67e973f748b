"""Runs that many pictures are of."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.pitfalls import crossing

ROBOT = fb.FiveBar()


@pytest.fixture(scope="session")
def crossing_run():
    reference = crossing.compliant(ROBOT)
    return fb.simulate(ROBOT, crossing.OpenLoop(ROBOT, 0.002), reference, control_period=0.002)


@pytest.fixture(scope="session")
def run():
    reference = fb.line((0.09, 0.06796322535018479), (0.0, 0.1), 0.5)
    return fb.simulate(ROBOT, fb.PD(ROBOT, 1.0, 0.1), reference)


def long_run(t, q, **changes):
    xi = np.zeros((len(t), 2))
    good = np.isfinite(q).all(axis=1)
    xi[good], xi[~good] = fb.dgm(ROBOT, q[good]).xi, np.nan
    zero = np.zeros_like(q)
    return replace(fb.Run(ROBOT, t, q, zero, xi, zero, zero[:, 0]), **changes)
