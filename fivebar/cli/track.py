"""`fivebar demo` and `fivebar track`: a path tracked, its table, its files."""

from __future__ import annotations

import json
import sys
import textwrap
import time
from argparse import _SubParsersAction
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from ..control.laws import PD, ComputedTorque
from ..models.robots import FiveBar
from ..planning.samples import from_csv
from ..planning.trajectory import line
from .robot_options import add_robot_options, chosen_robot, robot_is_chosen

TASK_1 = (0.09, 0.06796322), (0.0, 0.1), 2.0  # the lab's control task 1: from, to, seconds
KP, KD = 100.0, 20.0
GAINS = {"ctc": (KP, KD), "pd": (0.4, 0.08), "mpc": None}
BIGLIDE_PD = (
    250.0,
    50.0,
)  # N/m, N s/m: about those of ctc, for the 2.5 kg that a foot moves at the lab's home


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `demo` and `track` to the program's commands."""
    demo = commands.add_parser("demo")
    demo.add_argument(
        "--out",
        type=Path,
        default=Path("fivebar-demo"),
        metavar="DIR",
        help="folder for the files (default: %(default)s)",
    )
    demo.set_defaults(run=_demo)

    track = commands.add_parser("track")
    path = track.add_argument_group(
        "path", "a CSV file with columns t (s), x, y (m), or a straight line in m and s"
    )
    path.add_argument("csv", nargs="?", metavar="PATH.csv")
    path.add_argument("--from", dest="start", nargs=2, type=float, metavar=("X", "Y"))
    path.add_argument("--to", dest="goal", nargs=2, type=float, metavar=("X", "Y"))
    path.add_argument("--duration", type=float, metavar="S")
    path.add_argument(
        "--case",
        help=(
            "compare computed torque and MPC on task-1, torque-limit, mass, delay, encoder,"
            " crossing"
        ),
    )
    track.add_argument(
        "--controller",
        choices=GAINS,
        default="ctc",
        help="computed torque, PD, or model-predictive (default: %(default)s)",
    )
    track.add_argument(
        "--kp",
        type=float,
        help="of ctc in 1/s² (default: 100), of pd in N m/rad (0.4), of a biglide's in N/m (250)",
    )
    track.add_argument(
        "--kd",
        type=float,
        help="of ctc in 1/s (default: 20), of pd in N m s/rad (0.08), of a biglide's in N s/m (50)",
    )
    track.add_argument(
        "--period",
        type=float,
        default=0.01,
        metavar="S",
        help="of the controller (default: %(default)g)",
    )
    track.add_argument(
        "--torque-limit", type=float, metavar="NM", help="of either motor, N m (biglide: N)"
    )
    track.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="write run.csv, tracking.png and animation.html there",
    )
    track.add_argument(
        "--page",
        type=Path,
        metavar="OUT.html",
        help="robot and plots on one page, linked by the time",
    )
    track.add_argument("--json", action="store_true", help="the figures as JSON on stdout")
    track.add_argument(
        "--working",
        nargs=2,
        type=int,
        choices=(-1, 1),
        metavar="W",
        help="working modes, as 1 -1 (default: -1 -1)",
    )
    track.add_argument(
        "--units",
        nargs="+",
        default=(),
        metavar="UNIT",
        help="of the CSV's columns, as mm or t=ms x=mm",
    )
    track.add_argument(
        "--polyline",
        type=float,
        metavar="M",
        help="straight between the CSV's rows, its corners cut by at most so much",
    )
    add_robot_options(track)
    track.set_defaults(run=_track)


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
    print(*files, sep="\n")


def _task_2(robot):
    """The lab's task 2 with a timing that can cross its singularity: the Run, and what is to be
    said.
    """
    from ..constraints.path_check import check_path
    from ..simulation.simulate import simulate
    from ..study.pitfalls import crossing

    met = check_path(robot, crossing.straight())
    controller = crossing.OpenLoop(robot, 0.002)
    run = simulate(robot, controller, crossing.compliant(robot), control_period=0.002, step=0.002)
    how = f"at {met.time:.4f} s it meets Type {int(met.type)}, where its torque diverges"
    peak = f"timed to cross without acceleration it needs {1e3 * np.abs(run.tau).max():.0f} mN m"
    return run, f"Task 2: on the lab's quintic it is refused: {how}; {peak}."


def _track(arguments):
    if arguments.case is not None:
        return _compare(arguments)
    robot, reference = chosen_robot(arguments), _reference(arguments)
    for name in ("period", "torque_limit"):
        value = getattr(arguments, name)
        if value is not None and not 0 < value < float("inf"):
            raise UsageError(f"--{name.replace('_', '-')} must be finite and > 0, not {value:g}")
    for sentence in reference.notes:
        print(f"{arguments.csv}: {sentence}", file=sys.stderr)
    working = tuple(arguments.working or (-1, -1))
    try:
        controller = _controller(arguments, robot, reference, working)
    except ValueError as error:
        raise UsageError(error) from None
    figures, run = _tracked(
        robot, reference, controller, arguments.period, arguments.torque_limit, working
    )
    files = [str(path) for path in _write(run, arguments.out)] if arguments.out else []
    if arguments.page:
        files.append(str(_write_page(run, arguments.page)))
    if arguments.json:
        print(json.dumps({**figures, "files": files}, indent=2))
    else:
        _print_table(robot, figures)
        print(*files, sep="\n", end="\n" if files else "")


def _assembly(robot, reference, working):
    """The assembly mode in which a motion begins, in these working modes."""
    if working is None:
        return -1
    from ..models.geometry import igm

    return int(igm(robot, reference(reference.start)[0], tuple(working)).assembly)


def _controller(arguments, robot, reference, working):
    given, assembly = (arguments.kp, arguments.kd), _assembly(robot, reference, arguments.working)
    if arguments.controller == "mpc":
        if given != (None, None):
            raise UsageError("--kp and --kd are gains of ctc and pd: mpc has none")
        from ..constraints.constraints import Constraints
        from ..control.matched import asks_for_it, matched
        from ..control.tracker import Tracker

        if peak := asks_for_it(robot, reference, arguments.period, arguments.torque_limit, working):
            return matched(robot, peak, arguments.period, arguments.torque_limit, assembly)
        constraints = Constraints(torque=arguments.torque_limit)
        return Tracker(robot, period=arguments.period, constraints=constraints, assembly=assembly)
    kind = {"ctc": ComputedTorque, "pd": PD}[arguments.controller]
    default = BIGLIDE_PD if kind is PD and not robot.turns else GAINS[arguments.controller]
    gains = (usual if gain is None else gain for gain, usual in zip(given, default))
    return kind(robot, *gains, working=working, assembly=assembly)


def _compare(arguments):
    """Computed torque at two gains and the tracker on one case: table, picture, and the runs."""
    from ..simulation.cases import CASES, case, run_case
    from ..simulation.comparison import compare

    if arguments.case not in CASES:
        raise UsageError(f"no case {arguments.case!r}; the known ones are {', '.join(CASES)}")
    if arguments.csv or arguments.start or arguments.goal or arguments.duration:
        raise UsageError("--case brings its own path")
    if robot_is_chosen(arguments):
        raise UsageError("--case brings its own robot")
    runs = run_case(arguments.case)
    comparison, files = compare(runs), []
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        files = [
            arguments.out / "comparison.png",
            *(arguments.out / f"{name}.csv" for name in runs),
        ]
        comparison.plot(files[0])
        for file, run in zip(files[1:], runs.values()):
            run.to_csv(file)
    if arguments.page:
        files.append(_write_page(runs, arguments.page))
    if arguments.json:
        figures = {}
        for name, row in comparison.figures.items():
            # JSON has no nan.
            figures[name] = {key: None if value != value else value for key, value in row.items()}
        print(
            json.dumps(
                {"case": arguments.case, "controllers": figures, "files": list(map(str, files))},
                indent=2,
            )
        )
        return
    print(case(arguments.case).title)
    print(comparison)
    print(*files, sep="\n", end="\n" if files else "")


def _reference(arguments):
    ends = {"--from": arguments.start, "--to": arguments.goal, "--duration": arguments.duration}
    given = [name for name, value in ends.items() if value is not None]
    if (arguments.csv is None) != (len(given) == 3) or (arguments.csv and given):
        raise UsageError("track needs a CSV file, or all of --from X Y, --to X Y and --duration S")
    try:
        if arguments.csv is None:
            return line(arguments.start, arguments.goal, arguments.duration)
        if arguments.polyline is None:
            return from_csv(arguments.csv, units=arguments.units)
        return from_csv(
            arguments.csv, kind="polyline", deviation=arguments.polyline, units=arguments.units
        )
    except (ValueError, OSError) as error:
        raise UsageError(error) from None


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
    from ..simulation.comparison import peak_name
    from ..visualization.style import length

    words = robot.words
    left, right = figures[peak_name(robot)]
    error_left, error_right = figures[f"max_joint_error_{words.unit}"]
    rows = [
        ("largest error", length(figures["max_error_m"])),
        ("RMS error", length(figures["rms_error_m"])),
        ("error at the end", length(figures["final_error_m"])),
        ("largest joint error", f"{1e3 * error_left:.4f}, {1e3 * error_right:.4f} m{words.unit}"),
        (f"peak {words.effort}", f"{1e3 * left:.3f}, {1e3 * right:.3f} m{words.effort_unit}"),
        ("real-time factor", f"{figures['real_time_factor']:.0f} ×"),
    ]
    if "saturated_fraction" in figures:
        rows.insert(5, ("saturated", f"{100 * figures['saturated_fraction']:.0f} % of the time"))
    rows += [
        ("crossing", f"Type {kind} at {t:.6f} s") for t, kind in figures["singularity_crossings"]
    ]
    for name, value in rows:
        print(f"  {name:<20} {value}")


def _write(run, folder):
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / "run.csv", folder / "tracking.png", folder / "animation.html"
    run.to_csv(paths[0])
    run.plot(paths[1])
    run.animate(paths[2])
    return paths


def _write_page(subject, path, title=None):
    from ..visualization.pages import page

    page(subject, path, title=title)
    return path
