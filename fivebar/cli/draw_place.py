"""`fivebar draw`: where the drawing lies, and in which modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.checks import positive
from ..base.errors import UnreachableError, UsageError
from ..base.representation import working_words
from .options import WORKING, changed_options, option_of, point_words, print_notes, size_words

MODES = (-1, -1), (-1, 1), (1, -1), (1, 1)
MARGIN = 0.005  # m, from singularities
SAMPLES = 501  # of a motion, whose assembly modes are looked at
PLACE = {
    "--at X Y": "where the drawing's middle goes, m",
    "--as-drawn": "at the coordinates that the file has, in the robot's measuring frame",
    "--turn-deg DEG": (0.0, "to the left"),
    "--scale K": "of the drawing (default: 1)",
    "--fit": "as large as it fits, in the workspace or on the page",
    "--page M M": "width and height of a sheet, all of it in the workspace; 0, 0 of the drawing is"
    " its lower left corner",
    "--margin M": "from singularities (default: clearance of the robot's file, or 0.005, with --fit"
    " and no page a tenth of the shortest bar)",
    WORKING: "working modes, as -1 -1",
}
CHOOSE = {  # option: what it does, and the options that would do it otherwise
    "fit": ("chooses scale and place", ("scale", "at")),
    "page": ("finds a place for the sheet", ("at",)),
    "at": ("chooses the place, for which --margin looks", ("margin",)),
    "as_drawn": (
        "keeps a drawing where it is",
        ("at", "turn_deg", "scale", "fit", "page", "margin"),
    ),
}


def placed(arguments, machine, path):
    """Return the path in its place in the robot's frame, the working modes, the largest scale known
    to fit, or None, and the corners (5, 2) of the page, or None.
    """
    from ..paths.placement import Placement
    from ..paths.placing.fitting_in import bounds, fitted_in
    from ..paths.reading.read import path as path_of

    changed = changed_options(arguments)
    for option, (effect, others) in CHOOSE.items():
        if option in changed and changed.intersection(others):
            first, *names = map(option_of, (option, *others))
            raise UsageError(f"{first} {effect}: it goes without {' and '.join(names)}")
    robot = machine.robot
    turn = np.deg2rad(arguments.turn_deg)
    scale = 1.0 if arguments.scale is None else positive(arguments.scale, "scale")
    if arguments.at is not None or arguments.as_drawn:
        placed = path
        if arguments.at is not None:
            first = Placement((0.0, 0.0), turn, scale)(path)
            shift = arguments.at - bounds(first).mean(axis=0)
            placed = Placement(tuple(shift.tolist()))(first)
        working = _modes(arguments, machine, placed)
        return machine.led(placed, working), working, None, None
    if not robot.turns:
        raise UsageError(
            "a biglide's aspects have no ends to fit into: say where with --at X Y or --as-drawn"
        )
    corners = None
    to_robot = machine.frame.inverse
    if arguments.page is not None:
        path, corners = _on_page(arguments, path, scale)
        whole = path_of(corners)
        scale = 1.0
    else:
        whole = path
        scale = None if arguments.fit else scale
    margin = arguments.margin
    if margin is None:
        bars = *robot.distal, *(drive.length for drive in robot.drives)
        usual = min(bars) / 10 if scale is None else MARGIN
        margin = machine.constraints.clearance or usual
    kept = replace(machine.on_poses, clearance=margin)
    chosen = arguments.working, kept, machine.tool, machine.measured
    scale = scale and scale * to_robot.scale
    fit = fitted_in(robot, whole, turn + to_robot.turn, scale, *chosen)
    working = fit.aspect.working
    placed = machine.led(machine.frame(fit.placement(path)), working)
    page = None if corners is None else fit.placement(corners)
    return placed, working, fit.scale * machine.frame.scale, page


def _on_page(arguments, path, scale):
    """Return the path in its place on the page, and the page's corners (5, 2), m."""
    from ..paths.placement import Placement
    from ..paths.placing.fitting_in import bounds

    size = np.array([positive(side, "page") for side in arguments.page])
    shift = np.zeros(2)
    if arguments.fit:
        low, high = bounds(path)
        scale = float((size / np.maximum(high - low, 1e-9)).min())
        shift = (size - scale * (low + high)) / 2
    on_page = Placement(tuple(shift.tolist()), 0.0, scale)(path)
    first, last = bounds(on_page)
    if (first < -1e-9).any() or (last > size + 1e-9).any():
        raise UsageError(
            f"{arguments.file}: it is not all on the page of {size_words(size)}, as its corners are"
            f" {(1e3 * first).round(1)} and {(1e3 * last).round(1)} mm: --fit puts it there"
        )
    return on_page, size * [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]


def says_other_modes(arguments, machine, motion):
    """Return whether the machine was calibrated in the modes of a motion, and say if not; None
    where its file does not tell.
    """
    if not machine.measured:
        return None
    t = np.linspace(0.0, motion.duration, SAMPLES)
    assembly = motion.accelerations(t).rates.pose.assembly
    modes = np.unique(assembly[assembly != 0]).tolist()
    others = [sign for sign in modes if not machine.is_measured(motion.working, sign)]
    for sign in others:
        words = (
            f"it was calibrated in {machine.measured_words}; this drawing is in"
            f" {working_words(motion.working)} with assembly mode {sign:+d}, where it may be"
            " several times less exact: measure points in these modes, too"
        )
        print_notes(arguments.robot, [words])
    return not others


def _modes(arguments, machine, path):
    """Return the working modes in which the path keeps farthest from singularities; those in which
    the robot was calibrated, if the path is free of singularities there; if it is so in none, those
    in which least is in the way.
    """
    from ..constraints.path_check import check_path
    from ..models.geometry import igm

    modes = [tuple(arguments.working)] if arguments.working else MODES
    robot, kept = machine.robot, machine.on_poses
    checks = {}
    measured = []
    refused = None
    for mode in modes:
        try:
            led = machine.led(path, mode).at_unit_speed
            start = igm(robot, led(0.0)[0], mode, unreachable="nan")
        except UnreachableError as error:  # of a tool
            refused = error
            continue
        checks[mode] = check_path(robot, led, mode, None, kept)
        if machine.is_measured(mode, int(start.assembly)):
            measured.append(mode)
    if not checks:
        raise refused

    def worth(mode):
        check = checks[mode]
        violations = [each.by for each in check.broken]
        return (
            not violations and check.singularity_free,
            not violations and may_cross(arguments, check),
            check.singularity_free,
            -len(violations),
            -sum(violations),
            mode in measured,
            check.min_margin,
        )

    return max(checks, key=worth)  # `_checked` says what is in the way


def may_cross(arguments, check):
    """Return whether a path may go on where it meets the first singularity; whether it can,
    `time_path` finds.
    """
    return arguments.through and check.leaves is None and int(check.type) == 2


def page_row(corners):
    """Return the row that says where the page lies, in the frame of the table."""
    if corners is None:
        return []
    first, along, *_ = np.array(corners)
    turn = np.rad2deg(np.arctan2(*(along - first)[::-1])).round(9) + 0.0  # -0 is 0
    return [("page", f"its lower left corner at {point_words(first)}, turned by {turn:.4g}°")]
