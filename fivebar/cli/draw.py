"""`fivebar draw`: a drawing read, placed, timed, checked, drawn by the simulated robot; pictures
and tables of it.
"""

from __future__ import annotations

import sys
from argparse import _SubParsersAction
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from ..base.folders import locked_folder
from .options import (
    JSON,
    WORKING,
    add_options,
    print_files,
    print_json,
    print_notes,
    print_table,
    usage_errors,
    used_options,
)
from .robot_options import add_robot_options, chosen_robot

MODES = (-1, -1), (-1, 1), (1, -1), (1, 1)
USUAL = {"acceleration": 0.5, "speed": 0.1}  # m/s^2, m/s: where no limit is given
LARGE_ERROR = 0.01  # of a drawing's size: beyond, it is not what was asked for
STEP = 1e-3  # s, of the simulation
DRAWING = {
    "--example": "the word fivebar, shipped with this package",
    "--units UNIT": "of a file that does not name them: mm, in, px, m",
    "--deviation M": (2e-5, "within which corners are rounded"),
}
PLACE = {
    "--at X Y": "where the drawing's middle goes, m",
    "--turn-deg DEG": (0.0, "to the left"),
    "--scale K": "of the drawing (default: 1)",
    "--fit": "as large as it fits",
    "--margin M": (0.005, "from singularities"),
    WORKING: "working modes, as -1 -1",
}
SPEED = {
    "--torque-limit NM": "of either motor",
    "--reserve SHARE": (0.05, "of it, for the tracker"),
    "--speed-limit M/S": "of the pen",
    "--acceleration-limit M/S2": "of the pen",
    "--joint-speed-limit RAD/S": "of either joint",
    "--duration S": "asked for instead of the least",
}
PROOF = {
    "--tolerance M": (5e-5, "of all five lengths"),
    "--through": "it may cross Type 2, where there is then no proof",
}
OUTPUT = JSON | {
    "--period S": "of the tracker (default: 0.005, or as the fastest motion asks)",
    "--rate HZ": (1000.0, "of the setpoints"),
    "--angles rad|deg": ("rad", "of the setpoints"),
    "--out DIR": (
        Path("fivebar-draw"),
        "folder for drawing.png, setpoints.csv, run.csv and proof.json",
    ),
}


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `draw` to the program's commands."""
    draw = commands.add_parser("draw")
    words = "an SVG, G-code (.nc, .gcode, ...) or a CSV of x, y"
    draw.add_argument("drawing", nargs="?", metavar="FILE", help=words)
    add_options(draw, DRAWING)
    words = "default: the middle of the largest rectangle of an aspect, in true size"
    add_options(draw, PLACE, "place", words)
    words = "least time under these limits; default: 0.1 m/s and 0.5 m/s²"
    add_options(draw, SPEED, "speed", words)
    words = "that all robots within the tolerance reach it, in their mode"
    add_options(draw, PROOF, "proof", words)
    add_options(draw, OUTPUT)
    add_robot_options(draw)
    draw.set_defaults(run=_draw)


def _draw(arguments):
    from ..control.matched import matched, peak_acceleration, period_for
    from ..models.geometry import igm
    from ..models.kinematics import ikm
    from ..paths import strokes
    from ..paths.setpoints import setpoints
    from ..simulation.comparison import peak_name
    from ..simulation.simulate import simulate

    robot = chosen_robot(arguments)
    path = _read(arguments)
    print_notes(arguments.drawing, path.notes)
    path, working, share = _placed(arguments, robot, path)
    check = _checked(arguments, robot, path, working)
    proof = _proved(arguments, robot, path, working) if check.singularity_free else None
    motion = _timed(arguments, robot, path, working)
    start = ikm(igm(robot, motion(0.0)[0], working), (0.0, 0.0))
    limit = arguments.torque_limit
    peak = peak_acceleration(motion, 0.0, motion.duration)
    period = period_for(robot, peak) if arguments.period is None else arguments.period
    run = simulate(
        robot,
        matched(robot, peak, period, limit, int(start.pose.assembly)),
        motion,
        start=start,
        control_period=period,
        step=period / max(1, round(period / STEP)),
        torque_limit=limit,
    )
    table = setpoints(robot, motion, arguments.rate, working)
    down = strokes.pen_down(motion, run.t)
    error = np.linalg.norm(run.error, axis=1)
    figures = {
        "strokes": len(strokes.runs(down)),
        "drawn_m": sum(piece.length for piece, pen in zip(path.pieces, path.pen) if pen),
        "working": list(working),
        "largest_scale": share,
        "duration_s": motion.duration,
        "lower_bound_s": motion.lower_bound,
        "period_s": period,
        "peak_acceleration": peak,
        "smallest_margin": check.min_margin,
        "certified": proof is not None and proof.proved,
        "max_error_m": float(error[down].max()),
        peak_name(robot): np.abs(run.tau).max(axis=0).tolist(),
    }
    size = np.ptp(run.xi_ref[down], axis=0).max()
    if figures["max_error_m"] > LARGE_ERROR * size:
        print(
            f"fivebar: the simulated robot leaves its drawing by {1e3 * figures['max_error_m']:.3g}"
            " mm: the motion is too fast for its tracker: give a --duration, a larger --reserve or"
            " a shorter --period",
            file=sys.stderr,
        )
    files = _written(arguments, robot, path, working, run, table, down, error)
    certificate = arguments.out / "proof.json"
    certificate.unlink(missing_ok=True)  # that of an earlier drawing would be false
    if figures["certified"]:
        files.append(certificate)
        proof.to_json(certificate)
    if arguments.json:
        print_json({**figures, "notes": list(path.notes), "files": files})
        return
    _print(robot, figures)
    print_files(files)


def _read(arguments):
    """Return the Path of the drawing, in its own place."""
    from ..paths.reading.read import EXAMPLE, path

    if arguments.example == (arguments.drawing is not None):
        raise UsageError("draw needs a file, or --example")
    arguments.drawing = arguments.drawing or str(EXAMPLE)
    with usage_errors(ValueError, OSError, ImportError):
        return path(arguments.drawing, deviation=arguments.deviation, units=arguments.units)


def _placed(arguments, robot, path):
    """Return the path in its place, the working modes, and the largest scale known to fit, or
    None.
    """
    from ..paths.placement import Placement
    from ..paths.placing.fitting_in import bounds, fitted_in

    if arguments.fit and (arguments.scale or arguments.at):
        raise UsageError("--fit chooses scale and place: it goes without --scale and --at")
    turn = np.deg2rad(arguments.turn_deg)
    scale = arguments.scale or 1.0
    if arguments.at is not None:
        first = Placement((0.0, 0.0), turn, scale)(path)
        shift = np.array(arguments.at) - bounds(first).mean(axis=0)
        placed = Placement(tuple(shift.tolist()))(first)
        return placed, _modes(arguments, robot, placed), None
    if not robot.turns:
        raise UsageError("a biglide's aspects have no ends to fit into: say where with --at X Y")
    scale = None if arguments.fit else scale
    fit = fitted_in(robot, path, turn, scale, arguments.working, arguments.margin)
    return fit.placement(path), fit.aspect.working, fit.scale


def _modes(arguments, robot, path):
    """Return the working modes in which the path keeps farthest from singularities."""
    from ..constraints.path_check import check_path

    modes = [tuple(arguments.working)] if arguments.working else MODES
    checks = {mode: check_path(robot, path.at_unit_speed, mode) for mode in modes}
    margins = {mode: check.min_margin for mode, check in checks.items() if check.singularity_free}
    possible = [mode for mode, check in checks.items() if _may_cross(arguments, check)]
    # `_checked` says what is in the way where no mode is possible.
    return max(margins, key=margins.get) if margins else [*possible, *modes][0]


def _may_cross(arguments, check):
    """Return whether a path may go on where it meets the first singularity; whether it can,
    `time_path` finds.
    """
    return arguments.through and check.leaves is None and int(check.type) == 2


def _met(path, check):
    """Return in words where a path meets the first singularity."""
    s = check.leaves if check.time is None else check.time
    x, y = 1e3 * path(s)[0]
    what = "leaves the workspace" if check.leaves == s else f"meets Type {int(check.type)}"
    line = path.line_of(s)
    where = f" (line {line})" if line else ""
    return f"it {what} at ({x:.4g}, {y:.4g}) mm, {1e3 * s:.4g} mm along it{where}"


def _timed(arguments, robot, path, working):
    """Return the motion along the path in the least time."""
    from ..constraints.constraints import Constraints
    from ..paths.timing.time_path import time_path

    options = ("torque_limit", "speed_limit", "acceleration_limit", "joint_speed_limit")
    values = used_options(arguments, *options)
    limits = {name.removesuffix("_limit"): value for name, value in values.items()}
    if not 0 <= arguments.reserve < 1:
        raise UsageError(f"--reserve must be from 0 to below 1, not {arguments.reserve:g}")
    if "torque" in limits:
        limits["torque"] *= 1 - arguments.reserve
    constraints = Constraints(**(limits or USUAL))
    return time_path(robot, path, arguments.duration, constraints=constraints, working=working)


def _checked(arguments, robot, path, working):
    """Return the result of `check_path`; ValueError where a singularity is in the way."""
    from ..constraints.path_check import check_path

    check = check_path(robot, path.at_unit_speed, working)
    if not (check.singularity_free or _may_cross(arguments, check)):
        where = f"in working modes {working} {_met(path, check)}"
        raise ValueError(f"{arguments.drawing}: it cannot be drawn there: {where}")
    return check


def _proved(arguments, robot, path, working):
    """Return the Certificate, None for a biglide; say where it is not proved."""
    if not robot.turns:
        return None
    from ..paths.certificates.certify import certify

    proof = certify(robot, path, arguments.tolerance, working=working)
    for stretch in proof.unproved:
        ends = f"from s = {1e3 * stretch.start:.6g} to {1e3 * stretch.stop:.6g} mm"
        print_notes(arguments.drawing, [f"{ends} not proved: {stretch.why}"])
    return proof


def _written(arguments, robot, path, working, run, table, down, error):
    """Write the picture, the setpoints and the run; return their files."""
    from ..base.tables import saved
    from ..paths import strokes
    from ..visualization.plot.drawing import drawing

    files = [arguments.out / name for name in ("drawing.png", "setpoints.csv", "run.csv")]
    rows = strokes.runs(down)
    picture = drawing(
        robot,
        working,
        strokes.outlines(path),
        [run.xi[row] for row in rows],
        [error[row] for row in rows],
        f"drawn in {run.t[-1]:.4g} s, within {1e6 * error[down].max():.3g} µm",
    )
    with locked_folder(arguments.out):
        saved(picture, files[0], dpi=150)
        table.to_csv(files[1], arguments.angles)
        run.to_csv(files[2])
    return files


def _print(robot, figures):
    from ..simulation.comparison import peak_name
    from ..visualization.style import length

    words = robot.words
    left, right = figures[peak_name(robot)]
    bound = 100 * (figures["duration_s"] / figures["lower_bound_s"] - 1)
    drawn = 1e3 * figures["drawn_m"]
    peak = figures["peak_acceleration"]
    print_table(
        [
            ("drawn", f"{drawn:.4g} mm in {figures['strokes']} strokes"),
            ("working modes", ", ".join(f"{sign:+d}" for sign in figures["working"])),
            ("time", f"{figures['duration_s']:.4f} s, within {bound:.2g} % of the least possible"),
            ("smallest margin", f"{figures['smallest_margin']:.4f} (sine of a leg, or det A)"),
            ("certified", "yes, proof.json" if figures["certified"] else "no"),
            ("largest error", length(figures["max_error_m"])),
            ("tracker's period", f"{1e3 * figures['period_s']:.4g} ms, for {peak:.3g} m/s²"),
            (f"peak {words.effort}", f"{1e3 * left:.3f}, {1e3 * right:.3f} m{words.effort_unit}"),
        ]
    )
