"""Where the loci are the models close, and beyond the limits of reach they do not, for robots of all proportions."""

import dataclasses

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.leg_circles import size_of
from fivebar.singularities.loci import singularity_loci


def random_robots(count):
    """Of all proportions: bars alike and to 1 : 1000, legs of nearly equal bars, decimal lengths."""
    draw = np.random.default_rng(5)
    while count:
        bars = [
            draw.uniform(0.05, 1, 4),
            10 ** draw.uniform(-3, 0, 4),
            np.round(draw.uniform(0.01, 1, 4), 2),
        ][count % 3]
        if count % 7 == 0:
            bars[1] = bars[0] * (1 + 10 ** draw.uniform(-12, -1))
        try:
            yield fb.FiveBar(*bars, np.round(draw.uniform(0, 2), 2 + 12 * (count % 3)))
        except ValueError:
            continue
        count -= 1


@pytest.mark.deep
def test_the_models_accept_every_point_of_the_loci():
    """A limit of reach is reached to the rounding of its coordinates, and the bars keep their lengths there."""
    for robot in random_robots(200):
        loci, whole = singularity_loci(robot), size_of(robot)
        joint = [
            fb.dgm(robot, p.points, mode, unreachable="nan")
            for p in loci.joint
            for mode in p.assembly
        ]
        task = [
            fb.igm(robot, p.points, mode, unreachable="nan")
            for p in loci.task
            for mode in p.working
        ]
        for pose in joint + task:
            closed = ~np.isnan(pose.xi[:, 0] + pose.q[:, 0] + pose.q[:, 1])
            apart = np.min([np.sqrt(dyad.span_squared) for dyad in pose._dyads], axis=0)
            assert (closed | (apart < 1e-11 * whole)).all(), (
                "only a leg that is free to turn is refused"
            )
            bars = np.linalg.norm(pose.xi[:, None] - pose.elbows, axis=-1)
            np.testing.assert_allclose(
                bars[closed], np.broadcast_to(robot.distal, bars[closed].shape), 0, 4e-16 * whole
            )


@pytest.mark.parametrize("robot", list(random_robots(40)), ids=range(40))
def test_what_is_beyond_the_limit_by_1e_12_is_refused(robot):
    gap = 1e-12 * size_of(robot)
    u = np.exp(1j * np.linspace(0, 6, 50))
    for base, l1, l2 in ((-robot.d / 2, robot.l11, robot.l12), (robot.d / 2, robot.l21, robot.l22)):
        for radius in (l1 + l2 + gap, abs(l1 - l2) - gap):
            z = base + radius * u
            assert (
                radius <= 0
                or np.isnan(fb.igm(robot, _xy(z), unreachable="nan").q).any(axis=-1).all()
            )
    span = robot.l11 + robot.d + robot.l21
    reaches = [dataclasses.replace(robot, l12=0.3 * span, l22=0.7 * span - by) for by in (0, gap)]
    assert not np.isnan(fb.dgm(reaches[0], (np.pi, 0)).xi).any()
    with pytest.raises(fb.UnreachableError, match="gap"):
        fb.dgm(reaches[1], (np.pi, 0))


def _xy(z):
    return np.stack([z.real, z.imag], axis=-1)
