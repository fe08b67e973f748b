"""The package's colours and lines for plots of one's own with `matplotlib.pyplot`."""

from __future__ import annotations

import matplotlib
from cycler import cycler

from ..style import AMBER, BLACK, BLUE, GREEN, ORANGE, PINK, SKY
from .panels import STYLES

# In this order the first four are told apart best by eyes that confuse red and green.
CYCLE = BLUE, ORANGE, GREEN, BLACK, SKY, AMBER, PINK


def use_style() -> None:
    """Let all later plots of this session have the package's colours and lines.

    The first colours are blue for the left leg and orange for the right. Colour-blind readers can
    tell all of them apart.

    References
    ----------
    Okabe, Ito: Color universal design, 2008.

    Examples
    --------
    >>> import fivebar as fb
    >>> import matplotlib
    >>> with matplotlib.rc_context():  # so that the style ends with this example
    ...     fb.plot.use_style()
    ...     matplotlib.rcParams["axes.prop_cycle"].by_key()["color"][:2]
    ['#0072B2', '#D55E00']
    """
    matplotlib.rcParams |= {
        "axes.prop_cycle": cycler(color=CYCLE),
        "axes.axisbelow": True,
        "axes.grid": True,
        "grid.alpha": 0.25,
        "image.cmap": "cividis",
        "legend.fontsize": 8,
        "legend.frameon": False,
        "lines.linewidth": STYLES["line.medium"]["lw"],
    }
