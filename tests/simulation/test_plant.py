"""What fixed steps are refused for: each of the two checks without the other."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.charts import CHARTS
from fivebar.simulation.plant import refuse_losses
from fivebar.simulation.steps import COLUMNS, ENERGY, MARGIN_RATES, MARGINS

STEP = 1e-3


def rows(energy=(1.0, 1.0, 1.0), margin=0.2, rate=0.0):
    """Observations of three steps at rest in the joints, with these energies, sines and rates of det A's."""
    seen = np.zeros((3, COLUMNS))
    seen[:, ENERGY], seen[:, MARGINS] = energy, 0.2
    seen[:, MARGINS.stop - 1], seen[:, MARGIN_RATES.stop - 1] = margin, rate
    return seen


def refuse(seen, chart="joint"):
    refuse_losses(fb.FiveBar(), seen, np.zeros((2, 2)), CHARTS[chart], STEP)


@pytest.mark.parametrize("side", [1, -1])
def test_a_chart_ends_where_its_margin_would_vanish_in_one_and_a_half_steps(side):
    refuse(rows(margin=0.1 * side, rate=-0.1 * side / (1.51 * STEP)))
    refuse(rows(margin=0.1 * side, rate=0.1 * side / (0.1 * STEP)))
    with pytest.raises(fb.SingularityError, match="jumps the singularity of the joint chart .det A"):
        refuse(rows(margin=0.1 * side, rate=-0.1 * side / (1.49 * STEP)))
    refuse(rows(margin=0.1 * side, rate=-0.1 * side / (1.49 * STEP)), "auto")  # whose chart has no margin


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("chart", ["joint", "auto"])
def test_a_step_may_lose_a_thousandth_of_the_energy_that_it_turns_over(chart, side):
    refuse(rows(energy=(1.0, 1.0, 1.0 + 1.99e-3 * side)), chart)
    kind = fb.SingularityError if chart == "joint" else ArithmeticError
    with pytest.raises(kind, match="t = 0.001 s"):
        refuse(rows(energy=(1.0, 1.0, 1.0 + 2.01e-3 * side)), chart)
