"""A motion along a path in a given time, with forces as small as that allows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from ...base.progress import progress
from .lower_bound import duration as taken
from .solve import Solved, TimingError, hints_of, solve

if TYPE_CHECKING:
    from .constraint_rows import Limits
    from .mesh import Mesh

CLOSE = 1e-4  # to which the share of the limits is found
STEPS = 40


def slowed(mesh: Mesh, limits: Limits, known: Solved, wanted: float) -> Solved:
    """Return a motion that takes `wanted` s of moving, where `known` takes less: limits on torques
    and accelerations times the least share.

    The share is found by halving; the last step between two motions, one a little too fast and one
    a little too slow, is a mixture x = (1 - w) x_1 + w x_2 of their squares of the speed. Torques
    and accelerations of a mixture are the mixtures of theirs (with viscous friction nearly), and
    where both pass Type 2, so does it.
    """
    fast = known
    slow = None
    low = 0.0
    high = 1.0
    guess = (fast.time.sum() / wanted) ** 2
    along, bent, above = hints_of(mesh, known)
    for _ in progress(range(STEPS), desc="given time", unit=" motions", delay=2, leave=False):
        share = math.sqrt(low * high) if low else guess
        # x is about so much smaller, and so is how it is bent.
        found = _solved(mesh, limits.times(share), np.stack([along, share * bent, above]))
        if found is not None and found.time.sum() <= wanted:
            high = share
            fast = found
            guess = share * (found.time.sum() / wanted) ** 2 * (1 - CLOSE)
        else:
            low = share
            slow = found
        if low and high / low < 1 + CLOSE:
            break
    length = mesh.stretches.length
    if slow is None:
        slow = _slower(mesh, fast, wanted)
    x, bent, time = _mixture(length, fast, slow, wanted)
    return known._replace(x=x, bent=bent, time=time)


def _solved(mesh, limits, hints):
    try:
        found = solve(mesh, limits, hints)
    except TimingError:
        return None
    return found if math.isfinite(found.gap) else None


def _slower(mesh, fast, wanted):
    """Return the motion at a slower pace: all that grows with the speed becomes smaller; it must be
    held at rest, too.
    """
    has_gravity = any(name in mesh.found for name in ("c1", "c2"))
    if has_gravity and mesh.crossing.any():
        k = int(np.argmax(mesh.crossing))
        raise TimingError(
            f"time_path: no motion was found that takes {wanted:.6g} s of moving: with gravity it"
            f" has to pass Type 2 at {mesh.place(k)} at speed; the slowest one found takes"
            f" {fast.time.sum():.6g} s",
            float(mesh.s[k]),
            False,
        )
    share = (fast.time.sum() / (1.001 * wanted)) ** 2
    return fast._replace(
        x=share * fast.x, bent=share * fast.bent, time=fast.time / math.sqrt(share)
    )


def _mixture(length, fast, slow, wanted):
    """x, bent and the times of the mixture of two motions that takes so long."""

    def mixed(w):
        x = (1 - w) * fast.x + w * slow.x
        bent = (1 - w) * fast.bent + w * slow.bent
        return x, bent, taken(length, x[:-1], x[1:], bent)

    return mixed(brentq(lambda w: mixed(w)[2].sum() - wanted, 0.0, 1.0))
