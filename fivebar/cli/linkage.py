"""`fivebar linkage ...`: the verdict on a linkage, then its study as table, picture and
animation.
"""

from __future__ import annotations

import json
import math
from argparse import _SubParsersAction
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from ..linkages import (
    GRAVITY,
    PRESSES,
    FiveBarLinkage,
    FourBar,
    SliderCrank,
    crank_range,
    straight_line,
    straightness,
    study,
    verdict,
)
from ..linkages.checks import check_branch
from ..linkages.drives import DRIVES
from ..linkages.quantities import unit
from ..linkages.six_bar_press import SPEED
from ..models.robots import FiveBar
from .endings import check_ending
from .robot_options import ask_for_mm

SIX_BAR_LENGTHS = ("l2", "l3", "l4", "l5", "l11", "l12")


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `linkage` to the program's commands."""
    linkage = commands.add_parser("linkage")
    kinds = linkage.add_subparsers(dest="kind", required=True, metavar="KIND")

    four_bar = _kind(kinds, "four-bar", "four-bar A B C D: lengths in m", _four_bar)
    for name in ("ground", "crank", "coupler", "rocker"):
        four_bar.add_argument(name, type=float, metavar=name.upper(), help="m")
    four_bar.add_argument(
        "--point",
        nargs=2,
        type=float,
        metavar=("ALONG", "ACROSS"),
        help="coupler point from B along BC, to its left, m",
    )
    four_bar.add_argument(
        "--held", metavar="LINK", default="ground", help="ground, crank, coupler or rocker"
    )

    slider = _kind(kinds, "slider-crank", "slider-crank: lengths in m", _slider_crank)
    for name in ("crank", "rod"):
        slider.add_argument(name, type=float, metavar=name.upper(), help="m")
    slider.add_argument(
        "--offset",
        type=float,
        default=0.0,
        metavar="M",
        help="of the guide from the crank's pivot, m",
    )
    slider.add_argument(
        "--held", metavar="LINK", default="guide", help="guide, crank, rod or slider"
    )

    press = _kind(
        kinds, "six-bar-press", "six-bar press of Wang, Chen and Deng 2019", _press, branches=2
    )
    press.add_argument(
        "set", nargs="?", metavar="NAME", default="repaired", help="repaired (default) or printed"
    )
    for name in SIX_BAR_LENGTHS:
        press.add_argument(f"--{name}", type=float, metavar="M")
    press.add_argument(
        "--load", type=float, default=0.0, metavar="N", help="on the slider, along +y"
    )
    press.add_argument(
        "--no-gravity", action="store_true", help="leave out the weights (along +x in the paper)"
    )

    five = _kind(kinds, "five-bar", "five-bar with its motors at any two joints", _five_bar)
    for name in ("l11", "l12", "l21", "l22", "d"):
        five.add_argument(
            f"--{name}", type=float, metavar="M", help="m (default: the AMORO robot's)"
        )
    five.add_argument(
        "--motors",
        nargs=2,
        type=int,
        default=(1, 5),
        metavar=("I", "J"),
        help="joints 1 to 5 from base to base",
    )

    straight = _kind(
        kinds, "straight-line", "evans, chebyshev, watt, hoeken or roberts", _straight_line
    )
    straight.add_argument("name", metavar="NAME")


def _kind(kinds, name, words, build, branches=1):
    parser = kinds.add_parser(name, help=words, description=words)
    study = parser.add_argument_group(
        "study", "written files ask for one; without them the verdict is all"
    )
    study.add_argument(
        "--speed",
        type=float,
        metavar="RAD/S",
        help="default: one turn a second; the press: 120 deg/s",
    )
    study.add_argument("--turns", type=float, metavar="N", help="default: 1; the press: 3")
    study.add_argument(
        "--branch",
        type=int,
        nargs=branches if branches > 1 else None,
        metavar="+-1",
        help="default: the usual one",
    )
    study.add_argument("--drive", metavar="HOW", help="turn, until-lock or swing (to and fro)")
    study.add_argument("--plot", type=Path, metavar="OUT.png")
    study.add_argument("--csv", type=Path, metavar="OUT.csv")
    study.add_argument(
        "--html", type=Path, metavar="OUT.html", help="animation; or .gif, .mp4, .webm, .png"
    )
    study.add_argument(
        "--live",
        type=Path,
        metavar="OUT.html",
        help="a page on which it is dragged and its bars slide",
    )
    study.add_argument(
        "--page", type=Path, metavar="OUT.html", help="linkage and plots, linked by the crank angle"
    )
    parser.add_argument(
        "--json", action="store_true", help="the verdict and the least and largest values as JSON"
    )
    parser.set_defaults(run=lambda arguments: _run(arguments, build))
    return parser


def _run(arguments, build):
    try:
        linkage, options, extra = build(arguments)
        given = arguments.branch if arguments.branch is not None else options.pop("branch", None)
        branch = check_branch(linkage, given)
        if arguments.speed is not None and not 0 < abs(arguments.speed) < math.inf:
            raise ValueError(f"--speed must be finite and not 0, not {arguments.speed:g}")
        if arguments.turns is not None and not 0 < arguments.turns < math.inf:
            raise ValueError(f"--turns must be finite and > 0, not {arguments.turns:g}")
        for name in ("speed", "turns", "drive"):
            if getattr(arguments, name) is not None:
                options[name] = getattr(arguments, name)
        if options.get("drive", "turn") not in DRIVES:
            raise ValueError(
                f"no drive {options['drive']!r}; the known ones are {', '.join(DRIVES)}"
            )
        check_ending("--plot", arguments.plot)
    except ValueError as error:
        raise UsageError(error) from None
    longest = max((v for v in vars(linkage).values() if isinstance(v, float)), default=0.0)
    ask_for_mm(longest)
    options.pop("branch", None)
    if options.get("drive") != "swing":
        options.pop("between", None)
    lines, ranges, files = verdict(linkage, branch) + extra, {}, []
    if not arguments.json:
        print(*lines, sep="\n", flush=True)
    if any((arguments.plot, arguments.csv, arguments.html, arguments.page)):
        result = study(linkage, branch=branch, **options)
        ranges, files = _ranges(result), _write(result, arguments)
        if not arguments.json:
            _print_ranges(result, ranges)
            print(*files, sep="\n")
    if arguments.live:
        _live(linkage, branch, arguments.live)
        files.append(str(arguments.live))
        if not arguments.json:
            print(arguments.live)
    if arguments.json:
        print(json.dumps({"verdict": lines, "ranges": ranges, "files": files}, indent=2))


def _live(linkage, branch, path):
    from ..visualization.play import play

    if isinstance(linkage, FiveBarLinkage):
        if linkage.motors != (1, 5):
            raise UsageError("--live moves a five-bar by the motors at its base, 1 and 5")
        linkage, branch = linkage.robot, None
    play(linkage, branch=branch).save(path)


def _four_bar(arguments):
    linkage = FourBar(arguments.ground, arguments.crank, arguments.coupler, arguments.rocker)
    if arguments.held != "ground":
        linkage = linkage.inversion(arguments.held)
    if arguments.point is not None:
        linkage = replace(linkage, point=tuple(arguments.point))
    return linkage, {}, []


def _slider_crank(arguments):
    return SliderCrank(arguments.crank, arguments.rod, arguments.offset, arguments.held), {}, []


def _press(arguments):
    if arguments.set not in PRESSES:
        raise ValueError(f"no press {arguments.set!r}; the known ones are {', '.join(PRESSES)}")
    linkage, source = PRESSES[arguments.set]
    own = {
        name: value for name in SIX_BAR_LENGTHS if (value := getattr(arguments, name)) is not None
    }
    options = {
        "speed": SPEED,
        "turns": 3.0,
        "gravity": (0.0, 0.0) if arguments.no_gravity else GRAVITY,
    }
    if arguments.load:
        options["load"] = {"E": (0.0, arguments.load)}
    changed = f", with {', '.join(f'{k} = {v:g} m' for k, v in own.items())}" if own else ""
    return replace(linkage, **own), options, [f"source: {source}{changed}"]


def _five_bar(arguments):
    own = {
        f.name: value
        for f in fields(FiveBar)
        if (value := getattr(arguments, f.name, None)) is not None
    }
    return FiveBarLinkage(FiveBar(**own), tuple(arguments.motors)), {"drive": "swing"}, []


def _straight_line(arguments):
    mechanism = straight_line(arguments.name)
    ends, how = sorted(mechanism.stroke), straightness(mechanism)
    first, last = (f"{math.degrees(end):.6f}" for end in ends)
    extra = [
        (
            f"straight stroke {how.stroke:.6g} m with the crank from {first} to {last} deg: off the"
            f" line by at most {how.deviation:.6g} m, band {how.band:.6g} m, {100 * how.ratio:.4g}"
            " % of the stroke"
        ),
        f"source: {mechanism.source}",
    ]
    drive = "turn" if crank_range(mechanism.linkage).full else "swing"
    return (
        mechanism.linkage,
        {"drive": drive, "between": tuple(ends), "branch": mechanism.branch},
        extra,
    )


def _write(result, arguments):
    files = []
    for path, write in (
        (arguments.plot, result.plot),
        (arguments.csv, result.to_csv),
        (arguments.html, result.animate),
        (arguments.page, result.page),
    ):
        if path:
            write(path)
            files.append(str(path))
    return files


def _ranges(result):
    """Return {quantity: [least, largest]} of finite values, [None, None] where there is none."""
    ranges = {}
    for name, values in result.columns.items():
        finite = values[np.isfinite(values)]
        ranges[name] = [float(finite.min()), float(finite.max())] if len(finite) else [None, None]
    return ranges


def _print_ranges(result, ranges):
    from ..visualization.style import of_unit

    print(f"{len(result.t)} samples over {result.t[-1]:.6g} s, least and largest:")
    if result.lock:
        at = ", ".join(f"{math.degrees(angle):.6f}" for angle in _several(result.lock[0]))
        print(f"the run ends before the lock at {at} deg, {result.lock[1]:.6f} s")
    for name, (least, largest) in ranges.items():
        if least is not None:
            print(f"  {name:<24} {least + 0.0:>14.6g} {largest + 0.0:>14.6g} {of_unit(unit(name))}")


def _several(x):
    return x if isinstance(x, tuple) else (x,)
