"""`path`: a Path from points, or from a CSV, SVG or G-code file."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from pathlib import PurePath

from ...base.checks import flag, instance, not_negative, one_of, optional, shown, takes
from ...base.columns import units_named
from ...base.tables import named, whole_text
from ..curve import Path
from ..placement import Placement
from .draft import Draft
from .read_gcode import read_gcode
from .read_points import read_csv, read_points

KINDS = {
    "svg": ("svg",),
    "gcode": ("gcode", "nc", "ngc", "tap", "gc", "cnc", "g"),
    "csv": ("csv", "txt", "tsv", "dat"),
}
EXAMPLE = FilePath(__file__).parent / "drawings" / "fivebar.svg"  # a word, drawn for this package
LARGEST = 50_000_000  # bytes of a drawing's file


@takes(
    deviation=not_negative,
    curvature=flag,
    placement=optional(instance(Placement)),
    kind=one_of(None, "csv", "svg", "gcode"),
)
def path(
    points_or_file: object,
    *,
    deviation: float = 0.0,
    curvature: bool = False,
    placement: Placement | None = None,
    units: str | Mapping[str, str] | Sequence[str] | None = None,
    kind: str | None = None,
) -> Path:
    """The path through points, or of a drawing in a file: Path, a curve xi(s) with exact
    derivatives.

    points_or_file: points (n, 2) m, a list of strokes of points, between which the pen is up,
        pieces (Line, Arc, Polynomial); or a file's name, or an open text file: CSV with columns x
        and y (and perhaps pen), SVG, G-code.
    deviation: m, within which corners are rounded by quintics with continuous curvature, so that a
        motion goes on through them, and curves of an SVG that are no arcs become quintics; 0: a
        motion rests at each corner, and such curves are kept within 1 nm. Lines and arcs are exact.
    curvature: round where the curvature jumps, too, as between a line and an arc: for motions with
        limited jerk.
    placement: where the drawing is put first; deviation is of what is placed.
    units: of lengths in a file that does not name them ("mm"; of a CSV's columns as in
        `columns.read`).
    kind: "csv", "svg" or "gcode"; None: by the file's ending, else by how it begins.
    What was passed over, converted or assumed is in Path.said. ValueError, with file and line, for
    what is empty, not known, ambiguous or contradicts itself; ImportError for an SVG without the
    extra `draw`.
    """
    placement = placement or Placement()
    if isinstance(points_or_file, str | os.PathLike) or hasattr(points_or_file, "read"):
        text, name = whole_text(points_or_file, "a drawing", LARGEST)
        with named(name):  # pieces do not know it, as a line that ends at 1e200 m
            return _read(text, name, units, kind).finished(placement, deviation, curvature)
    for name, value in (("units", units), ("kind", kind)):
        if value is not None:
            raise ValueError(f"path: {name} is of a file, and there is none")
    return read_points(points_or_file).finished(placement, deviation, curvature)


def _read(
    text: str,
    name: str,
    units,
    kind,
) -> Draft:
    ending = PurePath(name).suffix.lower().lstrip(".")
    if kind is None:
        kinds = [kind for kind, endings in KINDS.items() if ending in endings]
        kind = kinds[0] if kinds else "svg" if text.lstrip().startswith("<") else "csv"
    if kind == "csv":
        again = io.StringIO(text)
        again.name = name
        return read_csv(again, units_named(units, "path: units"))
    if not (units is None or isinstance(units, str)):
        raise ValueError(f'path: units of {name} must be one word, as "mm", not {shown(units)}')
    if kind == "gcode":
        return read_gcode(text, name, units)
    try:
        from .read_svg import read_svg
    except ImportError as error:
        raise ImportError(
            "to read an SVG, svgelements is needed: pip install svgelements"
        ) from error
    return read_svg(text, name, units)
