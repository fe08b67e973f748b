"""A motion through samples from a CSV file: a spline, chords with their corners blended, or what
the file's own velocities and accelerations say.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ..base.checks import not_negative, one_of, optional, positive, takes
from ..base.columns import Columns, read, refuse_unclear_times
from ..base.headings import TIME, Quantity, units_named
from ..base.tables import TextFile, named
from ..base.units import ACCELERATIONS, METRES, SPEEDS
from .trajectory import Trajectory

PLACES = {
    "t": TIME,
    "x": Quantity(("x", "posx", "positionx", "xpos", "xposition"), METRES),
    "y": Quantity(("y", "posy", "positiony", "ypos", "yposition"), METRES),
}
SLOPES = {
    "x_dot": Quantity((), SPEEDS, needed=False),
    "y_dot": Quantity((), SPEEDS, needed=False),
    "x_ddot": Quantity((), ACCELERATIONS, needed=False),
    "y_ddot": Quantity((), ACCELERATIONS, needed=False),
}
WIDE = 5.0  # m: coordinates without a unit that reach so far may be in mm
SLOW = 1.0  # s: samples without a unit that are so far apart may be so many ms
WITHIN = np.linspace(0, 1, 14)[:-1]  # of each interval, where a curve is compared with its chord
TRIES = 14  # of a smoothing whose spline is within a deviation
# Of the change of velocity, times half of the time that it takes: how far a corner is cut.
CORNER = 3 / 16


@takes(
    smoothing=not_negative,
    kind=one_of("spline", "polyline"),
    deviation=optional(positive),
    units=units_named,
    columns=units_named,
)
def from_csv(
    path: TextFile,
    smoothing: float = 0.0,
    *,
    kind: str = "spline",
    deviation: float | None = None,
    units: Mapping[str, str] | Sequence[str] = (),
    columns: Mapping[str, str] | Sequence[str] = (),
) -> Trajectory:
    """Read a motion from a CSV file with columns t, s, and x, y, m.

    Parameters
    ----------
    path : str, Path or open text file
        Times are not negative and increase. A spline needs 6 rows. Columns may have units in their
        names: `t (s)`, `x [mm]`.
    smoothing : float
        Root-mean-square distance, m, that a spline may keep from the samples.
    kind : "spline" or "polyline"
        A spline of degree 5, or straight from sample to sample at constant speed, with corners cut
        as the acceleration needs it. Where the file has x_dot, y_dot, x_ddot and y_ddot in known
        units, as those that fivebar writes, a spline has these velocities and accelerations at its
        samples, unless it is smoothed.
    deviation : float, optional
        Largest distance, m, instead: of a spline from the samples, of a polyline from its corners.
    units : mapping or sequence
        Units of columns that do not name theirs: {"t": "ms"} or ["mm"].
    columns : mapping or sequence
        Headings of columns that are called otherwise: {"x": "East (mm)"} or ["x=East (mm)"].

    Returns
    -------
    Trajectory
        Its notes say how far it leaves the chords between samples, how large its accelerations are,
        and what was converted or not used.

    Raises
    ------
    ValueError
        The file and line of what is wrong, or columns whose unit is not clear.

    Examples
    --------
    >>> import io
    >>> import fivebar as fb
    >>> file = io.StringIO("t_s,x_m,y_m\\n0,0.09,0.07\\n1,0.05,0.09\\n")
    >>> fb.from_csv(file, kind="polyline", deviation=1e-3).duration
    1.0
    """
    if smoothing and (deviation or kind == "polyline"):
        raise ValueError(
            "from_csv: smoothing is of a spline, and without deviation: leave one of them"
        )
    if kind == "polyline" and not deviation:
        raise ValueError(
            "from_csv: kind=polyline needs a deviation, m, within which its corners are cut"
        )
    table = read(path, PLACES | SLOPES, units, "path", columns)
    exact = kind == "spline" and not (smoothing or deviation) and set(SLOPES) <= table.stated.keys()
    t, points = _samples(table, 2 if exact or kind == "polyline" else 6, kind)
    with named(table.name), np.errstate(all="ignore"):
        # `_compared` refuses what overflows.
        if kind == "polyline":
            motion = _polyline(t, points, deviation)
        elif exact:
            motion = hermite(
                t, points, *np.split(np.array([*map(table.values.get, SLOPES)]).T, 2, 1)
            )
        elif deviation:
            motion = _within(t, points, deviation)
        else:
            motion = _spline(t, points, smoothing)
        notes = _compared(motion, t, points, table.lines)
    span = float(t[0]), float(t[-1] - t[0])
    return Trajectory(*span, motion, (*notes, *table.notes), origin=table.origin)


def refuse_unclear_lengths(table: Columns) -> None:
    """Raise ValueError if the unit of x and y is not clear."""
    stated = table.stated.keys() & {"x", "y"}
    if len(stated) == 2:
        return
    if stated:
        other = "".join({"x", "y"} - stated)
        raise ValueError(
            f"{table.name}: {''.join(stated)} has a unit in its heading, but {other} has none:"
            " name it"
        )
    far = max(float(np.nanmax(np.abs(table.values[name]), initial=0.0)) for name in "xy")
    if far > WIDE:
        raise ValueError(
            f"{table.name}: x and y reach {far:g} and have no unit, they could be in metres or in"
            " millimetres: head them x_m, y_m or x_mm, y_mm, or give units: m or mm"
        )


def _samples(table, least, what):
    """Return times (n,) s and points (n, 2) m; ValueError where they are not in order."""
    t, x, y = (table.values[name] for name in PLACES)
    for name, values in table.values.items():
        missing = np.flatnonzero(np.isnan(values))
        if len(missing):
            raise table.error(missing[0], f"{name} is missing")
    early = np.flatnonzero(t < 0)
    if len(early):
        raise table.error(early[0], f"time must not be negative, but is {t[early[0]]:g}")
    late = np.flatnonzero(np.diff(t) <= 0) + 1
    if len(late):
        raise table.error(
            late[0], f"time must increase, but {t[late[0]]:g} follows {t[late[0] - 1]:g}"
        )
    if len(t) < least:
        raise ValueError(f"{table.name}: a {what} needs at least {least} rows, not {len(t)}")
    refuse_unclear_lengths(table)
    refuse_unclear_times(table, SLOW)
    return t, np.stack([x, y], axis=-1)


def _spline(t, points, smoothing):
    from scipy.interpolate import make_splrep  # `fivebar --help` reaches this file

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            splines = [
                make_splrep(t, values, k=5, s=len(t) * smoothing**2 / 2) for values in points.T
            ]
    except RuntimeWarning:
        raise ValueError(
            f"from_csv: no spline of degree 5 keeps smoothing = {smoothing:g} m; 0 goes through all"
            " samples"
        ) from None
    except ValueError as error:  # SciPy's, of times that are too close to one another
        raise ValueError(
            f"from_csv: no spline of degree 5 is found, {_steps(t)}: {error}"
        ) from None
    columns = [spline.derivative(order) for order in range(3) for spline in splines]
    return partial(_on_splines, columns)


def hermite(
    t: np.ndarray, xi: np.ndarray, xi_dot: np.ndarray, xi_ddot: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return the motion times (n,) -> (n, 6) that has these values (m, 2) at times t (m,): between
    them polynomials of degree 5, after the last one at rest there.
    """
    h = np.diff(t)[:, None]
    turn = xi_ddot[:-1] / 2
    place = xi[1:] - (xi[:-1] + h * (xi_dot[:-1] + h * turn))
    rate = h * (xi_dot[1:] - (xi_dot[:-1] + h * xi_ddot[:-1]))
    bend = h**2 * (xi_ddot[1:] - xi_ddot[:-1]) / 2
    third = (10 * place - 4 * rate + bend) / h**3
    fourth = (-15 * place + 7 * rate - 2 * bend) / h**4
    fifth = (6 * place - 3 * rate + bend) / h**5
    table = np.zeros((6, *xi.shape))
    table[:3] = xi, xi_dot, xi_ddot / 2
    table[3:, :-1] = third, fourth, fifth
    return partial(_on_quintics, t, table)


def _on_quintics(t, table, times):
    k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 1)
    since = np.asarray(times - t[k])[..., None]
    columns = []
    coefficients = [*table[:, k]]
    for _ in range(3):
        value = coefficients[-1]
        for coefficient in coefficients[-2::-1]:
            value = value * since + coefficient
        columns.append(value)
        coefficients = [order * each for order, each in enumerate(coefficients)][1:]
    return np.concatenate(columns, axis=-1)


def _on_splines(columns, times):
    return np.stack([spline(times) for spline in columns], axis=-1)


def _within(t, points, deviation):
    """Return the smoothest spline within the deviation of all samples."""
    # The root-mean-square distance is at most the largest one.
    low = 0.0
    high = deviation
    best = None
    smoothing = deviation
    for _ in range(TRIES):
        try:
            motion = _spline(t, points, smoothing)
            distances = np.linalg.norm(motion(t)[:, :2] - points, axis=1)
            near = distances.max() <= deviation
        except ValueError:
            near = False  # SciPy finds no knots
        if near:
            low = smoothing
            best = motion
            if smoothing == deviation:
                break
        else:
            high = smoothing
        smoothing = (low + high) / 2
    return best or _spline(t, points, 0.0)


def _polyline(t, points, deviation):
    """Return the motion along chords; corners have an acceleration that is a parabola of time."""
    slopes = np.diff(points, axis=0) / np.diff(t)[:, None]
    change = np.diff(slopes, axis=0)  # at all samples but the first and last
    steps = np.diff(t)
    clearance = np.minimum(steps[1:], steps[:-1]) / 2
    speed = np.linalg.norm(change, axis=1)
    half = np.minimum(clearance, deviation / (CORNER * np.where(speed > 0, speed, 1e-300)))

    return partial(_along_chords, t, points, slopes, change, half)


def _along_chords(t, points, slopes, change, half, times):
    """Return the motion of `_polyline`; half: of the times that the corners take."""
    k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    since = (times - t[k])[..., None]
    place = points[k] + slopes[k] * since
    values = np.concatenate([place, slopes[k], np.zeros((*np.shape(times), 2))], axis=-1)
    for corner in (k, k + 1):  # those at the interval's start and end
        inner = (corner > 0) & (corner < len(t) - 1)
        j = np.clip(corner - 1, 0, max(len(change) - 1, 0))
        if not inner.any():
            continue
        w = (times - t[corner]) / half[j]
        near = inner & (np.abs(w) < 1)
        w = np.where(near, w, 0.0)
        # The chord after the corner has this part already.
        if corner is k:
            after = np.maximum(w, 0.0)
        else:
            after = np.zeros_like(w)
        # The parabola 3/4 (1 - w^2), integrated once and twice.
        parabola = 3 / 4 * (1 - w**2)
        rate = 3 / 4 * (w - w**3 / 3 + 2 / 3)
        if corner is k:
            rate = rate - 1.0
        even = w**2 / 2 - w**4 / 12
        place = even + 2 * w / 3 + 1 / 4
        place = 3 / 4 * place - after
        place = half[j] * place
        bend = parabola / half[j]
        for columns, factor in ((slice(0, 2), place), (slice(2, 4), rate), (slice(4, 6), bend)):
            weights = np.where(near, factor, 0.0)[..., None]
            values[..., columns] += weights * change[j]
    return values


def _steps(t):
    steps = np.diff(t)
    return f"whose times are from {steps.min():.3g} to {steps.max():.3g} s apart"


def _compared(motion, t, points, lines):
    """Return notes: the distance from the chords, and the largest acceleration."""
    step = np.diff(t)[:, None]
    chord = np.diff(points, axis=0)
    values = motion((t[:-1, None] + step * WITHIN).ravel()).reshape(len(step), len(WITHIN), 6)
    away = values[..., :2] - points[:-1, None]
    square = np.maximum((chord**2).sum(axis=1), 1e-300)[:, None]
    along = np.clip((away * chord[:, None]).sum(axis=2) / square, 0, 1)
    off = np.linalg.norm(away - along[..., None] * chord[:, None], axis=2).max(axis=1)
    k = int(off.argmax())
    reached = np.linalg.norm(values[..., 4:], axis=2).max()
    if not np.isfinite(values).all() or not np.isfinite(reached):
        raise ValueError(
            f"from_csv: no motion has these samples, {_steps(t)}: its acceleration is beyond all"
            " bounds"
        )
    rounding = 1e-13 * np.abs(points).max()
    away = 1e3 * off[k] * (off[k] > rounding)
    notes = [
        f"it leaves the chords between samples by up to {away:.3g} mm (lines {lines[k]} to"
        f" {lines[k + 1]})"
    ]
    if len(t) > 2:
        own = 2 * np.diff(chord / step, axis=0) / (step[1:] + step[:-1])
        own = np.linalg.norm(own, axis=1).max()
        # What rounding alone can make is shown as 0.
        noise = rounding / step.min() ** 2
        reached = reached if reached > noise else 0.0
        own = own if own > noise else 0.0
        notes.append(
            f"its acceleration reaches {reached:.3g} m/s², second differences of the samples"
            f" {own:.3g} m/s²"
        )
    return notes
