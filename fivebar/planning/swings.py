"""First motions between two poses that swing: from both ends, under little torque, to a middle.

Random torques, most of them small, move the robot from the start, and backwards in time from the
goal. Where two such motions nearly meet after half of the time, little torque joins them.
"""

from __future__ import annotations

import numpy as np

from .search import nearest_turn
from .shooting import Motions, Shooting, at_all

SAMPLES = 400  # from each end
AMPLITUDES = 0.0, 0.03, 0.1, 0.3  # of the torques, over the unit
PIECES = 4  # of constant torque, in half of the time
BEST = 4000  # pairs of a forward and a backward motion that are looked at
APART = 0.8  # rad or bars between two motions that are not the same
TOO_FAST = 0.5  # rad or bars in a step


def swings(
    shooting: Shooting, start: np.ndarray, goal: np.ndarray, duration: float, count: int, most: int
) -> Motions | None:
    """Return `most` motions on `count` intervals that nearly join two poses, the best first.

    They are sampled in steps of half an interval.

    start, goal: bars (4,); whole turns of the goal's may be added.
    """
    rng = np.random.default_rng(53)
    h = duration / (2 * count)
    there, push = _sampled(shooting, start, count, h, rng)
    back, pull = _sampled(shooting, goal, count, -h, rng)
    if not len(there) or not len(back):
        return None
    last, first = there[:, None, -1], back[None, :, -1]
    turned = nearest_turn(shooting.problem.robot, first[..., :4], last[..., :4])
    places = (last[..., :4] - turned) / shooting.units[:4]
    rates = (last - first)[..., 4:] / shooting.units[4:]
    # Effort that closes a gap of places and rates within half of the time, of a unit of inertia.
    time = shooting.units[0] / shooting.units[4]
    left = duration / 2 / time
    gaps = 12 * (places**2).sum(axis=-1) / left**3 + 4 * (rates**2).sum(axis=-1) / left
    efforts = [(each**2).sum(axis=(1, 2)) * h / shooting.torque**2 for each in (push, pull)]
    total = efforts[0][:, None] + efforts[1] + gaps * time
    best = np.argsort(total, axis=None)[:BEST]
    chosen: list[np.ndarray] = []
    torques = []
    for i, j in zip(*np.unravel_index(best, total.shape)):
        tail = back[j, ::-1].copy()
        tail[:, :4] += turned[i, j] - tail[0, :4]
        x = np.concatenate([there[i, :-1], (there[i, -1:] + tail[:1]) / 2, tail[1:]])
        bars = x[:, :4] / shooting.units[:4]
        if all(np.abs(bars - one[:, :4] / shooting.units[:4]).max() > APART for one in chosen):
            chosen.append(x)
            torques.append(np.concatenate([push[i], pull[j, ::-1]]))
        if len(chosen) == most:
            break
    times = np.tile(np.linspace(0, duration, count + 1), (len(chosen), 1))
    mean = np.reshape(torques, (len(chosen), count, 2, 2)).mean(axis=2)
    return Motions(shooting, np.array(chosen)[:, ::2], mean, times, np.array([0, count]))


def _sampled(shooting, bars, count, h, rng):
    """Return motions (k, count + 1, 8) from rest under random torques (k, count, 2)."""
    size = rng.choice(AMPLITUDES, (SAMPLES, 1, 1)) * shooting.torque
    pieces = size * rng.normal(size=(SAMPLES, PIECES, 2))
    torques = pieces[:, np.arange(count) * PIECES // count]
    x = np.zeros((SAMPLES, count + 1, 8))
    x[:, 0, :4] = bars
    step = np.full((SAMPLES, 1), h)
    for k in range(count):
        x[:, k + 1] = at_all(shooting.step, x[:, k], torques[:, k], step)[0]
    with np.errstate(invalid="ignore"):
        fastest = np.abs(h * x[..., 4:] / shooting.units[:4]).max(axis=(1, 2))
        slow = fastest < TOO_FAST
    return x[slow], torques[slow]
