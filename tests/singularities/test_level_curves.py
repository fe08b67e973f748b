"""Curves of constant det A against the inverse geometric model, mpmath, and robots made around a pose that is known."""

import mpmath
import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.leg_circles import LegCircles
from fivebar.singularities.level_curves import LevelCurves
from fivebar.singularities.locus import MODES
from fivebar.singularities.margins import Singularity
from fivebar.singularities.regions import LocusArc

ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    "grashof": fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    "coaxial": fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0),
    "change point": fb.FiveBar(0.3, 0.2, 0.25, 0.35, 0.5),
}
LEVELS = [(0.3, 0.2), (0.6, 0.0), (1.0, 0.1), (0.0, 0.3)]


def curves(robot, det_A, sin=0.0):
    return LevelCurves(robot, det_A, LegCircles(robot, sin))


def numbers(points):
    return points @ (1, 1j)


@pytest.mark.parametrize("det_A", [0.0, 0.3, 1e-7, 0.999])
@pytest.mark.parametrize("name", ROBOTS)
def test_chains_close_with_the_angle_that_their_kind_says(name, det_A):
    robot = ROBOTS[name]
    levels = curves(robot, det_A)
    for kind, chain in levels.chains:
        t = np.random.default_rng(1).uniform(0, chain.motion.period, 9)
        (u11, u12, u21, u22), _ = chain._bars(t)
        off = robot.l11 * u11 + robot.l12 * u12 - robot.l21 * u21 - robot.l22 * u22 - robot.d
        assert np.abs(off).max() < 1e-15 * levels.circles.scale
        np.testing.assert_allclose(np.abs([u11, u12, u21, u22]), 1, rtol=0, atol=2e-15)
        word, *sign = kind.split()
        turn = u12.conj() * u22
        np.testing.assert_allclose(
            turn.imag, {"+": det_A, "-": -det_A}[sign[0]] if sign else 0, rtol=0, atol=1e-15
        )
        assert (turn.real > 0).all() == (word != "stretched") and bool(sign) == bool(det_A)
        assert (word == "self-motion") == (
            not det_A and word != "stretched" and robot.l12 == robot.l22
        )


@pytest.mark.parametrize("det_A", [1e-6, 0.3, 1.0])
@pytest.mark.parametrize("bars", [(0.2, 0.2), (0.31, 0.17), (0.17, 0.31)])
def test_the_way_between_the_elbows_is_known_to_the_last_digits(det_A, bars):
    """l12 - l22 exp(i theta): its length and its direction."""
    levels = curves(fb.FiveBar(0.3, bars[0], 0.35, bars[1], 0.2), det_A)
    assert {kind for kind, _ in levels.chains} == {
        f"{word} {sign}" for word in ("folded", "stretched") for sign in "+-"
    }
    for kind, chain in levels.chains:
        with mpmath.workdps(40):
            angle = mpmath.asin(mpmath.mpf(det_A)) * (1 if kind[-1] == "+" else -1)
            angle = angle if kind.startswith("folded") else mpmath.pi - angle
            way = bars[0] - bars[1] * mpmath.expj(angle)
            apart, first = float(abs(way)), complex(mpmath.conj(way) / abs(way))
        assert chain.motion.c == pytest.approx(apart, rel=1e-15)
        assert abs(chain.bars[1][1] - first) < 1e-15 and chain.bars[1][0] == 2


def test_a_robot_that_turns_as_a_whole_with_its_elbows_at_a_limit_has_no_such_curve():
    """Coaxial motors: elbows 0.3 apart at most and 0.1 at least; around it det A is on one side of what it is there."""
    for apart in (0.3, 0.1):
        robot = fb.FiveBar(0.1, apart / 0.8**0.5, 0.2, apart / 0.8**0.5, 0.0)
        kinds = {kind for kind, _ in curves(robot, 0.8).chains}
        assert not {"folded +", "folded -"} & kinds
        for det_A in (0.79, 0.81):
            number = sum(kind == "folded +" for kind, _ in curves(robot, det_A).chains)
            assert number == (2 if (det_A > 0.8) == (apart == 0.1) else 0)
    # Folded at the limit all along: Type 2 itself is such a curve.
    assert [kind for kind, _ in curves(fb.FiveBar(0.1, 0.5, 0.2, 0.2, 0.0), 0.0).chains] == [
        "folded"
    ]


@pytest.mark.every(4)
@pytest.mark.parametrize("det_A, sin", LEVELS)
@pytest.mark.parametrize("name", ROBOTS)
def test_pieces_are_where_det_a_is_that_and_end_on_the_circles(name, det_A, sin):
    robot = ROBOTS[name]
    levels = curves(robot, det_A, sin)
    size, bases = levels.circles.scale, (-robot.d / 2, robot.d / 2)
    corners = {v for arc in levels.circles.pieces for v in arc.vertices} | set(
        levels.circles.touches
    )
    assert set(levels.corners) == corners
    for working in MODES:
        seen = {}
        for piece in levels.pieces(working):
            assert piece.working == (working,) and piece.assembly == () and piece.circle == ()
            assert piece.type == (Singularity.NONE if det_A else Singularity.PARALLEL)
            low, high = piece.interval
            t = np.linspace(low, high, 13)[1:-1]
            pose = fb.igm(robot, piece.at(t), working)
            sign = {"+": 1, "-": -1, "d": 0, "n": 0}[piece.kind[-1]]
            assert np.abs(pose.det_A - sign * det_A).max() < 1e-10
            bars = pose.xi[:, None] - pose.elbows
            cosine = (bars[:, 0] * bars[:, 1]).sum(axis=-1)
            assert det_A == 1 or (cosine > 0).all() == (not piece.kind.startswith("stretched"))
            sines = piece._curve.__self__.sines(np.array([low, high]))[:2]
            assert (-np.array(working)[:, None] * piece._curve.__self__.sines(t)[:2] > sin).all()
            assert bool(piece.vertices) != piece.closed
            assert high - low <= piece._curve.__self__.motion.period + 1e-15
            for vertex, end, sine in zip(piece.vertices, piece.points[[0, -1]], sines.T):
                assert vertex.z == numbers(end)
                seen[vertex] = seen.get(vertex, 0) + 1
                for leg, side in vertex.circles:
                    assert abs(vertex.z - bases[leg]) == pytest.approx(
                        levels.circles.radius(leg, side), abs=1e-15 * size
                    )
                    assert -working[leg] * sine[leg] == pytest.approx(sin, abs=1e-7)
                assert bool(vertex.circles) or det_A
                assert (len(vertex.circles) < 2) or vertex in corners
        for vertex, number in seen.items():
            assert vertex.circles or number % 2 == 0  # a curve that meets itself goes on


@pytest.mark.every(3)
@pytest.mark.parametrize("det_A, sin", [(0.3, 0.2), (0.0, 0.3)])
@pytest.mark.parametrize("name", ["unequal", "grashof", "coaxial"])
def test_pieces_are_all_there_is(name, det_A, sin):
    """Wherever det A passes +-det_A along random lines there is one."""
    robot = ROBOTS[name]
    levels, rng = curves(robot, det_A, sin), np.random.default_rng(3)
    size = levels.circles.scale
    for working in MODES:
        low, high = (
            rng.uniform(-0.5, 0.5, (40, 1)) * size @ [[1]]
            + 1j * rng.uniform(-0.5, 0.5, (40, 1)) * size
            for _ in "ab"
        )

        def above(s, working=working, low=low, high=high):
            z = low + s * (high - low)
            pose = fb.igm(robot, np.stack([z.real, z.imag], axis=-1), working, unreachable="nan")
            kept = (np.abs(pose.sines) > sin + 1e-3).all(axis=0)
            value = pose.det_A if not det_A else np.abs(pose.det_A) - det_A
            return np.where(kept & np.isfinite(value), np.sign(value), 0), z

        s = np.broadcast_to(np.linspace(0, 1, 100), (40, 100))
        sign, _ = above(s)
        row, k = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0)
        low, high, a, b, left = low[row], high[row], s[row, k], s[row, k + 1], sign[row, k]
        low, high = low[:, 0], high[:, 0]
        for _ in range(45):
            middle = (a + b) / 2
            same = above(middle, low=low, high=high)[0] == left
            a, b = np.where(same, middle, a), np.where(same, b, middle)
        z = above(a, low=low, high=high)[1]
        pieces = [
            LocusArc(piece, *piece.interval)
            for piece in levels.pieces(working)
            if len(piece.points) > 1
        ]
        if len(z):
            assert np.min([arc.nearest(z)[1] for arc in pieces], axis=0).max() < 1e-9 * size


@pytest.mark.parametrize("name", ["amoro", "unequal", "grashof", "change point"])
def test_of_no_det_a_they_are_the_loci_of_type_2(name):
    robot = ROBOTS[name]
    levels, loci = curves(robot, 0.0), fb.singularity_loci(robot)

    def length(pieces):
        return sum(
            np.hypot(*np.diff(p.points, axis=0).T).sum()
            for p in pieces
            if p.type == Singularity.PARALLEL
        )

    for working in MODES:
        own = levels.pieces(working)
        other = [piece for piece in loci.task if working in piece.working]
        assert length(own) == pytest.approx(length(other), rel=1e-3)
        assert {p.kind for p in own} == {p.kind for p in other if p.type == Singularity.PARALLEL}


def made_around(u11, u12, u21, u22, lengths):
    """The robot with these bars, angles in rad, in one of its poses; the base follows from them, and turns them."""
    l11, l12, l21, l22 = lengths
    bars = np.exp(1j * np.array([u11, u12, u21, u22]))
    base = bars @ (l11, l12, -l21, -l22)
    bars = bars * base.conjugate() / abs(base)
    return fb.FiveBar(l11, l12, l21, l22, abs(base)), -abs(base) / 2 + l11 * bars[0] + l12 * bars[1]


@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize("working", MODES)
def test_a_curve_through_a_corner_of_two_circles_has_its_vertex(sides, working):
    sin, angle = 0.3, np.arcsin(0.3)
    passive = [-mode * (angle if side > 0 else np.pi - angle) for mode, side in zip(working, sides)]
    robot, z = made_around(-passive[0], 0.0, 0.9 - passive[1], 0.9, (0.21, 0.17, 0.19, 0.23))
    levels = curves(robot, np.sin(0.9), sin)
    (corner,) = (v for v in levels.corners if abs(v.z - z) < 1e-9)
    assert set(corner.circles) == {(0, sides[0]), (1, sides[1])}
    cuts = {}
    for kind, chain in levels.chains:
        t, vertices = levels._cuts(kind, chain, working)
        assert len(t) == len(vertices) and (np.diff(t) > 0).all()
        for vertex in vertices:
            if abs(vertex.z - z) < 1e-6:
                cuts.setdefault(kind, []).append(vertex)
    assert cuts == {"folded +": [corner]}


def test_a_circle_that_is_only_touched_cuts_once():
    """The right proximal bar along the bases: there the angle of the left leg's bars is the least or the largest."""
    for sign, turn in ((1, 0.4), (-1, 0.4), (1, 2.4), (-1, 2.4)):
        l11, l12, l21, l22 = 0.25, 0.19, 0.11, 0.2
        u11, u12 = 0.3, 0.3 - turn
        theta = -1.2 * sign
        tip = l11 * np.exp(1j * u11) + l12 * np.exp(1j * u12) - l22 * np.exp(1j * (u12 + theta))
        u21 = np.angle(tip)
        robot, z = made_around(
            u11, u12, u21 if abs(tip) > l21 else u21 + np.pi, u12 + theta, (l11, l12, l21, l22)
        )
        sin = abs(np.sin(turn))
        levels = curves(robot, np.sin(1.2), sin)
        working = 1, 1
        near = []
        for kind, chain in levels.chains:
            t, vertices = levels._cuts(kind, chain, working)
            near += [(kind, v.circles) for v in vertices if abs(v.z - z) < 1e-5]
        assert near == [(f"folded {'-+'[theta > 0]}", ((0, 1 if np.cos(turn) > 0 else -1),))]


def test_curves_meet_themselves_where_all_of_the_four_bar_is_in_line():
    """Elbows 0.5 apart, bars 0.3 and 0.4 and the base 0.6, as the coupler's length says: 0.3 + 0.5 is 0.4 + 0.4."""
    for theta in (0.7, 2.2):
        distal = 0.4
        way = abs(distal - 0.3 * np.exp(1j * theta))
        robot = fb.FiveBar(0.25, distal, 0.35, 0.3, 0.25 + way - 0.35)
        levels = curves(robot, np.sin(theta))
        found = set()
        for working in MODES:
            for piece in levels.pieces(working):
                for vertex in piece.vertices:
                    if not vertex.circles:
                        found.add(vertex)
                        assert vertex in levels.nodes[piece.kind]
        # In line the elbows are on the line of the bases, the end-effector at the corner of their triangle.
        assert len(found) == 2
        inner = (distal**2 - 0.3**2 + way**2) / (2 * way)
        place = complex(-robot.d / 2 + 0.25 + inner, np.sqrt(distal**2 - inner**2))
        assert {min(abs(v.z - place), abs(v.z - place.conjugate())) < 1e-9 for v in found} == {True}
        assert np.prod([v.z.imag for v in found]) < 0


def test_a_single_pose_is_no_curve_but_of_type_2():
    """All in line: the way between the elbows is as long as the base and both proximal bars."""
    distal = 0.3 / np.sqrt(0.8)
    levels = curves(fb.FiveBar(0.1, distal, 0.1, distal, 0.1), 0.8)
    assert {kind for kind, _ in levels.chains} == {"folded +", "folded -"}
    assert [piece for mode in MODES for piece in levels.pieces(mode)] == []


def test_a_short_piece_has_its_share_of_the_points():
    pieces = [p for mode in MODES for p in curves(ROBOTS["grashof"], 0.3, 0.2).pieces(mode)]
    assert min(len(piece.points) for piece in pieces) <= 40  # it is a tenth of its curve


def test_what_runs_along_a_circle_is_not_inside():
    """Coaxial motors: neither the sines nor det A change along a curve."""
    robot = ROBOTS["coaxial"]
    for _, chain in curves(robot, 0.3).chains:
        for sine in np.abs(chain.sines(np.zeros(1))[:2, 0]):
            levels = curves(robot, 0.3, float(sine))
            for working in MODES:
                for piece in levels.pieces(working):
                    sines = piece._curve.__self__.sines(np.zeros(1))[:2, 0]
                    assert (-np.array(working) * sines > sine + 1e-14).all()
