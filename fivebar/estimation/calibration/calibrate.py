"""`calibrate`: lengths, joint readings and measuring frame of a five-bar from measured points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy import ndarray

from ...base.backend import wrap
from ...base.checks import (
    LONGEST,
    SHORTEST,
    instance,
    number,
    one_of,
    optional,
    positive,
    shown,
    strings,
)
from ...base.robot_uses import takes_robot
from ...base.tables import FilePath
from ...models.robots import FiveBar
from ...paths.tool import Tool
from .backlash import told
from .few_rows import CHANGED
from .fit import (
    CLEAR,
    LOSSES,
    ROUNDS,
    LeastSquares,
    assembly_modes,
    possible_sides,
    residuals,
    robust_scatter,
    solve,
    solve_by_loops,
    weighted_by_loops,
)
from .measured_robot import LENGTHS, PLACE, RATIOS, UNKNOWNS, length_ok, place, sizes, values_of
from .report import LESS
from .result import Calibration
from .rows import rows_of
from .starts import begin, rows_far_off

TURNED = "offset1", "offset2", "turn"
FAR = 0.05  # of a bar: who measures misses by less
CHECKED = 4  # rows with a point: in fewer no mistake shows
UNUSUAL = 25.0  # times a bar: points do not move by so much more or less for each rad of the joints
LEAST_TURN = 1e-3  # rad, of the joints, to tell by
QUESTIONS = (
    "Are q1, q2 in degrees or rad, x, y or distance in mm or m (units=, --units)? Are q1, q2 in"
    " counts (ratio1 and ratio2 in start, --start: rad of one count)? Are two columns exchanged, or"
    " has one the wrong sign? Is all unknown that is not known (offsets, the frame x0, y0, turn)?"
    " Is a pen beside the joint, on which leg (tool=, --tool-leg)?"
    " mistakes='keep' (--mistakes keep) takes the data as they are"
)
DEFAULT = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2")


@takes_robot(
    unknown=strings,
    tool=optional(instance(Tool)),
    sigma=optional(positive),
    loss=one_of(*LOSSES),
    mistakes=one_of("raise", "keep"),
)
def calibrate(
    robot: FiveBar,
    data: Mapping | FilePath,
    unknown: Sequence[str] = DEFAULT,
    *,
    tool: Tool | None = None,
    start: Mapping[str, float] = MappingProxyType({}),
    sigma: float | None = None,
    priors: Mapping[str, float] = MappingProxyType({}),
    loss: str = "linear",
    mistakes: str = "raise",
    units: Mapping[str, str] | Sequence[str] = (),
    columns: Mapping[str, str] | Sequence[str] = (),
) -> Calibration:
    """Calibrate a five-bar: find its unknowns by least squares, and how well they are known.

        true angle = ratio q + offset        measured point = (x0, y0) + scale R(turn) xi
        xi = C + along u_i2 + across v_i2        distance = |xi - xi_to|

    Gauss-Newton, with derivatives in closed form from A d xi = B dq + ... (AMORO eq. 13).

    Parameters
    ----------
    robot : FiveBar
        Nominal: where the search begins.
    data : mapping of arrays (n,), CSV or NPZ file
        q1, q2 (rad, or counts with ratio1 and ratio2) and what was measured: x, y (m; a row may
        lack one of them), or `distance` (m, by a ruler) to the point of the row whose number,
        counted from 1, is in `to`. Modes are found from the points; working1, working2 or
        assembly, where they are noted, are checked, and needed where nothing else tells. `sigma`
        may be a column, too. Headings of a file may name a unit: x (mm), q1_deg.
    unknown : sequence of str
        Of l11, l12, l21, l22, d, offset1, offset2, ratio1, ratio2, x0, y0, turn, scale, and along,
        across of a tool.
    tool : Tool, optional
        What draws, beside joint C: whose place along and across its bar is known, or to begin with.
    start : mapping
        Values by name, known or to begin with; else offsets are 0, ratios and scale 1.
    sigma : float, optional
        Standard deviation of a measured number, m; with it chi^2 says whether the model fits.
    priors : mapping
        {name: standard deviation} of unknowns about their start, as a workshop's or a drawing's
        tolerance gives them, m or rad; with sigma. An unknown without one may be anything.
    loss : str
        Of scipy.optimize.least_squares: "linear", "huber" or "cauchy".
    mistakes : str
        "raise" refuses data that fit no such robot: misses of a twentieth of a bar, lengths
        far off, other modes than noted. "keep" takes them as they are.
    units : mapping or sequence of str
        Of columns whose heading has none: {"q1": "deg"} or ("deg", "mm").
    columns : mapping or sequence of str
        Headings of columns that are called otherwise: {"x": "probe (mm)"} or ("x=probe (mm)",).

    Returns
    -------
    Calibration
        Printed, it is a report.

    Raises
    ------
    ValueError
        What is wrong with the data or the options.

    Examples
    --------
    >>> import fivebar as fb
    >>> built = fb.FiveBar(l11=0.091)
    >>> where = fb.measurement_poses(fb.FiveBar(), 6)
    >>> pose = fb.igm(built, where.xi, where.working)
    >>> data = {"q1": pose.q[:, 0], "q2": pose.q[:, 1], "x": pose.xi[:, 0], "y": pose.xi[:, 1]}
    >>> round(fb.calibrate(fb.FiveBar(), data).values["l11"], 9)
    0.091
    """
    unknown = known_names(unknown)
    p0 = start_values(robot, start, tool, unknown)
    rows = rows_of(data, units, columns)
    free = np.array([PLACE[name] for name in unknown])
    absolute = sigma is not None or bool(np.isfinite(rows.sigma).any())
    weight = _weight(rows, sigma)
    size = sizes(robot, rows.q, unknown)
    task = LeastSquares(
        rows,
        free,
        start=p0,
        size=size,
        weight=weight,
        loss=loss,
        prior=_prior(priors, unknown, size, absolute),
        sigma=float(np.median(1 / weight)) if absolute else 0.0,
        turned=tuple(name for name in TURNED if name in unknown and name not in start),
    )
    if mistakes != "keep":
        _refuse_units(task)
    p = begin(task)
    # What the rows do not tell stays near the start, which of such angles is where they were found.
    found_angles = [PLACE[name] for name in task.turned if name not in priors]
    near = task.start.copy()
    near[found_angles] = p[found_angles]
    task = replace(task, start=near)
    assembly, uncertain = assembly_modes(p, task.rows)
    _refuse_unknown_modes(task.rows, p, assembly == 0)
    scatter = 1.0 if absolute else robust_scatter(task, p, assembly)
    looped = weighted_by_loops(task, p, scatter)
    p, assembly, uncertain = _reaching(looped, p, assembly, uncertain)
    task, p = solve_by_loops(task, p, assembly, scatter, absolute)
    notes = list(task.rows.notes)
    if p[PLACE["d"]] < 0 and task.names[1:]:
        task = _on_one_axis(task)
        p[PLACE["d"]] = 0.0
        p, assembly, uncertain = _reaching(task, p, assembly, uncertain)
        task, p = solve_by_loops(task, p, assembly, scatter, absolute)
        notes.append("d fits best below 0, and is taken as 0: motors on one axis")
    _refuse_impossible_lengths(p)
    if mistakes != "keep":
        _refuse_far_misses(task, p, p0, assembly)
        _refuse_unchecked_lengths(task, p)
    at = place(p, task.rows.q, assembly)
    sines = np.nan_to_num(np.column_stack([at.sines, at.det]))
    other = (task.rows.modes * sines > CLEAR).any(axis=1)
    if other.any() and mistakes != "keep":
        raise ValueError(
            f"{task.rows.named(other)}: the fitted robot is in other modes there than noted:"
            " give values to begin with (start), or put the modes right"
        )
    turns = [k for k in task.free if UNKNOWNS[k] in TURNED]
    p[turns] = p0[turns] + wrap(p[turns] - p0[turns])  # whole turns mean nothing
    if len(task.rows) < CHECKED:
        notes.append(
            f"so few rows do not show a wrong unit, sign or mode: {CHECKED} rows or more do"
        )
    if names := task.rows.named(uncertain):
        notes.append(f"assembly mode uncertain, the nearer one was taken: {names}")
    found = Calibration(
        nominal=robot,
        unknown=task.names,
        rows=task.rows,
        assembly=assembly,
        start=p0,
        p=p,
        weight=weight,
        absolute=absolute,
        loss=loss,
        prior=np.zeros(len(task.free)) if task.prior is None else task.prior,
        notes=tuple(notes),
    )
    return replace(found, notes=(*found.notes, *told(found)))


def known_names(unknown: Sequence[str], name: str = "unknown") -> tuple[str, ...]:
    """Return the names, each of them once one of UNKNOWNS; ValueError for others."""
    names = tuple(unknown)
    if not names:
        raise ValueError(f"{name} is empty: name some of {', '.join(UNKNOWNS)}")
    for each in names:
        if each not in UNKNOWNS:
            known = ", ".join(UNKNOWNS)
            raise ValueError(f"{name}: no {shown(each)}; the known ones are {known}")
        if names.count(each) > 1:
            raise ValueError(f"{name} names {each} twice")
    return names


def start_values(
    robot: FiveBar,
    start: Mapping[str, float],
    tool: Tool | None = None,
    unknown: Sequence[str] = (),
) -> ndarray:
    """Return all values (16,) of a robot and its tool with `start` over them."""
    if not isinstance(start, Mapping):
        raise TypeError(f"start must be a mapping {{name: value}}, not {shown(start)}")
    if start:
        known_names(tuple(start), "start")
    more = {}
    if tool is not None:
        more = {"along": tool.along, "across": tool.across, "tool_leg": tool.leg}
    elif {"along", "across"} & {*unknown, *start}:
        raise ValueError(
            "along, across: which distal bar carries the tool? tool=fb.Tool(1) is on the left one,"
            " fb.Tool(2) on the right one; on the command line --tool-leg"
        )
    for name, value in start.items():
        more[name] = number(value, f"start[{name!r}]", -LONGEST, LONGEST)
    p = values_of(robot, more)
    if not length_ok(p):
        raise ValueError(
            f"start: bars and scale must be from {SHORTEST:g} to {LONGEST:g}, and d from 0 on"
        )
    return p


def _weight(rows, sigma):
    """Return 1 / sigma of each measured number: the row's own, else the common one."""
    own = rows.sigma[rows.row_of]
    known = np.isfinite(own)
    if sigma is None and known.any() and not known.all():
        row = rows.where[rows.row_of[np.argmin(known)]]
        raise ValueError(f"{row}: no sigma, where other rows have one")
    return 1 / np.where(known, own, sigma or 1.0)


def _prior(priors, unknown, size, absolute):
    """Return the sizes of the unknowns over their standard deviations; None without priors."""
    if not isinstance(priors, Mapping):
        raise TypeError(f"priors must be a mapping {{name: sd}}, not {shown(priors)}")
    if not priors:
        return None
    if not absolute:
        raise ValueError("priors need sigma (--sigma), the standard deviation of a measured number")
    result = np.zeros(len(unknown))
    for name, sd in priors.items():
        if name not in unknown:
            raise ValueError(f"priors: {shown(name)} is none of unknown: {', '.join(unknown)}")
        k = unknown.index(name)
        result[k] = size[k] / positive(sd, f"priors[{name!r}]")
    return result


def _refuse_units(task):
    """Refuse points that move far less or more than bars do that turn as the readings say."""
    rows = task.rows
    if rows.whole.sum() < CHECKED or {"ratio1", "ratio2", "scale"} & set(task.names):
        return
    turned = np.linalg.norm(np.std(rows.q[rows.whole] * task.start[RATIOS], axis=0))
    moved = np.linalg.norm(np.std(rows.points[rows.whole], axis=0))
    size = task.bar * task.start[PLACE["scale"]]
    if turned > LEAST_TURN and not 1 / UNUSUAL < moved / (turned * size) < UNUSUAL:
        raise ValueError(
            f"x, y move by {1e3 * moved / turned:.3g} mm for each rad of q1, q2, and bars of"
            f" {1e3 * size:.3g} mm cannot. {QUESTIONS}"
        )


def _refuse_unknown_modes(rows, p, lost):
    """Refuse rows (n,) bool whose assembly mode nothing tells, and say why."""
    none = lost & ~possible_sides(p, rows).any(axis=0)
    if none.any():
        raise ValueError(
            f"{rows.named(none)}: at these angles the robot does not close in the modes noted. Are"
            " q1, q2 in degrees or rad (units=, --units), swapped, or of the wrong sign? Are the"
            " modes right, and the offsets to begin with (start, on the command line --start)?"
        )
    if lost.any():
        missing = (
            "no mode is noted, and no measured point tells it: add columns assembly, or working1"
            " and working2"
        )
        if rows.working[lost].all():
            missing = "both assembly modes have the working modes noted: add a column assembly"
        raise ValueError(f"{rows.named(lost)}: {missing}")


def _on_one_axis(task):
    """Return the task with d known to be 0."""
    kept = task.free != PLACE["d"]
    start = task.start.copy()
    start[PLACE["d"]] = 0.0
    prior = None if task.prior is None else task.prior[kept]
    return replace(task, free=task.free[kept], size=task.size[kept], start=start, prior=prior)


def _refuse_impossible_lengths(p):
    """Refuse a fit in which a bar has no length, or one below 0."""
    if not length_ok(p):
        lengths = ", ".join(f"{name} = {1e3 * p[PLACE[name]]:.3g} mm" for name in LENGTHS)
        raise ValueError(
            f"no robot has the lengths that fit best, scale {p[PLACE['scale']]:.3g} and {lengths}."
            " Measure more rows, or say what is known: priors (--prior l11=0.5mm), or fewer"
            f" unknowns. {QUESTIONS}"
        )


def _refuse_far_misses(task, p, start, assembly):
    """Refuse a fit that is none: its misses are of another size than errors of measurement.

    start: the values that the search began with.
    """
    off, _ = residuals(p, task.rows, assembly, derive=False)
    missed = np.sqrt(np.mean(off**2)) if task.loss == "linear" else np.median(np.abs(off))
    size = task.bar * p[PLACE["scale"]]
    if task.sigma > FAR * size:
        raise ValueError(
            f"sigma is {1e3 * task.sigma:.3g} mm, {task.sigma / size:.0%} of a bar, and to that"
            " any robot fits. Is it in mm (--sigma 0.02mm), or are x, y in m, not in mm?"
            " mistakes='keep' (--mistakes keep) takes this fit as it is"
        )
    if missed > max(FAR * size, 4 * task.sigma):
        bad, far = rows_far_off(task, start)
        if far < FAR * size:
            raise ValueError(
                f"{task.rows.named(bad)}: off all other rows, by more than {1e3 * far:.3g} mm. Are"
                f" they mistyped? Put them right or {LESS}. mistakes='keep' (--mistakes keep) takes"
                " all rows as they are"
            )
        raise ValueError(
            f"no robot with these unknowns fits: the best one misses by {1e3 * missed:.3g} mm,"
            f" {missed / size:.0%} of a bar. {QUESTIONS}"
        )


def _refuse_unchecked_lengths(task, p):
    """Refuse a length that no five-bar is built with, where no measured number checks the fit."""
    if task.left_over > 0:
        return
    for name in LENGTHS:
        now = 1e3 * p[PLACE[name]]
        before = 1e3 * task.start[PLACE[name]]
        if abs(now - before) > CHANGED * 1e3 * task.bar:
            raise ValueError(
                f"{len(task.rows.numbers)} measured numbers for {len(task.free)} unknowns leave"
                f" none over to check the fit with, and {name} would be {now:.4g} mm in place of"
                f" {before:.4g} mm: measure more rows, or give values to begin with (start, on the"
                " command line --start). mistakes='keep' (--mistakes keep) takes this fit as it is"
            )


def _reaching(task, p, assembly, uncertain):
    """Return values from which every row is reached, the assembly modes, and where these are
    uncertain.

    By fits of the rows that are reached, in certain modes: where only a coordinate tells the mode,
    it may be certain only after a fit of the others.
    """
    row_of = task.rows.row_of
    settled = False
    for left in range(ROUNDS, -1, -1):
        reached = np.isfinite(residuals(p, task.rows, assembly, derive=False)[0])
        if reached.all() and (settled or not left):
            return p, assembly, uncertain
        weight = task.weight * (reached & ~uncertain[row_of])
        p = solve(replace(task, weight=weight), p, assembly)
        now, uncertain = assembly_modes(p, task.rows)
        settled = (now * assembly >= 0).all()
        assembly = np.where(now, now, assembly)
    out = np.isin(np.arange(len(task.rows)), row_of[~reached])
    frame = ""
    if len(task.rows.measured[0]) and not {"x0", "y0", "turn"} & set(task.names):
        frame = (
            " Or is the measuring frame another than the robot's: are x0, y0, turn unknown, too?"
        )
    raise ValueError(
        f"{task.rows.named(out)}: with these angles the robot that fits the other rows does"
        f" not close: a wrong reading, or q1, q2 in degrees or rad (units=, --units)?{frame}"
    )
