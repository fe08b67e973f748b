"""What a log shows beside the model: torques that come late, misses beyond its noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy import ndarray

from ...models.robots import Robot
from .dependent_columns import independent
from .filtering import filtered
from .regression import RegressionFit, fit
from .samples import Samples

MUCH = 0.01  # of the torque's rms, and
TIMES = 3.0  # the noise of the log: who misses more does not have all of the robot
SURE = 4.0  # standard deviations below 0: no mass and no friction can be there
USELESS = 0.2  # of the torque's rms: where a model misses more, its values mean nothing


class Delay(NamedTuple):
    """By how much torques are late, s, its deviation, its share of them, and the misfit with it."""

    late: float
    sd: float
    share: float
    misfit: float


def lateness(sample: Samples, told: list[int], theta: ndarray, known: ndarray) -> Delay:
    """Return the delay of the torques beside a model.

    told, theta: its columns and their values; known: those of all columns, 0 there. The deviation
    is infinite where the rate of the torques is a sum of the columns.
    """
    whole = known.copy()
    whole[told] = theta
    pieces = []
    for t, W, tau, counts in sample.pieces:
        rate = np.gradient(W @ whole, sample.step, axis=0)
        own = np.concatenate([W[:, :, told], rate[..., None]], axis=2)
        pieces.append((t, own, tau - W @ known, counts))
    rows = filtered(pieces, sample.step, sample.cutoff)
    columns = list(range(len(told) + 1))
    if independent(rows.W, columns, 1e-3)[0] != columns:
        return Delay(0.0, np.inf, 0.0, np.inf)
    shifted = fit(rows, columns)
    late = -float(shifted.theta[-1])
    share = abs(late) * np.linalg.norm(rows.W[:, :, -1]) / np.linalg.norm(rows.tau)
    return Delay(late, float(np.sqrt(shifted.cov[-1, -1])), float(share), shifted.misfit)


def beyond_the_model(
    robot: Robot, sample: Samples, theta: ndarray, full: RegressionFit, delay: Delay
) -> list[str]:
    """Return sentences on what the log shows besides the model.

    Parameters
    ----------
    robot : FiveBar or Biglide
        The robot.
    sample : Samples
        The log.
    theta : (p,) array
        The values of all parameters.
    full : RegressionFit
        The fit of the columns that the log tells.
    delay : Delay
        That of its torques.

    Raises
    ------
    ValueError
        The model misses so much that its values mean nothing.
    """
    efforts = f"{robot.words.effort}s"
    late, sd, share, misfit = delay
    times = full.sigma / np.maximum(_noise(sample, theta), 1e-300)
    misses = full.misfit > MUCH and times.max() > TIMES
    # What a model lacks may look like a delay: friction, for one.
    explains = not misses or misfit < full.misfit / 2
    notes = []
    if abs(late) > 6.0 * sd and share > 2e-3 and explains:
        word = "late" if late > 0 else "early"
        notes.append(
            f"the {efforts} come {1e3 * abs(late):.3g} ± {1e3 * sd:.1g} ms too {word} for the"
            " motion: shift their times"
        )
    if misses:
        words = (
            f"the model misses {100 * full.misfit:.3g} % of the {efforts}, {times[0]:.3g} and"
            f" {times[1]:.3g} times the noise of this log. Is t in ms? Has q or tau of a motor the"
            f" wrong sign, are the motors exchanged, do {efforts} come late? Are the assembly mode"
            f" {sample.assembly:+d}, gravity, the lengths, gear_ratio and offset of q those of this"
            " robot, is its gear given once, by the log or by gear_ratio, and is all unknown that"
            " it has (friction)?"
        )
        if full.misfit > USELESS:
            raise ValueError(words)
        notes.append(words)
    return notes


def _noise(sample, theta):
    """Return the noise (2,) of a row, N m, that the torques' and the encoders' noise make.

    The torques' is the median of their fourth differences, in which no motion is left; of white
    noise the variance of these is 70 times its own, and 7 times where two rows are averaged.
    """
    rows = sample.rows
    by_q = np.sqrt(((rows.change @ theta) ** 2).sum(axis=0) / rows.counts.sum(axis=0))
    tau = max((tau for _, _, tau, _ in sample.pieces), key=len)
    fourth = np.diff(tau[np.isfinite(tau).all(axis=1)], 4, axis=0)
    noise = 0.0
    if len(fourth):
        noise = np.median(np.abs(fourth), axis=0) / 0.6745 / np.sqrt(7.0 if sample.held else 70.0)
    return np.hypot(noise * rows.gain, by_q)
