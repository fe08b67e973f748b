"""What lab 4 checks; its models are in exercises.py."""

from itertools import product

import numpy as np
import pytest

import fivebar as fb
from fivebar.grading.columns import batch, joints, pose
from fivebar.grading.samples import (
    beside_type_1,
    beside_type_2,
    poses,
    straight_paths,
    unequal_robot,
)
from fivebar.models.dyads import RRR
from fivebar.models.geometry import reach

NEAR = np.array([1, -1] * 6) * np.logspace(-1, -6, 12)


def u(angle):
    return np.exp(1j * angle)


def chosen(robot, rows, n, kind):
    """n of the joint columns in which exactly this is singular, and the rest is clearly regular."""
    sines = np.abs(
        [np.sin(rows[1]), np.sin(rows[3]), np.sin(rows[2] + rows[3] - rows[0] - rows[1])]
    )
    with np.errstate(invalid="ignore"):
        clear = np.all((sines > 0.2) | (sines < 1e-8), axis=0) & (
            fb.singularity(pose(robot, *rows), 1e-6) == kind
        )
    return tuple(column[clear][:n] for column in rows)


def in_line(robot, draw, n, side):
    """Distal bars stretched (side -1) or folded (+1): the four-bar with coupler l12 - side l22."""
    psi = draw.uniform(-np.pi, np.pi, 40 * n)
    span = robot.d - (robot.l12 - side * robot.l22) * u(psi)
    dyad = RRR((span.real, span.imag), robot.l11, robot.l21, draw.choice([-1, 1], 40 * n))
    q11, q21 = (np.arctan2(y, x) for x, y in (dyad.first, dyad.second))
    return chosen(robot, (q11, psi - q11, q21, psi - q21 + (np.pi if side < 0 else 0)), n, 2)


def straight(robot, draw, n, leg, passive):
    """One leg with this passive angle, 0 or pi; the other closes on its end."""
    own, passives = draw.uniform(-np.pi, np.pi, 200 * n), np.full(200 * n, passive)
    drive, other = robot.drives[leg], robot.drives[1 - leg]
    end = drive.x + (drive.length + robot.distal[leg] * np.cos(passive)) * u(own)
    closing = reach(
        other, (end.real, end.imag), robot.distal[1 - leg], draw.choice([-1, 1], 200 * n)
    )
    found = closing.q, np.arctan2(closing.sine, closing.cosine)
    return chosen(robot, (own, passives, *found) if leg == 0 else (*found, own, passives), n, 1)


def both_straight(robot):
    """Type 1 twice: both legs stretched, on either side of the base; they form a triangle with it."""
    (left, right), (l12, l22) = robot.drives, robot.distal
    base = np.full(2, right.x - left.x), np.zeros(2)
    legs = RRR(base, left.length + l12, right.length + l22, np.array([1, -1]))
    q11, q21 = (np.arctan2(y, x) for x, y in (legs.first, legs.second))
    return chosen(robot, (q11, np.zeros(2), q21, np.zeros(2)), 2, 1)


def doubly(robot, n):
    """Type 3: a leg in line and the distal bars too, so that a triangle of the base and two sides is left."""
    rows = []
    for leg in (0, 1):
        own, other = robot.drives[leg], robot.drives[1 - leg]
        for passive in (0.0, np.pi):
            for side in (-1, 1):
                along = own.length + np.cos(passive) * (
                    robot.distal[leg] - side * robot.distal[1 - leg]
                )
                for branch in (-1, 1):
                    dyad = RRR(
                        (np.array([other.x - own.x]), np.zeros(1)), along, other.length, branch
                    )
                    q, q_other = (np.arctan2(y, x) for x, y in (dyad.first, dyad.second))
                    phi = q + passive + (np.pi if side < 0 else 0)
                    row = q, np.full(1, passive), q_other, phi - q_other
                    rows.append(row if leg == 0 else row[2:] + row[:2])
    return chosen(robot, batch(*rows), n, 3)


def misread(robot, draw, n, leg):
    """Regular poses in which a leg would be in line if its passive angle were measured from the x axis."""
    own = draw.uniform(-np.pi, np.pi, 200 * n)
    passive = own + np.pi * draw.integers(0, 2, 200 * n)
    drive, other = robot.drives[leg], robot.drives[1 - leg]
    end = drive.x + drive.length * u(own) + robot.distal[leg] * u(own + passive)
    closing = reach(
        other, (end.real, end.imag), robot.distal[1 - leg], draw.choice([-1, 1], 200 * n)
    )
    found = closing.q, np.arctan2(closing.sine, closing.cosine)
    return chosen(robot, (own, passive, *found) if leg == 0 else (*found, own, passive), n, 0)


def of_wrong_angles(robot, draw, count=8, places=181):
    """One regular pose for each sum of joint angles that may be mistaken for the angle between the distal bars:
    the sum is 0 or pi there. It is where the sine of the sum changes its sign on straight lines of motor angles."""
    legs_and_right = {(0, 1, 0, 0), (0, 0, 0, 1), (1, 1, -1, -1)}
    up_to_sign = [c for c in product((-1, 0, 1), repeat=4) if c > (0, 0, 0, 0)]
    sums = np.array([c for c in up_to_sign if c not in legs_and_right])

    middle = draw.uniform(-np.pi, np.pi, (count, 2))
    along = u(draw.uniform(-np.pi, np.pi, count))
    assembly = draw.choice([-1, 1], count)

    def at(line, place):
        turned = along[line] * place
        q = middle[line] + np.stack([turned.real, turned.imag], axis=-1)
        return np.array(joints(fb.dgm(robot, q, assembly[line], unreachable="nan")))

    grid = np.linspace(-np.pi, np.pi, places)
    scan = at(np.repeat(np.arange(count), places), np.tile(grid, count))
    signs = np.sign(np.sin(sums @ scan)).reshape(len(sums), count, places)
    which, line, k = np.nonzero(signs[..., 1:] * signs[..., :-1] < 0)
    low, high = grid[k], grid[k + 1]
    for _ in range(40):
        half = (low + high) / 2
        sines = np.sin(np.sum(sums[which] * at(line, half).T, axis=1))
        same = np.sign(sines) == signs[which, line, k]
        low, high = np.where(same, half, low), np.where(same, high, half)
    found = at(line, low)
    return batch(*(chosen(robot, tuple(found[:, which == i]), 1, 0) for i in range(len(sums))))


def hardly_singular(robot, draw):
    """On both sides of what counts as singular: sines of 1e-3 and 1e-4, and of 3e-7."""
    sines = np.array([1e-3, -1e-4, 3e-7])
    return batch(
        *(
            joints(pose)
            for pose in (
                beside_type_2(robot, draw, sines),
                *(beside_type_1(robot, draw, sines, leg) for leg in (0, 1)),
            )
        )
    )


def of_all_types(robot, draw):
    lines = [in_line(robot, draw, 3, side) for side in (-1, 1)]
    legs = [straight(robot, draw, 2, leg, passive) for leg in (0, 1) for passive in (0.0, np.pi)]
    misleading = [misread(robot, draw, 2, leg) for leg in (0, 1)]
    return batch(
        joints(poses(robot, draw, 6)),
        *misleading,
        hardly_singular(robot, draw),
        *lines,
        *legs,
        doubly(robot, 4),
        both_straight(robot),
        of_wrong_angles(robot, draw),
    )


@pytest.mark.points(3)
def test_type(ask, robot, draw):
    """singularity_type: regular and singular poses of all types"""
    ask("singularity_type", *of_all_types(robot, draw))


@pytest.mark.points(2)
def test_type_unequal(ask, draw):
    """singularity_type: four bars of different lengths"""
    other = unequal_robot(draw)
    ask("singularity_type", *of_all_types(other, draw), robot=other)


@pytest.mark.points(2)
def test_margins_regular(ask, robot, draw):
    """margins: regular poses of all modes"""
    ask("margins", *joints(poses(robot, draw, 16)))


@pytest.mark.points(2)
def test_margins_near_singularity(ask, robot, draw):
    """margins: on both sides of singularities"""
    parts = [
        beside_type_2(robot, draw, NEAR),
        *(beside_type_1(robot, draw, NEAR, leg) for leg in (0, 1)),
    ]
    ask("margins", *batch(*(joints(part) for part in parts)))


def locus(robot, draw, n, reachable=True):
    """q11 at which the stretched coupler closes well, or does not."""
    q11 = draw.uniform(-np.pi, np.pi, 200)
    span = np.abs(robot.d - robot.l11 * u(q11))
    bar = robot.l12 + robot.l22
    closes = (span > bar - robot.l21) & (span < bar + robot.l21)
    clear = np.min(np.abs([span - bar + robot.l21, span - bar - robot.l21]), axis=0) > 0.003
    return q11[clear & (closes == reachable)][:n]


@pytest.mark.points(3)
def test_type2_point(ask, robot, draw):
    """type2_point: both branches"""
    q11 = locus(robot, draw, 16)
    ask("type2_point", q11, draw.choice([-1, 1], len(q11)))


@pytest.mark.points(2)
def test_type2_point_unequal(ask, draw):
    """type2_point: four bars of different lengths"""
    other = unequal_robot(draw)
    q11 = locus(other, draw, 16)
    ask("type2_point", q11, draw.choice([-1, 1], len(q11)), robot=other)


@pytest.mark.points(1)
def test_type2_point_unreachable(ask, robot, draw):
    """type2_point: angles at which the distal bars cannot be stretched"""
    some, none = locus(robot, draw, 8), locus(robot, draw, 8, reachable=False)
    q11 = np.concatenate([some, none])
    ask("type2_point", q11, draw.choice([-1, 1], len(q11)), refuse=np.arange(len(q11)) >= len(some))


def soon_back(robot, draw, n):
    """Paths that cross and come back within some hundredths of their length, where few samples of p
    see no crossing: along the locus, through a point a little beyond it.
    """
    pose = beside_type_2(robot, draw, 0.0015 * draw.choice([-1, 1], 240))

    def p(xi):
        found = fb.igm(robot, xi, pose.working, unreachable="nan")
        return fb.singularity_margins(found)

    steps = 1e-6 * np.eye(2)
    slope = np.stack([p(pose.xi + h).parallel - p(pose.xi - h).parallel for h in steps], -1)
    along = np.stack([-slope[:, 1], slope[:, 0]], -1) / np.linalg.norm(slope, axis=-1)[:, None]
    ahead = draw.uniform(0.01, 0.05, (2, 240, 1)) * along
    a, b = pose.xi - ahead[0], pose.xi + ahead[1]
    margins = p(a + (b - a) * np.linspace(0, 1, 201)[:, None, None])
    beyond = margins.parallel * np.sign(margins.parallel[0]) < 0
    share = beyond.mean(axis=0)
    twice = np.abs(np.diff(beyond.astype(int), axis=0)).sum(axis=0) == 2
    regular = np.abs(margins.serial).min(axis=(0, 2)) > 0.05
    rows = np.flatnonzero(twice & regular & (share > 0.02) & (share < 0.07))[:n]
    return (*a[rows].T, *b[rows].T, *pose.working[rows].T)


def crossing(ask, draw, drawn, counts, working=None, soon=(), **choices):
    """Ask about some paths for each count of crossings; soon: about others that cross, too."""
    parts = [straight_paths(drawn, draw, n, count, working) for count, n in counts.items()]
    parts += soon
    kinds = [*counts, *(2 for _ in soon)]
    none = np.concatenate([np.full(len(part[0]), count == 0) for count, part in zip(kinds, parts)])
    ask("first_crossing", *batch(*parts), refuse=none, tolerance=1e-6, **choices)


@pytest.mark.points(2)
def test_crossing(ask, robot, draw):
    """first_crossing: working modes -1, -1"""
    crossing(ask, draw, robot, {1: 6, 0: 4}, (-1, -1))


@pytest.mark.points(1)
def test_crossing_modes(ask, robot, draw):
    """first_crossing: all four working modes"""
    crossing(ask, draw, robot, {1: 8, 0: 4})


@pytest.mark.points(1)
def test_crossing_twice(ask, robot, draw):
    """first_crossing: paths that cross and come back"""
    crossing(ask, draw, robot, {2: 4, 1: 4, 0: 4}, soon=[soon_back(robot, draw, 4)])


@pytest.mark.points(1)
def test_crossing_unequal(ask, draw):
    """first_crossing: four bars of different lengths"""
    other = unequal_robot(draw)
    crossing(ask, draw, other, {1: 8, 0: 4}, robot=other)
