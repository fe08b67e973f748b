"""Places on a path where it cannot be timed, refused with s and what is wrong there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...base.errors import SingularityError, UnreachableError
from ...constraints.load import too_heavy
from ...models.geometry import igm
from ...singularities.degenerate import refuse_singular_everywhere

if TYPE_CHECKING:
    from ...models.robots import Robot
    from ..curve import Path
    from .bounds import Stretches
    from .constraint_rows import Limits
    from .mesh import Mesh

VOID = 1e-9  # of a factor's largest size, that counts as 0 where Type 2 is crossed
SAMPLES = 8  # of each stretch, at which it must be reached
TOUCH = 1e-6  # of det A: about 0.1 um, nearer to Type 2 than any robot knows itself


def where(path: Path, s: float) -> str:
    """Return a place of a path, in words."""
    x, y = path(s)[0]
    line = f", line {path.line_of(s)}" * bool(path.line_of(s))
    joint = f"joint C at ({x:.9g}, {y:.9g}) m in the robot's own frame"
    return f"s = {s:.9g} m of {path.length:.6g}{line}, {joint}"


def held(mesh: Mesh, limits: Limits, k: int) -> str:
    """Return in words that the limits do not hold the robot at rest at node k; "" where they do."""
    holds = [limit for limit in (limits.torque, limits.stall) if limit is not None]
    if not holds or mesh.crossing[k]:
        return ""
    pose = igm(mesh.robot, mesh.path(mesh.s[k])[0], mesh.working)
    words = too_heavy(pose, np.min(holds, axis=0))
    return f": {words}" if words else ""


def refuse_unreachable(
    robot: Robot, path: Path, stretches: Stretches, working: tuple[int, int]
) -> None:
    """UnreachableError or SingularityError where the path first leaves what the legs reach, or
    where all poses of the modes are singular.
    """
    refuse_singular_everywhere(robot, working, "time_path")
    s = stretches.first[:, None] + stretches.length[:, None] * np.linspace(0, 1, SAMPLES + 1)
    xi = path.on(np.broadcast_to(stretches.piece[:, None], s.shape), s)[0].reshape(-1, 2)
    bad = ~np.isfinite(igm(robot, xi, working, unreachable="nan").q).all(axis=1)
    if not bad.any():
        return
    k = int(np.argmax(bad))
    piece = stretches.piece[k // (SAMPLES + 1)]
    last = s.ravel()[k]
    place = float(path.knots[piece] + last)
    try:
        igm(robot, path.on(piece, last)[0], working)
    except (UnreachableError, SingularityError) as error:
        amount = error.gap if isinstance(error, UnreachableError) else error.margin
        raise type(error)(
            f"time_path: the path leaves the workspace before s = {place:.9g} m: {error}", amount
        ) from None


def refuse_undecided(mesh: Mesh, k: int, leg: bool) -> None:
    """Of a stretch too short to be divided, k; leg: whether a leg is in line on it, else det A is
    0.
    """
    s = mesh.s[k]
    at = where(mesh.path, s)
    if leg:
        raise SingularityError(
            f"time_path: the path touches Type 1 (a leg in line) in working modes {mesh.working} at"
            f" {at}",
            0.0,
        )
    raise SingularityError(
        f"time_path: the path grazes Type 2 (det A = 0 without changing sign) at {at}: there the"
        " bars carry nothing across themselves, and no speed makes that right on both sides; move"
        " or turn the path",
        0.0,
    )


def refuse_touching(mesh: Mesh) -> None:
    """Of a path that rests on Type 2, touches it at a node, or runs along the bars there and
    bends.
    """
    D = mesh.found["D"]
    side = mesh.side
    ends = np.append(D.first, D.last[-1])
    bad = ((np.abs(ends) <= TOUCH) | mesh.crossing) & mesh.rest
    if bad.any():
        raise SingularityError(
            f"time_path: the path rests on Type 2 at {mesh.place(int(np.argmax(bad)))} (|det A| is"
            f" at most {TOUCH:g}): no torque starts it there; let it pass, or rest elsewhere",
            0.0,
        )
    graze = np.flatnonzero(mesh.crossing[1:-1] & (side[1:] == side[:-1]))
    if len(graze):
        refuse_undecided(mesh, int(graze[0]) + 1, False)
    for k in np.flatnonzero(mesh.crossing).tolist():
        a, *others = (mesh.share(name, k) for name in "abvc")
        if a <= VOID < max(others):
            raise SingularityError(
                "time_path: the path runs along the distal bars where it crosses Type 2, at"
                f" {mesh.place(k)}, and bends or falls across them: nothing can push it there: no"
                " speed, or one alone, would cross it",
                0.0,
            )
