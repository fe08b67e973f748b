"""Driving torque of linkages with one drive: J q'' + J'(q) q'^2 / 2 + U'(q) = Q (six-bar paper, eq.
24-38).
"""

from __future__ import annotations

import numpy as np

from ..base.checks import instance, takes, two_numbers
from ..models.dyads import dot
from .checks import loads
from .motion import Motion, one_drive, stretch


@takes(motion=instance(Motion))
def equivalent_inertia(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the inertia of all bodies at the crank, and its derivative.

    J = sum m |S'|^2 + j theta'^2, so dJ/dq = 2 sum m S'.S'' + j theta' theta''.

    Parameters
    ----------
    motion : Motion
        In analogs, as `move` gives it.

    Returns
    -------
    J, dJ/dq : (*batch,), kg m^2

    References
    ----------
    Six-bar paper, eq. 29 and 30.

    Examples
    --------
    >>> from fivebar import linkages
    >>> J, slope = linkages.equivalent_inertia(linkages.move(linkages.REPAIRED, 0.3))
    >>> float(J) > 0
    True
    """
    _one_drive(motion)
    inertia, slope = _inertia(motion.chain)
    return motion._full(inertia), motion._full(slope)


@takes(motion=instance(Motion), gravity=two_numbers)
def potential(motion: Motion, gravity: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the potential energy of the weights, and its derivative by the crank angle.

    Parameters
    ----------
    motion : Motion
    gravity : (2,)
        m/s^2.

    Returns
    -------
    U, dU/dq : (*batch,), J and N m

    References
    ----------
    Six-bar paper, eq. 31 and 37.

    Examples
    --------
    >>> from fivebar import linkages
    >>> U, slope = linkages.potential(linkages.move(linkages.REPAIRED, 0.3), (0.0, -9.81))
    >>> float(U) != 0
    True
    """
    _one_drive(motion)
    energy, slope = 0.0, 0.0
    for link in motion.chain.links.values():
        if link.body.mass:
            energy = energy - link.body.mass * dot(gravity, link.centre.p)
            slope = slope - link.body.mass * dot(gravity, link.centre.v)
    return motion._full(energy), motion._full(slope)


@takes(motion=instance(Motion), load=loads, gravity=two_numbers)
def driving_torque(
    motion: Motion, load: dict | None = None, gravity: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Return the motor's torque on the driven link, counter-clockwise, N m.

    J q'' + J'(q) q'^2 / 2 + U'(q) = Q (six-bar paper, eq. 38).

    Parameters
    ----------
    motion : Motion
        Of a linkage with one drive.
    load : mapping
        {point: (Fx, Fy)}, N, numbers or arrays of the batch's shape.
    gravity : (gx, gy), m/s^2

    Returns
    -------
    (*batch,) array

    Examples
    --------
    >>> from fivebar import linkages
    >>> bar = linkages.FourBar(0.2, 0.06, 0.16, 0.14, rocker_body=linkages.Body(1.0))
    >>> torque = linkages.driving_torque(linkages.move(bar, 0.5), gravity=(0.0, -9.81))
    >>> round(float(torque), 4)
    0.0168
    """
    _one_drive(motion)
    load = load or {}
    for point, force in load.items():
        for component in force:
            try:
                motion._full(component)
            except ValueError:
                raise ValueError(
                    f"load[{point!r}] of shape {component.shape} does not fit a motion of shape"
                    f" {motion._shape}"
                ) from None
    torques = []
    for part, piece in motion.stretches():
        if part is None:
            return piece._full(_torque(piece, load, gravity))
        share = {}
        for point, (x, y) in load.items():
            share[point] = stretch(x, motion._shape, part), stretch(y, motion._shape, part)
        torques.append(piece._full(_torque(piece, share, gravity)))
    return np.concatenate(torques).reshape(motion._shape)


def _torque(motion, load, gravity):
    inertia, slope = _inertia(motion.chain)
    torque = inertia * motion.q_ddot + slope * (0.5 * motion.q_dot * motion.q_dot)
    for link in motion.chain.links.values() if any(gravity) else ():
        mass = link.body.mass
        if mass:
            torque = torque - dot((mass * gravity[0], mass * gravity[1]), link.centre.v)
    for point, force in load.items():
        torque = torque - dot(force, motion._point(point).v)
    return torque


def _one_drive(motion):
    """Raise ValueError for a linkage with two motors."""
    if type(motion.linkage).start is not one_drive:
        raise ValueError("a driving torque is that of a linkage with one drive")


def _inertia(chain):
    inertia, slope = 0.0, 0.0
    for link in chain.links.values():
        body = link.body
        if body.mass:
            v = link.centre.v
            a = link.centre.a
            inertia = inertia + body.mass * dot(v, v)
            slope = slope + 2 * body.mass * dot(v, a)
        if body.inertia:
            rate = link.heading.rate
            inertia = inertia + body.inertia * (rate * rate)
            slope = slope + 2 * body.inertia * (rate * link.heading.acceleration)
    return inertia, slope
