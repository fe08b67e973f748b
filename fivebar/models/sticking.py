"""Which drives stick: dry friction at a drive that stands, the complementarity problem of both."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from .kinematics import Rates
from .physics import loads_of

EDGE = 1e-12  # of the friction, by which what holds may exceed it: rounding


def slip_of(rates: Rates, tau: tuple, held_by: Callable) -> tuple:
    """Return per drive the direction in which it slips, 0 where friction holds it, on components.

    A drive that moves slips with its rate. One that stands is held where no more than its friction
    is needed, else it slips as its acceleration then has it; of two, both at once (the mass matrix
    is positive: one answer, but for ties).
    held_by: (rates, tau, slip) -> (accelerations, what holds).
    """
    dry = loads_of(rates.pose.robot).coulomb
    signs = [np.sign(rate) for rate in rates._q_dot]
    standing = np.array([np.logical_and(s == 0, f > 0) for s, f in zip(signs, dry)])
    if not standing.any():
        return tuple(_plain(np.where(s == 0, 1.0, s)) for s in signs)
    shape = np.broadcast_shapes(np.shape(signs[0]), np.shape(tau[0]), np.shape(rates.pose.point[0]))
    found = [np.zeros(shape), np.zeros(shape)]
    open_ = np.ones(shape, dtype=bool)
    for choice in product((0.0, 1.0, -1.0), repeat=2):
        if any(not stands.any() and c != 1.0 for stands, c in zip(standing, choice)):
            continue
        slip = tuple(
            _plain(np.where(stands, c, np.where(s == 0, 1.0, s)))
            for stands, c, s in zip(standing, choice, signs)
        )
        with np.errstate(all="ignore"):
            try:
                acc, holds = held_by(rates, tau, slip)
            except ArithmeticError:
                continue  # what both drives hold leaves a Type-2 pose free: another choice moves it
        fits = np.ones(shape, dtype=bool)
        for k, c in enumerate(choice):
            if c == 0:
                good = np.abs(holds[k]) <= dry[k] * (1 + EDGE)
            else:
                good = acc._q_ddot[k] * c >= 0
            fits &= np.where(standing[k], good, c == 1.0)
        for k in (0, 1):
            found[k] = np.where(open_ & fits, slip[k], found[k])
        open_ &= ~fits
    return tuple(_plain(each) for each in found)


def _plain(value):
    return float(value) if np.ndim(value) == 0 else value
