"""What is wrong with a log that the model misses: signs, exchanged motors, mode, gravity, time.

Each suspicion is tried, and the one under which the model fits is named. Where the model fits, a
torque that comes late is looked for, and whether it misses more than the log's noise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, product
from typing import NamedTuple

import numpy as np
from numpy import ndarray
from numpy.lib.stride_tricks import sliding_window_view

from ...base.progress import progress
from ...models.robots import Robot
from ..logs.logs import Log
from .dependent_columns import NEARLY, independent
from .filtering import filtered
from .regression import RegressionFit, fit, price, smallest
from .regressor import linear_names
from .samples import Samples, samples

POOR = 0.05  # of the torque's rms: where a model misses more, something is wrong with the log
LINEAR = 0.2  # of it: where a model misses more, a delay is too long for its linear term
USELESS = 0.3  # of it: where a model misses more, its values mean nothing
LATEST = 0.25  # s by which torques may be late or early
FEW = 2000  # rows and lags that are looked at


def explain(
    robot: Robot,
    logs: list[tuple[Log, bool]],
    assembly: int,
    cutoff: float | None,
    columns: list[int],
    known: ndarray,
    misfit: float,
    impossible: Callable,
) -> None:
    """Raise the ValueError that names what is wrong with the log, if one suspicion stands out.

    Parameters
    ----------
    columns : list of int
        The unknown parameters.
    known : (p,) array
        The values of the others.
    misfit : float
        Of the log as it is.
    impossible : callable
        (robot, names, fit) -> names of values that no robot has.
    """
    log, held = max(logs, key=lambda pair: len(pair[0].t))
    least = (0.4 if misfit > POOR else 1.6) * misfit
    reason = ""
    tried = _suspicions(robot, assembly, log)
    if misfit > LINEAR:
        sample = samples(log, held, robot, assembly, cutoff)
        tried = chain(tried, [_lateness(robot, assembly, log, sample, columns, known)])
    for suspicion, mode, other_robot, changed in progress(
        tried, desc="what is wrong", unit=" reasons", delay=2, leave=False
    ):
        if suspicion and misfit <= POOR:
            break  # a model that fits has but the signs of both torques wrong
        try:
            rows = samples(changed, held, other_robot, mode, cutoff).rows
        except ValueError:
            continue
        if not suspicion and len(columns) < rows.W.shape[2]:
            least = min(least, _of_all_columns(rows)[1].misfit)
        told, _ = independent(rows.W, columns, NEARLY)
        names = [linear_names(robot)[k] for k in told]
        for signs in product((1, -1), repeat=2):
            reasons = [suspicion] if suspicion else []
            wrong = [f"tau{k + 1}" for k in (0, 1) if signs[k] < 0]
            if wrong:
                reasons.append(f"the sign of {' and '.join(wrong)} is the other one")
            tau = np.where(rows.counts, rows.tau * np.array(signs) - rows.W @ known, 0.0)
            found = fit(rows, told, tau)
            score = found.misfit * (1 + 0.5 * len(reasons))
            masses = [name for name in impossible(robot, names, found) if name[0] != "f"]
            if reasons and score < least and not masses:
                least = score
                reason = f"it misses {100 * found.misfit:.3g} % if {' and '.join(reasons)}"
    if reason:
        below = "" if misfit > POOR else ", but with masses or friction below 0"
        raise ValueError(
            f"the model misses {100 * misfit:.3g} % of this log's {robot.words.effort}s{below};"
            f" {reason}"
        )


def _suspicions(robot, assembly, log) -> Iterator[tuple[str, int, Robot, Log]]:
    """Yield what may be wrong, and the mode, robot and log without it."""
    yield "", assembly, robot, log
    efforts = f"the {robot.words.effort}s of the two motors are exchanged"
    yield efforts, assembly, robot, _exchanged(log, "tau")
    yield f"the assembly mode is {-assembly:+d}", -assembly, robot, log
    joints = f"{' and '.join(robot.words.joints)} are exchanged"
    yield joints, assembly, robot, _exchanged(log, "q", "q_dot")
    for signs in ((-1, 1), (1, -1), (-1, -1)):
        wrong = [joint for joint, sign in zip(robot.words.joints, signs) if sign < 0]
        turned = {"q": log.q * signs}
        if log.q_dot is not None:
            turned["q_dot"] = log.q_dot * signs
        words = f"the sign of {' and '.join(wrong)} is the other one"
        yield words, assembly, robot, replace(log, **turned)
    for x, y in ((0.0, -9.81), (0.0, 9.81), (9.81, 0.0), (-9.81, 0.0), (0.0, 0.0)):
        if (x, y) != robot.gravity:
            words = f"gravity is ({x:g}, {y:g}) m/s²"
            yield words, assembly, replace(robot, gravity=(x, y)), log


def _lateness(robot, assembly, log, sample, columns, known):
    """Return the suspicion that all torques are late, by as much as leaves least squares least."""
    t, W, tau, counts = max(sample.pieces, key=lambda piece: len(piece[0]))
    most = min(int(LATEST / sample.step), len(t) // 4)
    lags = np.arange(-most, most + 1, 2 * most // FEW + 1)
    rows = np.arange(most, len(t) - most, len(t) // FEW + 1)
    size = np.maximum(np.nanstd(tau, axis=0), 1e-300)
    weight = (counts[rows] / size)[..., None]
    around = sliding_window_view(np.nan_to_num(tau), 2 * most + 1, axis=0)
    late = around[rows - most][..., lags + most] - (W[rows] @ known)[..., None]
    own = (weight * W[rows][..., columns]).reshape(-1, len(columns))
    own /= np.maximum(np.linalg.norm(own, axis=0), 1e-300)
    late = (weight * late).reshape(len(own), -1)
    missed = late - own @ np.linalg.lstsq(own, late, rcond=None)[0]
    lag = sample.step * lags[np.argmin((missed**2).sum(axis=0))]
    moved = [np.interp(log.t + lag, log.t, column, np.nan, np.nan) for column in log.tau.T]
    word = "late" if lag > 0 else "early"
    words = f"the {robot.words.effort}s come {1e3 * abs(lag):.3g} ms too {word}: shift their times"
    return words, assembly, robot, replace(log, tau=np.stack(moved, axis=1))


def _of_all_columns(rows):
    """Return the columns that are told of all, and their fit."""
    told, _ = independent(rows.W, list(range(rows.W.shape[2])), NEARLY)
    return told, fit(rows, told)


def _left_out(robot, sample, chosen, most):
    """Return in words the parameters with which the model misses at most `most`, if there are."""
    told, whole = _of_all_columns(sample.rows)
    if whole.misfit > most:
        return ""
    places = [k for k, column in enumerate(told) if column not in chosen]
    names = [linear_names(robot)[column] for column in told]
    never = [k for k in places if names[k][0] == "f" and whole.theta[k] < 0]
    each = price(int(sample.rows.counts.sum()), len(places))
    kept = [names[k] for k in smallest(whole.theta, whole.cov, places, each, never)]
    return f"and {100 * whole.misfit:.3g} % with {', '.join(kept)}, too: name them as unknown"


def _exchanged(log, *names):
    pairs = {name: getattr(log, name) for name in names}
    return replace(log, **{name: pair[:, ::-1] for name, pair in pairs.items() if pair is not None})


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
    robot: Robot,
    sample: Samples,
    chosen: list[int],
    theta: ndarray,
    last: RegressionFit,
    delay: Delay,
) -> list[str]:
    """Return sentences on what the log shows besides the model.

    Parameters
    ----------
    robot : FiveBar or Biglide
        The identified robot.
    sample : Samples
        The log.
    chosen : list of int
        The columns of the last fit.
    theta : (p,) array
        The values of all parameters.
    last : RegressionFit
        The last fit.
    delay : Delay
        That of its torques.
    """
    efforts = f"{robot.words.effort}s"
    late, sd, share, misfit = delay
    notes = []
    if abs(late) > 6.0 * sd and share > 2e-3:
        word = "late" if late > 0 else "early"
        notes.append(
            f"the {efforts} come {1e3 * abs(late):.3g} ± {1e3 * sd:.1g} ms too {word} for the"
            " motion: shift their times"
        )
    most = min(0.4 * last.misfit, 0.7 * misfit)  # friction is like a delay
    missed = f"the model misses {100 * last.misfit:.3g} % of the {efforts}"
    times = last.sigma / np.maximum(_noise(sample, theta), 1e-300)
    misses_much = last.misfit > 0.01 and times.max() > 3.0
    if misses_much and (more := _left_out(robot, sample, chosen, most)):
        return [f"{missed}, {more}"]
    if last.misfit > USELESS:
        return [f"{missed}, and nothing that was tried explains it"]
    if misses_much:
        notes.append(
            f"what the model misses is {times[0]:.3g} and {times[1]:.3g} times the noise of this"
            " log: it does not have all of this robot (lengths, zeros of q, backlash, a bend)"
        )
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
