"""Profile likelihood: how far an unknown can go before the best fit of all others is much worse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

if TYPE_CHECKING:
    from .result import Calibration


def profile(found: Calibration, name: str, far: float) -> tuple[float, float]:
    """Return (low, high) where chi2 has risen by far^2 times the variance; inf where it never does.

    Bates and Watts, Nonlinear Regression Analysis and Its Applications, 1988, ch. 6.
    """
    value, step = found.values[name], found.sd[name]
    if not np.isfinite(step):
        return -np.inf, np.inf
    limit = far * far * found.variance

    def excess(at):
        return found.refit({name: at}) - found.chi2 - limit

    def side(sign):
        near, reach = value, far * step
        for _ in range(60):
            end = value + sign * reach
            risen = excess(end)
            if np.isinf(risen):  # beyond what the robot reaches: nearer
                reach = (reach + abs(near - value)) / 2
                if abs(reach - abs(near - value)) < 1e-9 * reach:
                    return end
            elif risen > 0:
                return brentq(excess, near, end, xtol=1e-6 * step)
            else:
                near, reach = end, 1.5 * reach
        return sign * np.inf

    return side(-1), side(1)
