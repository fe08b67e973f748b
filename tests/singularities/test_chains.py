"""Motions of closed four-bars against triangles that are solved anew for each place of a crank."""

from itertools import permutations, product

import casadi
import numpy as np
import pytest

from fivebar.base.backend import as_numbers
from fivebar.singularities.four_bar_motion import Turning, aligned, closures, four_bar_directions

CHAINS = {
    "grashof": [*permutations((1.0, 2.1, 2.9, 3.3))],
    "not grashof": [*permutations((1.0, 1.7, 2.2, 3.3))],
    "change point": [*permutations((0.1, 0.2, 0.3, 0.4))],
    "nearly": [*permutations((0.1, 0.2, 0.3, 0.4 + 1e-12))][::2]
    + [*permutations((0.1, 0.2, 0.3, 0.4 - 1e-12))][::2],
    "two equal": [
        *sorted({*permutations((0.1, 0.1, 0.3, 0.3))}),
        *sorted({*permutations((0.3, 0.3, 0.4, 0.1))}),
    ],
    "three equal": [
        *sorted({*permutations((0.2, 0.2, 0.2, 0.1))}),
        *sorted({*permutations((0.2, 0.2, 0.2, 0.5))}),
    ],
    "rhombus": [(0.3, 0.3, 0.3, 0.3)],
    "scaled": [(1e-4, 1.1e-4, 1.2e-4, 1.3e-4), (100.0, 130.0, 110.0, 120.0)],
    "without a base": [(0.0, 0.3, 0.2, 0.4)],
}
EACH = [pytest.param(chains, id=name) for name, chains in CHAINS.items()]
# Sides: of all motions, which of e1, e2, u turn.
SPECIAL = {
    **dict.fromkeys(permutations((0.1, 0.2, 0.3, 0.6)), [(0, 0, 0)]),
    **dict.fromkeys(permutations((0.1, 0.2, 0.3, 0.61)), []),
    (0.0, 0.3, 0.2, 0.4): [(1, 1, 1)] * 2,
    (0.0, 0.3, 0.7, 0.4): [(1, 1, 1)],
    (0.0, 0.3, 0.1, 0.4): [(1, 1, 1)],
    (0.0, 0.4, 0.1, 0.3): [(1, 1, 1)],
    (0.0, 0.3, 0.05, 0.4): [],
    (0.0, 0.3, 0.8, 0.4): [],
    (0.5, 0.3, 0.0, 0.4): [(0, 0, 1)] * 2,
    (0.7, 0.3, 0.0, 0.4): [(0, 0, 1)],
    (0.1, 0.3, 0.0, 0.4): [(0, 0, 1)],
    (0.8, 0.3, 0.0, 0.4): [],
    (0.5, 0.0, 0.3, 0.4): [(1, 0, 0)] * 2,
    (0.5, 0.0, 0.9, 0.4): [(1, 0, 0)],
    (0.5, 0.0, 1.0, 0.4): [],
    (0.5, 0.3, 0.4, 0.0): [(0, 1, 0)] * 2,
    (0.5, 0.3, 0.2, 0.0): [(0, 1, 0)],
    (0.5, 0.3, 0.1, 0.0): [],
    (0.3, 0.3, 0.3, 0.3): [(1, 1, 0), (1, 0, 1), (0, 1, 1)],
    (0.0, 0.3, 0.0, 0.3): [(1, 1, 0)],
    (0.0, 0.3, 0.0, 0.4): [],
    **dict.fromkeys(
        [(0.0, 0.0, 0.3, 0.3), (0.0, 0.3, 0.3, 0.0), (0.3, 0.0, 0.0, 0.3), (0.3, 0.3, 0.0, 0.0)], []
    ),
    (0.3, 0.0, 0.3, 0.0): [],
}


def closed_with(sides, e1):
    """(e2, u), two rows of them, that close the chain with this first crank, by the cosine rule."""
    base, r1, c, r2 = sides
    span = r1 * e1 - base
    cosine = (abs(span) ** 2 + r2**2 - c**2) / (2 * abs(span) * r2)
    if abs(cosine) > 1:
        return np.empty((0, 2))
    e2 = span / abs(span) * np.exp(1j * np.arccos(cosine) * np.array([1, -1]))
    return np.stack([e2, (r2 * e2 - span) / c], axis=1)


def passed(motion, crank, turn, k=2):
    """Parameters, to rounding, at which direction k is turned by `turn` against that crank (-1: against x)."""

    def relative(t):
        directions, rates = motion(t)
        if crank < 0:
            return directions[k] / turn, rates[k]
        return directions[k] / (directions[crank] * turn), rates[k] - rates[crank]

    t = np.linspace(0.013, 0.013 + motion.period, 1001)
    sine, cosine = relative(t)[0].imag, relative(t)[0].real
    at = np.flatnonzero((np.sign(sine[1:]) != np.sign(sine[:-1])) & (cosine[1:] > 0))
    found = t[at] - sine[at] * (t[at + 1] - t[at]) / (sine[at + 1] - sine[at])
    for _ in range(3):
        z, rate = relative(found)
        found = found - z.imag / rate
    return np.sort(found % motion.period)


def apart(found, period=2 * np.pi):
    """Sorted parameters; what comes as two counts once, also at the two ends of the period."""
    found = np.sort((np.array(found) + 1e-7) % period - 1e-7)
    return found[np.diff(found, prepend=-1) > 1e-7]


def residual(sides, directions):
    base, r1, c, r2 = sides
    e1, e2, u = directions
    return np.abs(base + r2 * e2 - r1 * e1 - c * u) / sum(sides)


@pytest.mark.parametrize("chains", [*EACH, pytest.param([*SPECIAL], id="special")])
def test_directions_close_the_chain_and_turn_as_their_rates_say(chains):
    for sides in chains:
        for motion in closures(*sides):
            t = np.concatenate(
                [np.random.default_rng(1).uniform(0, motion.period, 60), [0.0, motion.period / 2]]
            )
            directions, rates = motion(t)
            assert residual(sides, directions).max() < 4e-16
            np.testing.assert_allclose(np.abs(directions), 1, rtol=0, atol=1e-15)
            ends, _ = motion(np.array([0.0, motion.period]))
            np.testing.assert_allclose(np.diff(ends), 0, atol=1e-14)
            h = 1e-5
            after, before = motion(t[:-2] + h)[0], motion(t[:-2] - h)[0]
            for later, earlier, rate in zip(after, before, rates, strict=True):
                known = np.abs(rate[:-2]) < 20  # of a chain that nearly folds all happens at once
                slope = (np.angle(later / earlier) / (2 * h))[known]
                np.testing.assert_allclose(slope, rate[:-2][known], rtol=0, atol=1e-5)


@pytest.mark.parametrize("chains", EACH)
def test_every_place_of_a_crank_is_passed_as_often_as_its_triangle_closes(chains):
    """So the motions are all there are, each once."""
    for sides in chains:
        motions = closures(*sides)
        for e1 in np.exp(1j * np.random.default_rng(2).uniform(-3, 3, 2)):
            found = []
            for motion in motions:
                directions, _ = motion(passed(motion, -1, e1, k=0))
                found += [*zip(*directions[1:])]
            wanted = closed_with(sides, e1)
            assert len(found) == len(wanted), sides
            if len(found):
                off = np.abs(np.array(found)[:, None] - wanted).max(axis=-1)
                assert off.min(axis=0).max() < 1e-6 and off.min(axis=1).max() < 1e-6


@pytest.mark.parametrize(
    "chains", [*EACH, pytest.param([*SPECIAL, *SPECIAL, *SPECIAL], id="special")]
)
def test_a_motion_meets_an_angle_between_coupler_and_crank_wherever_that_passes_it(chains):
    ways = [
        (k % 2, np.exp(1j * a)) for k, a in enumerate(np.random.default_rng(6).uniform(-3, 3, 6))
    ]
    for sides in chains[::3]:
        for motion in closures(*sides):
            for (crank, turn), found in zip(ways, motion.meets(ways), strict=True):
                np.testing.assert_allclose(
                    apart(found), passed(motion, crank, turn), rtol=0, atol=1e-9
                )
                ends, _ = motion(np.array(found))
                np.testing.assert_allclose(ends[2] / (ends[crank] * turn), 1, rtol=0, atol=4e-15)


@pytest.mark.parametrize(
    "chains", [CHAINS["grashof"], CHAINS["not grashof"], CHAINS["nearly"][::5]]
)
def test_bars_are_in_line_wherever_they_pass_each_other(chains):
    for sides in chains:
        for motion in closures(*sides):
            wanted = np.sort(
                np.concatenate(
                    [passed(motion, crank, turn) for crank in (0, 1) for turn in (1, -1)]
                )
            )
            np.testing.assert_allclose(
                apart(aligned(motion), motion.period),
                apart(wanted, motion.period),
                rtol=0,
                atol=1e-7,
            )
            (e1, e2, u), _ = motion(np.array(aligned(motion)))
            assert np.minimum(np.abs((u / e1).imag), np.abs((u / e2).imag)).max(initial=0) < 1e-14


def test_bars_of_one_length_meet_where_they_coincide():
    """Of crank 2 and coupler nothing is left there: the base is as long as crank 1, or it is not so."""
    for sides in permutations((0.3, 0.3, 0.4, 0.2)):
        for motion in closures(*sides):
            for crank, turn in product((0, 1), (1.0, -1.0)):
                (found,) = motion.meets([(crank, turn)])
                np.testing.assert_allclose(
                    apart(found), passed(motion, crank, turn), rtol=0, atol=1e-9
                )


@pytest.mark.parametrize("scale", [1.0, 1e-3, 7.3])
def test_special_chains_are_told_to_rounding(scale):
    rng = np.random.default_rng(3)
    for sides, turns in SPECIAL.items():
        for _ in range(4):
            near = scale * np.array(sides) * (1 + 4e-16 * rng.uniform(-1, 1, 4))
            motions = closures(*map(float, near))
            assert [motion.turns for motion in motions] == turns, near
            for motion in motions:
                assert residual(near, motion(rng.uniform(0, motion.period, 9))[0]).max() < 1e-14
        for k in np.flatnonzero(sides):  # a billionth of a billionth is another chain
            other = scale * np.array(sides)
            other[k] *= 1 + 1e-12
            for motion in closures(*map(float, other)):
                assert residual(other, motion(rng.uniform(0, motion.period, 9))[0]).max() < 4e-16


def test_symbols_say_what_numbers_say():
    for sides in (
        *CHAINS["change point"][::5],
        *CHAINS["grashof"][::5],
        *CHAINS["not grashof"][::5],
    ):
        for motion in closures(*sides):
            if isinstance(motion, Turning) or motion.mirrored:
                continue
            own = motion.base, motion.r1, motion.c, motion.r2
            t, slack, span = casadi.SX.sym("t"), casadi.SX.sym("slack", 4), casadi.SX.sym("span")
            with as_numbers():
                units, rates = four_bar_directions(
                    own, span, ((slack[0], slack[1]), (slack[2], slack[3])), motion.signs, t
                )
            parts = casadi.vertcat(*(part for unit in units for part in unit), *rates)
            found = casadi.Function("found", [t, slack, span], [parts])
            for at in (0.0, 0.7, 4.0):
                directions, rates = motion(np.array([at]))
                wanted = [part for z in directions for part in (z[0].real, z[0].imag)] + [
                    rate[0] for rate in rates
                ]
                assert found(
                    at, np.ravel(motion.slack), motion.span
                ).full().ravel() == pytest.approx(wanted, abs=1e-13)
