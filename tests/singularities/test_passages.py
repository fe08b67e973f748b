"""How the aspects hang together, against the poses of the robot flooded on a grid."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities import passages as module
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity
from fivebar.singularities.passages import _shared_place, aspect_of, known_aspects, passages
from fivebar.singularities.regions import LocusArc
from tests.conftest import UNEQUAL
from tests.helpers.pose_manifold import FOLDED, LEFT, PARALLEL, RIGHT, Flood

AMORO = fb.FiveBar()
SERIAL, BOTH = Singularity.SERIAL, Singularity.SERIAL | Singularity.PARALLEL
# Their aspects have no sliver that a grid of half a degree would not see.
DRAWN = [
    fb.FiveBar(*lengths)
    for lengths in np.random.default_rng(77).uniform(0.05, 0.2, (8, 5)).tolist()
]
ROBOTS = {
    "amoro": AMORO,
    "unequal": UNEQUAL,
    "twelve aspects": fb.FiveBar(0.126, 0.127, 0.163, 0.072, 0.173),
    "sixteen aspects": fb.FiveBar(0.4, 0.1, 0.35, 0.15, 0.6),
    "two circuits": fb.FiveBar(0.05, 0.2, 0.05, 0.2, 0.29),
    "equal bars in both legs": fb.FiveBar(0.1, 0.1, 0.06, 0.06, 0.07),
    "equal bars on the right": fb.FiveBar(0.13, 0.07, 0.1, 0.1, 0.12),
    "coaxial": fb.FiveBar(0.1, 0.07, 0.08, 0.06, 0.0),
    "one circle, coaxial": fb.FiveBar(0.1, 0.07, 0.1, 0.08, 0.0),
    "rhombus": fb.FiveBar(0.2, 0.1, 0.2, 0.1, 0.2),
    **{f"drawn {k}": robot for k, robot in enumerate(DRAWN)},
}


def pose_in(aspect):
    return fb.igm(aspect.robot, aspect.point, aspect.working)


def groups(robot, types, folds=True):
    """The aspects' numbers, grouped by what motions join that cross these types alone."""
    left = {aspect.number: {aspect.number} for aspect in known_aspects(robot)}
    for passage in passages(robot):
        if passage.type in types and (folds or not passage.fold):
            one, other = (left[number] for number in passage.between)
            one |= other
            for number in other:
                left[number] = one
    return tuple({id(group): frozenset(group) for group in left.values()}.values())


def test_type_1_joins_amoros_aspects_into_two_groups_or_without_folds_into_four():
    """Two, one per assembly sign, where a leg may pass folded through its base joint."""
    by_sign = {
        frozenset(a.number for a in known_aspects(AMORO) if a.assembly == sign) for sign in (1, -1)
    }
    assert set(groups(AMORO, SERIAL)) == by_sign
    without = groups(AMORO, SERIAL, folds=False)
    assert len(without) == 4 and all(any(part <= whole for whole in by_sign) for part in without)
    assert sorted(map(len, without)) == [1, 1, 4, 4]
    assert groups(AMORO, BOTH) == groups(AMORO, BOTH, folds=False) == (frozenset(range(1, 11)),)


def test_a_route_says_when_it_folds():
    folds = [passage for passage in passages(AMORO) if passage.fold]
    assert folds and all(passage.type == SERIAL for passage in folds)
    for passage in folds:
        base = AMORO.drives[passage.leg]
        assert passage.xi == pytest.approx((base.x, base.y), abs=0)
        one, other = (pose_in(known_aspects(AMORO)[number - 1]) for number in passage.between)
        shortest, *_ = fb.routes(AMORO, one, other)
        assert shortest.folds and "folded" in str(shortest)
        unfolded = [route for route in fb.routes(AMORO, one, other) if not route.folds]
        assert unfolded and all("folded" not in str(route) for route in unfolded)
    small = next(
        a
        for a in known_aspects(AMORO)
        if a.assembly == 1 and frozenset({a.number}) in groups(AMORO, SERIAL, False)
    )
    (same, *_) = fb.routes(AMORO, pose_in(small), pose_in(small))
    assert same.aspects == (small.number,) and same.passages == () and not same.folds


@pytest.mark.every(20)
@pytest.mark.parametrize("name", ROBOTS)
def test_the_graph_is_that_of_the_flooded_poses(name):
    """Groups by any types with and without folds, and every passage for itself."""
    robot = ROBOTS[name]
    flood, found = Flood(robot), known_aspects(robot)
    nodes = {aspect.number: flood.node(pose_in(aspect)) for aspect in found}
    assert None not in nodes.values()
    for types, may in (
        (SERIAL, LEFT | RIGHT),
        (Singularity.PARALLEL, PARALLEL),
        (BOTH, LEFT | RIGHT | PARALLEL),
    ):
        for folds in (True, False):
            components, flooded = flood.components(may | FOLDED * folds), {}
            for number, node in nodes.items():
                flooded.setdefault(components[node], set()).add(number)
            assert set(groups(robot, types, folds)) == set(map(frozenset, flooded.values())), (
                types,
                folds,
            )
    components = flood.components(0)
    number = np.zeros(components.max() + 2, dtype=int)
    for own, node in nodes.items():
        assert number[components[node]] == 0  # no two aspects flooded into one
        number[components[node]] = own
    one, other, what = flood.edges.T
    pairs = np.sort(np.stack([number[components[one]], number[components[other]]]), axis=0)
    edges = np.stack([*pairs, what], axis=-1)[(pairs[0] > 0) & (pairs[0] != pairs[1])]
    crossed = set(map(tuple, np.unique(edges, axis=0).tolist()))
    crossed = {
        edge
        for edge in crossed
        if not (edge[2] & FOLDED and (*edge[:2], edge[2] ^ FOLDED) in crossed)
    }
    kinds = {None: PARALLEL, 0: LEFT, 1: RIGHT}
    assert {(*p.between, kinds[p.leg] | FOLDED * p.fold) for p in passages(robot)} == crossed


@pytest.mark.parametrize("name", list(ROBOTS)[:8])
def test_a_passage_is_singular_as_it_says_and_in_nothing_else(name):
    robot = ROBOTS[name]
    for passage in passages(robot):
        if passage.fold:
            continue
        own = 2 if passage.leg is None else passage.leg
        base = np.array([robot.drives[passage.leg or 0].x, 0.0])
        for number in passage.between:
            # On one side of a limit of reach or on the other, by a billionth.
            both = [base + (1 + side) * (passage.xi - base) for side in (1e-9, -1e-9)]
            pose = fb.igm(
                robot, np.array(both), known_aspects(robot)[number - 1].working, unreachable="nan"
            )
            margins = np.abs([*pose.sines, pose.det_A]).T
            margins = margins[np.isfinite(margins).all(axis=1)][0].tolist()
            assert margins.pop(own) < 1e-3 < min(margins)


@pytest.mark.parametrize("leg, wanted", [(None, Singularity.PARALLEL), (0, SERIAL), (1, SERIAL)])
def test_the_place_on_a_shared_arc_is_the_farthest_of_its_samples(leg, wanted, monkeypatch):
    """Two samples, at a quarter and three quarters of what is shared; none where arcs meet in an end only."""
    monkeypatch.setattr(module, "SAMPLES", 2)
    for locus in singularity_loci(UNEQUAL).task:
        if locus.type != wanted or (
            leg is not None and not locus.kind.startswith(("left", "right")[leg])
        ):
            continue
        s = np.quantile(locus.interval, (0, 0.2, 0.3, 0.7, 0.9))
        working = locus.working[0]
        one, twin, next_to_it = (
            SimpleNamespace(working=working, boundary=[[LocusArc(locus, s[i], s[k])]])
            for i, k in ((0, 3), (4, 2), (4, 3))
        )
        samples = locus.at(s[2] + np.array([0.25, 0.75]) * (s[3] - s[2]))
        pose = fb.igm(UNEQUAL, samples, working, unreachable="nan")
        margins = np.abs([*pose.sines, pose.det_A])
        clear = np.nan_to_num(np.delete(margins, 2 if leg is None else leg, axis=0).min(axis=0))
        for both in ((one, twin), (twin, one)):
            np.testing.assert_allclose(
                _shared_place(UNEQUAL, *both, leg), samples[clear.argmax()], rtol=0, atol=1e-15
            )
        assert _shared_place(UNEQUAL, one, next_to_it, leg) is None


def test_two_circuits_have_no_route():
    robot = ROBOTS["two circuits"]
    one, other = groups(robot, BOTH)
    start, goal = (pose_in(known_aspects(robot)[min(group) - 1]) for group in (one, other))
    assert fb.routes(robot, start, goal) == ()
    assert fb.routes(robot, goal, goal)[0].aspects == (min(other),)


def test_what_is_no_pose_of_an_aspect_is_said():
    for aspect in known_aspects(AMORO):
        assert aspect_of(pose_in(aspect)) is aspect
    home = fb.dgm(AMORO, (0.1, 0.2))
    with pytest.raises(ValueError, match="goal is a pose of another robot"):
        fb.routes(AMORO, home, fb.dgm(UNEQUAL, (0.1, 0.2)))
    singular = fb.igm(
        AMORO, (0.0, 0.0), (-1, 1)
    )  # elbows one above the other: parallelogram, not singular
    assert aspect_of(singular).contains((0.0, 0.0))
    x = AMORO.d / 2
    stretched = fb.igm(AMORO, (-x + 0.18, 0.0), (-1, -1))
    with pytest.raises(
        ValueError, match=r"in no aspect.*singular: xi = \(0.121, 0\) m, modes \(0, -1\)"
    ):
        aspect_of(stretched)
