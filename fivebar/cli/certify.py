"""`fivebar certify`: a whole path proved free of singularities and within reach, and such a proof
checked.
"""

from __future__ import annotations

import json
import math
import sys
from argparse import ArgumentParser, _SubParsersAction
from pathlib import Path

from ..base.errors import UsageError
from .robot_options import add_robot_options, chosen_robot


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `certify` to the program's commands."""
    parser: ArgumentParser = commands.add_parser("certify")
    parser.add_argument(
        "path", nargs="?", metavar="FILE", help="a CSV of x, y, an SVG or G-code, as for draw"
    )
    parser.add_argument(
        "--check", type=Path, metavar="PROOF.json", help="check a proof instead, with mpmath alone"
    )
    parser.add_argument(
        "--units", metavar="UNIT", help="of a file that does not name them: mm, in, px, m"
    )
    parser.add_argument(
        "--deviation", type=float, default=0.0, metavar="M", help="within which corners are rounded"
    )
    parser.add_argument(
        "--shift",
        nargs=2,
        type=float,
        default=(0.0, 0.0),
        metavar=("X", "Y"),
        help="of the path, m",
    )
    parser.add_argument(
        "--turn-deg", type=float, default=0.0, metavar="DEG", help="about its origin, to the left"
    )
    parser.add_argument(
        "--scale", type=float, default=1.0, metavar="K", help="of the path (default: 1)"
    )
    parser.add_argument(
        "--working",
        nargs=2,
        type=int,
        default=(-1, -1),
        metavar=("W1", "W2"),
        help="(default: -1 -1)",
    )
    parser.add_argument(
        "--tolerance",
        action="append",
        default=[],
        metavar="M|NAME=M",
        help="of every length, or of one (l11=1e-4), m; may be given again",
    )
    parser.add_argument(
        "--margin",
        type=float,
        default=0.0,
        metavar="SINE",
        help="least |sin q12|, |sin q22|, |det A|",
    )
    parser.add_argument("--out", type=Path, metavar="PROOF.json", help="where to write the proof")
    parser.add_argument("--json", action="store_true", help="what was found, as JSON")
    add_robot_options(parser)
    parser.set_defaults(run=_certify)


def _certify(arguments):
    if (arguments.check is None) == (arguments.path is None):
        raise UsageError("certify needs a path's file, or --check and a proof")
    if arguments.check:
        _check(arguments.check)
        return
    from ..constraints.constraints import Constraints
    from ..paths.certificates.certify import certify
    from ..paths.placement import Placement
    from ..paths.reading.read import path as read

    robot = chosen_robot(arguments)
    try:
        placement = Placement(
            tuple(arguments.shift), math.radians(arguments.turn_deg), arguments.scale
        )
        path = read(
            arguments.path,
            deviation=arguments.deviation,
            units=arguments.units,
            placement=placement,
        )
        constraints = Constraints(det_A=arguments.margin, sin=arguments.margin)
        tolerances = _tolerances(arguments.tolerance)
        found = certify(robot, path, tolerances, constraints, arguments.working)
    except (TypeError, ValueError, OSError) as error:
        raise UsageError(error) from None
    for sentence in path.notes:
        print(f"{arguments.path}: {sentence}", file=sys.stderr)
    if arguments.json:
        stretches = [stretch._asdict() for stretch in found.unproved]
        print(
            json.dumps(
                {"proved": found.proved, "assembly": found.assembly, "unproved": stretches},
                indent=2,
            )
        )
    elif found.proved:
        print(f"proved on {len(path.pieces)} pieces, {path.length:.6g} m: {_claim(found.claim)}")
    for stretch in () if arguments.json else found.unproved:
        lengths = ", ".join(f"{name} = {value:.9g}" for name, value in stretch.lengths.items())
        verdict = (
            f"false at s = {stretch.at:.9g} m for {lengths}" if stretch.false else "not proved"
        )
        print(f"from s = {stretch.start:.9g} to {stretch.stop:.9g} m: {verdict}: {stretch.why}")
    if not found.proved:
        raise ValueError(f"not proved: {_claim(found.claim)}")
    if arguments.out:
        found.to_json(arguments.out)
        print(arguments.out)


def _claim(claim):
    robot, tolerances = claim["robot"], claim["tolerances"]
    lengths = ", ".join(
        f"{n} = {v:g}{f' +- {tolerances[n]:g}' if n in tolerances else ''}"
        for n, v in robot.items()
    )
    return (
        f"{lengths} m, working {claim['working']}, assembly {claim['assembly']:+d}, margin"
        f" {claim['margin']:g}"
    )


def _check(file):
    from ..base.progress import progress
    from ..paths.certificates.checker import check

    if not file.is_file():
        raise UsageError(f"there is no file {file}")
    if reason := check(file, lambda pieces: progress(pieces, desc="check", delay=2)):
        raise ValueError(f"{file}: refused: {reason}")
    claim = json.loads(file.read_text(encoding="utf-8"))
    print(f"proved on {len(claim['pieces'])} pieces: {_claim(claim)}")


def _tolerances(words):
    """One number for all lengths, and numbers for lengths by name."""
    found: dict[str, float] = {}
    for word in words:
        name, _, value = word.rpartition("=")
        try:
            amount = float(value)
        except ValueError:
            raise UsageError(f"--tolerance takes a number of m, or NAME=M, not {word!r}") from None
        found |= (
            {name: amount} if name else dict.fromkeys(("l11", "l12", "l21", "l22", "d"), amount)
        )
    return found
