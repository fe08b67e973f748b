"""Every chart says the same of a motion where it is regular, and one of them is regular wherever the robot is."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.charts import CHARTS
from fivebar.models.robots import nearest_equivalent_angle

ALL = tuple(CHARTS.values())
ROBOT = fb.FiveBar()
CORNER = np.array([0.0, np.sqrt(0.18**2 - 0.059**2)])  # both legs straight


def single(values):
    return tuple(float(value) for value in values)


@pytest.mark.every(2)
@pytest.mark.parametrize("chart", ALL, ids=lambda chart: chart.name)
def test_charts_agree(robot, reachable, chart):
    xi, working = reachable
    for position, modes in zip(xi[:200].tolist(), working[:200].tolist()):
        known = fb.ikm(fb.igm(robot, position, tuple(modes)), (0.2, -0.1))
        rates = chart.rates(robot, *(part for part in chart.coordinates(known)))
        sines = [*known.pose.sines, known.pose.det_A]
        kappa = 1 / np.abs(sines).min() ** 2
        for name in ("q_dot", "xi_dot", "q_passive_dot", "d"):
            expected = getattr(known, name)
            bound = 1e-12 * kappa * (1 + np.abs(expected).max())
            np.testing.assert_allclose(getattr(rates, name), expected, atol=bound, err_msg=name)
        expected = fb.forward_dynamics(known, (0.01, 0.02))
        there = fb.forward_dynamics(rates, (0.01, 0.02))
        for name in ("q_ddot", "xi_ddot", "q_passive_ddot"):
            expected_value = getattr(expected, name)
            bound = 1e-12 * kappa * (1 + np.abs(expected_value).max())
            np.testing.assert_allclose(
                getattr(there, name), expected_value, atol=bound, err_msg=name
            )
        assert (rates.pose.working == modes).all() and rates.pose.assembly == known.pose.assembly
        told = {
            "task": tuple(modes),
            "joint": (int(known.pose.assembly), 0),
            "bars": (0, 0),
        }  # 0: not asked for
        assert chart.coordinates(known)[2] == told[chart.name]


@pytest.mark.every(2)
@pytest.mark.parametrize("chart", ALL, ids=lambda chart: chart.name)
def test_accelerations_do_not_depend_on_where_the_robot_stands(robot, reachable, chart):
    xi, working = reachable
    for position, modes in zip(xi[:200].tolist(), working[:200].tolist()):
        known = fb.ikm(fb.igm(robot, position, tuple(modes)), (0.2, -0.1))
        c = chart.coordinates(known)
        expected, found = (
            np.array(chart.accelerations(fb.forward_dynamics(rates, (0.01, 0.02))))
            for rates in (chart.rates(robot, *c), chart.turned(robot, *c))
        )
        sines = [*known.pose.sines, known.pose.det_A]
        np.testing.assert_allclose(
            found, expected, atol=1e-12 * (1 + np.abs(expected).max()) / np.abs(sines).min() ** 2
        )


@pytest.mark.every(7)
@pytest.mark.parametrize("speed", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("angle", [0.0, 1e-4, -1e-4, 1e-3, -1e-3])
@pytest.mark.parametrize("start", [(0.0, 0.12), (0.02, 0.11), (-0.03, 0.13), (0.0, 0.165)])
@pytest.mark.parametrize("working", [(1, -1), (-1, 1), (-1, -1), (1, 1)])
def test_motions_at_and_past_the_corner_go_through(start, angle, speed, working):
    """Both legs straighten together: of the charts with two coordinates only the joints' is regular there."""
    towards = CORNER - start
    c, s = np.cos(angle), np.sin(angle)
    velocity = speed * np.array([[c, -s], [s, c]]) @ towards / np.linalg.norm(towards)
    rates = fb.ikm(fb.igm(ROBOT, start, working), velocity)
    run = fb.simulate(ROBOT, duration=2 * np.linalg.norm(towards) / speed, start=rates, step=5e-4)
    assert np.abs(run.energy / run.energy[0] - 1).max() <= 1e-6


def test_angles_go_on_in_the_turn_that_is_nearest():
    q, before = np.random.default_rng(3).uniform((-np.pi, -30), (np.pi, 30), (200, 2)).T
    found = nearest_equivalent_angle(ROBOT, q, before)
    assert (np.abs(found - before) <= np.pi).all() and np.ptp(
        np.round((found - q) / (2 * np.pi))
    ) >= 8
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * q), atol=1e-13)
    np.testing.assert_array_equal(
        nearest_equivalent_angle(fb.Biglide(), q, before), q
    )  # lengths do not wrap
