"""What defines a linkage: each number and body is checked by its name; what is drawn is where it should be."""

import math
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.linkages import (
    REPAIRED,
    FiveBarLinkage,
    FourBar,
    SixBarPress,
    SliderCrank,
    crank_range,
    move,
)
from fivebar.linkages.checks import check_branch, loads, one_branch, pair
from fivebar.linkages.checks import linkage as linkage_rule

BODY = fb.linkages.Body(0.2, 1e-3)
FOUR_BAR = FourBar(
    0.2, 0.06, 0.16, 0.14, point=(0.08, 0.06), crank_body=BODY, coupler_body=BODY, rocker_body=BODY
)
SLIDER = SliderCrank(0.05, 0.2)
LINKAGES = FOUR_BAR, SLIDER, REPAIRED


def cases(kind):
    return [
        pytest.param(linkage, field.name, id=f"{type(linkage).__name__}.{field.name}")
        for linkage in LINKAGES
        for field in fields(linkage)
        if isinstance(getattr(linkage, field.name), kind)
        and not isinstance(getattr(linkage, field.name), bool)
    ]


@pytest.mark.parametrize("linkage,name", cases((int, float)))
@pytest.mark.parametrize("bad", [math.nan, "0.1", None])
def test_every_number_is_checked_by_its_name(linkage, name, bad):
    with pytest.raises((ValueError, TypeError), match=rf"\b{name}\b"):
        replace(linkage, **{name: bad})


@pytest.mark.parametrize("linkage,name", cases(fb.linkages.Body))
def test_every_body_is_checked_by_its_name(linkage, name):
    with pytest.raises((ValueError, TypeError), match=rf"\b{name}\b"):
        replace(linkage, **{name: 0.2})


@pytest.mark.parametrize("along,bars", [(0.3, {("B", "M")}), (-0.1, {("B", "M")}), (0.1, set())])
def test_a_point_beyond_the_coupler_adds_a_bar_to_the_linkages_own(along, bars):
    chain = move(replace(FOUR_BAR, point=(along, 0.0)), 0.7).chain
    assert set(chain.bars) == {("A", "B"), ("B", "C"), ("D", "C")} | bars
    chain = move(FOUR_BAR, 0.7).chain
    assert set(chain.bars) == {("A", "B"), ("B", "C"), ("D", "C"), ("B", "M"), ("C", "M")}


def test_one_pose_that_does_not_close_is_not_counted():
    with pytest.raises(fb.UnreachableError, match="^unreachable: "):
        move(FourBar(0.2, 0.15, 0.16, 0.14), math.pi)
    with pytest.raises(
        fb.UnreachableError, match="^1 of 2 poses, the first at index .1,.: unreachable"
    ):
        move(FourBar(0.2, 0.15, 0.16, 0.14), np.array([0.9, math.pi]))


@pytest.mark.parametrize("length", [0.2, 2.0])
def test_a_block_is_as_long_as_a_share_of_the_rod(length):
    motion = move(SliderCrank(0.1 * length, length), 0.4)
    shares = [
        np.linalg.norm(motion.position(end) - motion.position("B")) / (1.1 * length) for end in "KL"
    ]
    assert shares == pytest.approx([0.06, 0.06])


@pytest.mark.parametrize("motors", [(1, 5), (1, 3), (2, 4), (1, 2), (2, 3)])
def test_accelerations_of_the_motors_count(motors):
    """Against second differences of positions along q(t) = q0 + v t + a t² / 2."""
    linkage = FiveBarLinkage(fb.FiveBar(0.11, 0.14, 0.08, 0.12, 0.09), motors)
    q, v, a = (
        np.array([linkage.home[k] for k in motors]),
        np.array([0.7, -0.4]),
        np.array([2.0, 3.0]),
    )
    motion = move(linkage, q, v, a, linkage.usual_branch)
    h = 1e-4
    places = [
        move(linkage, q + v * t + a * t * t / 2, branch=linkage.usual_branch).position("joint 3")
        for t in (-h, 0.0, h)
    ]
    second = (places[0] - 2 * places[1] + places[2]) / h**2
    assert motion.acceleration("joint 3") == pytest.approx(second, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("theta11", [0.4, -0.4, 2.5])
def test_a_press_with_a_short_bar_locks_where_its_range_ends(theta11):
    """Bar 5 is shorter than the rocker: just inside the range it closes, just outside it does not."""
    press = SixBarPress(l2=0.1, l3=0.3, l4=0.3, l5=0.15, l11=0.3, l12=0.05, theta11=theta11)
    found = 0
    for branch in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        for low, high in crank_range(press, branch).intervals:
            if high - low >= 2 * math.pi - 1e-9:
                continue
            found += 1
            move(press, np.array([low + 1e-6, high - 1e-6]), branch=branch)
            for outside in (low - 1e-6, high + 1e-6):
                with pytest.raises(fb.UnreachableError):
                    move(press, outside, branch=branch)
    assert found


@pytest.mark.parametrize(
    "check, words",
    [
        (
            lambda: one_branch(FOUR_BAR, [1, -1]),
            r"branch must be one branch of this linkage, \+1 or -1, not a batch of \[1, -1\]$",
        ),
        (
            lambda: check_branch(REPAIRED, 1),
            "the branch of this linkage must be a pair of .1 or -1, not 1",
        ),
        (lambda: check_branch(FOUR_BAR, 2), "branch"),
        (lambda: loads([1], "load"), r"load must be \{point: \(Fx, Fy\)\}, not \[1\]"),
        (lambda: loads({3: (0, 1)}, "load"), r"load must be \{point: \(Fx, Fy\)\}, not \{3: "),
        (
            lambda: loads({"M": (0, 1, 2)}, "load"),
            r"load\['M'\] must be two numbers \(Fx, Fy\), .*\(0, 1, 2\)",
        ),
        (
            lambda: loads({"M": 3.0}, "load"),
            r"load\['M'\] must be two numbers \(Fx, Fy\), or arrays, not 3",
        ),
        (lambda: loads({"M": (0, math.nan)}, "load"), r"load\['M'\]"),
        (lambda: pair((1, 2, 3), "base"), r"base must be finite, two numbers, not \(1, 2, 3\)"),
        (lambda: pair(1.0, "base"), "base must be finite, two numbers, not 1"),
        (lambda: pair((0, 1e12), "base"), "base must be"),
        (
            lambda: linkage_rule(FourBar, "linkage"),
            "linkage must be a linkage, as FourBar or SliderCrank, not",
        ),
        (
            lambda: linkage_rule(3, "linkage"),
            "linkage must be a linkage, as FourBar or SliderCrank, not 3",
        ),
    ],
)
def test_what_does_not_fit_a_linkage_is_named(check, words):
    with pytest.raises((ValueError, TypeError), match=f"^{words}"):
        check()


def test_what_fits_a_linkage():
    assert check_branch(FOUR_BAR, None) == FOUR_BAR.usual_branch == one_branch(FOUR_BAR, None)
    assert check_branch(FOUR_BAR, np.array([1, -1])).tolist() == [1, -1]
    assert check_branch(REPAIRED, [1, -1]) == (1, -1)
    assert type(check_branch(FOUR_BAR, np.array(-1))) is int
    assert pair(None, "base") is None and pair(np.array([1, 2]), "base") == (1.0, 2.0)
    found = loads({"M": (1, np.array([2.0, 3.0]))}, "load")
    assert found["M"][0] == 1.0 and found["M"][1].tolist() == [2, 3] and loads(None, "load") is None
    assert linkage_rule(SLIDER, "linkage") is SLIDER


class Ranged:
    """Stands for a linkage that closes at crank angles from 1 to -1 and on to 0 rad."""

    title, usual_branch, start = "ranged", 1, 0.0

    def crank_limits(self, branch):
        return [-1.0, 0.0, 1.0]

    def chain(self, q, branch):
        closes = (np.abs((np.asarray(q) + np.pi) % (2 * np.pi) - np.pi) > 1) | (np.asarray(q) < 0)
        return SimpleNamespace(found=np.where(closes, 1.0, np.nan))


def test_a_range_goes_on_over_half_a_turn():
    found = crank_range(Ranged())
    assert not found.full and len(found.intervals) == 1
    assert found.intervals[0] == pytest.approx((1.0, 2 * np.pi))
    assert found.contains(-0.5) and found.contains(3.0) and not found.contains(0.5)
    assert found.nearest(0.3) == pytest.approx(0.0, abs=1e-12) and found.nearest(0.8) == 1.0


@pytest.mark.parametrize(
    "held, offset, flats",
    [
        ("guide", 0.0, []),
        ("guide", 0.15, [-math.pi / 2]),
        ("guide", -0.15, [math.pi / 2]),
        ("guide", 0.15 + 1e-9, []),
        ("slider", 0.15, [-math.pi / 2]),
        ("crank", 0.15, [math.pi]),
        ("crank", 0.1, []),
        ("rod", -0.15, [0.0]),
    ],
)
def test_where_a_slider_crank_is_flat(held, offset, flats):
    """The rod is perpendicular to the guide with the crank in line, or rod and crank fold onto it."""
    assert SliderCrank(0.05, 0.2, offset, held=held).flats == flats
