"""`fivebar map`: singularities, aspects, what constraints leave of them, crossings of a path."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.errors import UnreachableError, UsageError
from ..base.tables import saved
from ..base.units import METRES, unit_named
from ..planning.samples import from_csv
from ..singularities.degenerate import EVERYWHERE
from ..singularities.maps import FIELDS, checked_window, singularity_map
from .options import (
    TABLE,
    WORKING,
    add_command,
    point_words,
    print_files,
    print_json,
    print_message,
    print_notes,
    size_words,
    usage_errors,
    used_options,
)
from .robot_options import (
    add_robot_options,
    chosen_limits,
    chosen_machine,
    machine_for,
    print_frames,
)

OPTIONS = TABLE | {
    "--space task|joint": ("task", "what the map is over"),
    "--field MARGIN": ("parallel", f"one of {', '.join(FIELDS)}"),
    "--window X0 X1 Y0 Y1": "m, or in joint space rad (biglide: m)",
    "--nodes N": (401, "nodes of the grid on each side"),
    "--det-A NUMBER": "show the regions with at least this |det A|",
    "--sin SINE": "show the regions with at least this |sin q_i2|",
    "--load FX FY": "show where the motors hold this force on the end-effector or tool at rest",
    "--torque-limit NM": "of either motor, for the load",
    "--fits X Y": "whether an upright board of this size, m, fits in an aspect or region, and the"
    " largest of its shape",
    "--path PATH.csv": "a path t (s), x, y (m) to draw and to check",
    "--units UNIT ...": "units of the path's columns, as mm or t=ms x=mm",
    "--out OUT.png": (Path("map.png"), "PNG, SVG or PDF"),
    WORKING: "of the picture and of the largest shapes: these working modes alone",
    "--width column|page": "of the picture: that of a journal's column, 88 mm, or page, 181 mm",
    "--unit UNIT": "of the picture's axes: um, mm, cm, m or in; of joints that turn deg or rad",
    "--labels NAME=TEXT ...": "what is written for x, y, q11, a field or words of the legend",
    "--data GRID.csv": "the grid as .csv or .npz",
    "--page PAGE.html": "an interactive page: point at the map to move the robot",
    "--graph OUT.png": "a graph of the aspects between which a motion may pass",
}


PATH = (  # of JSON: attributes of a PathCheck, some with a unit
    "reachable singularity_free leaves_s time_s type touching criterion_N criterion_holds"
    " min_margin"
).split()


def add_parsers(commands):
    """Add `map` to the program's commands."""
    add_robot_options(add_command(commands, "map", _map, (OPTIONS,)))


def _map(arguments):
    from ..constraints.constraints import Constraints
    from ..paths.placing.tool_regions import tool_regions
    from ..singularities.passages import known_aspects
    from ..visualization.pages.linked import map_page
    from ..visualization.plot.graph import aspect_graph
    from ..visualization.plot.maps import singularity_map as picture
    from ..visualization.plot.panels import in_frame
    from ..visualization.style import length_unit

    task = arguments.space == "task"
    user = "map --load" if arguments.load else "map" if task else "map --space joint"
    machine = chosen_machine(arguments, user)
    levels = used_options(arguments, "det_A", "sin")
    if arguments.fits is not None and not (machine.robot.turns and min(arguments.fits) > 0):
        raise UsageError("--fits takes two sizes > 0, m, of a board for a five-bar")
    if not task and (levels or arguments.path or arguments.load or arguments.working):
        raise UsageError("--path, --load, --det-A, --sin and --working are of task space only")
    if arguments.torque_limit is not None and not arguments.load:
        raise UsageError("--torque-limit says what holds a load: it goes with --load FX FY")
    regions = path = points = None
    with usage_errors():
        if arguments.path:
            path = from_csv(arguments.path, **used_options(arguments, "units", "columns"))
            machine = machine_for(arguments, machine, arguments.path, path)
            points = path(np.linspace(path.start, path.start + path.duration, 1001))[0]
            points = machine.frame.inverse(points)
        robot, tool = machine.robot, machine.tool
        if task:
            regions = _feasible(
                machine, replace(machine.on_poses, **levels), _load(arguments, machine)
            )
        shape = (arguments.nodes, arguments.nodes)
        window = arguments.window and checked_window(arguments.window)
        if window:
            corners = machine.frame.inverse([(x, y) for x in window[:2] for y in window[2:]])
            window = np.transpose([corners.min(axis=0), corners.max(axis=0)]).ravel()
        data = singularity_map(robot, arguments.field, arguments.space, window, shape, tool)
    parts = None
    if robot.turns:
        parts = known_aspects(robot) if tool is None else tool_regions(tool, robot)
    checks = []
    if path:
        print_notes(arguments.path, path.notes)
        checks = [(mode, _checked(machine, path, mode)) for mode in data.modes]
    style = used_options(arguments, "width", "unit")
    if wrong := [text for text in arguments.labels if "=" not in text]:
        raise UsageError(f"--labels must be NAME=TEXT, not {wrong[0]!r}")
    style["labels"] = dict(text.split("=", 1) for text in arguments.labels)
    if arguments.working:
        style["modes"] = [tuple(arguments.working)]
    with usage_errors():
        figure = picture(data, points, regions, **style)
    unit = length_unit(robot)
    scale = 1 / METRES.get(unit_named(arguments.unit or unit[1]), 1e-3)
    saved(in_frame(figure, machine.frame, scale), arguments.out)
    if arguments.graph:
        saved(aspect_graph(robot), arguments.graph)
        if tool is not None:
            print_notes(arguments.graph, ["of the aspects of joint C, without the tool"])
    if arguments.data:
        write = data.to_csv if arguments.data.suffix == ".csv" else data.to_npz
        write(arguments.data)
    if arguments.page:
        map_page(data, arguments.page, along=points, regions=regions)
    result = _as_json(machine, parts, checks)
    places, name = (parts or [], "aspect") if regions is None else (regions, "region")
    if arguments.working:
        places = [part for part in places if part.working in style["modes"]]
    margin = Constraints(clearance=machine.constraints.clearance)
    if regions is not None:
        result["regions"] = _parts_as_json(machine, regions)
        result |= _largest(machine, places, margin)
    if arguments.fits is not None:
        result["board"] = _board(machine, places, margin, arguments.fits) | {"in": name}
    if arguments.json:
        print_json({"frame": arguments.frame} | result)
        return
    print_frames(arguments, machine, *used_options(arguments, "data", "page").values())
    if parts is None:
        print_message("aspects are not listed: those of a biglide are strips without ends")
    else:
        _print_regions("aspect", parts, *unit)
    if regions is not None:
        _print_regions("region", regions, *unit)
    _print_largest(result, arguments.fits, *unit)
    for mode, check in checks:
        print(f"path in working mode {_signs(mode)}: {_verdict(check)}")
    print_files(used_options(arguments, "out", "graph", "data", "page").values())


def _largest_of(parts, what, measure):
    """Return (size, part, shape) of the largest shape in any part, of several that of the lowest
    number; None where no part has one. measure: what gives the size and the shape in a part.
    """
    from ..base.progress import progress

    found = []
    for part in progress(parts, desc=what, delay=2, leave=False):
        with suppress(ValueError):  # there is no room for it
            size, shape = measure(part)
            found.append((size, part, shape))
    return max(found, key=lambda each: round(each[0], 6), default=None)


def _load(arguments, machine):
    """Return the Load that the motors are to hold, or None."""
    from ..constraints.load import Load

    if arguments.load is None:
        return None
    torque = replace(machine.constraints, **chosen_limits(arguments)).torque
    if torque is None:
        words = "give --torque-limit, or torque or motors in the constraints of the robot's file"
        raise UsageError(f"--load needs the motors' torque: {words}")
    of_tool = {} if machine.tool is None else {"jacobian": machine.tool.jacobian}
    force = complex(*arguments.load) * np.exp(-1j * machine.frame.turn)
    return Load((force.real, force.imag), torque, **of_tool)


def _feasible(machine, kept, load):
    """Return the numbered parts of all aspects in which constraints hold; None without any."""
    from ..base.progress import progress
    from ..constraints.disc import bounded_by
    from ..constraints.feasible import feasible_parts
    from ..paths.placing.tool_regions import tool_regions
    from ..singularities.aspects import numbered
    from ..singularities.dexterous import dexterous
    from ..singularities.passages import known_aspects

    robot = machine.robot
    if not kept.named and load is None:
        return None
    if machine.tool is not None:
        bases = tool_regions(machine.tool, robot, None, kept, load)
    elif set(kept.named) <= {"det_A", "sin"} and load is None or not robot.turns:
        return dexterous(robot, kept.det_A, kept.sin)
    else:
        bases = known_aspects(robot)
    found = []
    for base in progress(bases, desc="regions", delay=2, leave=False):
        found += feasible_parts(bounded_by(base, kept, load) if machine.tool is None else base)
    return numbered(found)


def _largest(machine, regions, margin):
    """Return the largest disc in all regions, and the largest rectangle in its region."""
    from ..constraints.disc import largest_disc
    from ..constraints.rectangle import largest_rectangle

    def disc(region):
        shape = largest_disc(region, margin)
        return shape.radius, shape

    best = _largest_of(regions, "discs", disc)
    if best is None:
        return {"largest_disc": None, "largest_rectangle": None}
    radius, region, shape = best
    found = {
        "region": region.number,
        "center_m": machine.frame(shape.center),
        "radius_m": radius * machine.frame.scale,
    }
    own = None
    with suppress(ValueError):
        own = _placed(machine, largest_rectangle(region, margin))
    return {"largest_disc": found, "largest_rectangle": own}


def _placed(machine, rectangle):
    """Return a rectangle's sides and its lower left corner, in the frame of the command."""
    sides = rectangle.x_max - rectangle.x_min, rectangle.y_max - rectangle.y_min
    return {
        "rectangle_m": [side * machine.frame.scale for side in sides],
        "corner_m": machine.frame((rectangle.x_min, rectangle.y_min)),
        "turned_rad": machine.frame.turn,
    }


def _board(machine, parts, margin, size):
    """Return the aspect or region that holds a board of this shape (2,) m largest."""
    from ..constraints.rectangle import largest_rectangle

    def board(part):
        rectangle = largest_rectangle(part, margin, size[0] / size[1])
        return (rectangle.x_max - rectangle.x_min) / size[0], rectangle

    best = _largest_of(parts, "boards", board)
    if best is None:
        raise ValueError("no aspect holds a board of this shape")
    scale, part, rectangle = best
    own = _placed(machine, rectangle)
    return {"fits": scale >= 1, "scale": scale, "number": part.number} | own


def _print_largest(result, size, scale, unit):
    """Print the largest disc and rectangle, and whether a board of a size fits."""
    if disc := result.get("largest_disc"):
        where = f"about {point_words(disc['center_m'], scale, unit)}, in region {disc['region']}"
        print(f"largest disc: radius {scale * disc['radius_m']:.4f} {unit} {where}")
    if rectangle := result.get("largest_rectangle"):
        print(f"largest rectangle in it: {_rectangle_words(rectangle, scale, unit)}")
    if board := result.get("board"):
        verb = "fits" if board["fits"] else "does not fit"
        where = f"scale {board['scale']:.4g}, in {board['in']} {board['number']}"
        print(
            f"a board of {size_words(size, scale, unit)} {verb}: the largest of its shape is"
            f" {_rectangle_words(board, scale, unit)}, {where}"
        )


def _rectangle_words(rectangle, scale, unit):
    angle = np.rad2deg(rectangle["turned_rad"])
    turned = f", turned by {angle:.4g}° as the robot" if angle else ""
    corner = f"its lower left corner at {point_words(rectangle['corner_m'], scale, unit)}{turned}"
    return f"{size_words(rectangle['rectangle_m'], scale, unit)}, {corner}"


def _print_regions(name, regions, scale, unit):
    print(f"{name}  working  assembly    area ({unit}²)")
    for region in regions:
        working, assembly = _signs(region.working), _signs((region.assembly,))
        error = scale**2 * getattr(region, "area_error", 0.0)
        area = f"{scale**2 * region.area:>12.4f}" + (f" ± {error:.2g}" if error else "")
        print(f"{region.number:>6}  {working:>7}  {assembly:>8}  {area}")
    if not regions:
        print_message("no pose keeps these margins")


def _checked(machine, path, working):
    """Return the check of a path, or the UnreachableError of a tool that cannot follow it."""
    from ..constraints.path_check import check_path

    try:
        return check_path(machine.robot, machine.led(path, working), working)
    except UnreachableError as error:
        return error


def _verdict(check):
    if isinstance(check, UnreachableError):
        return str(check)
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
        text += f", it asks for {check.criterion:.6g} N along the free direction t_s, {ending}"
    return text


def _parts_as_json(machine, parts):
    return parts and [
        {
            "number": part.number,
            "working": part.working,
            "assembly": part.assembly,
            "area_m2": part.area,
            "area_error_m2": getattr(part, "area_error", 0.0),
            "point_m": machine.frame(part.point),
        }
        for part in parts
    ]


def _as_json(machine, parts, checks):
    paths = []
    for mode, check in checks:
        attributes = (name.removesuffix("_s").removesuffix("_N") for name in PATH)
        row = {key: getattr(check, name, None) for key, name in zip(PATH, attributes)}
        paths.append({"working": mode} | row)
    return {"aspects": _parts_as_json(machine, parts), "path": paths}


def _signs(modes):
    return "".join("+" if mode > 0 else "-" for mode in modes)
