"""Motion studies: a linkage over one or more turns as a table, a CSV file, a picture and an
animation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ..base.backend import finite_numbers
from ..base.checks import optional, positive, strings, takes, text, two_numbers, whole
from ..base.errors import SingularityError
from ..base.presentation import Animated
from ..base.representation import one_line
from ..base.tables import Table, TextFile, write
from ..models.robots import FiveBar
from .checks import check_branch, loads
from .checks import linkage as must_be_linkage
from .drives import DRIVES, law, smooth_branch, two_motors
from .five_bar import FiveBarLinkage
from .four_bar import FourBar
from .motion import Body, Motion
from .moving import move
from .quantities import evaluate, unit, usual
from .six_bar_press import SixBarPress
from .slider_crank import SliderCrank

Linkage = FourBar | SliderCrank | SixBarPress | FiveBarLinkage
KINDS = {kind.__name__: kind for kind in Linkage.__args__}
FULL = 2 * np.pi
MOST_SAMPLES = 10**6  # of some 700 bytes each
SLOWEST = 1e-60  # rad/s


@dataclass(frozen=True, eq=False)
class Study(Animated):
    """A linkage in motion on a grid of times, from `study`.

    Attributes
    ----------
    t : (n,), s
    q : (n,) or (n, 2), rad
        Continuous.
    columns : dict
        {quantity: (n,)}.
    motion : Motion
        Of all samples; any other quantity is read in it.
    lock : (crank angle, time) or None
        Where the crank locks.

    Examples
    --------
    >>> from fivebar import linkages
    >>> four_bar = linkages.FourBar(0.2, 0.06, 0.16, 0.14)
    >>> linkages.study(four_bar, speed=6.28, samples=101).lock is None
    True
    """

    linkage: Linkage
    t: np.ndarray
    q: np.ndarray
    motion: Motion
    columns: dict
    lock: tuple | None
    _arguments: dict = field(repr=False)

    def __repr__(self) -> str:
        rows = f"{self.t[-1]:g} s in {len(self.t)} rows"
        locks = "locks" if self.lock else ""
        return one_line(
            "Study", type(self.linkage).__name__, rows, f"{len(self.columns)} quantities", locks
        )

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a quantity (n,) by its name, of the table or not; angles are continuous."""
        if name in self.columns:
            return self.columns[name]
        return _column(self.motion, name, self._arguments["load"], self._arguments["gravity"])

    def points(self) -> np.ndarray:
        """Return positions of all points, (n, k, 2) m, in the order of `motion.points`."""
        return np.stack([self.motion.position(name) for name in self.motion.points], axis=1)

    def to_csv(self, path: TextFile) -> None:
        """Write the table, units in its header; what `from_csv` needs to repeat the study is in its
        first line.
        """
        about = {
            "linkage": {"kind": type(self.linkage).__name__, **asdict(self.linkage)},
            **self._arguments,
        }
        rows = np.column_stack([self.t, *self.q.reshape(len(self.t), -1).T, *self.columns.values()])
        write(path, "linkage study", about, _header(self.q, self.columns), rows.tolist())

    @classmethod
    def from_csv(cls, path: TextFile) -> Study:
        """Read what `to_csv` wrote: the study is repeated, its columns are those of the file.

        ValueError with file and line for what is not such a file.
        """
        table = Table(path)
        again = table.about("linkage study", "a file written by Study.to_csv", _repeated)
        values = table.numbers(
            _header(again.q, again.columns), finite=False
        )  # a straight path's radius is inf
        if len(values) != len(again.t):
            raise ValueError(
                f"{table.name}: {len(values)} rows, where its first line makes {len(again.t)}"
            )
        columns = dict(zip(again.columns, values[:, -len(again.columns) :].T))
        return replace(again, t=values[:, 0], columns=columns)


@takes(
    linkage=must_be_linkage,
    turns=positive,
    drive=text,
    samples=whole(0, MOST_SAMPLES),
    load=loads,
    gravity=two_numbers,
    between=optional(two_numbers),
    quantities=optional(strings),
)
def study(
    linkage: Linkage,
    speed: float | tuple[float, float] = FULL,
    turns: float = 1.0,
    drive: str = "turn",
    branch: int | tuple[int, int] | None = None,
    start: ArrayLike | None = None,
    between: tuple[float, float] | None = None,
    samples: int = 361,
    load: dict[str, ArrayLike] | None = None,
    gravity: ArrayLike = (0.0, 0.0),
    quantities: Sequence[str] | None = None,
) -> Study:
    """Return a linkage's motion over one or more turns, as a table of quantities.

    Parameters
    ----------
    linkage : FourBar, SliderCrank, SixBarPress or FiveBarLinkage
    speed : float
        rad/s, a pair for two motors; < 0 turns clockwise.
    turns : float
    drive : {"turn", "until-lock", "swing"}
        "turn" evenly, and smoothly through the flat poses of a change point; "until-lock" the
        same up to where the crank locks; "swing" to and fro in its range, or in `between`.
    branch, start
        None: the linkage's usual ones; start in rad. Of a swing, start says in which range.
    between : (low, high), rad
        Of a swing; ends at which the crank locks are left out by a thousandth of it.
    samples : int
        Per turn, at most 10^6 in all.
    load : mapping
        {point: (Fx, Fy)}, N, for the torque.
    gravity : (gx, gy), m/s^2
        For the torque.
    quantities : sequence of str
        Of the table; None: the usual ones.

    Returns
    -------
    Study

    Raises
    ------
    UnreachableError
        The crank locks, with drive "turn", or cannot stand at `start` or `between`.

    Examples
    --------
    >>> from fivebar import linkages
    >>> study = linkages.study(linkages.FourBar(0.2, 0.06, 0.16, 0.14), samples=5)
    >>> study["rocker.angle"].round(3)
    array([1.925, 1.978, 2.58 , 2.561, 1.925])
    """
    motors = 2 if isinstance(linkage, FiveBarLinkage) else 1
    speed = finite_numbers(speed, "speed")
    shapes = [(), (2,)][:motors]
    if speed.shape not in shapes or not (np.abs(speed) > SLOWEST).all():
        raise ValueError(f"speed must be finite and not 0, one number for each motor, not {speed}")
    if samples < 3 or turns * (samples - 1) < 0.5:
        raise ValueError(
            f"a study needs at least 3 samples a turn and 2 in all, not {samples} over {turns:g}"
            " turns"
        )
    if turns * (samples - 1) > MOST_SAMPLES:
        raise ValueError(f"{turns:g} turns of {samples} samples are more than 10^6 poses")
    if start is not None:
        start = finite_numbers(start, "start")
        if start.shape != shapes[-1]:
            raise ValueError(f"start must be one number for each motor, rad, not {start}")
        start = start.tolist()
    speed = speed.tolist()
    branch = check_branch(linkage, branch)
    if drive not in DRIVES:
        raise ValueError(f"no drive {drive!r}; the known ones are {', '.join(DRIVES)}")
    if isinstance(linkage, FiveBarLinkage):
        if between is not None:
            raise ValueError("between is for linkages with one drive")
        drive_law = two_motors(linkage, drive, speed, turns, samples, branch, start)
    else:
        drive_law = law(linkage, drive, speed, turns, samples, branch, start, between)
    t, q, q_dot, q_ddot, lock = drive_law
    flat = getattr(linkage, "flats", ())
    motion = move(linkage, q, q_dot, q_ddot, smooth_branch(linkage, q, branch) if flat else branch)
    arguments = {
        "speed": speed,
        "turns": turns,
        "drive": drive,
        "branch": branch,
        "start": start,
        "between": between,
        "samples": samples,
        "load": load,
        "gravity": gravity,
        "quantities": quantities,
    }
    names = usual(motion, bool(load)) if quantities is None else quantities
    try:
        columns = {name: _column(motion, name, load, gravity) for name in names}
    except SingularityError as error:
        at = ", ".join(f"{x:.9g}" for x in np.atleast_1d(np.degrees(q[error.index])))
        raise SingularityError(
            f"{error}; the first at {t[error.index]:.9g} s, {at} deg", error.margin, error.index
        ) from None
    return Study(linkage, t, q, motion, columns, lock, arguments)


def _column(motion, name, load, gravity):
    values = evaluate(motion, name, load, gravity)
    return np.unwrap(values) if name.endswith(".angle") else np.array(values)


def _header(q, columns):
    drives = ["q (rad)"] if q.ndim == 1 else ["q1 (rad)", "q2 (rad)"]
    return ["t (s)", *drives, *(f"{name} ({unit(name)})" for name in columns)]


def _repeated(about):
    """Return the study that the first line of its file speaks of."""
    return study(_linkage(about.pop("linkage")), **about)


def _linkage(about):
    """Return the linkage of a table of its parameters, as read from JSON."""
    kind = KINDS[about.pop("kind")]
    for name, value in about.items():
        if name.endswith("_body"):
            about[name] = Body(
                **{k: tuple(v) if isinstance(v, list) else v for k, v in value.items()}
            )
        elif name == "robot":
            about[name] = FiveBar(**value)
        elif isinstance(value, list):
            about[name] = tuple(value)
    return kind(**about)
