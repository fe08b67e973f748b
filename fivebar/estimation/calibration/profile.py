"""Profile likelihood: how far an unknown can go before the best fit of all others is much worse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

if TYPE_CHECKING:
    from .result import Calibration


def profile(found: Calibration, name: str, far: float) -> tuple[float, float]:
    """Return (low, high): where chi2 has risen by far^2 times the variance, or the robot no
    longer closes; inf where neither is.

    Bates and Watts, Nonlinear Regression Analysis and Its Applications, 1988, ch. 6.
    """
    value = found.values[name]
    step = found.sd[name]
    if not np.isfinite(step):
        return -np.inf, np.inf
    exact = 1e-6 * step
    limit = far * far * found.variance

    def side(sign):
        def excess(way):
            return found.refit({name: value + sign * way}) - found.chi2 - limit

        near = 0.0
        wall = np.inf
        reach = far * step
        for _ in range(60):
            risen = excess(reach)
            if risen == np.inf:  # beyond what the robot reaches
                wall = reach
            elif risen > 0:
                return value + sign * brentq(excess, near, reach, xtol=exact)
            else:
                near = reach
            if wall - near < exact:
                break
            reach = min(1.5 * reach, (near + wall) / 2)
        return value + sign * wall

    return side(-1), side(1)
