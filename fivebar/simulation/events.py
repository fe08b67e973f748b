"""When a motion crosses a singularity: every change of a sine's sign, two in one step too."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.backend import sign
from ..models.robots import Robot
from ..singularities.margins import Singularity
from .run import Event
from .steps import MARGIN_RATES, MARGINS

KINDS = Singularity.SERIAL, Singularity.SERIAL, Singularity.PARALLEL
MOST_NEWTON = 50  # where the sine hardly dips below 0, a step only halves the distance at first
ENOUGH = 1e-7  # of a step: after a Newton step as small as this the next is at rounding
NEARBY = 1e-4  # of a step, between which the rate's slope is taken
DIP = 0.05  # of the smaller end: a cubic that comes as near to 0 is looked at in the motion itself


def meets(margins: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Which motions (*batch,) may cross a singularity: sines (*batch, n, 3) and their rates.

    None that crosses is left out; some that come near to one are in.
    """
    low, high = margins[..., :-1, :], margins[..., 1:, :]
    dips = (low * slopes[..., :-1, :] < 0) & (high * slopes[..., 1:, :] > 0)
    return ((low * high <= 0) | dips).any(axis=(-1, -2))


def crossings(
    robot: Robot, t: np.ndarray, rows: np.ndarray, after: Callable | None = None
) -> tuple[Event, ...]:
    """The crossings of Type 1 and Type 2 on times t (n,) with observations (n, columns), in order.

    after: (k, length) -> the three sines and their rates `length` s after row k, by the motion
    itself: then times are good to 1e-12 s; else they are those of the cubic through a step's ends
        and their slopes.
    """
    margins, rates, step = rows[:, MARGINS], rows[:, MARGIN_RATES], t[1] - t[0]
    modes = -sign(margins, 0.0)
    for k in np.flatnonzero(
        (modes == 0).any(axis=1)
    ):  # a step that ends on a singularity has not crossed it yet
        modes[k] = np.where(modes[k] == 0, modes[k - 1] if k else 0, modes[k])
    found = []  # (time, column, step)
    for column in range(3):
        y, slopes = margins[:, column], step * rates[:, column]
        for k in np.flatnonzero(modes[1:, column] * modes[:-1, column] < 0):
            ends = y[k], y[k + 1], slopes[k], slopes[k + 1]
            found.append((t[k] + step * _zero(ends, _of(after, k, column, step)), column, k))
        towards = (y[:-1] * slopes[:-1] < 0) & (y[1:] * slopes[1:] > 0) & (y[:-1] * y[1:] > 0)
        for k in np.flatnonzero(towards):
            ends = y[k], y[k + 1], slopes[k], slopes[k + 1]
            for place in _there_and_back(ends, _of(after, k, column, step)):
                found.append((t[k] + step * place, column, k))
    events, now = [], modes[0].copy()
    for when, column, k in sorted(found):
        before = np.where(
            now == 0, modes[k], now
        )  # what began on a singularity has a mode from its first step on
        now[column] = -now[column] if now[column] else modes[k + 1, column]
        events.append(
            Event(
                float(when), KINDS[column], robot.words.sines[column], _plain(before), _plain(now)
            )
        )
    return tuple(events)


def _plain(modes):
    return tuple(int(mode) for mode in modes)


def _of(after, k, column, step):
    """place in [0, 1] of step k -> (sine, its rate over the step) by the motion itself, None where
    it is not known.
    """
    if after is None:
        return None

    def look(place):
        sines, rates = after(k, place * step)
        return sines[column], step * rates[column]

    return look


def _cubic(y0, y1, d0, d1):
    """Coefficients of 1, s, s^2, s^3."""
    change = y1 - y0
    return y0, d0, 3 * change - 2 * d0 - d1, d0 + d1 - 2 * change


def _zero(ends, look, low=0.0, high=1.0):
    """Where in [low, high], at whose ends it has opposite signs, the sine is 0: on the cubic, then
    in the motion.
    """
    k0, k1, k2, k3 = _cubic(*ends)
    bottom, top, place = low, high, (low + high) / 2
    rising = k0 + high * (k1 + high * (k2 + high * k3)) > 0
    for _ in range(60):  # Newton's steps, bisection's where these leave the bracket
        value, rate = (
            k0 + place * (k1 + place * (k2 + place * k3)),
            k1 + place * (2 * k2 + place * 3 * k3),
        )
        bottom, top = (bottom, place) if (value > 0) == rising else (place, top)
        better = place - value / rate if rate else top
        if not bottom < better < top:
            better = (bottom + top) / 2
        change, place = abs(better - place), better
        if change < 1e-14:
            break
    for _ in range(MOST_NEWTON if look else 0):
        value, rate = look(place)
        if not rate:
            break
        better = min(max(place - value / rate, low), high)
        change, place = abs(better - place), better
        if change < ENOUGH:
            break
    return place


def _there_and_back(ends, look):
    """Places of the two crossings of a step whose ends have one sign; () where the sine only comes
    near to 0.
    """
    k0, k1, k2, k3 = _cubic(*ends)
    side = 1.0 if k0 > 0 else -1.0
    # The cubic goes towards 0 at the step's start and away at its end: it turns at that root of its
    # slope where the second derivative has the sign of the ends; of its two forms the one without
    # cancellation.
    root = max(k2 * k2 - 3 * k1 * k3, 0.0) ** 0.5
    low = -k1 / (k2 + side * root) if side * k2 > 0 else (side * root - k2) / (3 * k3)
    if side * (k0 + low * (k1 + low * (k2 + low * k3))) > DIP * min(abs(ends[0]), abs(ends[1])):
        return ()
    if look is not None:
        for _ in range(
            3
        ):  # the cubic's turn is good to third order; then secants of the motion's own rate
            slope = (look(low + NEARBY)[1] - look(low - NEARBY)[1]) / (2 * NEARBY)
            low = min(max(low - look(low)[1] / slope, NEARBY), 1 - NEARBY) if slope else low
    value = look(low)[0] if look else k0 + low * (k1 + low * (k2 + low * k3))
    return () if side * value >= 0 else (_zero(ends, look, 0.0, low), _zero(ends, look, low, 1.0))
