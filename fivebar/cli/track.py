"""`fivebar demo` and `fivebar track`: a path tracked, its table, its files."""

from __future__ import annotations

import textwrap
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ..base.checks import positive
from ..base.errors import UsageError
from ..control.laws import PD, ComputedTorque
from ..models.robots import FiveBar
from ..planning.samples import from_csv
from ..planning.trajectory import line
from ..singularities.degenerate import refuse_singular_everywhere
from .options import (
    TABLE,
    WORKING,
    add_command,
    print_files,
    print_json,
    print_notes,
    print_table,
    refuse_others,
    usage_errors,
    used_options,
    write_files,
    write_options,
)
from .robot_options import (
    add_robot_options,
    chosen_limits,
    chosen_machine,
    machine_for,
    peak_row,
    print_frames,
)

TASK_1 = (0.09, 0.06796322), (0.0, 0.1), 2.0  # the lab's control task 1: from, to, seconds
KP, KD = 100.0, 20.0
LAWS = {"ctc": (ComputedTorque, (KP, KD)), "pd": (PD, (0.4, 0.08))}
# N/m, N s/m: about those of ctc, for the 2.5 kg that a foot moves at the lab's home.
BIGLIDE_PD = (250.0, 50.0)
DEMO = {"--out DIR": (Path("fivebar-demo"), "folder for the files")}
PATH = {
    "[PATH.csv]": "",
    "--from X Y": "its start",
    "--to X Y": "its end",
    "--duration S": "of the line",
    "--case task-1|torque-limit|mass|delay|encoder|crossing": "compare computed torque and MPC",
    "--units UNIT ...": "of the CSV's columns, as mm or t=ms x=mm",
    "--polyline M": "straight between the CSV's rows, its corners cut by at most so much",
}
OPTIONS = TABLE | {
    "--controller ctc|pd|mpc": ("ctc", "computed torque, PD, or model-predictive"),
    "--kp NUMBER": "of ctc in 1/s² (default: 100), of pd in N m/rad (0.4; biglide: 250 N/m)",
    "--kd NUMBER": "of ctc in 1/s (default: 20), of pd in N m s/rad (0.08; biglide: 50 N s/m)",
    "--period S": (0.01, "of the controller"),
    "--torque-limit NM": "of either motor, N m (biglide: N)",
    "--out DIR": "write run.csv, tracking.png and animation.html there",
    "--page PAGE.html": "robot and plots on one page, linked by the time",
    WORKING: "working modes, as 1 -1 (default: -1 -1, elbows to the right)",
}


def add_parsers(commands):
    """Add `demo` and `track` to the program's commands."""
    add_command(commands, "demo", _demo, (DEMO,))
    words = "a CSV file with columns t (s), x, y (m), or a straight line in m and s"
    track = add_command(commands, "track", _track, (PATH, "path", words), (OPTIONS,))
    add_robot_options(track)


def _demo(arguments):
    from ..visualization.pages.linked import story

    robot = FiveBar()
    figures, run = _tracked(robot, line(*TASK_1), ComputedTorque(robot, KP, KD), 0.01, None)
    print(
        "AMORO lab, control task 1: (90, 68) mm to (0, 100) mm in 2 s,\ncomputed torque, one sample"
        " each 10 ms"
    )
    _print_table(robot, figures)
    files = _write(run, arguments.out)
    error = 1e6 * figures["max_error_m"]
    crossed, sentence = _task_2(robot)
    print(textwrap.fill(sentence, 80))
    page = arguments.out / "page.html"
    runs = {f"task 1, within {error:.0f} µm": run, "task 2, through the singularity": crossed}
    title = f"AMORO lab: task 1 within {error:.0f} µm, and task 2 through a singularity"
    story(runs, page, ("error", "tau", "margins"), title, ["Point at any curve.", sentence])
    print(f"{page}  (open it in a browser, and point at any curve)")
    print_files(files)


def _task_2(robot):
    """Return the lab's task 2 with a timing that can cross its singularity: the Run, and what is to
    be said.
    """
    from ..constraints.path_check import check_path
    from ..simulation.simulate import simulate
    from ..study.pitfalls import crossing

    met = check_path(robot, crossing.straight())
    controller = crossing.OpenLoop(robot, 0.002)
    run = simulate(robot, controller, crossing.compliant(robot), control_period=0.002, step=0.002)
    how = f"at {met.time:.4f} s it meets Type {int(met.type)}, where its torque diverges"
    peak = (
        f"a time law that crosses without acceleration needs {1e3 * np.abs(run.tau).max():.0f} mN m"
    )
    return run, f"Task 2 along the lab's quintic polynomial is not possible: {how}; {peak}."


def _track(arguments):
    if arguments.case is not None:
        return _compare(arguments)
    machine = chosen_machine(arguments)
    robot = machine.robot
    with usage_errors():
        reference = _reference(arguments)
    positive(arguments.period, "period")
    print_notes(arguments.path, reference.notes)
    machine = machine_for(arguments, machine, arguments.path, reference)
    working = tuple(arguments.working or (-1, -1))
    refuse_singular_everywhere(robot, working, "track")
    with usage_errors(ValueError):
        limits = replace(machine.constraints, **chosen_limits(arguments))
        if limits.torque:  # a tracker has one for both motors
            limits = replace(limits, torque=min(limits.torque))
        reference = machine.led(reference, working)
        controller = _controller(arguments, robot, reference, working, limits)
    saturation = limits.motors or limits.torque and limits.torque[0]
    figures, run = _tracked(robot, reference, controller, arguments.period, saturation, working)
    files = _write(run, arguments.out) if arguments.out else []
    files += write_options(arguments, {"page": run.page})
    if arguments.json:
        print_json({**figures, "frame": arguments.frame, "files": files})
        return
    print_frames(arguments, machine, *files)
    _print_table(robot, figures)
    print_files(files)


def _controller(arguments, robot, reference, working, limits):
    from ..models.geometry import igm

    assembly = -1
    if arguments.working:
        assembly = int(igm(robot, reference(reference.start)[0], working).assembly)
    if arguments.controller == "mpc":
        return _mpc(arguments, robot, reference, working, assembly, limits)
    kind, (kp, kd) = LAWS[arguments.controller]
    if kind is PD and not robot.turns:
        kp, kd = BIGLIDE_PD
    gains = {"kp": kp, "kd": kd} | used_options(arguments, "kp", "kd")
    return kind(robot, **gains, working=working, assembly=assembly)


def _mpc(arguments, robot, reference, working, assembly, limits):
    from ..control.matched import asks_for_it, matched
    from ..control.tracker import Tracker

    if used_options(arguments, "kp", "kd"):
        raise UsageError("--kp and --kd are gains of ctc and pd: mpc has none")
    period = arguments.period
    limit = limits.torque and limits.torque[0]
    if peak := asks_for_it(robot, reference, period, limit, working):
        return matched(robot, peak, period, limits, assembly)
    return Tracker(robot, period=period, constraints=limits, assembly=assembly)


def _compare(arguments):
    """Compare computed torque at two gains and the tracker on one case."""
    from ..simulation.comparison import compare
    from ..study.control_cases import case, run_case
    from ..visualization.pages import page

    words = "brings its own path, robot and controller: --out, --page and --json go with it"
    refuse_others(arguments, f"--case {words}", "case", "out", "page", "json")
    runs = run_case(arguments.case)
    comparison = compare(runs)
    files = []
    if arguments.out:
        tables = {f"{name}.csv": run.to_csv for name, run in runs.items()}
        files = write_files(arguments.out, {"comparison.png": comparison.plot, **tables})
    files += write_options(arguments, {"page": partial(page, runs)})
    if arguments.json:
        figures = comparison.figures
        print_json({"case": arguments.case, "controllers": figures, "files": files})
        return
    print(case(arguments.case).title)
    print(comparison)
    print_files(files)


def _reference(arguments):
    ends = used_options(arguments, "from", "to", "duration")
    of_file = used_options(arguments, "path", "units", "columns", "polyline")
    if ends and of_file:
        raise UsageError(
            "--from, --to and --duration make a line, which goes without a CSV file, --units,"
            " --columns and --polyline"
        )
    if not (len(ends) == 3 or arguments.path):
        raise UsageError("track needs a CSV file, or all of --from X Y, --to X Y and --duration S")
    if ends:
        return line(*ends.values())
    told = used_options(arguments, "units", "columns")
    if arguments.polyline is not None:
        told |= {"kind": "polyline", "deviation": arguments.polyline}
    return from_csv(arguments.path, **told)


def _tracked(robot, reference, controller, period, torque_limit, working=(-1, -1)):
    """Simulate; gives the figures for the table, and the Run."""
    from ..models.geometry import igm
    from ..models.kinematics import ikm
    from ..simulation.comparison import compare, peak_name
    from ..simulation.simulate import simulate  # here, and with it CasADi: before the clock starts

    step = period / max(1, round(period / 1e-3))
    xi, xi_dot, _ = reference(reference.start)
    start = ikm(igm(robot, xi, working), xi_dot)
    before = time.perf_counter()
    run = simulate(
        robot,
        controller,
        reference,
        start=start,
        control_period=period,
        step=step,
        torque_limit=torque_limit,
    )
    elapsed = time.perf_counter() - before
    own = compare({"": run}).figures[""]
    figures = {
        "duration_s": float(run.t[-1]),
        **{name: own[name] for name in ("max_error_m", "rms_error_m", "final_error_m")},
        f"max_joint_error_{robot.words.unit}": np.nanmax(np.abs(run.q_error), axis=0).tolist(),
        peak_name(robot): own[peak_name(robot)],
        "singularity_crossings": [[event.t, int(event.type)] for event in run.events],
        "real_time_factor": float(run.t[-1] / elapsed),
    }
    if torque_limit is not None:
        figures["saturated_fraction"] = float(np.mean(run.saturated[:-1].any(axis=1)))
    return figures, run


def _print_table(robot, figures):
    from ..visualization.style import length

    unit = robot.words.unit
    error_left, error_right = figures[f"max_joint_error_{unit}"]
    rows = [
        ("largest error", length(figures["max_error_m"])),
        ("RMS error", length(figures["rms_error_m"])),
        ("error at the end", length(figures["final_error_m"])),
        ("largest joint error", f"{1e3 * error_left:.4f}, {1e3 * error_right:.4f} m{unit}"),
        peak_row(robot, figures),
        ("real-time factor", f"{figures['real_time_factor']:.0f} ×"),
    ]
    if share := figures.get("saturated_fraction"):
        rows.append(("saturated", f"{100 * share:.3g} % of the time"))
    for t, kind in figures["singularity_crossings"]:
        rows.append(("crossing", f"Type {kind} at {t:.6f} s"))
    print_table(rows)


def _write(run, folder):
    names = {"run.csv": run.to_csv, "tracking.png": run.plot, "animation.html": run.animate}
    return write_files(folder, names)
