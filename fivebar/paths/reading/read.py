"""`path`: a Path from points, or from a CSV, SVG or G-code file."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from pathlib import PurePath
from typing import Any

from ...base.checks import flag, instance, not_negative, one_of, optional, shown, takes, two_numbers
from ...base.headings import units_named
from ...base.tables import named, whole_text
from ..curve import Path
from ..placement import Placement
from .draft import Draft
from .read_gcode import read_gcode
from .read_points import read_csv, read_points

KINDS = {  # by the ending of a file's name and, in the lines below it, the text
    "svg": r"svg\n|.*\n\s*<",
    "gcode": r"(gcode|nc|ngc|tap|gc|cnc|g)\n"
    r"|(?!csv).*\n\s*([;(%].*\n\s*)*(G\d|[MNO]\d+ *([A-Z]\d|[\r\n]))",  # after comments
    "csv": "",
}
NOT_READ = {"mp": "a program of a DexTAR robot", "dxf": "a DXF drawing"}
EXAMPLE = FilePath(__file__).parent / "drawings" / "fivebar.svg"  # a word, drawn for this package
LARGEST = 50_000_000  # bytes of a drawing's file


@takes(
    deviation=not_negative,
    curvature=flag,
    placement=optional(instance(Placement)),
    kind=one_of(None, "csv", "svg", "gcode"),
    pen_values=optional(two_numbers),
)
def path(
    points_or_file: Any,
    *,
    deviation: float = 0.0,
    curvature: bool = False,
    placement: Placement | None = None,
    units: str | Mapping[str, str] | Sequence[str] | None = None,
    columns: Mapping[str, str] | Sequence[str] | None = None,
    kind: str | None = None,
    pen_values: tuple[float, float] | None = None,
) -> Path:
    """Return the path through points, or of a drawing in a file.

    Lines and arcs are exact. Curves of an SVG that are no arcs become quintics.

    Parameters
    ----------
    points_or_file : array, list, str or open file
        Points (n, 2), m; a list of strokes of points, between which the pen is up; pieces (Line,
        Arc, Polynomial); or a file: SVG, G-code, or CSV with columns x, y and perhaps pen.
    deviation : float
        Distance, m, within which corners are rounded by quintics of continuous curvature, and
        curves kept. Of lines so short that they follow a curve, as dense rows do, a few quintics
        take the place. 0: a motion rests at each corner, and curves are kept within 1 nm.
    curvature : bool
        Round also where the curvature jumps, as between a line and an arc: for a limit on jerk.
    placement : Placement, optional
        Where the drawing is put first; deviation is that of the placed drawing.
    units : str, optional
        Unit of lengths in a file that names none, "mm" for example; of a CSV as in `columns.read`.
    pen_values : (2,), optional
        Height Z, or angle of the servo, where the pen of G-code is down, and where it is up; as the
        file writes them. By default it is down at Z <= 0, or where no G0 goes.
    columns : mapping or sequence of str, optional
        Headings of a CSV that are called otherwise: {"x": "East (mm)"} or ("x=East (mm)",).
    kind : {"csv", "svg", "gcode"}, optional
        Kind of the file; by default from its ending, or how its text begins.

    Returns
    -------
    Path
        Its `notes` list what was left out, converted or assumed.

    Raises
    ------
    ValueError
        A file is empty, unknown, ambiguous or contradicts itself; the message has its line.

    Examples
    --------
    >>> import fivebar as fb
    >>> path = fb.path([(0.0, 0.0), (0.03, 0.0), (0.03, 0.04)], deviation=1e-3)
    >>> len(path.stops)
    2
    """
    placement = placement or Placement()
    if isinstance(points_or_file, str | os.PathLike) or hasattr(points_or_file, "read"):
        text, name = whole_text(points_or_file, "a drawing", LARGEST)
        with named(name):  # pieces do not know it, as a line that ends at 1e200 m
            draft = _read(text, name, units, columns, kind, pen_values)
            return draft.finished(placement, deviation, curvature)
    of_files = {"units": units, "columns": columns, "kind": kind, "pen_values": pen_values}
    for name, value in of_files.items():
        if value is not None:
            raise ValueError(f"path: {name} is of a file, and there is none")
    return read_points(points_or_file).finished(placement, deviation, curvature)


def _read(text: str, name: str, units, columns, kind, pen_values) -> Draft:
    ending = PurePath(name).suffix.lower().lstrip(".")
    if ending in NOT_READ and kind is None:
        raise ValueError(
            f"{name}: {NOT_READ[ending]}, which is not read: save it as SVG, G-code or a CSV of x,"
            " y, or give kind= if it is something else"
        )
    kind = kind or next(k for k, start in KINDS.items() if re.match(start, f"{ending}\n{text}"))
    if pen_values and kind != "gcode":
        raise ValueError(f"path: pen_values are of G-code, and {name} is read as {kind}")
    if kind == "csv":
        again = io.StringIO(text)
        again.name = name
        return read_csv(again, units_named(units, "path: units"), columns)
    if columns:
        raise ValueError(f"path: columns are of a CSV file, and {name} is none")
    if not (units is None or isinstance(units, str)):
        raise ValueError(f'path: units of {name} must be one word, as "mm", not {shown(units)}')
    if kind == "gcode":
        return read_gcode(text, name, units, pen_values)
    from .read_svg import read_svg  # here, as it brings in svgelements

    return read_svg(text, name, units)
