"""What fixed steps are refused for, each check without the others; and how long the chosen steps are."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.charts import CHARTS
from fivebar.simulation.fixed_plant import refuse_losses
from fivebar.simulation.plant import Plant
from fivebar.simulation.simulate import Grid
from fivebar.simulation.steps import COLUMNS, ENERGY, MARGIN_RATES, MARGINS, Q_DOT, XI, between
from fivebar.simulation.stick_slip import _powers

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
    with pytest.raises(
        fb.SingularityError, match="jumps the singularity of the joint chart .det A"
    ):
        refuse(rows(margin=0.1 * side, rate=-0.1 * side / (1.49 * STEP)))
    refuse(
        rows(margin=0.1 * side, rate=-0.1 * side / (1.49 * STEP)), "auto"
    )  # whose chart has no margin


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("chart", ["joint", "auto"])
def test_a_step_may_lose_a_thousandth_of_the_energy_that_it_turns_over(chart, side):
    refuse(rows(energy=(1.0, 1.0, 1.0 + 1.99e-3 * side)), chart)
    kind = fb.SingularityError if chart == "joint" else ArithmeticError
    with pytest.raises(kind, match="t = 0.001 s"):
        refuse(rows(energy=(1.0, 1.0, 1.0 + 2.01e-3 * side)), chart)


def test_where_nothing_moves_each_step_may_err_by_the_rounding_of_its_own_torque():
    seen, tau = rows(energy=(0.0, 0.9e-14, 0.9e-14)), np.array([[0.6, -0.4], [0.0, 0.0]])
    refuse_losses(fb.FiveBar(), seen, tau, CHARTS["auto"], STEP)
    for energy in ((0.0, 1.1e-14, 1.1e-14), (0.0, 0.0, 0.9e-14)):
        with pytest.raises(ArithmeticError):
            refuse_losses(fb.FiveBar(), rows(energy=energy), tau, CHARTS["auto"], STEP)


@pytest.mark.parametrize(
    "robot, drops",
    [
        (fb.FiveBar(gravity=(0.0, -9.81)), 0.5 * 9.81 * 0.01),
        (fb.FiveBar(gravity=(-3.0, 0.0)), 0.0),
        (
            fb.FiveBar(fv1=8.0, fv2=2.0),
            -STEP * (8.0 * (0.3**2 + 0.3 * 1.3 + 1.3**2) + 2.0 * (0.4**2 + 0.4 * 1.4 + 1.4**2)) / 3,
        ),
    ],
)
def test_what_falls_gains_and_what_rubs_loses(robot, drops):
    """The balance at rest in the joints: m g h on the way down, what viscous friction takes where
    rates change evenly."""

    def seen(more):
        found = rows(energy=(0.1, 0.1 + drops + more, 0.1 + 2 * drops + more))
        found[:, Q_DOT] = (0.3, 0.4), (1.3, 1.4), (0.3, 0.4)
        found[:, XI] = (0.0, 0.15), (0.0, 0.14), (0.0, 0.13)
        return found

    turned = 0.2 + drops + abs(drops)
    refuse_losses(robot, seen(0.99e-3 * turned), np.zeros((2, 2)), CHARTS["auto"], STEP)
    with pytest.raises(ArithmeticError, match="t = 0 s"):
        refuse_losses(robot, seen(1.02e-3 * turned), np.zeros((2, 2)), CHARTS["auto"], STEP)


def test_a_refusal_has_the_figures_of_its_step():
    seen = rows(energy=(1.0, 1.0, 2.0))
    seen[1, XI], seen[1, Q_DOT], seen[1, MARGINS] = (0.01, 0.02), (3.0, -4.0), (0.5, 0.25, 0.31)
    tau = np.array([[0.0, 0.0], [5.0, 6.0]])
    with pytest.raises(ArithmeticError) as told:
        refuse_losses(fb.FiveBar(), seen, tau, CHARTS["joint"], STEP)
    assert str(told.value) == (
        "the motion at t = 0.001 s, xi = (0.01, 0.02) m is too fast for steps of 0.001 s (joint rates 3, -4 rad/s, "
        "torques 5, 6 N m): simulate(...) without integrator= chooses its steps, and says where gains are"
        " unstable"
    )
    seen[1, MARGINS] = -0.5, 0.25, 0.3
    for chart, sine, value in (("joint", "det A", 0.3), ("task", "sin q22", 0.25)):
        with pytest.raises(fb.SingularityError) as told:
            refuse_losses(fb.FiveBar(), seen, tau, CHARTS[chart], STEP)
        assert told.value.margin == value and str(told.value) == (
            f"the step from t = 0.001 s, xi = (0.01, 0.02) m jumps the singularity of the {chart} chart "
            f'({sine} = {value}): chart="auto" has none'
        )


def test_chosen_steps_are_few_and_as_many_as_order_8_asks_for():
    start, counts = fb.ikm(fb.igm(fb.FiveBar(), (0.01, 0.12), (1, -1)), (0.02, -0.3)), []
    for tolerance in (1e-13, 1e-11, 1e-9):
        plant, tried = Plant(fb.FiveBar(), start, tolerance), []
        step = plant._step
        plant._step = lambda *inputs, step=step, tried=tried: (
            tried.append(inputs[2]) or step(*inputs)
        )
        plant.advance(2.0, np.zeros(2))
        assert (
            plant.t == 2.0
            and len(tried) <= 1.3 * len(plant.pieces[0])
            and plant.pieces[1].sum() == pytest.approx(2)
        )
        counts.append(len(plant.pieces[0]))
    assert np.log10(counts[0] / counts[2]) == pytest.approx(4 / 8, abs=0.05)
    plant = Plant(fb.FiveBar(), start, 1e-12)
    for k in range(50):  # one step for each period that is shorter than a step
        plant.advance(0.01 * (k + 1), np.zeros(2))
    assert len(plant.pieces[0]) == 50


@pytest.mark.parametrize("until", [3e-13, 5e-10, 1e-8, 2e-5])
def test_times_as_short_as_one_likes_are_moved_on_by(until):
    """From rest by the acceleration times the time, at the time itself to the last bit, and no more from there."""
    robot, tau = fb.FiveBar(), np.array([0.02, -0.03])
    start = fb.dkm(fb.dgm(robot, (0.1, 0.2)), (0.0, 0.0))
    plant = Plant(robot, start, 1e-12)
    plant.advance(until, tau)
    assert plant.t == until
    assert plant.joints[1] == pytest.approx(
        until * fb.forward_dynamics(start, tau).q_ddot, rel=1e-6
    )
    state, count = plant.state, len(plant.pieces[0])
    plant.advance(until, tau)
    assert plant.state is state and len(plant.pieces[0]) == count


def test_a_steps_polynomial_nested_and_in_powers_of_the_place():
    draw, places = np.random.default_rng(4), np.linspace(0.0, 1.0, 9)
    state, coefficients = draw.normal(size=8), draw.normal(size=(7, 8))
    powers = np.polynomial.polynomial.polyval(places, _powers().T @ coefficients)
    np.testing.assert_allclose(
        between(state, np.array([coefficients] * 9), places), state + powers.T, atol=1e-13
    )


def test_how_long_a_run_is_that_is_not_told():
    assert Grid.of(None, SimpleNamespace(start=0.5, duration=1.5), 1e-3, 0.01) == (2000, 1e-3, 10)
    for half in ({"start": 0.0}, {"duration": 1.0}):
        with pytest.raises(ValueError, match="needs a duration, or a reference that has one"):
            Grid.of(None, SimpleNamespace(**half), 1e-3, None)
