"""When a motion crosses a singularity: every change of a sine's sign, two in one step too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from ..base.backend import EPS, sign
from ..models.robots import Robot
from ..singularities.margins import Singularity
from .run import Event

MOST_NEWTON = 50  # where the sine hardly dips below 0, a step only halves the distance at first
ENOUGH = 1e-7  # of a step: after a Newton step as small as this the next is at rounding
DIP = 0.05  # of the smaller end: a cubic that comes as near to 0 is looked at in the motion itself
KINDS = Singularity.SERIAL, Singularity.SERIAL, Singularity.PARALLEL  # of sin q12, sin q22, det A


def may_cross(margins: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return which motions (*batch,) may cross a singularity: sines (*batch, n, 3), their rates.

    No motion that crosses is left out. Some that come near to a singularity are in.
    """
    before = margins[..., :-1, :]
    after = margins[..., 1:, :]
    changes = before * after <= 0
    growth = margins * rates
    falls = growth[..., :-1, :] < 0
    rises = growth[..., 1:, :] > 0
    turns = falls & rises
    return (changes | turns).any(axis=(-1, -2))


def crossings(
    robot: Robot,
    t: np.ndarray,
    margins: np.ndarray,
    rates: np.ndarray,
    motion: Callable | None = None,
) -> tuple[Event, ...]:
    """Return the crossings of Type 1 and Type 2 singularities in order.

    Parameters
    ----------
    robot : FiveBar or Biglide
    t : (n,), s
    margins, rates : (n, 3)
        The three sines at these times, and their rates.
    motion : callable, optional
        t -> the three sines and their rates, (3,) each, of the motion itself, for times good to
        1e-12 s. None: each sine is the cubic that has the values and rates of a step's ends.
    """
    modes = _modes(margins)
    zeros = []  # (time, column, step)
    for column in range(3):
        changes = modes[1:, column] * modes[:-1, column] < 0
        growth = margins[:, column] * rates[:, column]
        turns = (growth[:-1] < 0) & (growth[1:] > 0)
        for k in np.flatnonzero(changes | turns).tolist():
            step = t[k + 1] - t[k]
            ends = slice(k, k + 2), column
            cubic = Cubic.through(margins[ends].tolist(), (step * rates[ends]).tolist())
            look = motion and partial(_look, motion, column, t[k], step)
            places = [zero(cubic, look)] if changes[k] else there_and_back(cubic, look)
            zeros += [(t[k] + step * place, column, k) for place in places]
    events = []
    now = modes[0].copy()
    for when, column, k in sorted(zeros):
        # What began on a singularity has a mode from its first step on.
        before = np.where(now == 0, modes[k], now)
        now[column] = -now[column] if now[column] else modes[k + 1, column]
        name = robot.words.sines[column]
        modes_before = tuple(before.astype(int).tolist())
        modes_after = tuple(now.astype(int).tolist())
        events.append(Event(float(when), KINDS[column], name, modes_before, modes_after))
    return tuple(events)


def _modes(margins):
    """Return the signs of the modes (n, 3).

    A step that ends on a singularity has not crossed it yet.
    """
    modes = -sign(margins, 0.0)
    for k in np.flatnonzero((modes == 0).any(axis=1)):
        modes[k] = np.where(modes[k] == 0, modes[k - 1] if k else 0, modes[k])
    return modes


def _look(motion, column, t, step, place):
    """Return a sine and its rate over a step, at a place in [0, 1] of it, by the motion itself."""
    sines, rates = motion(t + place * step)
    return sines[column], step * rates[column]


class Cubic(NamedTuple):
    """A polynomial in the place in a step, [0, 1], by its coefficients."""

    k0: float
    k1: float
    k2: float
    k3: float

    @classmethod
    def through(cls, values: Sequence[float], slopes: Sequence[float]) -> Cubic:
        """Return the cubic that has these two values and slopes at 0 and 1."""
        change = values[1] - values[0]
        bend = slopes[0] + slopes[1] - 2 * change
        return cls(values[0], slopes[0], change - slopes[0] - bend, bend)

    def __call__(self, s: float) -> float:
        return self.k0 + s * (self.k1 + s * (self.k2 + s * self.k3))

    def slope(self, s: float) -> float:
        """Return the derivative at s."""
        return self.k1 + s * (2 * self.k2 + s * 3 * self.k3)


def zero(cubic: Cubic, look: Callable | None, low: float = 0.0, high: float = 1.0) -> float:
    """Return where in [low, high] a sine is 0: on the cubic, then by Newton's steps in the motion.

    But for rounding, the cubic has opposite signs at low and high.
    """
    place = _bracketed(cubic, low, high)
    if look is None:
        return place
    for _ in range(MOST_NEWTON):
        value, slope = look(place)
        if not slope:
            break
        before = place
        place = min(max(place - value / slope, low), high)
        if abs(place - before) < ENOUGH:
            break
    return place


def there_and_back(cubic: Cubic, look: Callable | None) -> tuple[float, ...]:
    """Return the two zeros of a sine that turns in the step; () where it does not reach 0.

    At both ends it has one sign, and it goes towards 0 and away.
    """
    turn = _bracketed(cubic.slope, 0.0, 1.0)
    side = 1.0 if cubic(0.0) > 0 else -1.0
    value = side * cubic(turn)
    if value > DIP * min(side * cubic(0.0), side * cubic(1.0)):
        return ()
    if look is not None:
        turn = _bracketed(lambda place: look(place)[1], 0.0, 1.0)
        value = side * look(turn)[0]
    if value >= 0:
        return ()
    return zero(cubic, look, 0.0, turn), zero(cubic, look, turn, 1.0)


def _bracketed(function, low, high):
    """Return the zero between two places at which, but for rounding, the function has two signs."""
    at_low = function(low)
    at_high = function(high)
    if at_low * at_high >= 0:
        return low if abs(at_low) < abs(at_high) else high
    # A zero without a slope takes more than the usual 100 iterations.
    return brentq(function, low, high, xtol=1e-16, rtol=4 * EPS, maxiter=1000)
