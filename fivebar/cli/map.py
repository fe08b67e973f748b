"""`fivebar map`: the singularity map, the aspects, and the crossings of a path."""

from __future__ import annotations

import json
import sys
from argparse import _SubParsersAction
from pathlib import Path

from ..base.errors import UsageError
from ..base.tables import saved
from ..planning.samples import from_csv
from ..singularities.maps import FIELDS, singularity_map
from .endings import check_ending
from .robot_options import add_robot_options, chosen_robot


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `map` to the program's commands."""
    parser = commands.add_parser("map")
    parser.add_argument(
        "--space", choices=("task", "joint"), default="task", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--field",
        choices=FIELDS,
        default="parallel",
        metavar="MARGIN",
        help=f"one of {', '.join(FIELDS)}",
    )
    parser.add_argument(
        "--window",
        nargs=4,
        type=float,
        metavar=("X0", "X1", "Y0", "Y1"),
        help="m, or in joint space rad (biglide: m)",
    )
    parser.add_argument(
        "--nodes",
        type=int,
        default=401,
        metavar="N",
        help="nodes of the grid on each side (default: %(default)s)",
    )
    parser.add_argument(
        "--det-A", type=float, metavar="K", help="show dexterous regions with |det A| >= K"
    )
    parser.add_argument(
        "--sin",
        type=float,
        metavar="S",
        help="show dexterous regions with both |sin q_i2| >= S",
    )
    parser.add_argument(
        "--path", metavar="PATH.csv", help="a path t (s), x, y (m) to draw and to check"
    )
    parser.add_argument(
        "--units",
        nargs="+",
        default=(),
        metavar="UNIT",
        help="units of the path's columns, as mm or t=ms x=mm",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("map.png"), help="PNG, SVG or PDF (default: %(default)s)"
    )
    parser.add_argument("--data", type=Path, metavar="FILE", help="the grid as .csv or .npz")
    parser.add_argument(
        "--page",
        type=Path,
        metavar="OUT.html",
        help="an interactive page: point at the map to move the robot",
    )
    parser.add_argument(
        "--graph",
        type=Path,
        metavar="OUT.png",
        help="a graph of the aspects between which a motion may pass",
    )
    parser.add_argument("--json", action="store_true", help="aspects and path as JSON on stdout")
    add_robot_options(parser)
    parser.set_defaults(run=_map)


def _map(arguments):
    from ..constraints.path_check import check_path
    from ..singularities.aspects import aspects
    from ..singularities.dexterous import dexterous

    robot = chosen_robot(arguments)
    check_ending("--data", arguments.data, (".csv", ".npz"))
    check_ending("--out", arguments.out)
    check_ending("--graph", arguments.graph)
    if arguments.graph and not robot.turns:
        raise UsageError(
            "--graph needs a five-bar: the aspects of a biglide are strips without ends"
        )
    if arguments.units and not arguments.path:
        raise UsageError("--units is of the file of --path, and there is none")
    if arguments.path and arguments.space == "joint":
        raise UsageError("--path is drawn in task space only")
    levels = {"det_A": arguments.det_A, "sin": arguments.sin}
    levels = {name: value for name, value in levels.items() if value is not None}
    if levels and arguments.space == "joint":
        raise UsageError("--det-A and --sin are of task space only")
    try:
        regions = dexterous(robot, **levels) if levels else None
        path = from_csv(arguments.path, units=arguments.units) if arguments.path else None
        shape = (arguments.nodes, arguments.nodes)
        data = singularity_map(robot, arguments.field, arguments.space, arguments.window, shape)
    except (ValueError, OSError) as error:
        raise UsageError(error) from None
    for sentence in path.notes if path else ():
        print(f"{arguments.path}: {sentence}", file=sys.stderr)
    parts = aspects(robot) if robot.turns else None
    checks = [(mode, check_path(robot, path, mode)) for mode in data.modes] if path else []
    points = _points(path) if path else None
    _draw(data, points, regions, arguments.out)
    if arguments.graph:
        from ..visualization.plot.graph import aspect_graph

        saved(aspect_graph(robot), arguments.graph)
    if arguments.data:
        (data.to_csv if arguments.data.suffix == ".csv" else data.to_npz)(arguments.data)
    if arguments.page:
        from ..visualization.pages.linked import map_page

        map_page(data, arguments.page, along=points, regions=regions)
    if arguments.json:
        print(json.dumps(_as_json(parts, checks, regions, levels), indent=2))
        return
    if parts is None:
        print("aspects are not listed: those of a biglide are strips without ends", file=sys.stderr)
    else:
        _table("aspect", parts)
    if regions is not None:
        _table("region", regions)
        if not regions:
            print("no pose keeps these margins", file=sys.stderr)
    for mode, check in checks:
        print(f"path in working mode {_signs(mode)}: {_verdict(check)}")
    print(*filter(None, (arguments.out, arguments.graph, arguments.data, arguments.page)), sep="\n")


def _table(name, parts):
    print(f"{name}  working  assembly    area (mm²)")
    for part in parts:
        print(
            f"{part.number:>6}  {_signs(part.working):>7}  {_signs((part.assembly,)):>8} "
            f" {1e6 * part.area:>12.4f}"
        )


def _points(path):
    import numpy as np

    return path(np.linspace(path.start, path.start + path.duration, 1001))[0]


def _draw(data, points, regions, out):
    from ..visualization.plot.maps import singularity_map as picture

    saved(picture(data, points, regions), out)


def _verdict(check):
    if not check.reachable and check.leaves == check.time:
        return f"leaves the workspace at t = {check.leaves:.12g} s"
    if check.singularity_free:
        return (
            f"free of singularities, smallest sine {check.min_margin:.3g} at t ="
            f" {check.min_margin_time:.6g} s"
        )
    verb = "touches" if check.touching else "crosses"
    text = f"{verb} Type {int(check.type)} at t = {check.time:.12g} s"
    if check.criterion is not None:
        text += f", t_s . m xi'' = {check.criterion:.6g} N, "
        text += "the criterion holds" if check.criterion_holds else "off it: the torque diverges"
    return text


def _parts_as_json(parts):
    return [
        {
            "number": part.number,
            "working": part.working,
            "assembly": part.assembly,
            "area_m2": part.area,
            "point_m": part.point.tolist(),
        }
        for part in parts
    ]


def _as_json(parts, checks, regions, levels):
    paths = [
        dict(
            working=mode,
            reachable=check.reachable,
            singularity_free=check.singularity_free,
            leaves_s=check.leaves,
            time_s=check.time,
            type=int(check.type),
            touching=check.touching,
            criterion_N=check.criterion,
            criterion_holds=check.criterion_holds,
            min_margin=check.min_margin,
        )
        for mode, check in checks
    ]
    result = {"aspects": None if parts is None else _parts_as_json(parts), "path": paths}
    if regions is not None:
        result["dexterous"] = levels | {"regions": _parts_as_json(regions)}
    return result


def _signs(modes):
    return "".join("+" if mode > 0 else "-" for mode in modes)
