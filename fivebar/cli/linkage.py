"""`fivebar linkage ...`: the verdict on a linkage, then its study as table, picture and
animation.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

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
from ..linkages.quantities import unit
from ..linkages.six_bar_press import SPEED
from ..models.robots import FiveBar
from ..singularities.degenerate import NAMES as LENGTHS
from .options import (
    JSON,
    add_command,
    print_files,
    print_json,
    usage_errors,
    used_options,
    write_options,
)

PRESS_LENGTHS = ("l2", "l3", "l4", "l5", "l11", "l12")

STUDY = {
    "--speed RAD/S": "default: one turn a second; the press: 120 deg/s",
    "--turns NUMBER": "default: 1; the press: 3",
    "--drive turn|until-lock|swing": "swing is back and forth",
    "--plot OUT.png": "draw it",
    "--csv OUT.csv": "write its table",
    "--html OUT.html": "animation; or .gif, .mp4, .webm, .png",
    "--live PAGE.html": "a page on which it is dragged and its bars slide",
    "--page PAGE.html": "linkage and plots, linked by the crank angle",
}


def add_parsers(commands):
    """Add `linkage` to the program's commands."""
    linkage = commands.add_parser("linkage")
    kinds = linkage.add_subparsers(dest="kind", required=True, metavar="KIND")
    study = STUDY, "study", "written files ask for one; else the verdict is all"
    for name, (words, build, options) in KINDS.items():
        run = partial(_run, build)
        add_command(kinds, name, run, study, (JSON | options,), help=words, description=words)


def _run(build, arguments):
    with usage_errors(ValueError):
        linkage, options, extra = build(arguments)
        options |= used_options(arguments, "branch", "speed", "turns", "drive")
    branch = options.pop("branch", None)
    if options.get("drive") != "swing":
        options.pop("between", None)
    lines = verdict(linkage, branch) + extra
    ranges = {}
    files = []
    if not arguments.json:
        print(*lines, sep="\n", flush=True)
    if used_options(arguments, "plot", "csv", "html", "page"):
        result = study(linkage, branch=branch, **options)
        ranges = _ranges(result)
        writers = {"plot": result.plot, "csv": result.to_csv, "html": result.animate}
        files = write_options(arguments, writers | {"page": result.page})
        if not arguments.json:
            _print_ranges(result, ranges)
    files += write_options(arguments, {"live": partial(_live, linkage, branch)})
    if arguments.json:
        print_json({"verdict": lines, "ranges": ranges, "files": files})
    else:
        print_files(files)


def _live(linkage, branch, path):
    from ..visualization.play import play

    if isinstance(linkage, FiveBarLinkage):
        linkage, branch = linkage.robot, None
    play(linkage, branch=branch).save(path)


def _four_bar(arguments):
    linkage = FourBar(arguments.ground, arguments.crank, arguments.coupler, arguments.rocker)
    linkage = linkage.inversion(arguments.held)
    if arguments.point is not None:
        linkage = replace(linkage, point=tuple(arguments.point))
    return linkage, {}, []


def _slider_crank(arguments):
    return SliderCrank(arguments.crank, arguments.rod, arguments.offset, arguments.held), {}, []


def _press(arguments):
    if arguments.name not in PRESSES:
        raise UsageError(f"no press {arguments.name!r}; the known ones are {', '.join(PRESSES)}")
    linkage, source = PRESSES[arguments.name]
    options = {
        "speed": SPEED,
        "turns": 3.0,
        "gravity": (0.0, 0.0) if arguments.no_gravity else GRAVITY,
        "load": {"E": (0.0, arguments.load)},
    }
    own = used_options(arguments, *PRESS_LENGTHS)
    if own:
        source = f"as {arguments.name}, but for {', '.join(own)}"
    linkage = replace(linkage, **own)
    return linkage, options, [f"source of the set: {source}"]


def _five_bar(arguments):
    motors = tuple(arguments.motors)
    if arguments.live and motors != (1, 5):
        raise UsageError("--live moves a five-bar by the motors at its base, 1 and 5")
    robot = FiveBar(**used_options(arguments, *LENGTHS))
    return FiveBarLinkage(robot, motors), {"drive": "swing"}, []


def _straight_line(arguments):
    mechanism = straight_line(arguments.name)
    ends, how = sorted(mechanism.stroke), straightness(mechanism)
    first, last = map(math.degrees, ends)
    extra = [
        f"straight stroke {how.stroke:.6g} m with the crank from {first:.6f} to {last:.6f} deg: off"
        f" the line by at most {how.deviation:.6g} m, band {how.band:.6g} m,"
        f" {100 * how.ratio:.4g} % of the stroke",
        f"source: {mechanism.source}",
    ]
    drive = "turn" if crank_range(mechanism.linkage).full else "swing"
    options = {"drive": drive, "between": tuple(ends), "branch": mechanism.branch}
    return mechanism.linkage, options, extra


def _ranges(result):
    """Return {quantity: [least, largest]} of finite values, where there are any."""
    return {
        name: [min(finite), max(finite)]
        for name, values in result.columns.items()
        if (finite := values[np.isfinite(values)].tolist())
    }


def _print_ranges(result, ranges):
    from ..visualization.style import of_unit

    print(f"{len(result.t)} samples over {result.t[-1]:.6g} s, least and largest:")
    if result.lock:
        angles, time = result.lock
        angles = ", ".join(f"{angle:.6f}" for angle in np.degrees(np.atleast_1d(angles)))
        print(f"the run ends before the lock at {angles} deg, {time:.6f} s")
    for name, ends in ranges.items():
        least, largest = (round(end, 12) + 0.0 for end in ends)  # -0 is 0
        print(f"  {name:<24} {least:>14.6g} {largest:>14.6g} {of_unit(unit(name))}")


BRANCH = {"--branch -1|1": ""}
KINDS = {  # name: words, the function that builds it, its options
    "four-bar": (
        "four-bar A B C D: lengths in m",
        _four_bar,
        BRANCH
        | dict.fromkeys(("GROUND", "CRANK", "COUPLER", "ROCKER"), "m")
        | {
            "--point X Y": "coupler point from B along BC, to its left, m",
            "--held LINK": ("ground", "ground, crank, coupler or rocker"),
        },
    ),
    "slider-crank": (
        "slider-crank: lengths in m",
        _slider_crank,
        BRANCH
        | dict.fromkeys(("CRANK", "ROD"), "m")
        | {
            "--offset M": (0.0, "of the guide from the crank's pivot"),
            "--held LINK": ("guide", "guide, crank, rod or slider"),
        },
    ),
    "six-bar-press": (
        "six-bar press of Wang, Chen and Deng 2019",
        _press,
        {"--branch -1|1 -1|1": "", "[NAME]": ("repaired", "repaired or printed")}
        | {f"--{name} M": "in place of the set's" for name in PRESS_LENGTHS}
        | {
            "--load NUMBER": (0.0, "on the slider, along +y, N"),
            "--no-gravity": "leave out the weights (along +x in the paper)",
        },
    ),
    "five-bar": (
        "five-bar with its motors at any two joints",
        _five_bar,
        BRANCH
        | {f"--{name} M": "default: the AMORO robot's" for name in LENGTHS}
        | {"--motors N N": ((1, 5), "joints 1 to 5 from base to base")},
    ),
    "straight-line": (
        "evans, chebyshev, watt, hoeken or roberts",
        _straight_line,
        BRANCH | {"NAME": ""},
    ),
}
