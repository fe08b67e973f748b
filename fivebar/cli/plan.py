"""`fivebar plan`: an optimal motion between points or modes, its table, picture and setpoints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base.errors import SingularityError, UsageError
from ..models.geometry import igm
from .options import (
    JSON,
    WORKING,
    add_command,
    option_of,
    print_files,
    print_json,
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
    peak_row,
    print_frames,
    refuse_angles,
)

SAMPLES = 4001
ENDS = {
    "--from X Y": "its start",
    "--to X Y": "its end",
    "--via X Y ...": "points to pass",
    WORKING: "modes that the whole motion keeps, as 1 -1 (default: -1 -1)",
    "--from-working -1|1 -1|1": "modes at the start; they change on the way, through Type 1 and 2",
    "--to-working -1|1 -1|1": "modes at the goal",
}
PROBLEM = {
    "--duration S": "(default: free, for the least time)",
    "--objective effort|time|jerk": "(default: effort; without --duration time)",
    "--motor NAME": "of both joints, by its torque-speed line: a name of `fivebar sweep --list`",
    "--torque-limit NM": "of either motor",
    "--joint-speed-limit RAD/S": "of either joint",
    "--acceleration-limit M/S2": "of the end-effector",
    "--workspace X X Y Y": "to stay in, m: left, right, below, above",
    "--serial-margin SINE": "least |sin q_i2|",
    "--parallel-margin SINE": "least |det A|: no Type 2 is crossed",
    "--max-time S": (30.0, "of the search"),
}
OUTPUT = JSON | {
    "--rate HZ": (1000.0, "of the setpoints"),
    "--angles rad|deg": ("rad", "of the setpoints"),
    "--out DIR": "write plan.csv, plan.png and setpoints.csv there",
}


def add_parsers(commands):
    """Add `plan` to the program's commands."""
    words = "points in m, at rest; modes, where they are named, may change"
    groups = (ENDS, "from where to where", words), (PROBLEM, "problem"), (OUTPUT,)
    add_robot_options(add_command(commands, "plan", _plan, *groups))


def _plan(arguments):
    from ..planning.plan import LEAST_SIN, Collocation, plan

    machine = chosen_machine(arguments)
    robot = machine.robot
    if arguments.working and (arguments.from_working or arguments.to_working):
        raise UsageError(
            "--working keeps the modes: it goes without --from-working and --to-working"
        )
    refuse_angles(arguments, machine)
    if machine.tool is not None:
        machine = _for_tool(arguments, machine)
    limits = chosen_limits(arguments)
    if arguments.working:
        limits.setdefault("sin", machine.constraints.sin or LEAST_SIN)
    if arguments.workspace:
        x0, x1, y0, y1 = arguments.workspace
        limits["region"] = machine.frame.inverse([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    ends = used_options(arguments, "from", "to")
    if len(ends) < 2:
        raise UsageError("plan needs --from X Y and --to X Y")
    if len(arguments.via) % 2:
        raise UsageError("--via takes pairs X Y")
    points = zip(*[iter(arguments.via)] * 2)
    with usage_errors(ValueError, SingularityError):
        start = _end(machine, ends["from"], arguments.working or arguments.from_working)
        goal = _end(machine, ends["to"], arguments.working or arguments.to_working)
        result = plan(
            robot,
            start,
            goal,
            arguments.duration,
            via=[(None, machine.joint(p, arguments.working or (-1, -1))) for p in points],
            objective=arguments.objective or ("time" if arguments.duration is None else "effort"),
            constraints=replace(machine.constraints, **limits),
            collocation=Collocation(max_time=arguments.max_time),
        )
    figures = _figures(robot, result)
    files = _written(arguments, machine, result) if arguments.out else []
    if arguments.json:
        print_json({**figures, "frame": arguments.frame, "files": files})
        return
    print_frames(arguments, machine, *files[:2])
    _print(robot, figures)
    print_files(files)


def _end(machine, point, modes):
    """Return the point of joint C, or the Pose where modes are named."""
    xi = machine.joint(point, modes or (-1, -1))
    return xi if modes is None else igm(machine.robot, xi, tuple(modes))


def _for_tool(arguments, machine):
    """Return the machine without what would bound joint C in place of the tool, which is said;
    refuse the options that would, and points without modes.
    """
    for option in used_options(arguments, "workspace", "acceleration_limit"):
        raise UsageError(
            f"{option_of(option)} is of joint C, not of the tool: leave it out, or take"
            " the table tool out of the robot's file"
        )
    changes = arguments.from_working, arguments.to_working
    if any(changes) and (None in changes or arguments.via):
        raise UsageError(
            "with a tool each point needs its modes: give --from-working and --to-working both,"
            " and --via with --working only"
        )
    if machine.constraints.acceleration is None:
        return machine
    words = "plan leaves out acceleration: it is the tool's, and a plan could bound joint C's alone"
    print_notes(arguments.robot, [words])
    return replace(machine, constraints=replace(machine.constraints, acceleration=None))


def _figures(robot, plan):
    from ..simulation.comparison import peak_name
    from ..visualization.loci import crossings

    t = np.linspace(0.0, plan.duration, SAMPLES)
    pose = plan.accelerations(t).rates.pose
    return {
        "duration_s": plan.duration,
        "objective": plan.objective,
        peak_name(robot): np.abs(plan.torques(t)).max(axis=0).tolist(),
        "singularity_crossings": sorted([time, kind] for time, kind, *_ in crossings(t, pose)),
        "working_at_the_end": pose.working[-1],
        "relative_error": plan.error,
        "intervals": len(plan.pieces.xi),
        "solve_time_s": plan.solve_time,
    }


def _written(arguments, machine, plan):
    """Return the plan's own table, its picture and its setpoints, in their folder."""
    from ..paths.setpoints import setpoints

    table = setpoints(machine.robot, plan, arguments.rate, tool=machine.tool)
    return write_files(
        arguments.out,
        {
            "plan.csv": plan.to_csv,
            "plan.png": lambda path: plan.plot(path, tool=machine.tool),
            "setpoints.csv": lambda path: table.to_csv(path, arguments.angles, machine),
        },
    )


def _print(robot, figures):
    print_table(
        [
            ("duration", f"{figures['duration_s']:.6g} s"),
            ("objective", f"{figures['objective']:.6g} (SI)"),
            peak_row(robot, figures),
            ("modes at the end", ", ".join(f"{mode:+d}" for mode in figures["working_at_the_end"])),
            ("solved", f"on {figures['intervals']} intervals in {figures['solve_time_s']:.2f} s"),
        ]
    )
    for t, kind in figures["singularity_crossings"]:
        print(f"  crossing             Type {kind} at about {t:.4f} s")
