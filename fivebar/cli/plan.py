"""`fivebar plan`: an optimal motion between points or modes, its table, picture and setpoints."""

from __future__ import annotations

import json
from argparse import _SubParsersAction
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot

SAMPLES = 4001
LIMITS = {  # option: constraint
    "torque_limit": "torque",
    "joint_speed_limit": "joint_speed",
    "acceleration_limit": "acceleration",
    "serial_margin": "sin",
    "parallel_margin": "det_A",
}


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `plan` to the program's commands."""
    plan = commands.add_parser("plan")
    ends = plan.add_argument_group(
        "from where to where", "points in m, at rest; modes, where they are named, may change"
    )
    ends.add_argument(
        "--from", dest="start", nargs=2, type=float, required=True, metavar=("X", "Y")
    )
    ends.add_argument("--to", dest="goal", nargs=2, type=float, required=True, metavar=("X", "Y"))
    ends.add_argument(
        "--via",
        nargs=2,
        type=float,
        action="append",
        metavar=("X", "Y"),
        help="to pass; again for more",
    )
    ends.add_argument(
        "--working",
        nargs=2,
        type=int,
        choices=(-1, 1),
        metavar="W",
        help="modes that the whole motion keeps, as 1 -1 (default: -1 -1)",
    )
    for name, words in (("start", "from"), ("goal", "to")):
        ends.add_argument(
            f"--{words}-working",
            dest=f"{name}_working",
            nargs=2,
            type=int,
            choices=(-1, 1),
            metavar="W",
            help=f"modes at the {name}: they change on the way, through Type 1 and Type 2",
        )
    what = plan.add_argument_group("what is asked")
    what.add_argument(
        "--duration", type=float, metavar="S", help="(default: free, for the least time)"
    )
    what.add_argument(
        "--objective",
        choices=("effort", "time", "jerk"),
        help="(default: effort; without --duration time)",
    )
    what.add_argument("--torque-limit", type=float, metavar="NM", help="of either motor")
    what.add_argument("--joint-speed-limit", type=float, metavar="RAD/S")
    what.add_argument(
        "--acceleration-limit", type=float, metavar="M/S2", help="of the end-effector"
    )
    what.add_argument(
        "--workspace", nargs=4, type=float, metavar=("X0", "X1", "Y0", "Y1"), help="to stay in, m"
    )
    what.add_argument("--serial-margin", type=float, metavar="SINE", help="least |sin q_i2|")
    what.add_argument(
        "--parallel-margin", type=float, metavar="SINE", help="least |det A|: no Type 2 is crossed"
    )
    what.add_argument(
        "--max-time",
        type=float,
        default=30.0,
        metavar="S",
        help="of the search (default: %(default)g)",
    )
    plan.add_argument(
        "--rate",
        type=float,
        default=1000.0,
        metavar="HZ",
        help="of the setpoints (default: %(default)g)",
    )
    plan.add_argument("--angles", choices=("rad", "deg"), default="rad", help="of the setpoints")
    plan.add_argument(
        "--out", type=Path, metavar="DIR", help="write plan.csv, plan.png and setpoints.csv there"
    )
    plan.add_argument("--json", action="store_true", help="the figures as JSON on stdout")
    add_robot_options(plan)
    plan.set_defaults(run=_plan)


def _plan(arguments):
    robot = chosen_robot(arguments)
    start, goal = (_end(arguments, robot, name) for name in ("start", "goal"))
    from ..constraints.constraints import Constraints
    from ..planning.plan import LEAST_SIN, Collocation, plan

    limits = {name: getattr(arguments, option) for option, name in LIMITS.items()}
    limits = {name: limit for name, limit in limits.items() if limit is not None}
    if arguments.working:
        limits.setdefault("sin", LEAST_SIN)
    if arguments.workspace:
        x0, x1, y0, y1 = arguments.workspace
        limits["region"] = (x0, y0), (x1, y0), (x1, y1), (x0, y1)
    try:
        found = plan(
            robot,
            start,
            goal,
            arguments.duration,
            via=[(None, point) for point in arguments.via or ()],
            objective=arguments.objective or ("effort" if arguments.duration else "time"),
            constraints=Constraints(**limits),
            collocation=Collocation(max_time=arguments.max_time),
        )
    except ValueError as error:
        raise UsageError(error) from None
    figures = _figures(robot, found)
    files = _written(arguments, robot, found) if arguments.out else []
    if arguments.json:
        print(json.dumps({**figures, "files": files}, indent=2))
        return
    _print(robot, figures)
    print(*files, sep="\n", end="\n" if files else "")


def _end(arguments, robot, name):
    """A point, or the Pose in the modes asked for."""
    point, modes = getattr(arguments, name), getattr(arguments, f"{name}_working")
    if modes and arguments.working:
        raise UsageError(
            "--working keeps the modes: it goes without --from-working and --to-working"
        )
    modes = modes or arguments.working
    if modes is None:
        return tuple(point)
    from ..models.geometry import igm

    try:
        return igm(robot, point, tuple(modes))
    except (ValueError, ArithmeticError) as error:
        raise UsageError(error) from None


def _figures(robot, plan):
    from ..simulation.comparison import peak_name

    t = np.linspace(0.0, plan.duration, SAMPLES)
    pose = plan.accelerations(t).rates.pose
    margins = {"1": pose.sines, "2": [pose.det_A]}
    crossed = [
        [float(t[k]), int(kind)]
        for kind, own in margins.items()
        for each in own
        for k in np.flatnonzero(np.diff(each >= 0))
    ]
    return {
        "duration_s": plan.duration,
        "objective": plan.objective,
        peak_name(robot): np.abs(plan.tau(t)).max(axis=0).tolist(),
        "singularity_crossings": sorted(crossed),
        "working_at_the_end": [int(mode) for mode in pose.working[-1]],
        "relative_error": plan.error,
        "intervals": len(plan.pieces.xi),
        "solve_time_s": plan.solve_time,
    }


def _written(arguments, robot, plan):
    """The plan's own table, its picture and its setpoints, in their folder."""
    from ..paths.setpoints import setpoints

    arguments.out.mkdir(parents=True, exist_ok=True)
    files = [arguments.out / name for name in ("plan.csv", "plan.png", "setpoints.csv")]
    plan.to_csv(files[0])
    plan.plot(files[1])
    setpoints(robot, plan, arguments.rate).to_csv(files[2], arguments.angles)
    return list(map(str, files))


def _print(robot, figures):
    from ..simulation.comparison import peak_name

    words = robot.words
    left, right = figures[peak_name(robot)]
    rows = [
        ("duration", f"{figures['duration_s']:.6g} s"),
        ("objective", f"{figures['objective']:.6g} (SI)"),
        (f"peak {words.effort}", f"{1e3 * left:.3f}, {1e3 * right:.3f} m{words.effort_unit}"),
        *(
            ("crossing", f"Type {kind} at about {t:.4f} s")
            for t, kind in figures["singularity_crossings"]
        ),
        ("modes at the end", ", ".join(f"{mode:+d}" for mode in figures["working_at_the_end"])),
        ("solved", f"on {figures['intervals']} intervals in {figures['solve_time_s']:.2f} s"),
    ]
    for name, value in rows:
        print(f"  {name:<20} {value}")
