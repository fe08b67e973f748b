"""What friction takes from a motion: what the balance of its energy needs beside the drives'
work.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_simpson

from ..models.four_joints import bars_rates
from ..models.loads import lost_power
from .plant import stretches
from .steps import between, motion_of

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(
    8
)  # exact for what polynomials of degree 7 give squared


def loss_by_rows(robot, t, rows):
    """What friction has taken until each of the rows of a motion, (n,) J, by Simpson's rule on
    them.
    """
    return cumulative_simpson(
        lost_power(motion_of(robot, rows)) + np.zeros(len(t)), x=t, initial=0.0
    )


def friction_loss(plant, t):
    """What friction has taken until times t (n,), J (n,): integrated on the steps' own
    polynomials.
    """
    t0, lengths, states, polynomials = plant.pieces
    ends = np.concatenate(
        [[0.0], np.cumsum(_lost(plant.robot, states, polynomials, lengths, np.ones(len(t0))))]
    )
    found = np.empty(len(t))
    for part, at, places in stretches(t, t0, lengths):
        found[part] = ends[at] + _lost(
            plant.robot, states[at], polynomials[at], lengths[at], places
        )
    return found


def _lost(robot, states, polynomials, lengths, ends):
    """Of each step, from its beginning to the place `ends`."""
    total = 0.0
    for node, weight in zip(GAUSS, WEIGHTS):
        columns = between(states, polynomials, ends * (1 + node) / 2).T
        total = total + weight / 2 * lost_power(
            bars_rates(robot, tuple(columns[:4]), tuple(columns[4:]))
        )
    return total * ends * lengths
