"""The equations of a measured robot against `fivebar.dgm`, and their derivatives against differences in 40 digits."""

import mpmath as mp
import numpy as np
import pytest

from fivebar.estimation.calibration.measured_robot import (
    UNKNOWNS,
    bars_off,
    frame,
    seen,
    sines_at,
    unframe,
    values_of,
)
from tests.helpers.twins import LAB, NOMINAL, poses, twin
from tests.helpers.twins import seen as seen_by_hand


def exact(p, q, assembly):
    """The point seen, of 16 values and two readings, in mpmath: two circles met on paper."""
    l11, l12, l21, l22, d, o1, o2, r1, r2, x0, y0, turn, scale, along_bar, across, leg = p
    left = mp.mpc(-d / 2, 0) + l11 * mp.expj(r1 * q[0] + o1)
    right = mp.mpc(d / 2, 0) + l21 * mp.expj(r2 * q[1] + o2)
    span = right - left
    c = abs(span)
    along = (l12**2 - l22**2 + c**2) / (2 * c)
    height = mp.sqrt(l12**2 - along**2)
    # Assembly -1: left of the line from the left elbow to the right one.
    xi = left + span / c * mp.mpc(along, -assembly * height)
    elbow = left if leg == 1 else right
    xi += mp.mpc(along_bar, across) * (xi - elbow) / abs(xi - elbow)
    seen = mp.mpc(x0, y0) + scale * mp.expj(turn) * xi
    return seen.real, seen.imag


def exact_jacobian(p, q, assembly):
    """(2 n, 15) in mpmath, by central differences good to 50 digits at 80."""
    step = mp.mpf(10) ** -25
    rows = mp.matrix(2 * len(q), 15)
    for k in range(15):
        up, down = ([v + s * step * (j == k) for j, v in enumerate(p)] for s in (1, -1))
        for n in range(len(q)):
            high, low = exact(up, q[n], assembly[n]), exact(down, q[n], assembly[n])
            for axis in (0, 1):
                rows[2 * n + axis, k] = (high[axis] - low[axis]) / (2 * step)
    return rows


@pytest.fixture
def some():
    rng = np.random.default_rng(4)
    true = twin(rng, NOMINAL, spread=20.0)
    q, points, assembly, working = seen_by_hand(true, poses(true, 12, rng))
    p = values_of(NOMINAL, {name: true[name] for name in UNKNOWNS if name in true})
    return p, q, points, assembly, working


def test_points_are_those_of_dgm(some):
    p, q, points, assembly, _ = some
    assert np.abs(seen(p, q, assembly)[0] - points).max() < 1e-15


def test_derivatives_to_rounding(some):
    p, q, _, assembly, _ = some
    with mp.workdps(80):
        right = exact_jacobian([mp.mpf(float(v)) for v in p], q.tolist(), assembly.tolist())
        right = np.array(right.tolist(), float).reshape(len(q), 2, -1)
    assert np.abs(seen(p, q, assembly)[1] - right).max() < 1e-14
    with_tool = [*p[:13].tolist(), 0.013, -0.007, 2.0]
    with mp.workdps(80):
        right = exact_jacobian([mp.mpf(v) for v in with_tool], q.tolist(), assembly.tolist())
        right = np.array(right.tolist(), float).reshape(len(q), 2, -1)
    assert np.abs(seen(np.array(with_tool), q, assembly)[1] - right).max() < 1e-14


def test_bars_close_on_the_true_points_and_their_derivatives(some):
    p, q, points, _, _ = some
    assert np.abs(bars_off(p, q, points)[0]).max() < 1e-16
    near = points + np.array([1e-3, -2e-3])
    _, slope = bars_off(p, q, near)
    for k in range(15):
        step = np.zeros(len(p))
        step[k] = 1e-6
        central = (bars_off(p + step, q, near)[0] - bars_off(p - step, q, near)[0]) / 2e-6
        assert np.abs(central - slope[:, :, k]).max() < 1e-9


def test_modes_are_read_off_the_point(some):
    p, q, points, assembly, working = some
    signs = -np.sign(sines_at(p, q, points))
    assert (signs == np.column_stack([working, assembly])).all()


def test_what_does_not_close_is_nan():
    points, slopes = seen(values_of(LAB), np.array([[np.pi, 0.0], [0.2, -0.1]]), np.array([-1, -1]))
    assert np.isnan(points[0]).all() and np.isnan(slopes[0]).any() and np.isfinite(points[1]).all()


def test_frame_and_back(some):
    p, _, points, _, _ = some
    z = points @ (1, 1j)
    assert np.abs(frame(p, unframe(p, z)) - z).max() < 1e-15
