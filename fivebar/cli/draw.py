"""`fivebar draw`: a drawing read, placed, timed, checked, drawn by the simulated robot; pictures
and tables of it.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.checks import not_negative, optional, positive
from ..base.errors import UsageError
from ..base.representation import working_words
from ..base.tables import saved
from ..paths.curve import DEVIATION
from ..singularities.degenerate import EVERYWHERE
from .draw_gcode import GCODE, Drawn, dialect_of, machine_of_axes, written_gcode
from .draw_place import PLACE, may_cross, page_row, placed, says_other_modes
from .options import (
    TABLE,
    add_command,
    point_words,
    print_files,
    print_json,
    print_message,
    print_notes,
    print_table,
    usage_errors,
    used_options,
    write_files,
)
from .robot_options import (
    add_robot_options,
    chosen_limits,
    chosen_machine,
    machine_for,
    peak_row,
    print_frames,
    refuse_angles,
)

USUAL = {"acceleration": 0.5, "speed": 0.1}  # m/s^2, m/s: where no limit is given
LARGE_ERROR = 0.01  # of a drawing's size: beyond, it is not what was asked for
LEAP = 10.0  # times its median: an error that a place has, and not the whole motion
COUNTS = 3.0  # of the encoders, at the tip: a smaller error is theirs
TWICE = 2.0  # times the largest torque that the motion needs: its tracker is not in control
STEP = 1e-3  # s, of the simulation
# What a robot draws that is not simulated.
NOTHING = Drawn(np.empty((0, 2)), np.empty(0), np.empty(0, bool), {})
SAMPLES = 2001  # of the motion, for backlash
DRAWING = {
    "[FILE]": "an SVG, G-code (.nc, .gcode, ...) or a CSV of x, y",
    "--example": "the word fivebar, shipped with this package",
    "--units UNIT": "of a file that does not name them: mm, in, px, m",
    "--deviation M": (DEVIATION, "within which corners are rounded"),
}
SPEED = {
    "--motor NAME": "of both joints, by its torque-speed line: a name of `fivebar sweep --list`",
    "--torque-limit NM": "of either motor",
    "--reserve SHARE": (0.05, "of it, for the tracker"),
    "--speed-limit M/S": "of the pen",
    "--acceleration-limit M/S2": "of the pen",
    "--joint-speed-limit RAD/S": "of either joint",
    "--duration S": "asked for instead of the least",
    "--accept-slow": "write a motion, too, that takes over 1 percent longer than its proved bound",
    "--pen-time S": (0.0, "of rest where the pen goes down or up, at both ends too"),
    "--lead M": "of run-up and run-out in the air, so that strokes begin and end in motion, as with"
    " a laser: no rest there",
}
DRIVES = {
    "--counts-per-turn N": "of the encoders: what the simulated controller reads",
    "--delay N": (0, "of the simulated controller, periods"),
    "--backlash RAD": (0.0, "of each joint: by how much it may turn while its motor holds"),
}
PROOF = {
    "--tolerance M": (5e-5, "of all five lengths"),
    "--through": "it may cross Type 2, where there is then no proof",
}
OUTPUT = TABLE | {
    "--period S": "of the tracker (default: 0.005, or as the fastest motion asks)",
    "--rate HZ": (1000.0, "of the setpoints"),
    "--angles rad|deg|counts": ("rad", "of the setpoints"),
    "--drive NAME": "drives.csv of dynamixel, dynamixel-extended, odrive, moteus, or counts a turn",
    "--zero-counts NUMBER NUMBER": "what the drives are told where the readings are 0",
    "--wrap": "drives' counts by whole turns into their range",
    "--binary": "drives.bin, 32 bits, in place of drives.csv",
    "--out DIR": (
        Path("fivebar-draw"),
        "folder for drawing.png, proof.json, and setpoints.csv and run.csv or drawing.nc",
    ),
}


def add_parsers(commands):
    """Add `draw` to the program's commands."""
    place = (
        "default: in true size, in the middle of the largest rectangle of its shape in an aspect;"
        " of a calibrated robot in the modes in which it was measured, if it fits there"
    )
    gcode = "joint angles for a controller that does not know the robot; with --format gcode"
    groups = (
        (DRAWING,),
        (PLACE, "place", place),
        (SPEED, "speed", "least time under these limits; default: 0.1 m/s and 0.5 m/s²"),
        (DRIVES, "drives", "what is between the motors and the tip"),
        (PROOF, "proof", "that all robots within the tolerance reach it, in their mode"),
        (GCODE, "G-code", gcode),
        (OUTPUT,),
    )
    add_robot_options(add_command(commands, "draw", _draw, *groups))


def _draw(arguments):
    from ..paths import strokes
    from ..paths.placing.fitting_in import bounds

    dialect = dialect_of(arguments)
    user = "draw --at" if arguments.at else "draw --as-drawn" if arguments.as_drawn else "draw"
    machine = machine_of_axes(arguments, chosen_machine(arguments, user), dialect)
    counts = arguments.counts_per_turn
    if arguments.angles == "counts" and counts is None:
        raise UsageError("--angles counts needs --counts-per-turn")
    # A unit that the axes or drives cannot have is refused before the work.
    if dialect is not None:
        dialect.scale(machine)
    else:
        refuse_angles(arguments, machine, _counts_of_angles(arguments))
    if arguments.lead is not None and (arguments.pen_time or dialect is not None):
        words = "a pen that needs time rests, and firmware rests for M3 and M5"
        raise UsageError(f"--lead goes without --pen-time and --format gcode: {words}")
    resolution = None if counts is None else 2 * np.pi / positive(counts, "counts_per_turn")
    pen_time = not_negative(arguments.pen_time, "pen_time")
    lead = optional(positive)(arguments.lead, "lead")
    backlash = not_negative(arguments.backlash, "backlash")
    path = _read(arguments, machine)
    print_notes(arguments.file, path.notes)
    if arguments.as_drawn:  # elsewhere it is a shape
        machine = machine_for(arguments, machine, arguments.file, path)
    path, working, share, page = placed(arguments, machine, path)
    if lead:
        path = strokes.with_leads(path, lead)
    if pen_time:
        path = strokes.with_pen_time(path, pen_time)
    check = _checked(arguments, machine, path, working)
    proof = _proved(arguments, machine.robot, path, working) if check.singularity_free else None
    motion, drives = _timed(arguments, machine, path, working)
    writers = _setpoints(arguments, machine, motion) if dialect is None else {}
    figures = {
        "strokes": len(strokes.runs(np.array(path.pen))),
        "drawn_m": sum(piece.length for piece, pen in zip(path.pieces, path.pen) if pen),
        "working": working,
        "measured_modes": says_other_modes(arguments, machine, motion),
        "largest_scale": share,
        "page": None if page is None else machine.frame(page),
        "frame": arguments.frame,
        "middle": bounds(machine.frame(path.drawn)).mean(axis=0).round(12) + 0.0,
        "duration_s": motion.duration,
        "lower_bound_s": motion.lower_bound or None,  # 0: it is not known
        "smallest_margin": check.min_margin,
        "certified": proof is not None and proof.proved,
        "backlash_error_m": backlash and _tip_error(motion, backlash / 2),
    }
    files = []
    if dialect is not None:
        drawn, files = written_gcode(arguments, machine, motion, dialect)
    elif min(*machine.robot.inertias, machine.robot.m) <= 0:
        drawn = NOTHING
        words = "it has no inertia, so it is not simulated: there is no run.csv"
        print_notes(arguments.robot, [words])
    else:
        drawn, writers["run.csv"] = _simulated(arguments, machine, motion, drives, resolution)
    figures |= drawn.figures

    def draw_picture(path):
        saved(_picture(arguments, machine, motion, drawn, page), path)

    # That of an earlier drawing would be false.
    (arguments.out / "proof.json").unlink(missing_ok=True)
    files = [*write_files(arguments.out, {"drawing.png": draw_picture, **writers}), *files]
    if figures["certified"]:
        files += write_files(arguments.out, {"proof.json": proof.to_json})
    if arguments.json:
        print_json({**figures, "notes": path.notes, "files": files})
        return
    print_frames(arguments, machine, *(file for file in files if file.name == "run.csv"))
    _print(arguments, machine, figures)
    print_files(files)


def _simulated(arguments, machine, motion, drives, resolution):
    """Return what the simulated robot draws, and what writes its run."""
    from ..control.matched import matched, peak_acceleration, period_for
    from ..models.geometry import igm
    from ..simulation.comparison import peak_name
    from ..simulation.settings import Measurement
    from ..simulation.simulate import simulate

    robot = machine.robot
    measurement = Measurement(arguments.delay, resolution)
    assembly = int(igm(robot, motion(0.0)[0], motion.working).assembly)
    peak = peak_acceleration(motion, 0.0, motion.duration)
    period = period_for(robot, peak) if arguments.period is None else arguments.period
    run = simulate(
        robot,
        matched(robot, peak, period, drives, assembly, arguments.delay, resolution),
        motion,
        control_period=period,
        step=period / max(1, round(period / STEP)),
        torque_limit=drives.motors or (drives.torque and drives.torque[0]),
        measurement=measurement,
    )
    down = motion.pen(run.t)
    off = np.linalg.norm(run.error, axis=1)
    figures = {
        "period_s": period,
        "peak_acceleration": peak,
        "max_error_m": float(off[down].max()),
        peak_name(robot): np.abs(run.tau).max(axis=0).tolist(),
    }
    size = np.ptp(run.drawn_ref[down], axis=0).max()
    count = resolution and _tip_error(motion, resolution)
    _say_leaps(machine, motion, run, off * down, size, count)
    return Drawn(run.drawn, off, down, figures), run.to_csv


def _say_leaps(machine, motion, run, off, size, count):
    """Say where the simulated error is large, or the torque (force) far above what is needed.

    count: how far the tip is off, m, where the encoders of both joints are by a count; or None.
    """
    from ..models.physics import loads_of
    from ..visualization.style import length

    words = machine.robot.words
    usual = float(np.median(off[off > 0])) if off.any() else 0.0
    needed = float(np.abs(motion.torques(run.t)).max())
    efforts = np.abs(run.tau).max(axis=1)
    error, effort = float(off.max()), float(efforts.max())
    dry = ", its dry friction changes there" * loads_of(machine.robot).sticks
    cause = (
        f"the robot is near a singularity there{dry} or it is too fast for its tracker: give a"
        " larger --margin or --reserve, another place, a longer --duration or a shorter --period"
    )
    if count and error <= COUNTS * count:
        step = f"a count of the encoders is up to {length(count)} at the tip"
        cause = f"{step}: give a larger --counts-per-turn"

    def say(what, values, ratio):
        place = _place(machine, run.drawn_ref[values.argmax()])
        print_message(f"fivebar: the simulated {what}, at {place}, {ratio}: {cause}")

    if error > min(LARGE_ERROR * size, max(LEAP * usual, LARGE_ERROR / LEAP * size)):
        say(f"error is up to {length(error)}", off, f"{error / usual:.3g} times its median")
    if effort > TWICE * needed:
        ratio = f"{effort / needed:.3g} times what the motion needs"
        say(f"{words.effort} is up to {effort:.3g} {words.effort_unit}", efforts, ratio)


def _read(arguments, machine):
    """Return the Path of the drawing, in its own place; for a limit on jerk its curvature does not
    jump.
    """
    from ..paths.reading.read import EXAMPLE, path

    if arguments.example == (arguments.file is not None):
        raise UsageError("draw needs one drawing: a file or --example")
    arguments.file = arguments.file or str(EXAMPLE)
    with usage_errors(ValueError, OSError):
        return path(
            arguments.file,
            curvature=machine.constraints.jerk is not None,
            pen_values=None if arguments.format == "gcode" else arguments.pen_values,
            **used_options(arguments, "deviation", "units", "columns"),
        )


def _met(machine, path, check):
    """Return in words where a path meets the first singularity."""
    if check.everywhere:
        return EVERYWHERE
    s = check.leaves if check.time is None else check.time
    what = "leaves the workspace" if check.leaves == s else f"meets Type {int(check.type)}"
    line = path.line_of(s)
    where = f" (line {line})" if line else ""
    place = _place(machine, path.drawn(s)[0])
    return f"it {what} at {place}, {1e3 * s:.4g} mm along it{where}"


def _place(machine, point):
    """Return in words a point of the robot's own frame, in the measuring frame."""
    frame = " in the measuring frame" if machine.moves_points else ""
    return point_words(machine.frame(point)) + frame


def _timed(arguments, machine, path, working):
    """Return the motion along the path in the least time, and what limits the tracker's torques."""
    from ..constraints.constraints import Constraints
    from ..paths.timing.constraint_rows import Limits
    from ..paths.timing.solve import TimingError
    from ..paths.timing.time_path import SLOW, slowness, time_path

    if not 0 <= arguments.reserve < 1:
        raise UsageError(f"--reserve must be from 0 to below 1, not {arguments.reserve:g}")
    with usage_errors(ValueError):
        constraints = replace(machine.constraints, clearance=0.0, **chosen_limits(arguments))
    known = Limits.of(constraints)
    if known == Limits():
        constraints = replace(constraints, **USUAL)
    elif arguments.duration is None and not (known.forces or known.jerk):
        constraints = replace(constraints, acceleration=USUAL["acceleration"])
    drives = Constraints(motors=constraints.motors)
    if constraints.torque is not None:
        share = 1 - arguments.reserve
        least = min(constraints.torque)  # the tracker has one for both motors
        drives = replace(drives, torque=least)
        # Less of the speed, too: beyond that without load a weaker motor would have to brake less.
        motors = drives.motors and [
            replace(
                motor,
                efficiency=share * motor.efficiency,
                no_load_speed=share * motor.no_load_speed,
            )
            for motor in drives.motors
        ]
        constraints = replace(constraints, torque=least * share, motors=motors)
    duration = arguments.duration
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # it is said below
        try:
            motion = time_path(
                machine.robot, path, duration, constraints=constraints, working=working
            )
        except TimingError as error:
            words = f"{error}; the drawing is there at {_place(machine, path.drawn(error.s)[0])}"
            if constraints.torque is not None and arguments.reserve:
                words += f"; --reserve keeps {arguments.reserve:.3g} of the limit for the tracker"
            raise TimingError(words, error.s, error.proved) from None
    if duration is None and motion.gap > SLOW and motion.lower_bound:
        words = f"slow: {slowness(motion)}"
        if not (arguments.accept_slow or known.jerk):  # the bound leaves the jerk out
            raise ValueError(f"{words}. Nothing is written without --accept-slow")
        print_message(f"fivebar: {words}")
    return motion, drives


def _checked(arguments, machine, path, working):
    """Return the result of `check_path`; ValueError where a singularity or a constraint is in the
    way.
    """
    from ..constraints.constraints import plane_words
    from ..constraints.path_check import check_path

    check = check_path(machine.robot, path.at_unit_speed, working, None, machine.on_poses)
    amiss = f"{arguments.file}: it cannot be drawn there in {working_words(working)}"
    if not (check.singularity_free or may_cross(arguments, check)):
        raise ValueError(f"{amiss}: {_met(machine, path, check)}")
    for each in check.broken[:1]:
        planes = machine.constraints.half_planes, machine.measured_constraints.half_planes
        own, measured = ([plane_words(*plane) for plane in some] for some in planes)
        what = dict(zip(own, measured)).get(each.what, each.what)
        unit = {"j": " rad", "|": ""}.get(what[0], " m")  # of joint limits, and of margins
        raise ValueError(
            f"{amiss}: {arguments.robot} has the constraint"
            f" {what}, which is violated by {each.by:.4g}{unit} at"
            f" {_place(machine, path.drawn(each.worst)[0])}"
        )
    return check


def _tip_error(motion, error):
    """Return how far the tip may be off, m, where both joints are off by this error, rad."""
    t = np.linspace(0.0, motion.duration, SAMPLES)
    pose = motion.accelerations(t[motion.pen(t)]).rates.pose
    J = pose.J if motion.path.tool is None else motion.path.tool.tool.jacobian(pose)
    corners = J @ [(1, 1), (1, -1)]  # the tip's moves, as columns: both joints one way, or apart
    return float(np.linalg.norm(corners, axis=-2).max() * error)


def _proved(arguments, robot, path, working):
    """Return the Certificate, None for a biglide; say where it is not proved."""
    if not robot.turns:
        return None
    from ..paths.certificates.certify import certify

    proof = certify(robot, path, arguments.tolerance, working=working)
    for stretch in proof.unproved:
        ends = f"from s = {1e3 * stretch.start:.6g} to {1e3 * stretch.stop:.6g} mm"
        print_notes(arguments.file, [f"{ends} not proved: {stretch.why}"])
    return proof


def _counts_of_angles(arguments):
    return arguments.counts_per_turn if arguments.angles == "counts" else None


def _setpoints(arguments, machine, motion):
    """Return {file: what writes it} of the set-points."""
    from ..paths.setpoints import setpoints

    table = setpoints(machine.robot, motion, arguments.rate, motion.working)
    counts = _counts_of_angles(arguments)
    writers = {"setpoints.csv": lambda path: table.to_csv(path, arguments.angles, machine, counts)}
    if arguments.drive is not None:
        how = machine, arguments.zero_counts, arguments.wrap
        with usage_errors(ValueError):
            drive = float(arguments.drive) if arguments.drive[:1].isdigit() else arguments.drive
            table.for_drives(drive, *how)  # what it refuses is said before files are written
        name = f"drives.{'bin' if arguments.binary else 'csv'}"
        writers[name] = lambda path: table.to_drives(path, drive, *how)
    return writers


def _picture(arguments, machine, motion, drawn, page):
    from ..paths import strokes
    from ..visualization.plot.drawing import drawing

    rows = strokes.runs(drawn.down)
    title = f"drawn in {motion.duration:.4g} s"
    if rows:
        title += f", within {1e6 * drawn.off[drawn.down].max():.3g} µm"
    return drawing(
        machine.robot,
        motion.working,
        strokes.outlines(motion.path.drawn),
        [drawn.tip[row] for row in rows],
        [drawn.off[row] for row in rows],
        title,
        machine.tool,
        "the G-code" if arguments.format == "gcode" else "the simulated robot",
        page,
        machine.frame,
    )


def _print(arguments, machine, figures):
    from ..visualization.style import length

    least = figures["lower_bound_s"]
    jerky = machine.constraints.jerk is not None
    near = ", as asked for" if arguments.duration is not None else ""
    if least and (jerky or near):
        words = "without the limit on jerk the least" if jerky else "the least"
        near += f"; {words} is {least:.4g} s"
    elif least:
        near = f", within {100 * (figures['duration_s'] / least - 1):.2g} % of the least possible"
    drawn = 1e3 * figures["drawn_m"]
    rows = [
        ("drawn", f"{drawn:.4g} mm in {figures['strokes']} strokes"),
        ("middle of it", point_words(figures["middle"])),
        *page_row(figures["page"]),
        ("working modes", ", ".join(f"{sign:+d}" for sign in figures["working"])),
        ("time", f"{figures['duration_s']:.4f} s{near}"),
        ("smallest margin", f"{figures['smallest_margin']:.4f} (sine of a leg, or det A)"),
        ("certified", "yes, proof.json" if figures["certified"] else "no"),
    ]
    if "max_error_m" in figures:
        rows.append(("largest error", length(figures["max_error_m"])))
    if figures["backlash_error_m"]:
        rows.append(("of backlash", f"up to {length(figures['backlash_error_m'])} more"))
    if "period_s" in figures:
        peak = figures["peak_acceleration"]
        period = f"{1e3 * figures['period_s']:.4g} ms, for {peak:.3g} m/s²"
        rows += [("tracker's period", period), peak_row(machine.robot, figures)]
    if "lines" in figures:
        lines = f"{figures['lines']} lines, at most {figures['lines_per_s']:.4g} a second"
        speeds = f"within {100 * figures['speed_error']:.2g} % of the largest"
        rows += [("G-code", lines), ("speeds in it", speeds)]
    print_table(rows)
