"""Enclosures along a path: series against mpmath's, and torques on stretches against the models'."""

import mpmath
import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line
from fivebar.paths.timing.bounds import Stretches, enclosed
from fivebar.paths.timing.enclosures import TERMS, Series, place_series
from tests.helpers.paths_to_time import ROBOTS, bezier

CURVE = bezier([(-0.03, 0.09), (-0.02, 0.13), (0.0, 0.06), (0.02, 0.13), (0.03, 0.1)], 0.1)
PIECES = {
    "line": Line((-0.03, 0.08), (0.03, 0.1)),
    "arc": Arc((0.0, 0.1), 0.02, 0.3, 2.5),
    "curve": CURVE,
}

FUNCTIONS = {  # of a series, and of a number
    "product": (lambda s: s * (s + 2.0) - 3.0 * s, lambda x: x * (x + 2) - 3 * x),
    "quotient": (lambda s: (1.0 + s) / (s * s + 2.0), lambda x: (1 + x) / (x * x + 2)),
    "root": (lambda s: (s * s + 1.0).sqrt() / 7.0, lambda x: mpmath.sqrt(x * x + 1) / 7),
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("radius", [0.0, 1e-3, 0.05])
def test_a_series_holds_the_taylor_coefficients_at_all_places_of_its_stretch(name, radius):
    of_series, of_number = FUNCTIONS[name]
    middle = np.linspace(-0.8, 0.9, 7)
    m, r = np.zeros((2, TERMS, 7))
    m[0], m[1], r[0] = middle, 1.0, radius
    found = of_series(Series(m, r))
    with mpmath.workdps(40):
        for k, place in enumerate(middle):
            for share in (-1.0, -0.3, 0.7, 1.0):
                true = mpmath.taylor(
                    of_number, mpmath.mpf(place) + mpmath.mpf(share) * mpmath.mpf(radius), TERMS - 1
                )
                off = [abs(a - b) for a, b in zip(true, found.m[:, k].tolist())]
                assert all(o <= bound for o, bound in zip(off, found.r[:, k].tolist())), (
                    place,
                    share,
                    off,
                )
    if radius == 0:
        assert found.r.max() < 1e-12


def test_what_may_be_divided_by_0_or_has_no_root_is_nan():
    m, r = np.array([[0.01, 0.1], [1.0, 1.0]]), np.array([[0.02, 0.02], [0.0, 0.0]])
    for found in (Series(m, r).inverse(), Series(m, r).sqrt()):
        assert np.isnan(found.m[:, 0]).all() and np.isfinite(found.m[:, 1]).all()


@pytest.mark.parametrize("name", PIECES)
def test_the_place_and_its_derivatives_are_enclosed(name):
    path = Path((PIECES[name],))
    edges = np.linspace(0.0, path.length, 14)
    x, y = place_series(path, np.zeros(13, int), edges[:-1], edges[1:], TERMS)
    for share in np.linspace(0, 1, 9):
        found = path(edges[:-1] + share * np.diff(edges))
        for order, factorial in enumerate((1, 1, 2, 6)):
            for axis, series in enumerate((x, y)):
                off = np.abs(found[order][:, axis] / factorial - series.m[order])
                assert (off <= series.r[order] + 1e-15 * np.abs(series.m[order])).all()


def bernstein(value, t):
    middle = (
        value.first[:, None] * (1 - t) ** 2
        + 2 * value.middle[:, None] * t * (1 - t)
        + value.last[:, None] * t**2
    )
    return middle, value.bend[:, None] * t * (1 - t) + value.slack[:, None]


@pytest.mark.parametrize("name", ROBOTS)
def test_torques_are_enclosed_on_stretches(name):
    """det A tau = a u + b x + v sqrt(x) + c + f sigma, with the room that is said, against `inverse_dynamics`."""
    robot = ROBOTS[name][0]
    path = Path((Arc((0.0, 0.2), 0.03, 0.3, 2.5) if name == "biglide" else PIECES["curve"],))
    edges = np.linspace(0.0, path.length, 161)
    stretches = Stretches(np.zeros(160, int), edges[:-1], edges[1:])
    found, t = enclosed(robot, path, stretches, (-1, -1)), np.linspace(0.05, 0.95, 7)
    s = edges[:-1, None] + np.diff(edges)[:, None] * t
    xi, xi_s, xi_ss, _ = path(s.ravel())
    for u, speed in ((0.3, 0.5), (-2.0, 0.1), (0.0, 1.0)):
        acc = fb.ikm2(fb.ikm(fb.igm(robot, xi), xi_s * speed), xi_s * u + xi_ss * speed**2)
        tau, det_A = fb.inverse_dynamics(acc), acc.rates.pose.det_A
        for leg in (0, 1):
            turns = np.sign(acc.rates.q_dot[:, leg]).reshape(s.shape)
            middle = room = 0.0
            for part, factor in (("a", u), ("b", speed**2), ("v", speed), ("c", 1.0), ("f", turns)):
                if f"{part}{leg + 1}" in found:
                    value, open_ = bernstein(found[f"{part}{leg + 1}"], t)
                    middle, room = middle + value * factor, room + open_ * np.abs(factor)
            true = (det_A * tau[:, leg]).reshape(s.shape)
            assert (np.abs(true - middle) <= room + 1e-14).all()
            assert room.max() < 0.02 * np.abs(true).max()
        for what, true in (
            ("D", det_A),
            ("q1", acc.rates.q_dot[:, 0] / speed),
            ("w2", (acc.rates.q_dot[:, 1] / speed) ** 2),
        ):
            middle, room = bernstein(found[what], t)
            assert (np.abs(true.reshape(s.shape) - middle) <= room + 1e-13 * np.abs(middle)).all()
