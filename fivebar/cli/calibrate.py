"""`fivebar calibrate`: lengths, readings and measuring frame of a robot, from measured points."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..base.errors import UsageError
from ..base.tables import written
from .options import (
    TABLE,
    WORKING,
    add_command,
    named_values,
    print_json,
    usage_errors,
    used_options,
    write_files,
)
from .robot_options import add_robot_options, chosen_machine

OPTIONS = TABLE | {
    "[DATA.csv]": "",
    "--unknown NAME ...": (
        "of l11 l12 l21 l22 d offset1 offset2 ratio1 ratio2 x0 y0 turn scale along across (default:"
        " lengths and offsets)"
    ),
    "--tool-leg 1|2": "that carries a pen beside the joint (default: as in the robot's file)",
    "--start NAME=VALUE ...": "known, or to begin with",
    "--sigma M": "standard deviation of a measured number, m",
    "--prior NAME=SD ...": "what is known of an unknown beforehand, as l11=0.3mm offset1=1deg",
    "--loss linear|huber|cauchy": ("linear", ""),
    "--units UNIT ...": "without one in the heading: deg, x=mm",
    "--mistakes raise|keep": ("raise", "refuse data that fit no such robot, or take them"),
    "--from-drawing A4|A5": "write a test drawing, and a table for a ruler to fill in, instead",
    "--photo PICTURE": "of the drawn sheet, whole, on a darker ground: with --from-drawing",
    "--sides MM MM": "of that sheet, by a ruler, the longer one first: scale of the photograph",
    WORKING: "of the test drawing: working modes",
    "--out FOLDER": "calibration.png, .json, .txt, and robot.toml go there",
}


def add_parsers(commands):
    """Add `calibrate` to the program's commands."""
    words = (
        "The file has columns q1, q2 and x, y (m, rad, or a unit in the heading: x (mm), q1_deg);"
        " or distance and to, the number of the row it leads to; perhaps working1, working2,"
        " assembly, sigma."
    )
    parser = add_command(commands, "calibrate", _calibrate, (OPTIONS,), description=words)
    add_robot_options(parser)


def _sheet(arguments, machine):
    """Return the test drawing and the folder of its files."""
    from ..estimation.calibration.sheet import sheet

    if arguments.data is not None:
        raise UsageError("--from-drawing is of a test drawing: it goes without measured data")
    with usage_errors(ValueError):
        drawn = sheet(machine, arguments.from_drawing, arguments.working)
    return drawn, Path(arguments.out or "fivebar-sheet")


def _measure_photo(arguments, drawn, folder):
    """Write the crosses of a photograph as measured data, to be calibrated with."""
    from matplotlib.image import imread

    from ..estimation.calibration.calibrate import DEFAULT
    from ..estimation.calibration.photo import crosses_in

    size = None if arguments.sides is None else 1e-3 * np.array(arguments.sides)
    with usage_errors(ValueError, OSError):
        points = crosses_in(imread(arguments.photo), drawn, arguments.from_drawing, size)
    (table,) = write_files(folder, {"crosses.csv": lambda path: drawn.points_to_csv(path, points)})
    arguments.data = table
    arguments.unknown = arguments.unknown or [*DEFAULT, "x0", "y0", "turn"]


def _write_sheet(arguments, drawn, folder):
    """Write the test drawing and the table for the ruler, and say what to do with them."""
    from ..paths.placing.fitting_in import bounds

    drawing, table = write_files(
        folder, {"sheet.csv": drawn.drawing_to_csv, "distances.csv": drawn.distances_to_csv}
    )
    x, y = bounds(drawn.path).mean(axis=0).round(6) + 0.0  # -0 is 0
    signs = " ".join(map(str, drawn.working))
    robot = f"--robot {arguments.robot}"
    print(f"{drawing}\n{table}")
    print(
        f"draw it:      fivebar draw {drawing} {robot} --at {x:.6g} {y:.6g} --working {signs}"
        f" --deviation 0\nmeasure the {len(drawn.pairs)} distances between crosses, in mm, into"
        f" {table}; A1 is below on the left\ncalibrate:    fivebar calibrate {table} {robot}"
        " --sigma 0.0003 --out calibrated\nor, with a photograph of"
        f" the sheet:   fivebar calibrate --from-drawing {arguments.from_drawing} --photo PICTURE"
        f" --sides LONG SHORT {robot} --working {signs} --sigma 0.0001 --out calibrated"
    )


def _calibrate(arguments):
    from ..estimation.calibration.calibrate import DEFAULT, calibrate
    from ..estimation.calibration.measured_robot import mounting_of
    from ..paths.tool import Tool

    machine = chosen_machine(arguments)
    robot = machine.robot
    if arguments.sides is not None and arguments.photo is None:
        raise UsageError("--sides are of a sheet on a photograph: give --photo PICTURE")
    if arguments.from_drawing is not None:
        drawn, folder = _sheet(arguments, machine)
        if arguments.photo is None:
            return _write_sheet(arguments, drawn, folder)
        _measure_photo(arguments, drawn, folder)
    elif arguments.photo is not None:
        raise UsageError("--photo is of a test drawing: give --from-drawing A4 or A5, too")
    elif arguments.working is not None:
        raise UsageError(
            "--working is of a test drawing: give --from-drawing A4 or A5, too; the modes of"
            " measured data are in columns working1, working2"
        )
    if arguments.data is None:
        raise UsageError("calibrate needs a file of measured data, or --from-drawing A5")
    unknown = tuple(" ".join(arguments.unknown or DEFAULT).replace(",", " ").split())
    tool = machine.tool
    if arguments.tool_leg:
        tool = replace(tool or Tool(1), leg=int(arguments.tool_leg))
    result = calibrate(
        robot,
        arguments.data,
        unknown,
        tool=tool,
        start=mounting_of(machine) | named_values(arguments.start, "--start"),
        priors=named_values(arguments.prior, "--prior"),
        **used_options(arguments, "sigma", "loss", "units", "columns", "mistakes"),
    )
    text = str(result)
    if arguments.json:
        print_json(_as_json(result))
    else:
        print(text)
    if arguments.out:
        calibrated = replace(result.machine, constraints=machine.constraints)
        files = write_files(
            arguments.out,
            {
                "calibration.png": result.plot,
                "calibration.json": result.to_json,
                "calibration.txt": lambda path: _write_text(path, text),
                "robot.toml": lambda path: calibrated.save(
                    path, result.sd, ("calibrated; SI units",)
                ),
            },
        )
        print(*files, sep="\n", file=sys.stderr if arguments.json else sys.stdout)


def _write_text(path, text):
    with written(path) as file:
        file.write(text + "\n")


def _as_json(result):
    names = (
        "values sd rank indistinguishable weakly_identified dof p_value fits outliers notes robot"
        " correlation"
    )
    table = {name: getattr(result, name) for name in names.split()}
    return table | {
        "intervals_95": result.intervals(),
        "rows": len(result.rows),
        "rms_m": result.rms,
        "rms_before_m": result.rms_before,
        "advised_priors": result.advised_priors,
        "chi2": result.chi2 if result.absolute else None,
        "residuals_m": result.residuals,
    }
