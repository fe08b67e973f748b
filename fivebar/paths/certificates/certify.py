"""A proof that a whole path is reached, keeps its mode and its margin, by every robot within
tolerances.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import NamedTuple

import flint
import numpy as np

from ...base.checks import instance, modes, not_negative
from ...base.progress import progress
from ...base.representation import one_line
from ...base.robot_uses import takes_robot
from ...base.tables import TextFile, written
from ...constraints.constraints import Constraints, kept_by
from ...models.geometry import igm
from ...models.robots import FiveBar
from ...singularities.degenerate import refuse_singular_everywhere
from ..curve import Path
from ..pieces import Arc, Line
from .checker import LENGTHS, Number, digest, joint, legs, margins, point, proved

# Of a piece; not parted any more are parts as short as this
FINEST = 2.0**-48  #  whatever they are,
FINE = 2.0**-10  # where nothing is proved in their middle,
COARSE = 2.0**-5  # where nothing is proved there and at their ends.
INSIDE = 1 - 2.0**-40  # of a tolerance: so that rounding leaves it within
BITS = 64  # the checker has 80, so that what is proved here is proved there


def _ball(value):
    if isinstance(value, tuple):
        return _ball(value[0]).union(_ball(value[1]))
    return flint.arb(value)


# As the checker's intervals.
_BALLS = SimpleNamespace(
    mpf=_ball,
    sqrt=flint.arb.sqrt,
    cos=flint.arb.cos,
    sin=flint.arb.sin,
    low=flint.arb.lower,
    high=flint.arb.upper,
)


class Unproved(NamedTuple):
    """A stretch of a path, s from `start` to `stop` m, on which the claim is not proved: `false`
    where a robot within the tolerances, of these `lengths`, breaks it at s = `at`; else neither
    that nor the opposite was found.
    """

    start: float
    at: float
    stop: float
    false: bool
    why: str
    lengths: dict[str, float]


@dataclass(frozen=True, eq=False)
class Certificate:
    """What `certify` proved: `proved`, or where not (`unproved`, Unproved in the order of the
    path).

    claim: all that is claimed and its proof, as `to_json` writes it; assembly: the assembly mode
        that is kept, 0 where the path is out of reach.
    """

    claim: dict
    unproved: tuple[Unproved, ...]

    @property
    def proved(self) -> bool:
        return not self.unproved

    @property
    def assembly(self) -> int:
        return self.claim["assembly"]

    def __repr__(self) -> str:
        count = sum(len(parts) - 1 for parts in self.claim["parts"])
        stretches = (f"{u.start:.6g} to {u.stop:.6g} m: {u.why}" for u in self.unproved[:1])
        more = f"and {len(self.unproved) - 1} more" if len(self.unproved) > 1 else ""
        notes = (
            f"margin {self.claim['margin']:g}",
            f"{len(self.claim['pieces'])} pieces in {count} parts",
        )
        return one_line(
            "Certificate", "proved" if self.proved else "not proved", *notes, *stretches, more
        )

    def to_json(self, file: TextFile) -> None:
        """Write it for `fivebar certify --check` (or checker.py alone). ValueError where it is not
        proved.
        """
        if not self.proved:
            first = self.unproved[0]
            raise ValueError(
                f"certify: not proved from s = {first.start:.9g} to {first.stop:.9g} m: {first.why}"
            )
        with written(file) as out:
            json.dump(self.claim | {"sha256": digest(self.claim)}, out)


@takes_robot(path=instance(Path), constraints=kept_by("fb.certify"), working=modes(2))
def certify(
    robot: FiveBar,
    path: Path,
    tolerances: float | Mapping[str, float] = 0.0,
    constraints: Constraints | None = None,
    working: tuple[int, int] = (-1, -1),
) -> Certificate:
    """Return a proof that every robot within the tolerances reaches a whole path in one mode.

    Each piece is divided until interval arithmetic (FLINT's balls) encloses the three sines on
    every part, for all its points and all robots, by the mean value theorem. Where that fails, a
    robot and a point that violate the claim are searched.

    Parameters
    ----------
    robot : FiveBar or Machine
    path : Path
        Lines, arcs and polynomials, exactly as their numbers say. Of a Machine it is that of its
        tool, in its measuring frame.
    tolerances : float or {name: float}
        Tolerance, m, of all five lengths or of those named.
    constraints : Constraints, optional
        det_A and sin: the larger one is the margin, the least |det A|, |sin q12| and |sin q22|. By
        default all three are proved to be above 0.
    working : (2,)
        Working modes.

    Returns
    -------
    Certificate
        `proved`; or `unproved`, with the robot and the point where the claim is false, or with
        the part on which nothing was proved.

    Raises
    ------
    ValueError
        The tolerances leave nothing of a length, or another constraint is named.
    SingularityError
        All poses of these modes are singular.
    """
    constraints = constraints or Constraints()
    refuse_singular_everywhere(robot, working, "certify")
    claim: dict = {
        "robot": {name: float(getattr(robot, name)) for name in LENGTHS},
        "tolerances": _tolerances(robot, tolerances),
        "working": list(working),
        "assembly": _assembly(robot, path, working),
        "margin": max(constraints.det_A, constraints.sin),
        "pieces": [_plain(piece) for piece in path.pieces],
        "parts": [],
    }
    if path.tool is not None:
        path.tool.refuse_other(robot, working, "certify")
        claim["tool"] = asdict(path.tool.tool)
    found = []
    with flint.ctx.workprec(BITS):
        for k, piece in enumerate(progress(claim["pieces"], desc="certify", delay=2)):
            parts, failed = _parted(claim, piece)
            claim["parts"].append(parts)
            for first, last in failed:
                middle = (first + last) / 2
                length = path.pieces[k].length
                start, at, stop = (float(path.knots[k] + u * length) for u in (first, middle, last))
                false, why, lengths = _broken(claim, piece, middle)
                found.append(Unproved(start, at, stop, false, why, lengths))
    return Certificate(claim, tuple(_stretches(found)))


def _stretches(found):
    """Return parts that follow on each other, with one verdict, as one."""
    joined = []
    for each in found:
        if (
            joined
            and joined[-1].false == each.false
            and each.start - joined[-1].stop <= 1e-9 * each.stop
        ):
            joined[-1] = joined[-1]._replace(stop=each.stop)
        else:
            joined.append(each)
    return joined


def _parted(claim, piece):
    """Return where to part a piece, u from 0 to 1, and the parts without a proof."""
    parts = [0.0]
    failed = []
    left = [(0.0, 1.0)]
    while left:
        first, last = left.pop()
        if not proved(claim, piece, first, last, _BALLS):
            middle = (first + last) / 2
            size = last - first
            tried = (middle,) if size <= FINE else (middle, first, last)
            if size > FINEST and (
                size > COARSE or any(proved(claim, piece, u, u, _BALLS) for u in tried)
            ):
                left += [(middle, last), (first, middle)]
                continue
            failed.append((first, last))
        parts.append(last)
    return parts, failed


def _broken(claim, piece, u):
    """Return whether a robot within the tolerances breaks the claim at a point, how, and the
    lengths of that robot.
    """
    nominal = claim["robot"]
    tolerances = claim["tolerances"]
    for k, (_, value, _) in enumerate(_kept(claim, piece, u, nominal)):
        lengths = {  # of which this is the least, as far as it is linear
            name: (
                nominal[name]
                - INSIDE * math.copysign(tolerances.get(name, 0.0), float(slope.mid()))
            )
            for name, slope in zip(LENGTHS, value.slopes)
        }
        there = list(_kept(claim, piece, u, lengths))
        if k < len(there) and there[k][1].value < there[k][2]:
            what, value, least = there[k]
            return (
                True,
                f"{what} = {float(value.value.mid()):.6g}, where at least {least:g} is claimed",
                lengths,
            )
    return False, "neither proved nor broken at its middle", nominal


def _kept(claim, piece, u, lengths):
    """Yield (name, quantity, its least value) of what is claimed at a point, as far as that is
    reached.
    """
    zero = _ball(0)
    numbers = []
    for name in LENGTHS:
        slopes = [_ball(name == other) for other in LENGTHS]
        numbers.append(Number(_ball(lengths[name]), slopes))
    place = point(piece, Number(_ball(u), [zero] * len(LENGTHS)), _BALLS)
    if tool := claim.get("tool"):
        place = joint(*place, numbers, tool, claim["working"], _BALLS)
    if place is None:
        return
    reached = list(legs(*place, numbers))
    for leg, (*_, outer, inner) in enumerate(reached, 1):
        yield f"(l{leg}1 + l{leg}2)^2 - r{leg}^2", outer, 0.0
        yield f"r{leg}^2 - (l{leg}1 - l{leg}2)^2", inner, 0.0
    if sines := margins(reached, claim["working"], _BALLS):
        yield from zip(("sin^2 q12", "sin^2 q22"), sines, (claim["margin"] ** 2,) * 2)
        yield (
            ("det A", "-det A")[claim["assembly"] > 0],
            sines[2] * -claim["assembly"],
            claim["margin"],
        )


def _tolerances(robot, tolerances):
    if not isinstance(tolerances, Mapping):
        tolerances = dict.fromkeys(LENGTHS, tolerances)
    if unknown := sorted(map(str, set(tolerances) - set(LENGTHS))):
        raise ValueError(
            f"certify: tolerances of {', '.join(unknown)}: known are {', '.join(LENGTHS)}"
        )
    found = {
        name: not_negative(value, f"certify: tolerances of {name}")
        for name, value in tolerances.items()
    }
    for name, value in found.items():
        if name != "d" and value >= getattr(robot, name):
            raise ValueError(
                f"certify: tolerances of {value:g} m leave nothing of {name} ="
                f" {getattr(robot, name):g} m"
            )
    return {name: value for name, value in found.items() if value}


def _assembly(robot, path, working):
    """Return the assembly mode in which a path begins, as far as it is reached; 0: nowhere."""
    found = igm(
        robot, path(np.linspace(0.0, path.length, 65))[0], working, unreachable="nan"
    ).assembly
    return int(next((mode for mode in found if mode), 0))


def _plain(piece):
    """As the checker reads it."""
    if isinstance(piece, Line):
        return {"line": [[*piece.start], [*piece.end]]}
    if isinstance(piece, Arc):
        return {"arc": [[*piece.centre], piece.radius, piece.angle0, piece.angle1]}
    return {"polynomial": piece.coefficients.tolist()}
