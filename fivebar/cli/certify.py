"""`fivebar certify`: a whole path proved free of singularities and within reach, and such a proof
checked.
"""

from __future__ import annotations

import json
import math

from ..base.errors import UsageError
from .options import (
    TABLE,
    WORKING,
    add_command,
    number,
    print_json,
    print_notes,
    refuse_others,
    usage_errors,
    used_options,
)
from .robot_options import add_robot_options, chosen_machine, machine_for, print_frames

OPTIONS = TABLE | {
    "[FILE]": "a CSV of x, y, an SVG or G-code, as for draw",
    "--check PROOF.json": "check a proof instead, with mpmath alone",
    "--units UNIT": "of a file that does not name them: mm, in, px, m",
    "--deviation M": (0.0, "within which corners are rounded"),
    "--shift X Y": ((0.0, 0.0), "of the path, m"),
    "--turn-deg DEG": (0.0, "about its origin, to the left"),
    "--scale K": (1.0, "of the path"),
    WORKING: ((-1, -1), "working modes"),
    "--tolerance [NAME=]M ...": "of every length, or of one (l11=1e-4), m",
    "--margin SINE": (0.0, "least |sin q12|, |sin q22|, |det A|, over that of the robot's file"),
    "--out OUT.json": "where to write the proof",
}


def add_parsers(commands):
    """Add `certify` to the program's commands."""
    add_robot_options(add_command(commands, "certify", _certify, (OPTIONS,)))


def _certify(arguments):
    if (arguments.check is None) == (arguments.file is None):
        raise UsageError("certify needs a path's file, or --check and a proof")
    if arguments.check:
        refuse_others(arguments, "--check goes alone: a proof holds all that it needs", "check")
        _check(arguments.check)
        return
    from ..constraints.constraints import Constraints
    from ..paths.certificates.certify import certify
    from ..paths.placement import Placement
    from ..paths.reading.read import path as read

    machine = chosen_machine(arguments)
    tolerances = _tolerances(arguments.tolerance)
    with usage_errors(TypeError, ValueError, OSError):
        placement = Placement(
            tuple(arguments.shift), math.radians(arguments.turn_deg), arguments.scale
        )
        told = used_options(arguments, "deviation", "units", "columns")
        path = read(arguments.file, placement=placement, **told)
        machine = machine_for(arguments, machine, arguments.file, path)
        constraints = Constraints(det_A=arguments.margin, sin=arguments.margin)
        proof = certify(machine, path, tolerances, constraints, arguments.working)
    print_notes(arguments.file, path.notes)
    if arguments.json:
        print_json(
            {
                "proved": proof.proved,
                "assembly": proof.assembly,
                "frame": arguments.frame,
                "unproved": [stretch._asdict() for stretch in proof.unproved],
            }
        )
    else:
        print_frames(arguments, machine)
        _print(proof)
    if not proof.proved:
        raise ValueError(f"not proved: {_claim(proof.claim)}")
    if arguments.out:
        proof.to_json(arguments.out)
        print(arguments.out)


def _print_proved(claim):
    print(f"proved on {len(claim['pieces'])} pieces: {_claim(claim)}")


def _print(proof):
    if proof.proved:
        _print_proved(proof.claim)
    for stretch in proof.unproved:
        verdict = "not proved"
        if stretch.false:
            lengths = ", ".join(f"{name} = {value:.9g}" for name, value in stretch.lengths.items())
            verdict = f"false at s = {stretch.at:.9g} m for {lengths}"
        print(f"from s = {stretch.start:.9g} to {stretch.stop:.9g} m: {verdict}: {stretch.why}")


def _claim(claim):
    tolerances = claim["tolerances"]
    lengths = [f"{n} = {v:g} +- {tolerances.get(n, 0.0):g} m" for n, v in claim["robot"].items()]
    if tool := claim.get("tool"):
        offset = f"{tool['along']:g} m along its bar and {tool['across']:g} m to its left"
        lengths.append(f"a tool on leg {tool['leg']}, {offset}")
    return (
        f"{', '.join(lengths)}, working {claim['working']}, assembly {claim['assembly'] or 'none'},"
        f" margin {claim['margin']:g}"
    )


def _check(file):
    from ..base.progress import progress
    from ..paths.certificates.checker import check

    if reason := check(file, lambda pieces: progress(pieces, desc="check", delay=2)):
        raise ValueError(f"{file}: refused: {reason}")
    _print_proved(json.loads(file.read_text(encoding="utf-8")))


def _tolerances(words):
    """Return tolerances by length: of one number for all lengths, of NAME=M for one."""
    from ..paths.certificates.checker import LENGTHS

    tolerances = {}
    for word in words:
        name, _, value = word.rpartition("=")
        names = [name] if name else LENGTHS
        tolerances |= dict.fromkeys(names, number(value, "--tolerance", names[0]))
    return tolerances
