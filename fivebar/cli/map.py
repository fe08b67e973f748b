"""`fivebar map`: the singularity map, the aspects, and the crossings of a path."""

from __future__ import annotations

import sys
from argparse import _SubParsersAction
from contextlib import suppress
from pathlib import Path

from ..base.errors import UsageError
from ..base.tables import saved
from ..planning.samples import from_csv
from ..singularities.degenerate import EVERYWHERE
from ..singularities.maps import FIELDS, singularity_map
from .options import (
    TABLE,
    add_options,
    check_ending,
    print_files,
    print_json,
    print_notes,
    print_table,
    usage_errors,
    used_options,
)
from .robot_options import FRAMES, add_robot_options, chosen_machine

OPTIONS = TABLE | {
    "--space task|joint": ("task", "what the map is over"),
    "--field MARGIN": ("parallel", f"one of {', '.join(FIELDS)}"),
    "--window X0 X1 Y0 Y1": "m, or in joint space rad (biglide: m)",
    "--nodes N": (401, "nodes of the grid on each side"),
    "--det-A NUMBER": "show dexterous regions with at least this |det A|",
    "--sin SINE": "show dexterous regions with at least this |sin q_i2|",
    "--fits X Y": "whether an upright board of this size, m, fits in an aspect, and the largest of"
    " its shape",
    "--path PATH.csv": "a path t (s), x, y (m) to draw and to check",
    "--units UNIT ...": "units of the path's columns, as mm or t=ms x=mm",
    "--out FILE": (Path("map.png"), "PNG, SVG or PDF"),
    "--data FILE": "the grid as .csv or .npz",
    "--page OUT.html": "an interactive page: point at the map to move the robot",
    "--graph OUT.png": "a graph of the aspects between which a motion may pass",
}


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `map` to the program's commands."""
    parser = commands.add_parser("map")
    add_options(parser, OPTIONS)
    add_robot_options(parser)
    parser.set_defaults(run=_map)


def _map(arguments):
    import numpy as np

    from ..constraints.path_check import check_path
    from ..singularities.aspects import aspects
    from ..singularities.dexterous import dexterous
    from ..visualization.pages.linked import map_page
    from ..visualization.plot.graph import aspect_graph
    from ..visualization.plot.maps import singularity_map as picture
    from ..visualization.plot.panels import in_frame

    machine = chosen_machine(arguments)
    robot = machine.robot
    check_ending("--data", arguments.data, (".csv", ".npz"))
    check_ending("--out", arguments.out)
    check_ending("--graph", arguments.graph)
    if machine.tool is not None:
        _map_of_tool(arguments, machine)
        return
    levels = used_options(arguments, "det_A", "sin")
    if arguments.fits is not None and not (robot.turns and min(arguments.fits) > 0):
        raise UsageError("--fits takes two sizes > 0, m, of a board for a five-bar")
    if arguments.space == "joint" and (levels or arguments.path):
        raise UsageError("--path, --det-A and --sin are of task space only")
    regions = path = points = None
    with usage_errors():
        if levels:
            regions = dexterous(robot, **levels)
        if arguments.path:
            path = from_csv(arguments.path, units=arguments.units, columns=arguments.columns)
            path = machine.frame.inverse(path)
        shape = (arguments.nodes, arguments.nodes)
        window = arguments.window
        if window and arguments.space == "task":
            corners = machine.frame.inverse([(x, y) for x in window[:2] for y in window[2:]])
            window = np.transpose([corners.min(axis=0), corners.max(axis=0)]).ravel()
        data = singularity_map(robot, arguments.field, arguments.space, window, shape)
    parts = aspects(robot) if robot.turns else None
    checks = []
    if path:
        print_notes(arguments.path, path.notes)
        points = path(np.linspace(path.start, path.start + path.duration, 1001))[0]
        checks = [(mode, check_path(robot, path, mode)) for mode in data.modes]
    figure = picture(data, points, regions)
    saved(figure if arguments.space == "joint" else in_frame(figure, machine.frame), arguments.out)
    if arguments.graph:
        saved(aspect_graph(robot), arguments.graph)
    if arguments.data:
        write = data.to_csv if arguments.data.suffix == ".csv" else data.to_npz
        write(arguments.data)
    if arguments.page:
        map_page(data, arguments.page, along=points, regions=regions)
    board = None if arguments.fits is None else _board(machine, parts, arguments.fits)
    if arguments.json:
        result = {"frame": arguments.frame}
        result |= _as_json(machine, parts, checks, regions, levels)
        print_json(result if board is None else result | {"board": board})
        return
    print_table(arguments.frame_row)
    if machine.moves_points and (arguments.data or arguments.page):
        print_table([("--data and --page", FRAMES["robot"])])
    if parts is None:
        print("aspects are not listed: those of a biglide are strips without ends", file=sys.stderr)
    else:
        _print_regions("aspect", parts)
    if regions is not None:
        _print_regions("region", regions)
    if board is not None:
        width, height = (1e3 * size for size in board["rectangle_m"])
        verb = "fits" if board["fits"] else "does not fit"
        x, y = (1e3 * size for size in arguments.fits)
        left, below = (1e3 * size for size in board["corner_m"])
        angle = np.rad2deg(board["turned_rad"])
        turned = f", turned by {angle:.4g}° as the robot" if angle else ""
        print(
            f"a board of {x:.4g} x {y:.4g} mm {verb}: the largest of its shape is {width:.4g} x"
            f" {height:.4g} mm, scale {board['scale']:.4g}, in aspect {board['aspect']}, its lower"
            f" left corner at ({left:.4g}, {below:.4g}) mm{turned}"
        )
    for mode, check in checks:
        print(f"path in working mode {_signs(mode)}: {_verdict(check)}")
    print_files(used_options(arguments, "out", "graph", "data", "page").values())


def _board(machine, parts, size):
    """Return the aspect that holds a board of this shape (2,) m largest."""
    from ..constraints.rectangle import largest_rectangle

    found = []
    for part in parts:
        with suppress(ValueError):  # no rectangle of that shape is found there
            rectangle = largest_rectangle(part, machine.constraints, size[0] / size[1])
            scale = (rectangle.x_max - rectangle.x_min) / size[0]
            found.append((round(scale, 6), -part.number, scale, rectangle))
    if not found:
        raise ValueError("no aspect holds a board of this shape")
    _, number, scale, rectangle = max(found)
    return {
        "fits": scale >= 1,
        "scale": scale,
        "rectangle_m": [scale * side for side in size],
        "corner_m": machine.frame((rectangle.x_min, rectangle.y_min)).tolist(),
        "turned_rad": machine.frame.turn,
        "aspect": -number,
    }


def _map_of_tool(arguments, machine):
    """Draw and list where the machine's tool goes."""
    from ..paths.placing.tool_regions import tool_regions
    from ..visualization.plot.panels import in_frame
    from ..visualization.plot.tools import tool_map

    options = "det_A", "sin", "path", "fits", "window", "data", "page", "graph"
    if used := used_options(arguments, *options):
        option = next(iter(used)).replace("_", "-")
        words = "the map of a tool has no such option: take the table tool out of the robot's file"
        raise UsageError(f"--{option}: {words}")
    saved(in_frame(tool_map(machine.tool, machine.robot), machine.frame), arguments.out)
    regions = tool_regions(machine.tool, machine.robot)
    if arguments.json:
        print_json(
            {"frame": arguments.frame, "tool": [_region_as_json(region) for region in regions]}
        )
        return
    print_table(arguments.frame_row)
    _print_regions("region", regions)
    print_files([arguments.out])


def _region_as_json(region):
    return {
        "number": region.number,
        "working": region.working,
        "assembly": region.assembly,
        "area_m2": region.area,
    }


def _print_regions(name, regions):
    print(f"{name}  working  assembly    area (mm²)")
    for region in regions:
        working, assembly = _signs(region.working), _signs((region.assembly,))
        area = 1e6 * region.area
        print(f"{region.number:>6}  {working:>7}  {assembly:>8}  {area:>12.4f}")
    if not regions:
        print("no pose keeps these margins", file=sys.stderr)


def _verdict(check):
    if not check.reachable and check.leaves == check.time:
        return f"leaves the workspace at t = {check.leaves:.12g} s"
    if check.singularity_free:
        time = f"{check.min_margin_time:.6g} s"
        return f"free of singularities, smallest sine {check.min_margin:.3g} at t = {time}"
    if check.everywhere:
        return EVERYWHERE
    verb = "touches" if check.touching else "crosses"
    text = f"{verb} Type {int(check.type)} at t = {check.time:.12g} s"
    if check.criterion is not None:
        ending = "the criterion holds" if check.criterion_holds else "off it: the torque diverges"
        text += f", t_s . m xi'' = {check.criterion:.6g} N, {ending}"
    return text


def _parts_as_json(machine, parts):
    return [
        {
            "number": part.number,
            "working": part.working,
            "assembly": part.assembly,
            "area_m2": part.area,
            "point_m": machine.frame(part.point).tolist(),
        }
        for part in parts
    ]


def _as_json(machine, parts, checks, regions, levels):
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
    result = {"aspects": None if parts is None else _parts_as_json(machine, parts), "path": paths}
    if regions is not None:
        result["dexterous"] = levels | {"regions": _parts_as_json(machine, regions)}
    return result


def _signs(modes):
    return "".join("+" if mode > 0 else "-" for mode in modes)
