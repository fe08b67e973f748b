"""What a linkage can do, in a few lines of text: what turns, what locks, and where."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import takes
from .checks import linkage, one_branch
from .four_bar import FourBar, dead_centres, time_ratio, transmission_range
from .limits import crank_range
from .six_bar_press import SPEED, START, SixBarPress
from .slider_crank import HELD, TURNING, SliderCrank

if TYPE_CHECKING:
    from .motion import Linkage


@takes(linkage=linkage)
def verdict(linkage: Linkage, branch: int | tuple[int, int] | None = None) -> list[str]:
    """Return lines of text about a linkage on a branch: what turns, what locks, where.

    Parameters
    ----------
    linkage : Linkage
    branch : int or (2,), optional
        None: its usual one.

    Returns
    -------
    list of str

    Examples
    --------
    >>> from fivebar import linkages
    >>> len(linkages.verdict(linkages.FourBar(0.2, 0.06, 0.16, 0.14))) > 0
    True
    """
    branch = one_branch(linkage, branch)
    match linkage:
        case FourBar():
            return _four_bar(linkage, branch)
        case SliderCrank():
            return _slider_crank(linkage, branch)
        case SixBarPress():
            return _press(linkage, branch)
    return _five(linkage, branch)


def _four_bar(linkage, branch):
    lines = [f"four-bar, {_sides(linkage)}: {linkage.kind}", _grashof(linkage.grashof)]
    turning = linkage.turning
    lines.append("turns fully: " + (", ".join(turning) if turning else "no link"))
    lines += _change_point(linkage, "all bars are in line")
    lines += _drive("crank", crank_range(linkage, branch), "coupler and rocker come in line")
    ends = dead_centres(linkage, branch)
    for end in ends:
        where = f"crank at {_degrees(end.crank)}, rocker at {_degrees(end.rocker)}"
        lines.append(f"dead centre, crank and coupler {end.kind}: {where}")
    ratio = time_ratio(linkage, branch)
    if ratio is not None:
        swing = abs(math.remainder(ends[1].rocker - ends[0].rocker, 2 * math.pi))
        lines.append(f"the rocker swings by {_degrees(swing)}, time ratio {ratio:.6g}")
    low, high = transmission_range(linkage)
    lines.append(
        f"angle between coupler and rocker (transmission): {_degrees(low)} to {_degrees(high)}"
    )
    return lines


def _slider_crank(linkage, branch):
    where = {
        "guide": "the rod comes perpendicular to the guide",
        "slider": "the crank comes perpendicular to the guide",
    }.get(linkage.held, "the guide comes perpendicular to the line of its pivots")
    allowed = crank_range(linkage, branch)
    words = HELD[linkage.held]
    if linkage.held in ("crank", "rod") and allowed.full:
        driven, held = (getattr(linkage, name) for name in (linkage.driven, linkage.held))
        words = TURNING.format(linkage.driven) if driven > held else words
    lines = [
        f"slider-crank, crank {linkage.crank:g} m, rod {linkage.rod:g} m, offset {linkage.offset:g}"
        f" m, {linkage.held} held: {words}"
    ]
    lines += _change_point(linkage, where)
    lines += _drive(linkage.driven, allowed, where)
    if allowed.full:
        side = -branch if linkage.held == "slider" else branch
        near, far = (
            side * math.sqrt(max(d * d - linkage.offset**2, 0.0))
            for d in (linkage.rod - linkage.crank, linkage.rod + linkage.crank)
        )
        if linkage.flats:
            near = -far
        if len(linkage.flats) == 2 and branch < 0:
            near = far = 0.0  # one bar lies on the other, and turns about the slider's place
        low, high = sorted((near, far))
        lines.append(
            f"the slider goes from {low:.6g} to {high:.6g} m along the guide, stroke"
            f" {high - low:.6g} m"
        )
    return lines


def _press(linkage, branch):
    core = FourBar(linkage.l11, linkage.l2, linkage.l3, linkage.l4, tilt=linkage.theta11)
    lines = [f"six-bar press on the four-bar {_sides(core)}: {core.kind}", _grashof(core.grashof)]
    allowed = crank_range(linkage, branch)
    bar = ", or bar 5 perpendicular to the guide" if linkage.l4 > linkage.l5 else ""
    lines += _drive("crank", allowed, f"coupler and rocker come in line{bar}")
    interval = allowed.interval(START)
    if not allowed.full and interval:
        time = (interval[1] - START) / SPEED
        lines.append(
            f"from the paper's {_degrees(START)} at {math.degrees(SPEED):g} deg/s it locks at"
            f" {_degrees(interval[1])} after {time:.6f} s"
        )
    for end in dead_centres(core, branch[0]):
        lines.append(f"dead centre, crank and coupler {end.kind}: crank at {_degrees(end.crank)}")
    return lines


def _five(linkage, branch):
    robot = linkage.robot
    sides = [robot.d, robot.l11, robot.l12, robot.l22, robot.l21]
    lines = [
        "five-bar, ground and bars "
        + ", ".join(f"{s:g}" for s in sides)
        + f" m around; motors at joints {linkage.motors[0]} and {linkage.motors[1]}"
    ]
    for k in range(1, 6):
        a = sides[k - 1]
        b = sides[k % 5]
        rest = [s for i, s in enumerate(sides) if i not in (k - 1, k % 5)]
        turns = all(2 * max(*rest, x) <= sum(rest) + x for x in (abs(a - b), a + b))
        motor = "motor" if k in linkage.motors else "passive"
        lines.append(
            f"joint {k} ({motor}) {'can' if turns else 'cannot'} turn fully while the others follow"
        )
    home = ", ".join(f"joint {k} {_degrees(linkage.home[k])}" for k in linkage.motors)
    lines.append(f"a pose far from singularities: {home}, branch {linkage.usual_branch:+d}")
    return lines


def _drive(name, allowed, where):
    if allowed.full:
        return [f"the {name} turns through full turns"]
    if not allowed.intervals:
        return [f"on this branch the {name} closes at no angle"]
    locks = sorted(
        {
            round(math.degrees(math.remainder(end, 2 * math.pi)), 9)
            for piece in allowed.intervals
            for end in piece
        }
    )
    return [
        f"the {name} cannot turn fully: it goes {allowed}",
        f"it locks at {', '.join(f'{lock:.6f}' for lock in locks)} deg, where {where}",
    ]


def _change_point(linkage, where):
    if not linkage.flats:
        return []
    return [
        f"where {where} it can pass to the other branch; a study does, as without it rates would"
        " jump"
    ]


def _sides(four_bar):
    return ", ".join(
        f"{name} {side:g} m"
        for name, side in zip(("ground", "crank", "coupler", "rocker"), four_bar.sides)
    )


def _grashof(excess):
    if excess == 0:
        relation, turns = "equal to", "a change point"
    elif excess < 0:
        relation, turns = f"{-excess:.6g} m less than", "one link can turn fully"
    else:
        relation, turns = f"{excess:.6g} m more than", "no link can turn fully"
    return f"shortest + longest is {relation} the two others together: {turns}"


def _degrees(angle):
    return f"{np.degrees(angle):.6f} deg"
