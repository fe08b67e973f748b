"""The chains behind the loci: that they close, where they are cut, and the labels of the pieces between."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.five_bar_loci import CouplerCurve, FiveBarLoci, _serial_chains
from fivebar.singularities.locus import MODES, Vertex
from fivebar.singularities.margins import Singularity

ROBOTS = {
    "unequal": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "amoro": fb.FiveBar(),
    "long distal bars": fb.FiveBar(0.3, 1.1, 0.5, 0.4, 0.55),
    "kite": fb.FiveBar(0.3, 0.1, 0.2, 0.2, 0.2),
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
    "coaxial and equal": fb.FiveBar(0.12, 0.1, 0.12, 0.1, 0),
}


def all_chains(robot):
    """(leg in line or None, side, chain): side 1 where the two bars point the same way."""
    for kind, chain in FiveBarLoci(robot)._chains:
        yield None, -1 if kind == "stretched" else 1, chain
    for leg in (0, 1):
        for side in (1, -1):
            yield from ((leg, side, chain) for chain in _serial_chains(robot, leg, side))


@pytest.mark.parametrize("name", ROBOTS)
def test_chains_close_with_the_bars_in_line_that_they_say(name):
    robot = ROBOTS[name]
    size = robot.l11 + robot.l12 + robot.l21 + robot.l22 + robot.d
    for leg, side, chain in all_chains(robot):
        t = np.random.default_rng(1).uniform(0, chain.motion.period, 9)
        (u11, u12, u21, u22), rates = chain._bars(t)
        np.testing.assert_allclose(np.abs([u11, u12, u21, u22]), 1, rtol=0, atol=2e-15)
        assert (
            np.abs(
                robot.l11 * u11 + robot.l12 * u12 - robot.l21 * u21 - robot.l22 * u22 - robot.d
            ).max()
            < 2e-15 * size
        )
        one, other = {None: (u12, u22), 0: (u11, u12), 1: (u21, u22)}[leg]
        np.testing.assert_allclose(other, side * one, rtol=0, atol=2e-15)
        xi, slope = chain.task(t)
        np.testing.assert_allclose(
            xi, robot.d / 2 + robot.l21 * u21 + robot.l22 * u22, rtol=0, atol=2e-15
        )
        q, rate = chain.joint(t)
        np.testing.assert_allclose(
            np.exp(1j * np.array([q.real, q.imag])), [u11, u21], rtol=0, atol=2e-15
        )
        h = 1e-6
        step = chain.task(t + h)[0] - chain.task(t - h)[0]
        np.testing.assert_allclose(
            step / (2 * h), slope, rtol=0, atol=1e-7 * (1 + np.abs(slope).max())
        )
        (v11, _, v21, _), (w11, _, w21, _) = chain._bars(t + h)[0], chain._bars(t - h)[0]
        turned = np.angle(v11 / w11) + 1j * np.angle(v21 / w21)
        np.testing.assert_allclose(
            turned / (2 * h), rate, rtol=0, atol=1e-7 * (1 + np.abs(rate).max())
        )
        wanted = np.sin([np.angle(u12 / u11), np.angle(u22 / u21), np.angle(u22 / u12)])
        np.testing.assert_allclose(chain.sines(t), wanted, rtol=0, atol=2e-15)


@pytest.mark.parametrize("name", ROBOTS)
def test_chains_are_cut_where_a_leg_is_in_line(name):
    robot = ROBOTS[name]
    bases, size = (
        (-robot.d / 2, robot.d / 2),
        robot.l11 + robot.l12 + robot.l21 + robot.l22 + robot.d,
    )
    lengths = (robot.l11, robot.l12), (robot.l21, robot.l22)
    for _leg, _side, chain in all_chains(robot):
        edges = chain.edges
        assert (
            edges[-1] - edges[0] == pytest.approx(chain.motion.period, rel=1e-15)
            and (np.diff(edges) > 0).all()
        )
        for low, high, modes in zip(edges[:-1], edges[1:], chain.modes, strict=True):
            sines = chain.sines(np.linspace(low, high, 9)[1:-1])
            sines[np.abs(sines) < 1e-14] = 0
            assert (-np.sign(sines) == modes[:, None]).all()
        sines = np.abs(chain.sines(edges))
        assert not chain.aligned or sines.min(axis=0).max() < 1e-7
        shared = [Vertex(complex(z) + 0.5e-9) for z in chain.corners[:-1]]
        vertices = chain.vertices(shared, 1e-9)
        assert len(vertices) == len(edges) and vertices[0] is vertices[-1]
        for k, vertex in enumerate(vertices):
            assert vertex.z == chain.corners[k % (len(edges) - 1)] or vertex in shared
            assert abs(vertex.z - chain.task(edges[k : k + 1])[0][0]) < 1e-9
            assert {leg for leg, _ in vertex.circles} == {
                leg for leg in (0, 1) if sines[leg, k] < 1e-7
            }
            for leg, side in vertex.circles:
                radius = abs(lengths[leg][0] + side * lengths[leg][1])
                assert (
                    abs(abs(chain.corners[k] - bases[leg]) - radius)
                    <= (1e-8 if len(vertex.circles) > 1 else 4e-16) * size
                )
        vertices = chain.vertices([], 1e-9)
        own = [Vertex(complex(v.z) + 0.5e-9, v.circles) for v in vertices[:-1]]
        far = [Vertex(complex(v.z) + 2e-9, v.circles) for v in vertices[:-1]]
        other = [Vertex(complex(v.z), (*v.circles, (2, 1))) for v in vertices[:-1]]
        assert all(v in own for v in chain.vertices([*far, *other, *own], 1e-9))
        assert all(v not in (*far, *other) for v in chain.vertices([*far, *other], 1e-9))


def test_cuts_that_rounding_divided_are_one():
    def edges(*aligned, period=2.0):
        motion = SimpleNamespace(meets=lambda ways: [list(aligned)], period=period)
        return CouplerCurve(None, motion, ()).edges.tolist()

    assert edges() == [0.0, 2.0] and edges(0.5) == [0.5, 2.5] and edges(1.5, 0.5) == [0.5, 1.5, 2.5]
    assert edges(0.5, 0.5 + 1e-7, 1.5) == [0.5, 1.5, 2.5] and edges(0.5, 0.5 + 3e-7) == [
        0.5,
        0.5 + 3e-7,
        2.5,
    ]
    assert edges(0.0, 1.0, 2.0 - 1e-7) == [0.0, 1.0, 2.0] and edges(0.0, 2.0 - 3e-7) == [
        0.0,
        2.0 - 3e-7,
        2.0,
    ]
    assert edges(0.5, 0.5 + 3e-7, period=4.0) == [0.5, 4.5] and edges(1e-7, 2.0 - 2e-7, period=2.0)[
        1:2
    ] == [2.0 - 2e-7]


@pytest.mark.parametrize("name", ROBOTS)
def test_what_is_singular_says_in_which_modes(name):
    """Beside a piece of joint space the pose is nearly singular, in the modes of that piece and no others."""
    robot = ROBOTS[name]
    loci = FiveBarLoci(robot)
    assert loci.everywhere == (((1, 1), (-1, -1)) if name == "coaxial and equal" else ())
    for piece in loci.joint:
        q = piece.at(np.linspace(*piece.interval, 7)[1:-1])
        for assembly in piece.assembly:
            pose = fb.dgm(robot, q, assembly, unreachable="nan")
            sines, det = np.array(pose.sines), pose.det_A
            if piece.kind.startswith(("left", "right")):
                leg = int(piece.kind.startswith("right"))
                known = np.isfinite(det) & (np.abs(det) > 1e-6)
                assert np.abs(sines[leg][known]).max(initial=0) < 1e-7
                assert {w[leg] for w in piece.working} == {1, -1}
                assert {w[1 - leg] for w in piece.working} >= set(-np.sign(sines[1 - leg][known]))
                assert len(piece.working) == 2 or np.abs(sines[:, known]).max(initial=0) < 1e-7
                assert piece.type == (Singularity.SERIAL if known.any() else 3) and len(
                    piece.assembly
                ) == 1 + (not known.any())
    for xi, q, working in zip(loci.type3.xi, loci.type3.q, loci.type3.working):
        z = [
            drive.x + drive.length * np.exp(1j * angle) - xi @ (1, 1j)
            for drive, angle in zip(robot.drives, q)
        ]
        assert np.abs(np.abs(z) - robot.distal).max() < 1e-9
        sines = [
            (-each / np.exp(1j * angle)).imag / bar for each, angle, bar in zip(z, q, robot.distal)
        ]
        np.testing.assert_array_equal(working, [0 if abs(s) < 2e-7 else -np.sign(s) for s in sines])
    for piece in loci.task:
        assert len(set(piece.working)) == len(piece.working) and set(piece.working) <= set(MODES)
