"""The Jacobian J = A^-1 B, and the rates of drives whose guides are inclined."""

from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.dyads import RRP, cross, dot


def test_jacobian_of_floats_batches_and_symbols(robot, reachable):
    xi, working = reachable
    pose = fb.igm(robot, xi, working)
    np.testing.assert_allclose(pose.J, np.linalg.solve(pose.A, pose.B), rtol=1e-9, atol=1e-12)
    rates = fb.dkm(pose, np.ones_like(xi) * (0.3, -0.7))
    np.testing.assert_allclose(pose.J @ (0.3, -0.7), rates.xi_dot, rtol=1e-9, atol=1e-12)
    one = fb.igm(robot, xi[0], working[0])
    assert one.J.shape == (2, 2) and np.array_equal(one.J, pose.J[0])
    symbol = ca.SX.sym("xi", 2)
    modes = tuple(map(int, working[0]))
    function = ca.Function("J", [symbol], [fb.igm(robot, symbol, modes).J])
    np.testing.assert_allclose(np.array(function(xi[0])), one.J, rtol=1e-12)


def test_jacobian_is_nan_at_type_2_alone():
    type_2 = (0.0525327138758270, 0.00430328475849708)
    pose = fb.igm(fb.FiveBar(), np.array([type_2, (0.05, 0.09)]), (-1, -1))
    assert np.isnan(pose.J[0]).all() and np.isfinite(pose.J[1]).all()


class Inclined(NamedTuple):
    """A slider along the unit vector (ex, ey), which no other part of the package knows."""

    x: float
    y: float
    ex: float
    ey: float
    length: float = 1.0

    def direction(self, q):
        return q

    def coordinate(self, direction):
        return direction

    def pivot(self, direction):
        return self.x + direction * self.ex, self.y + direction * self.ey

    def extent(self, direction):
        return abs(self.x) + abs(self.y) + abs(direction)

    def tangent(self, direction):
        return self.ex, self.ey

    def sine(self, direction, distal):
        return dot((self.ex, self.ey), distal)

    def cosine(self, direction, distal):
        return cross(distal, (self.ex, self.ey))

    def velocity_coefficients(self, sine, cosine):
        return sine, cosine

    def acceleration_coefficients(self, sine, cosine):
        return 0.0, 0.0

    def close(self, xi, bar, working):
        return RRP((self.x - xi[0], self.y - xi[1]), bar, (self.ex, self.ey), working)

    def direction_in(self, dyad):
        return dyad.slide

    def distal_in(self, dyad):
        x, y = dyad.first
        return -x, -y

    def limits(self, bar):
        return ((bar, True),)

    def apart(self, x, y):
        return cross((self.ex, self.ey), (x - self.x, y - self.y)), 0.0 * y

    def relative(self, absolute, own):
        return absolute

    def absolute(self, passive, own):
        return passive


@pytest.mark.parametrize("angle", [0.5 * np.pi, 1.2, 1.7])
def test_bars_of_inclined_sliders_turn_as_differences_of_their_angles(angle, monkeypatch):
    robot = fb.Biglide()
    e = np.cos(angle), np.sin(angle)
    drives = tuple(Inclined(drive.x, drive.y, *e) for drive in robot.drives)
    monkeypatch.setattr(type(robot), "drives", property(lambda self: drives))
    xi, velocity, acceleration = np.array([0.03, 0.25]), np.array([0.2, -0.1]), np.array([0.7, 0.4])

    def pose_at(t):
        return fb.igm(robot, xi + velocity * t + acceleration * t * t / 2, (-1, -1))

    def angles(t):
        return np.array([np.arctan2(u[1], u[0]) for u in pose_at(t).u2])

    h = 1e-4
    rates = fb.ikm(pose_at(0.0), velocity)
    accelerations = fb.ikm2(rates, acceleration)
    first = (angles(h) - angles(-h)) / (2 * h)
    second = (angles(h) - 2 * angles(0.0) + angles(-h)) / h**2
    np.testing.assert_allclose(rates.phi_dot, first, rtol=1e-6)
    np.testing.assert_allclose(accelerations.phi_ddot, second, rtol=1e-5)
    again = fb.dkm2(fb.dkm(rates.pose, rates.q_dot), accelerations.q_ddot)
    np.testing.assert_allclose(again.rates.phi_dot, first, rtol=1e-6)
    np.testing.assert_allclose(again.phi_ddot, second, rtol=1e-5)
