"""`fivebar draw`: a drawing read, placed, timed, checked, drawn by the simulated robot; pictures
and tables of it.
"""

from __future__ import annotations

import json
import sys
from argparse import _SubParsersAction
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot

MODES = (-1, -1), (-1, 1), (1, -1), (1, 1)
USUAL = {"acceleration": 0.5, "speed": 0.1}  # m/s^2, m/s: where no limit is given
LOST = 0.01  # of its size, by which a drawing is no longer what was asked for
STEP = 1e-3  # s, of the picture's rows


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `draw` to the program's commands."""
    draw = commands.add_parser("draw")
    draw.add_argument(
        "drawing",
        nargs="?",
        metavar="FILE",
        help="an SVG, G-code (.nc, .gcode, ...) or a CSV of x, y",
    )
    draw.add_argument(
        "--example", action="store_true", help="the word fivebar, shipped with this package"
    )
    draw.add_argument(
        "--units", metavar="UNIT", help="of a file that does not name them: mm, in, px, m"
    )
    draw.add_argument(
        "--deviation",
        type=float,
        default=2e-5,
        metavar="M",
        help="within which corners are rounded (default: %(default)g)",
    )
    place = draw.add_argument_group(
        "place", "default: the middle of the largest rectangle of an aspect, in true size"
    )
    place.add_argument(
        "--at", nargs=2, type=float, metavar=("X", "Y"), help="where the drawing's middle goes, m"
    )
    place.add_argument("--turn-deg", type=float, default=0.0, metavar="DEG", help="to the left")
    place.add_argument("--scale", type=float, metavar="K", help="of the drawing (default: 1)")
    place.add_argument(
        "--largest-clearance",
        action="store_true",
        help="turned and shifted to the largest clearance: takes seconds",
    )
    place.add_argument("--fit", action="store_true", help="as large as it fits")
    place.add_argument(
        "--margin",
        type=float,
        default=0.005,
        metavar="M",
        help="from singularities (default: %(default)g)",
    )
    place.add_argument(
        "--working", nargs=2, type=int, choices=(-1, 1), metavar="W", help="working modes, as -1 -1"
    )
    speed = draw.add_argument_group(
        "speed", "least time under these limits; default: 0.1 m/s and 0.5 m/s²"
    )
    speed.add_argument("--torque-limit", type=float, metavar="NM", help="of either motor")
    speed.add_argument(
        "--reserve",
        type=float,
        default=0.05,
        metavar="SHARE",
        help="of it, for the tracker (default: %(default)g)",
    )
    speed.add_argument("--speed-limit", type=float, metavar="M/S", help="of the pen")
    speed.add_argument("--acceleration-limit", type=float, metavar="M/S2", help="of the pen")
    speed.add_argument("--joint-speed-limit", type=float, metavar="RAD/S")
    speed.add_argument("--duration", type=float, metavar="S", help="asked for instead of the least")
    proof = draw.add_argument_group(
        "proof", "that all robots within the tolerance reach it, in their mode"
    )
    proof.add_argument(
        "--tolerance",
        type=float,
        default=5e-5,
        metavar="M",
        help="of all five lengths (default: %(default)g)",
    )
    proof.add_argument(
        "--through", action="store_true", help="it may cross Type 2, where there is then no proof"
    )
    proof.add_argument(
        "--sine",
        type=float,
        default=0.0,
        metavar="SINE",
        help="least |sin q12|, |sin q22|, |det A| (default: above 0)",
    )
    draw.add_argument(
        "--period",
        type=float,
        metavar="S",
        help="of the tracker (default: 0.005, or as the fastest motion asks)",
    )
    draw.add_argument(
        "--rate",
        type=float,
        default=1000.0,
        metavar="HZ",
        help="of the setpoints (default: %(default)g)",
    )
    draw.add_argument("--angles", choices=("rad", "deg"), default="rad", help="of the setpoints")
    draw.add_argument(
        "--out",
        type=Path,
        default=Path("fivebar-draw"),
        metavar="DIR",
        help="folder for drawing.png, setpoints.csv, run.csv and proof.json (default: %(default)s)",
    )
    draw.add_argument("--json", action="store_true", help="the figures as JSON on stdout")
    add_robot_options(draw)
    draw.set_defaults(run=_draw)


def _draw(arguments):
    from ..base.progress import progress
    from ..control.matched import matched, missed, peak_acceleration, period_for
    from ..models.geometry import igm
    from ..models.kinematics import ikm
    from ..paths import strokes
    from ..paths.setpoints import setpoints
    from ..simulation.comparison import peak_name
    from ..simulation.simulate import simulate

    robot, path = chosen_robot(arguments), _read(arguments)
    for sentence in path.notes:
        print(f"{arguments.drawing}: {sentence}", file=sys.stderr)
    path, working, share = _placed(arguments, robot, path)
    check = _checked(arguments, robot, path, working)
    proof = _proved(arguments, robot, path, working) if check.singularity_free else None
    with progress(total=2, desc="least time", unit=" steps", leave=False) as bar:
        motion = _timed(arguments, robot, path, working)
        bar.set_description("simulated")
        bar.update()
        start = ikm(igm(robot, motion(0.0)[0], working), (0.0, 0.0))
        limit, assembly = arguments.torque_limit, int(start.pose.assembly)
        peak = peak_acceleration(motion, 0.0, motion.duration)
        period = period_for(robot, peak) if arguments.period is None else arguments.period
        tracker = matched(robot, peak, period, limit, assembly)
        step = period / max(1, round(period / STEP))
        run = simulate(
            robot,
            tracker,
            motion,
            start=start,
            control_period=period,
            step=step,
            torque_limit=limit,
        )
    table = setpoints(robot, motion, arguments.rate, working)
    down = strokes.pen_down(motion, run.t)
    error = np.linalg.norm(run.error, axis=1)
    figures = {
        "file": str(arguments.drawing),
        "strokes": len(strokes.runs(down)),
        "pieces": len(path.pieces),
        "length_m": path.length,
        "drawn_m": sum(p.length for p, pen in zip(path.pieces, path.pen) if pen),
        "working": list(working),
        "largest_scale": share,
        "duration_s": motion.duration,
        "lower_bound_s": motion.lower_bound,
        "period_s": period,
        "peak_acceleration": peak,
        "smallest_margin": check.min_margin,
        "certified": proof is not None and proof.proved,
        "max_error_m": float(error[down].max()),
        "rms_error_m": float(np.sqrt(np.mean(error[down] ** 2))),
        peak_name(robot): np.abs(run.tau).max(axis=0).tolist(),
        "setpoints": len(table.t),
    }
    if limit is not None:
        figures["saturated_fraction"] = float(np.mean(run.saturated[:-1].any(axis=1)))
    size = np.ptp(run.xi_ref[down], axis=0).max()
    if figures["max_error_m"] > LOST * size:
        print(
            f"fivebar: the simulated robot leaves its drawing of {1e3 * size:.3g} mm by"
            f" {1e3 * figures['max_error_m']:.3g} mm: the setpoints are right, but too fast for its"
            f" tracker, which changes its torques each {1e3 * period:.3g} ms, when {peak:.3g} m/s²"
            f" move it {1e3 * missed(peak, period):.2g} mm: give a --duration, a larger --reserve"
            " or a shorter --period",
            file=sys.stderr,
        )
    files = _written(arguments, robot, path, working, run, table, down, error)
    place = arguments.out / "proof.json"
    if proof is not None and proof.proved:
        files.append(str(place))
        proof.to_json(place)
    elif place.is_file():  # beside this drawing it would be a lie
        place.unlink()
        print(f"{place}: of an earlier drawing; removed", file=sys.stderr)
    if arguments.json:
        print(json.dumps({**figures, "notes": list(path.notes), "files": files}, indent=2))
        return
    _print(robot, figures)
    print(*files, sep="\n")


def _read(arguments):
    """The Path of the drawing, in its own place."""
    from ..paths.reading.read import EXAMPLE, path

    if arguments.example == (arguments.drawing is not None):
        raise UsageError("draw needs a file, or --example")
    arguments.drawing = arguments.drawing or str(EXAMPLE)
    try:
        return path(arguments.drawing, deviation=arguments.deviation, units=arguments.units)
    except (ValueError, OSError, ImportError) as error:
        raise UsageError(error) from None


def _placed(arguments, robot, path):
    """The path where it is to be drawn, the working modes, and the largest scale that is known to
    fit, or None.
    """
    from ..constraints.constraints import Constraints
    from ..paths.placement import Placement
    from ..paths.placing.fitting_in import bounds, fitted_in
    from ..paths.placing.place import place

    if arguments.fit and (arguments.scale or arguments.at):
        raise UsageError("--fit chooses scale and place: it goes without --scale and --at")
    turn, scale = np.deg2rad(arguments.turn_deg), arguments.scale or 1.0
    if arguments.at is None:
        if not robot.turns:
            raise UsageError(
                "a biglide's aspects have no ends to fit into: say where with --at X Y"
            )
        scale = None if arguments.fit else scale
        if arguments.largest_clearance:
            turn = turn if arguments.turn_deg else None
            placed = place(
                robot,
                path,
                working=arguments.working,
                turn=turn,
                scale=scale,
                constraints=Constraints(clearance=arguments.margin),
            )
            return placed.path, placed.working, placed.largest
        fit = fitted_in(robot, path, turn, scale, arguments.working, arguments.margin)
        return fit.placement(path), fit.aspect.working, fit.scale
    first = Placement((0.0, 0.0), turn, scale)(path)
    shift = np.array(arguments.at) - bounds(first).mean(axis=0)
    placed = Placement(tuple(shift.tolist()))(first)
    return placed, _modes(arguments, robot, placed), None


def _modes(arguments, robot, path):
    """The working modes in which the path keeps farthest from singularities, of those that it can
    be followed in.
    """
    from ..constraints.path_check import check_path

    modes = [tuple(arguments.working)] if arguments.working else MODES
    found = {mode: check_path(robot, path.at_unit_speed, mode) for mode in modes}
    free = {mode: check.min_margin for mode, check in found.items() if check.singularity_free}
    free = free or {mode: 0.0 for mode, check in found.items() if _passes(arguments, check)}
    if not free:
        reasons = {}
        for mode, check in found.items():
            reasons.setdefault(_met(path, check), []).append(str(mode))
        why = "; ".join(
            f"in working modes {', '.join(own)} {words}" for words, own in reasons.items()
        )
        raise ValueError(f"{arguments.drawing}: it cannot be drawn there: {why}")
    return max(free, key=free.get)


def _passes(arguments, check):
    """Whether a path may go on where it meets the first singularity; whether it can, `time_path`
    finds.
    """
    return arguments.through and check.leaves is None and int(check.type) == 2


def _met(path, check):
    """Where a path that is not free of singularities meets the first, in words."""
    s = check.leaves if check.time is None else check.time
    x, y = 1e3 * path(s)[0]
    what = (
        "leaves the workspace"
        if check.leaves == s
        else f"{'touches' if check.touching else 'meets'} Type {int(check.type)}"
    )
    line = path.line_of(s)
    return (
        f"it {what} at ({x:.4g}, {y:.4g}) mm, {1e3 * s:.4g} mm along"
        f" it{f' (line {line})' if line else ''}"
    )


def _timed(arguments, robot, path, working):
    """The motion along the path in the least time."""
    from ..constraints.constraints import Constraints
    from ..paths.timing.time_path import time_path

    limits = {}
    for name in ("torque", "speed", "acceleration", "joint_speed"):
        limit = getattr(arguments, f"{name}_limit")
        if limit is not None:
            limits[name] = limit
    if not 0 <= arguments.reserve < 1:
        raise UsageError(f"--reserve must be from 0 to below 1, not {arguments.reserve:g}")
    if "torque" in limits:
        limits["torque"] *= 1 - arguments.reserve
    constraints = Constraints(**(limits or USUAL))
    return time_path(robot, path, arguments.duration, constraints=constraints, working=working)


def _checked(arguments, robot, path, working):
    """What `check_path` says of it in these modes; an error where it is not free of
    singularities.
    """
    from ..constraints.path_check import check_path

    check = check_path(robot, path.at_unit_speed, working)
    if not (check.singularity_free or _passes(arguments, check)):
        raise ValueError(f"{arguments.drawing}: in working modes {working} {_met(path, check)}")
    return check


def _proved(arguments, robot, path, working):
    """The Certificate, or None of a robot of another kind; where it is not proved, that is said."""
    if not robot.turns:
        return None
    from ..constraints.constraints import Constraints
    from ..paths.certificates.certify import certify

    constraints = Constraints(det_A=arguments.sine, sin=arguments.sine)
    proof = certify(robot, path, arguments.tolerance, constraints, working)
    for each in proof.unproved:
        verdict = "false" if each.false else "not proved"
        where = f"from s = {1e3 * each.start:.6g} to {1e3 * each.stop:.6g} mm"
        print(f"{arguments.drawing}: {where} it is {verdict}: {each.why}", file=sys.stderr)
    return proof


def _written(arguments, robot, path, working, run, table, down, error):
    """The picture, the setpoints and the run, in their folder."""
    from ..base.tables import saved
    from ..paths import strokes
    from ..visualization.plot.drawing import drawing

    arguments.out.mkdir(parents=True, exist_ok=True)
    files = [arguments.out / name for name in ("drawing.png", "setpoints.csv", "run.csv")]
    rows = strokes.runs(down)
    title = (
        f"{Path(arguments.drawing).name}: drawn in {run.t[-1]:.4g} s, within"
        f" {1e6 * error[down].max():.3g} µm"
    )
    picture = drawing(
        robot,
        working,
        strokes.outlines(path),
        [run.xi[each] for each in rows],
        [error[each] for each in rows],
        title,
    )
    saved(picture, files[0], dpi=150)
    table.to_csv(files[1], arguments.angles)
    run.to_csv(files[2])
    return list(map(str, files))


def _print(robot, figures):
    from ..simulation.comparison import peak_name
    from ..visualization.style import length

    words = robot.words
    left, right = figures[peak_name(robot)]
    bound = 100 * (figures["duration_s"] / figures["lower_bound_s"] - 1)
    rows = [
        (
            "drawn",
            (
                f"{1e3 * figures['drawn_m']:.4g} mm in {figures['strokes']} strokes,"
                f" {figures['pieces']} pieces"
            ),
        ),
        ("working modes", ", ".join(f"{sign:+d}" for sign in figures["working"])),
        (
            "time",
            f"{figures['duration_s']:.4f} s, within {bound:.2g} % of the least that is possible",
        ),
        ("smallest margin", f"{figures['smallest_margin']:.4f} (sine of a leg, or det A)"),
        ("certified", "yes, proof.json" if figures["certified"] else "no"),
        ("largest error", length(figures["max_error_m"])),
        ("RMS error", length(figures["rms_error_m"])),
        (
            "tracker's period",
            (
                f"{1e3 * figures['period_s']:.4g} ms, of {figures['peak_acceleration']:.3g} m/s² at"
                " most"
            ),
        ),
        (f"peak {words.effort}", f"{1e3 * left:.3f}, {1e3 * right:.3f} m{words.effort_unit}"),
        ("setpoints", f"{figures['setpoints']} rows"),
    ]
    if "saturated_fraction" in figures:
        rows.insert(-1, ("saturated", f"{100 * figures['saturated_fraction']:.0f} % of the time"))
    for name, value in rows:
        print(f"  {name:<20} {value}")
