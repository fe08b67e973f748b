"""What turns, what locks, where; and what is refused, with by how much."""

import math

import numpy as np
import pytest

import fivebar as fb
from fivebar.linkages import (
    PRINTED,
    REPAIRED,
    Body,
    FiveBarLinkage,
    FourBar,
    SixBarPress,
    SliderCrank,
    coupler_curves,
    crank_range,
    dead_centres,
    move,
    straight_line,
    study,
    time_ratio,
    transmission_range,
    type_2_curves,
    verdict,
)
from fivebar.linkages.four_bar import _wrap
from fivebar.linkages.straight_line import roberts
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity
from tests.conftest import UNEQUAL

TABLE_2 = FourBar(0.2, 0.06, 0.16, 0.14)


def random_four_bars(count=60):
    rng = np.random.default_rng(3)
    while count:
        sides = rng.uniform(0.05, 1.0, 4)
        if 2 * sides.max() < sides.sum():
            count -= 1
            yield FourBar(*sides.tolist(), tilt=float(rng.uniform(-3, 3)))


def random_slider_cranks(count=80):
    rng = np.random.default_rng(4)
    while count:
        crank, rod, offset = rng.uniform(0.02, 1, 2).tolist() + [float(rng.uniform(-1, 1))]
        if abs(offset) < crank + rod:
            count -= 1
            yield SliderCrank(crank, rod, offset, ("guide", "crank", "rod", "slider")[count % 4])


PRESSES = [
    PRINTED,
    REPAIRED,
    SixBarPress(0.1, 0.5, 0.4, 0.3, 0.5, 0.6, 0.2),
    SixBarPress(0.3, 0.5, 0.45, 0.2, 0.4, 0.6, 0),
]


@pytest.mark.parametrize(
    "linkage", [*random_four_bars(), *random_slider_cranks(), *PRESSES], ids=lambda x: x.title
)
def test_crank_range_is_where_poses_exist(linkage):
    """Every angle is inside of the closed-form range exactly if a pose exists there; just beyond its ends none does."""
    q = np.linspace(-np.pi, np.pi, 1441) + 1e-3
    for branch in (1, -1) if linkage.usual_branch == 1 else ((-1, -1), (1, 1), (1, -1)):
        allowed = crank_range(linkage, branch)
        exists = np.isfinite(linkage.chain(q, branch).found)
        assert np.array_equal(exists, [allowed.contains(x) for x in q])
        if allowed.full:
            continue
        for low, high in allowed.intervals:
            ends = np.array([low + 1e-9, high - 1e-9, low - 1e-9, high + 1e-9])
            assert np.isfinite(linkage.chain(ends, branch).found).tolist() == [
                True,
                True,
                False,
                False,
            ]


def test_grashof_turning_links_against_full_turns():
    """A link turns fully exactly if its angle covers all directions as the chain moves through all of its poses."""
    for four_bar in random_four_bars(40):
        if abs(four_bar.grashof) < 0.02 * sum(four_bar.sides):
            continue
        allowed = crank_range(four_bar)
        turns = dict.fromkeys(("crank", "coupler", "rocker"), False)
        intervals = [(0, 2 * np.pi)] if allowed.full else allowed.intervals
        for low, high in intervals:
            s = np.linspace(0, 2 * np.pi, 4001)
            q = (
                low + s
                if allowed.full
                else (low + high) / 2 - (high - low) / 2 * (1 - 1e-12) * np.cos(s)
            )
            for branch in (1, -1) if allowed.full else (np.where(s < np.pi, 1, -1),):
                motion = move(four_bar, q, branch=branch)
                for name in turns:
                    way = np.unwrap(motion.angle(name))
                    turns[name] |= bool(np.ptp(way) > 2 * np.pi - 1e-3)
        assert tuple(name for name, full in turns.items() if full) == four_bar.turning, four_bar


def test_angles_of_dead_centres_are_in_one_turn():
    for angle, one in ((-math.pi, math.pi), (3 * math.pi, math.pi), (7.0, 7.0 - 2 * math.pi)):
        assert _wrap(angle) == pytest.approx(one, abs=1e-15)


def test_dead_centres_and_transmission_of_any_four_bar():
    for four_bar in random_four_bars():
        for branch in (1, -1):
            for end in dead_centres(four_bar, branch):
                motion = move(four_bar, end.crank, branch=branch)
                aligned = math.remainder(motion.angle("crank") - motion.angle("coupler"), math.pi)
                assert aligned == pytest.approx(0, abs=1e-7) and motion.rate(
                    "rocker"
                ) == pytest.approx(0, abs=1e-6)
                assert math.cos(motion.angle("rocker") - end.rocker) == pytest.approx(1, abs=1e-12)
        low, high = transmission_range(four_bar)
        s = np.cos(np.linspace(0, np.pi, 2001))
        allowed = crank_range(four_bar)
        pieces = [(-np.pi, np.pi)] if allowed.full else allowed.intervals
        q = np.concatenate([(a + b) / 2 + (b - a) / 2 * s for a, b in pieces])
        if allowed.full:  # the extremes are where the crank is in line with the ground
            q = np.append(q, [four_bar.tilt, four_bar.tilt + np.pi])
        angles = move(four_bar, q, unreachable="nan").transmission_angle()
        assert low - 1e-9 <= np.nanmin(angles) and np.nanmax(angles) <= high + 1e-9
        assert np.nanmin(angles) < low + 0.01 and np.nanmax(angles) > high - 0.01


def test_change_points():
    square, kite = FourBar(2, 1, 2, 1), FourBar(2, 2, 1, 1)
    assert (square.kind, square.turning) == ("change point", ("crank", "rocker"))
    assert kite.kind == "change point" and crank_range(kite).full == ("crank" in kite.turning)
    assert FourBar(0.3, 0.1, 0.2, 0.4).grashof == 0.0  # in spite of rounding
    assert any("pass to the other branch" in line for line in verdict(square))


@pytest.mark.parametrize("held", ["guide", "crank", "rod", "slider"])
@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize(
    "crank, rod, offset",
    [
        (0.05, 0.15, 0.02),
        (0.15, 0.05, 0.02),
        (0.05, 0.05, 0.0),
        (0.05, 0.07, 0.02),
        (0.05, 0.07, -0.02),
    ],
)
def test_the_slider_goes_as_far_as_in_a_study(crank, rod, offset, branch, held):
    """Where crank, rod and guide come in line, a study passes to the other branch."""
    linkage = SliderCrank(crank, rod, offset, held)
    lines = verdict(linkage, branch)
    assert any("pass to the other branch" in line for line in lines) == (
        abs(abs(crank - rod) - abs(offset)) < 1e-12
    )
    ways = [line.split() for line in lines if line.startswith("the slider goes")]
    assert len(ways) == crank_range(linkage, branch).full
    for words in ways:
        run = study(linkage, branch=branch, turns=2, samples=7200, quantities=["slide.position"])
        way = run["slide.position"]
        found = [float(words[k]) for k in (4, 6, -2)]
        assert found == pytest.approx([way.min(), way.max(), np.ptp(way)], abs=1e-6)


@pytest.mark.parametrize("held", ["crank", "rod"])
@pytest.mark.parametrize("crank, rod", [(0.05, 0.15), (0.15, 0.05)])
@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_whether_a_guide_turns_or_swings_is_as_in_a_study(crank, rod, offset, held):
    linkage = SliderCrank(crank, rod, offset, held)
    run = study(linkage, speed=1.0, samples=721, quantities=["guide.angle"])
    turned = np.ptp(np.unwrap(run["guide.angle"]))
    words = "guide turns" if turned == pytest.approx(2 * math.pi, abs=1e-9) else "guide swings"
    assert words in verdict(linkage)[0]


@pytest.mark.parametrize(
    "sides",
    [
        (0.2, 0.16, 0.06, 0.14),  # a double-rocker: its crank cannot turn
        (0.2, 0.2, 0.1, 0.1),  # a kite: neither can
        (0.2, 0.1, 0.2, 0.1),  # a parallelogram: its rocker turns, too
        (0.06, 0.14, 0.16, 0.2),
    ],
)
def test_there_is_a_time_ratio_only_where_the_crank_turns_and_the_rocker_does_not(sides):
    assert time_ratio(FourBar(*sides)) is None
    assert not any("time ratio" in line for line in verdict(FourBar(*sides)))
    run = study(TABLE_2, samples=3601)
    rising = np.mean(np.diff(run["rocker.angle"]) > 0)
    slower = max(rising, 1 - rising)
    assert time_ratio(TABLE_2) == pytest.approx(slower / (1 - slower), rel=1e-3)


@pytest.mark.parametrize(
    "linkage, words",
    [
        (
            TABLE_2,
            [
                "crank-rocker",
                "0.04 m less",
                "turns fully: crank",
                "38.572651",
                "swings by 50.802591 deg",
            ],
        ),
        (TABLE_2.inversion("crank"), ["drag link", "turns fully: crank, coupler, rocker"]),
        (
            FourBar(0.2, 0.1, 0.11, 0.12),
            ["non-Grashof triple-rocker", "no link can turn", "it locks at"],
        ),
        (SliderCrank(0.05, 0.15, 0.02), ["turns through full turns", "stroke 0.101018 m"]),
        (
            SliderCrank(0.15, 0.05),
            ["crank cannot turn fully", "it locks at", "rod comes perpendicular to the guide"],
        ),
        (
            SliderCrank(0.05, 0.06, 0.02, "crank"),
            ["rod cannot turn fully", "guide comes perpendicular"],
        ),
        (PRINTED, ["0.058 m more", "locks at 336.825007 deg after 1.471542 s", "45.174993"]),
        (REPAIRED, ["0.092 m less", "turns through full turns", "160.241851 deg"]),
        (FiveBarLinkage(), ["motors at joints 1 and 5", "joint 3 (passive) can turn"]),
        (
            FiveBarLinkage(fb.FiveBar(d=0.3), (1, 4)),
            ["motors at joints 1 and 4", "joint 1 (motor) cannot turn"],
        ),
    ],
)
def test_verdicts(linkage, words):
    text = "\n".join(verdict(linkage))
    assert [word for word in words if word not in text] == []


def test_lengths_that_cannot_be():
    for make, message in (
        (
            lambda: FourBar(1, 1, 1, 5),
            r"can never close: rocker = 5 m is longer than ground \+ crank \+ coupler = 3 m, by 2",
        ),
        (lambda: FourBar(1, 0, 1, 1), "crank must be finite and > 0, not 0"),
        (lambda: FourBar(1, 1, "long", 1), "coupler must be a number, not 'long'"),
        (lambda: FourBar(1, 1, 1, math.nan), "rocker must be finite"),
        (lambda: FourBar(1, 1, 1, 1, point=(0.1, math.nan)), "point must be finite, two numbers"),
        (lambda: FourBar(1, 1, 1, 1, base=(1, 2, 3)), "base must be finite, two numbers"),
        (lambda: FourBar(1, 1, 1, 1, tilt=math.inf), "tilt must be finite, not inf"),
        (lambda: SliderCrank(0.1, 0.2, "left"), "offset must be a number, not 'left'"),
        (
            lambda: SliderCrank(0.1, 0.2, 0.35),
            r"offset = 0.35 m is more than crank \+ rod = 0.3 m, by 0.05",
        ),
        (lambda: SliderCrank(0.1, 0.2, held="piston"), "held must be one of guide, crank"),
        (lambda: TABLE_2.inversion("piston"), "held must be one of ground, crank"),
        (lambda: SixBarPress(0.1, 0.1, 0.1, 0.4, 0.5, 0.6, 0), "l11 = 0.5 m is longer than l2"),
        (lambda: SixBarPress(0.1, 0.5, 0.4, 0.0, 0.5, 0.6, 0), "l5 must be finite and > 0"),
        (lambda: Body(-1.0), "mass must be finite and >= 0"),
        (lambda: FiveBarLinkage(motors=(1, 1)), "motors must be two of the joints 1 to 5"),
        (lambda: FiveBarLinkage(motors=(0, 3)), "motors must be two of the joints 1 to 5"),
        (
            lambda: straight_line("peaucellier"),
            "known ones are evans, chebyshev, watt, hoeken, roberts",
        ),
        (lambda: roberts(1.0), "at least 1.18615"),
    ):
        with pytest.raises(ValueError, match=message):
            make()


def test_branches_that_cannot_be():
    for linkage, branch in (
        (TABLE_2, 0),
        (TABLE_2, 2),
        (REPAIRED, (1, 0)),
        (REPAIRED, 1),
        (TABLE_2, (1, -1, 3)),
    ):
        with pytest.raises(ValueError, match=r"branch .*must be"):
            move(linkage, np.zeros(3), branch=branch)


def test_forbidden_crank_angles_name_the_nearest_allowed_one():
    with pytest.raises(
        fb.UnreachableError,
        match=r"crank cannot stand at 0 deg.*nearest allowed angle is -23.1749929 deg",
    ) as e:
        move(PRINTED, 0.0)
    assert e.value.index is None
    span = (
        PRINTED.l11 - PRINTED.l2
    )  # the pivots' distance at about 11 degrees, too short for bars 3 and 4
    assert 0 < e.value.gap < PRINTED.l3 - PRINTED.l4 - span + 0.01
    with pytest.raises(
        fb.UnreachableError, match=r"2 of 4 poses, the first at index \(1,\).*cannot stand at 5.7"
    ) as e:
        move(PRINTED, np.array([2.0, 0.1, 0.2, 3.0]))
    assert e.value.index == (1,)
    values = move(PRINTED, np.array([2.0, 0.1]), unreachable="nan").position("E")
    assert np.isfinite(values[0]).all() and np.isnan(values[1]).all()
    with pytest.raises(fb.UnreachableError, match="the rod cannot stand at 90 deg"):
        move(SliderCrank(0.05, 0.15, 0.02, "slider"), math.pi / 2)
    with pytest.raises(fb.UnreachableError, match="bars cannot meet"):
        move(FiveBarLinkage(), (math.pi, 0.0))
    with pytest.raises(ValueError, match="q must be finite"):
        move(TABLE_2, math.nan)
    with pytest.raises(ValueError, match='must be "raise" or "nan"'):
        move(TABLE_2, 0.0, unreachable="ignore")
    with pytest.raises(
        ValueError, match="no link 'arm'; the known ones are crank, coupler, rocker"
    ):
        move(TABLE_2, 0.0).angle("arm")


def test_singular_poses_have_positions_but_no_rates():
    for linkage, q, words in (
        (FourBar(2, 1, 2, 1), 0.0, "coupler and rocker are in line"),
        (SliderCrank(0.1, 0.1), math.pi / 2, "the rod is perpendicular"),
        (SliderCrank(0.25, 0.375, 0.125, "rod"), 0.0, "the guide is perpendicular"),
    ):
        motion = move(linkage, q)
        assert np.isfinite(motion.position(motion.points[1])).all()
        with pytest.raises(fb.SingularityError, match=words):
            motion.rate(motion.links[1])
    with pytest.raises(fb.SingularityError, match=r"2 of 3 poses, the first at index \(0,\)"):
        move(FourBar(2, 1, 2, 1), np.array([0.0, 1.0, 0.0])).rate("rocker")


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "robot",
    [fb.FiveBar(), UNEQUAL, fb.FiveBar(l12=0.1, l22=0.13)],
    ids=["amoro", "unequal", "folded"],
)
def test_type_2_locus_is_a_coupler_curve(robot):
    """The curves lie on the exact locus, cover it, and every point of theirs is a singular pose."""
    curves = type_2_curves(robot)
    exact = [piece for piece in singularity_loci(robot).task if Singularity.PARALLEL in piece.type]
    cloud = np.concatenate([piece.points for piece in exact])
    mine = np.concatenate([curve.points for curve in curves])
    dense = np.concatenate(
        [np.linspace(a, b, 8) for p in exact for a, b in zip(p.points, p.points[1:])]
    )

    def farthest(points, others):
        return max(np.hypot(*(others - p).T).min() for p in points)

    assert farthest(mine[::7], dense) < 2e-4 and farthest(cloud[::3], mine) < 2e-3
    for curve in curves:
        assert curve.points[0] == pytest.approx(curve.points[-1], abs=1e-7)


def test_type_2_curves_of_a_circle_and_of_no_ground():
    """Equal distal bars and elbows that touch in one place only: one circle of self-motion about it."""
    curves = type_2_curves(fb.FiveBar(l11=0.25, l12=0.3, l21=0.5, l22=0.3, d=0.75))
    (circle,) = (curve for curve in curves if curve.label == "Type 2, elbows coincide")
    assert np.hypot(*(circle.points - (-0.125, 0.0)).T) == pytest.approx(0.3)
    with pytest.raises(ValueError, match="with d = 0 the ground of the four-bar has no length"):
        type_2_curves(fb.FiveBar(d=0.0))
    with pytest.raises(ValueError, match="l12 and l22 differ by 1e-10 m, too little"):
        type_2_curves(fb.FiveBar(l12=0.1, l22=0.1 + 1e-10))


def test_a_guide_that_passes_its_pin_too_far_away():
    """The pins are 0.1 m apart, and the guide passes one of them at 0.12 m."""
    linkage = SliderCrank(0.05, 0.15, 0.12, "rod")
    with pytest.raises(fb.UnreachableError, match="the crank cannot stand at 0 deg") as error:
        move(linkage, 0.0)
    assert error.value.gap == pytest.approx(0.02)
    ((low, high),) = crank_range(linkage).intervals
    for end in (low, high):
        assert abs(0.15 - 0.05 * np.exp(1j * end)) == pytest.approx(0.12)
    assert crank_range(linkage).nearest(1.0) == 1.0
    assert str(crank_range(TABLE_2)) == "through a full turn"
    with pytest.raises(ValueError, match=r"shapes \[\(3,\), \(4,\), \(\)\] do not go together"):
        move(linkage, np.zeros(3), np.zeros(4))


def test_coupler_curves_cover_both_branches():
    assert len(coupler_curves(TABLE_2)) == 2  # the crank turns: a curve for each branch
    assert len(coupler_curves(TABLE_2.inversion("rocker"))) == 2  # two ranges of the crank
    assert len(coupler_curves(FourBar(0.2, 0.1, 0.11, 0.12))) == 1  # one range, there and back
    for curve in coupler_curves(TABLE_2.inversion("rocker"), "drag"):
        assert curve.label == "drag" and curve.points[0] == pytest.approx(
            curve.points[-1], abs=1e-7
        )
        assert np.isfinite(curve.points).all() and len(curve.points) > 1400


def test_ranges_of_change_points_whose_pieces_have_a_flat_middle():
    """Of 400 change points in integers, the share of angles that close is that of the triangle B C D."""
    rng, folded = np.random.default_rng(3), 0
    four_bars = [FourBar(0.3, 0.3, 0.2, 0.2)]
    while len(four_bars) < 400:
        ground, crank, coupler = (int(side) for side in rng.integers(1, 20, 3))
        rocker = int(
            rng.choice(
                [ground + crank - coupler, ground + coupler - crank, crank + coupler - ground]
            )
        )
        if rocker > 0:
            four_bars.append(FourBar(ground, crank, coupler, rocker))
    for four_bar in four_bars:
        ground, crank, coupler, rocker = four_bar.sides
        q = np.linspace(-np.pi, np.pi, 20001)[:-1] + 1e-5  # no multiple of it is flat
        span = np.sqrt(ground**2 + crank**2 - 2 * ground * crank * np.cos(q))
        share = np.mean((span <= coupler + rocker) & (span >= abs(coupler - rocker)))
        allowed = crank_range(four_bar)
        own = (
            1.0
            if allowed.full
            else sum(high - low for low, high in allowed.intervals) / (2 * np.pi)
        )
        assert own == pytest.approx(share, abs=4e-4)
        folded += ground == crank and coupler == rocker
    assert folded >= 3
    assert sum(high - low for low, high in crank_range(four_bars[0]).intervals) / (
        2 * np.pi
    ) == pytest.approx(4 * np.arcsin(2 / 3) / (2 * np.pi), rel=1e-12)


@pytest.mark.parametrize("sides", [(0.3, 0.3, 0.2, 0.2), (5, 5, 3, 3), (3, 3, 5, 5)])
@pytest.mark.parametrize("samples", [361, 181, 1001])
def test_a_change_point_swings_through_its_flat_pose(sides, samples):
    """Smoothly: the rates are the differences of the angles."""
    motion = study(
        FourBar(*sides), drive="swing" if sides[2] < sides[0] else "turn", samples=samples
    )
    for link in ("coupler", "rocker"):
        rate, angle = motion[f"{link}.rate"], motion[f"{link}.angle"]
        steps, jump = np.diff(motion.t), np.abs(np.diff(rate)).max()
        assert np.abs(np.diff(angle) / steps - (rate[1:] + rate[:-1]) / 2).max() <= jump
        assert np.abs(np.diff(angle)).max() < 0.3
