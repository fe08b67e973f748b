"""Motion studies: a linkage over one or more turns as a table, a CSV file, a picture and an animation."""

from dataclasses import asdict, dataclass, field

import numpy as np

from ..errors import SingularityError
from ..models.robots import FiveBar
from .checks import check_branch
from .drives import law, smooth_branch, two_motors
from .five_bar import FiveBarLinkage
from .four_bar import FourBar
from .motion import Body, Motion
from .moving import move
from .quantities import evaluate, unit, usual
from .six_bar_press import SixBarPress
from .slider_crank import SliderCrank

KINDS = {kind.__name__: kind for kind in (FourBar, SliderCrank, SixBarPress, FiveBarLinkage)}
FIRST_LINE = "# fivebar linkage study, SI units: "
FULL = 2 * np.pi


@dataclass(frozen=True, eq=False)
class Study:
    """A linkage in motion on a grid of times, from `study`.

    t (n,) s; q (n,) or (n, 2) rad, continuous; columns: {quantity: (n,)}; motion: the Motion of all samples, in which
    any other quantity is read; lock: (crank angle, time) where the crank locks, or None.
    """

    linkage: object
    t: np.ndarray
    q: np.ndarray
    motion: Motion
    columns: dict
    lock: tuple | None
    _arguments: dict = field(repr=False)

    def __getitem__(self, name):
        """A quantity (n,) by its name, of the table or not; angles are continuous."""
        if name in self.columns:
            return self.columns[name]
        return _column(self.motion, name, self._arguments["load"], self._arguments["gravity"])

    def points(self):
        """Positions of all points, (n, k, 2) m, in the order of `motion.points`."""
        return np.stack([self.motion.position(name) for name in self.motion.points], axis=1)

    def plot(self, path=None, panels=None):
        """Matplotlib figure of the linkage and of quantities over time; written to `path` if given.

        panels: lists of quantity names, one list for each panel; None: ways or angles, rates, accelerations, torque.
        """
        from ..pictures.plot.linkages import study_figure

        figure = study_figure(self, panels)
        if path is not None:
            figure.savefig(path)
        return figure

    def animate(self, path, title=None, show=None):
        """The motion as a page in meshcat's viewer (.html; needs no server and no network) or as an animation (.gif).

        show: "trace", "velocity", "acceleration", "torques" of the traced point and the driven joint; None: its path.
        """
        from ..pictures.view import scene

        scene(self.linkage, self, show, title=title).save(path)

    def page(self, path, show=None, title=None):
        """One HTML file with the linkage beside plots of `show`, linked by the pose pointed at: `fb.page`."""
        from ..pictures.pages import page

        page(self, path, show, title)

    def to_csv(self, path):
        """Write the table, units in its header; what `from_csv` needs to repeat the study is in its first line."""
        import csv
        import json

        with open(path, "w", newline="", encoding="utf-8") as file:
            about = {"linkage": {"kind": type(self.linkage).__name__, **asdict(self.linkage)}, **self._arguments}
            file.write(f"{FIRST_LINE}{json.dumps(about)}\n")
            writer = csv.writer(file)
            writer.writerow(_header(self.q, self.columns))
            rows = np.column_stack([self.t, *self.q.reshape(len(self.t), -1).T, *self.columns.values()])
            writer.writerows(map(repr, row) for row in rows.tolist())

    @classmethod
    def from_csv(cls, path):
        """Read what `to_csv` wrote: the study is repeated, its columns are those of the file.

        ValueError with file and line for what is not such a file.
        """
        import json

        with open(path, encoding="utf-8") as file:
            first = file.readline()
        try:
            about = json.loads(first.removeprefix(FIRST_LINE))
            again = study(_linkage(about.pop("linkage")), **about)
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ValueError(f"{path}, line 1: not a file written by Study.to_csv") from None
        header = _header(again.q, again.columns)
        table = _read(path, header)
        if len(table) != len(again.t):
            raise ValueError(f"{path}: {len(table)} rows, where its first line makes {len(again.t)}")
        columns = dict(zip(again.columns, table[:, len(header) - len(again.columns) :].T))
        return cls(again.linkage, table[:, 0], again.q, again.motion, columns, again.lock, again._arguments)


def study(
    linkage, speed=FULL, turns=1.0, drive="turn", branch=None, start=None, between=None, samples=361, load=None,
    gravity=(0.0, 0.0), quantities=None,
):  # fmt: skip
    """A linkage over one or more turns: Study.

    speed: rad/s, a pair for two motors, < 0 turns clockwise; turns > 0; samples: per turn. drive: "turn" evenly, and
    smoothly through the flat poses of a change point, refused with UnreachableError where the crank locks;
    "until-lock"; or "swing" to and fro in its range, or in `between` (low, high) rad. branch, start (rad): None for the
    linkage's usual ones. load: {point: (Fx, Fy)} N, gravity: (gx, gy) m/s^2, for the torque. quantities: names for the
    table, None for the usual ones.
    """
    if not np.isfinite(speed).all() or not np.all(np.abs(speed) > 0):
        raise ValueError(f"speed must be finite and not 0, not {speed}")
    if not (np.isfinite(turns) and turns > 0):
        raise ValueError(f"turns must be finite and > 0, not {turns}")
    if samples < 3 or round(turns * (samples - 1)) < 1:
        raise ValueError(f"a study needs at least 3 samples a turn and 2 in all, not {samples} over {turns:g} turns")
    branch = check_branch(linkage, branch)
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
        "speed": np.asarray(speed, dtype=float).tolist(), "turns": turns, "drive": drive, "branch": branch,
        "start": None if start is None else np.asarray(start, dtype=float).tolist(), "between": between,
        "samples": samples, "load": load, "gravity": gravity, "quantities": quantities,
    }  # fmt: skip
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


def _read(path, header):
    """The rows under this header, (n, len(header)); unlike a trajectory's, they may hold inf (a straight path), nan."""
    import csv

    rows = []
    with open(path, newline="", encoding="utf-8") as file:
        for number, cells in enumerate(csv.reader(file), start=1):
            if number == 2 and cells != header:
                raise ValueError(f"{path}, line 2: the header is not that of the study in line 1")
            if number > 2:
                try:
                    rows.append([float(cell) for cell in cells])
                except ValueError as error:
                    raise ValueError(f"{path}, line {number}: {error}") from None
                if len(cells) != len(header):
                    raise ValueError(f"{path}, line {number}: {len(cells)} numbers, where the header has {len(header)}")
    return np.array(rows)


def _header(q, columns):
    drives = ["q (rad)"] if q.ndim == 1 else ["q1 (rad)", "q2 (rad)"]
    return ["t (s)", *drives, *(f"{name} ({unit(name)})" for name in columns)]


def _linkage(about):
    """The linkage of a table of its parameters, as read from JSON."""
    kind = KINDS[about.pop("kind")]
    for name, value in about.items():
        if name.endswith("_body"):
            about[name] = Body(**{k: tuple(v) if isinstance(v, list) else v for k, v in value.items()})
        elif name == "robot":
            about[name] = FiveBar(**value)
        elif isinstance(value, list):
            about[name] = tuple(value)
    return kind(**about)
