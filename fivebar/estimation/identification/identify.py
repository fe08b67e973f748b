"""`identify`: masses and friction of a robot from logs, and what these logs cannot tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit
from scipy.stats import chi2

from ...base.checks import modes, optional, positive, strings
from ...base.progress import progress
from ...base.robot_uses import takes_robot
from ...models.geometry import dgm
from ...models.robots import Robot
from ..logs.logs import AT_THE_JOINTS, Gauges
from .dependent_columns import EXACT, NEARLY, any_motion, independent, sentences
from .filtering import RegressionRows
from .misfit import SURE, beyond_the_model, lateness
from .regression import fit, left_out_cost, price, smallest, spread
from .regressor import ladder, linear_names
from .result import Identification, Validation
from .samples import log_of, samples, with_held_torques

POOR = 0.05  # of the torque's rms: whether torques are held shows where a model misses less
BIASED = 0.1  # standard deviations by which noise of the encoders may bend a value
HEAVIEST = 100.0  # kg, of a robot on a desk; of an inertia over a bar squared
POWERS = {"zz": 2, "mx": 1, "my": 1}  # of a bar
DOUBTFUL = (
    2.0  # kg, beyond which torques of a file that names no unit may be in N cm, kg cm or mN m
)
SIGNIFICANT = 3.0  # log of odds: from there on, torques are taken as held


@takes_robot(unknown=optional(strings), assembly=modes(1), cutoff=optional(positive))
def identify(
    robot: Robot,
    log: object,
    *,
    validate: object | None = None,
    unknown: Sequence[str] | None = None,
    assembly: int = -1,
    cutoff: float | None = None,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
    counts_per_turn: object = None,
    gear_ratio: object = 1.0,
    offset: object = (0.0, 0.0),
    torque_constant: object = None,
) -> Identification:
    """Identify inertial parameters and friction of a robot from logs of its motion and torques.

    Least squares of tau = W(q, q', q'') theta, both sides filtered alike. Of all parameters but the
    masses, the smallest set is kept that the data do not reject (extended BIC, see `regression`).

    Parameters
    ----------
    robot : FiveBar or Biglide
        Of known lengths and gravity; its masses and friction count where they are not unknown.
    log : Run, CSV or NPZ file, mapping of arrays, or a list of these
        Columns t, q1, q2, tau1, tau2, perhaps q1_dot, ... Torques of a simulated run are held from
        row to row. Others are those at their times, or held too if this fits the motion better.
        Not all rows need torques; these may also be in rows of their own, near to those of q.
    validate : as log, optional
        A second run, whose torques are only predicted.
    unknown : sequence of str, optional
        Parameters to identify; all in which the torque is linear by default. Deviations count that
        what is left out need not be 0: name what the robot has, and they are smaller.
    assembly : int
        The assembly mode of all logs, throughout: cut a log where it crosses Type 2.
    cutoff : float, optional
        Of all filters, Hz. By default, where the motion sinks into its noise, or lower, until that
        noise bends no value by more than 0.1 standard deviations, or too few rows are left. What it
        bends is taken off and counts in the deviations, also at a cut-off that is given.
    units : mapping, optional
        {"q1": "deg"} of columns without one.
    columns : mapping, optional
        {"q1": "position[0]", "tau1": "M1 (mNm)"} of columns with other headings.
    counts_per_turn, gear_ratio, offset, torque_constant
        As of `from_log`.

    Returns
    -------
    Identification
        Printed, it is a report.

    Raises
    ------
    ValueError
        The log tells nothing or is not of this robot; the message says what is wrong with it.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot, circle = fb.FiveBar(), fb.circle((0.06, 0.09), 0.02, 0.5)
    >>> run = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), circle, step=2e-3)
    >>> found = fb.identify(robot, run, unknown=["zz1", "zz2", "m"])
    >>> round(found.values["m"], 2)
    0.5
    """
    gauges = Gauges(counts_per_turn, gear_ratio, offset, torque_constant, units, columns)
    sources = log if isinstance(log, (list, tuple)) else [log]
    logs = [log_of(source, robot, gauges) for source in sources]
    if not logs:
        raise ValueError("identify needs at least one log")
    names = linear_names(robot)
    sought = sought_names(robot, unknown)
    known = np.array([0.0 if name in sought else getattr(robot, name) for name in names])
    places = [k for k, name in enumerate(names) if name in sought]

    bar = progress(desc="identify", unit=" fits", delay=2, leave=False)

    def sampled(at, logs):
        found = [samples(own, held, robot, assembly, at) for own, held in logs]
        rows = _joined(found, known)
        bar.update()
        return found, rows

    found, rows = sampled(cutoff, logs)
    _refuse_few(rows, found, 2 * len(sought))
    any_W = any_motion(robot, assembly, _working(robot, found[0]))
    base, unseen = independent(any_W, places, EXACT)

    def fitted(rows):
        told, unseen = independent(rows.W, base, NEARLY)
        return told, unseen, fit(rows, told)

    told, also_unseen, full = fitted(rows)
    while full.bias.max() > BIASED:
        fewer, lower = sampled(0.7 * min(each.cutoff for each in found), logs)
        if lower.counts.sum(axis=0).min() < 8 * len(places):
            break
        found = fewer
        rows = lower
        told, also_unseen, full = fitted(rows)
    notes = []
    alternatives = ()
    holds_better = False
    lowest = min(each.cutoff for each in found)
    if full.misfit < POOR and not all(held for _, held in logs):
        # A drive that holds its commands logs torques of whole samples, not of instants: half a
        # sample early. Which it is shows where the encoders' noise bends nothing.
        held_found = [each if each.held else with_held_torques(each) for each in found]
        held_rows = _joined(held_found, known)
        longest = _longest(found)
        half = longest.step / 2
        late, sd, *_ = lateness(longest, told, full.theta, known)
        evidence = (late**2 - (late + half) ** 2) / (2 * sd**2)
        surely_held = evidence > SIGNIFICANT
        alternatives = (rows, held_rows, expit(-evidence if surely_held else evidence))
        if surely_held:
            logs = [(own, True) for own, _ in logs]
            found = held_found
            rows = held_rows
            full = fit(rows, told)
            holds_better = True
            notes = ["each torque is taken as held to the next row, which fits the motion better"]
    if cutoff is not None and cutoff > lowest:
        found, rows = sampled(cutoff, logs)
        told, also_unseen, full = fitted(rows)
    if full.bias.max() > BIASED:
        most = int(np.argmax(full.bias))
        advice = "log longer"
        if cutoff is not None and cutoff > lowest:
            advice = f"a cutoff of {lowest:.3g} Hz bends less"
        notes.append(
            f"noise of the encoders bent {names[told[most]]} by {full.bias[most]:.2g} standard"
            f" deviations: it was taken off and counts in the deviations; {advice}"
        )
    longest = _longest(found)
    whole = known.copy()
    whole[told] = full.theta
    # A model that lacks what is left out below would take a part of the delay.
    delay = lateness(longest, told, full.theta, known)
    beyond = beyond_the_model(robot, longest, whole, full, delay)
    chosen, last = _smallest_model(robot, rows, told, full)
    out = [k for k, column in enumerate(told) if column not in chosen]
    labels = [names[k] for k in chosen]
    theta = last.theta
    _refuse_impossible(robot, labels, last, all(own.is_stated for own, _ in logs), gauges)
    values = dict(zip(labels, theta.tolist()))
    cov = spread(full, [told.index(column) for column in chosen], last) if out else last.cov
    if alternatives:  # what is between torques held and not counts as far as neither is sure
        at_times, held_rows, doubt = alternatives
        apart = fit(held_rows, chosen).theta - fit(at_times, chosen).theta
        cov = cov + doubt * np.outer(apart, apart)
    sd = np.sqrt(np.diag(cov))
    sd_of = dict(zip(labels, sd.tolist()))
    notes += [sentence for each in found for sentence in each.notes] + beyond
    by_known = rows.W @ known
    identified = Identification(
        robot=_robot(robot, sought, values, sd_of),
        given=robot,
        values=values,
        sd=sd_of,
        chosen=tuple(labels),
        rejected={names[told[k]]: _why_left_out(names[told[k]], full, k) for k in out},
        indistinguishable=(
            *sentences(robot, unseen, everywhere=True),
            *sentences(robot, also_unseen, everywhere=False),
        ),
        notes=tuple(dict.fromkeys(notes)),
        noise=tuple(last.sigma.tolist()),
        misfit=last.misfit,
        p_value=float(chi2.sf(left_out_cost(full.theta, full.cov, out), max(len(out), 1))),
        cutoff=min(each.cutoff for each in found),
        correlation=cov / np.outer(sd, sd),
        t=rows.t,
        tau=_shown(rows, rows.tau + by_known),
        predicted=_shown(rows, by_known + rows.W[:, :, chosen] @ theta),
    )
    if validate is None:
        return identified
    second, held = log_of(validate, robot, gauges)
    at = identified.cutoff if cutoff is None else cutoff
    rows = samples(second, held or holds_better, robot, assembly, at).rows
    return replace(identified, validation=_validation(identified, rows))


def sought_names(robot: Robot, unknown: Sequence[str] | None) -> tuple[str, ...]:
    """Return the unknown parameters in the order of the ladder; ValueError for impossible ones."""
    names = linear_names(robot)
    if unknown is None:
        return names
    wrong = [name for name in unknown if name not in names]
    if wrong or not unknown:
        raise ValueError(
            f"unknown: no parameter {', '.join(map(repr, wrong))}; the torque is linear in"
            f" {', '.join(names)}"
        )
    return tuple(name for name in names if name in unknown)


def _working(robot, first):
    """Return the working modes in which the first log spends most of its time."""
    q = np.concatenate([motion[0] for motion in first.motion])
    pose = dgm(robot, q[np.isfinite(q).all(axis=1)], first.assembly, unreachable="nan")
    return tuple(-1 if np.nanmedian(sine) > 0 else 1 for sine in pose.sines)


def _joined(found, known):
    """Return the rows of all logs, without the torques of the known parameters."""
    parts = [each.rows for each in found]
    starts = np.cumsum([0, *(len(part.t) for part in parts)])
    breaks = [int(start) + k for start, part in zip(starts, parts) for k in part.breaks]
    arrays = "W", "tau", "counts", "t", "cover", "change"
    joined = {}
    for name in arrays:
        joined[name] = np.concatenate([getattr(part, name) for part in parts])
    joined["tau"] = joined["tau"] - joined["W"] @ known
    return RegressionRows(**joined, breaks=tuple(breaks), gain=parts[0].gain)


def _longest(found):
    return max(found, key=lambda each: len(each.pieces[0][0]))


def _refuse_few(rows, found, least):
    left, right = rows.counts.sum(axis=0)
    if min(left, right) < least:
        notes = ". ".join(sentence for each in found for sentence in each.notes)
        raise ValueError(
            f"only {left} and {right} independent rows of the two motors are left, and at least"
            f" {least} of each are needed: log longer, or faster motions. {notes}"
        )


def _refuse_impossible(robot, names, last, is_stated, gauges):
    """Refuse masses that no robot on a desk has; without units, those that others make usual."""
    bar = max(robot.distal)
    for name, value, variance in zip(names, last.theta, np.diag(last.cov)):
        if name in ladder(robot)["masses"] and value < -SURE * np.sqrt(variance):
            raise ValueError(
                f"{name} = {value:.3g} ± {np.sqrt(variance):.2g} comes out, and no robot has less"
                " than 0. Has q or tau of a motor the wrong sign, are the motors exchanged? Are the"
                " lengths, the assembly mode and the offset of q those of this robot?"
            )
        mass = value / bar ** POWERS.get(name[:2], 0)
        if name[0] in "mz" and mass > (HEAVIEST if is_stated else DOUBTFUL):
            given = ""
            for option in ("counts_per_turn", "gear_ratio", "torque_constant"):
                number = getattr(gauges, option)
                if np.any(np.array(number) != getattr(AT_THE_JOINTS, option)):
                    given += f" Is {option} = {number} that of this log?"
            raise ValueError(
                f"{name} = {value:.3g} comes out, as of a robot of {mass:.3g} kg.{given} Is t in"
                " ms, or are torques in mN m, N cm or kg cm? Say which, N m too:"
                ' units={"t": "ms", "tau1": "mNm", "tau2": "mNm"}, on the command line --units mNm'
            )


def _smallest_model(robot, rows, told, full):
    """Return the columns of the smallest model that the data do not reject, and its fit.

    The masses stay; friction below 0 never does.
    """
    names = linear_names(robot)
    masses = ladder(robot)["masses"]
    optional_ = [k for k, column in enumerate(told) if names[column] not in masses]
    friction = [k for k in optional_ if names[told[k]][0] == "f"]
    never = [k for k in friction if full.theta[k] < 0]
    each = price(int(rows.counts.sum()), len(optional_))
    while True:
        kept = smallest(full.theta, full.cov, optional_, each, never)
        places = [k for k in range(len(told)) if k in kept or k not in optional_]
        chosen = [told[k] for k in places]
        last = fit(rows, chosen)
        below = [k for k, value in zip(places, last.theta) if k in friction and value < 0]
        if not below:
            return chosen, last
        never += below


def _why_left_out(name, full, k):
    value = full.theta[k]
    sd = np.sqrt(full.cov[k, k])
    if name[0] == "f" and value < 0:
        return f"friction would be {value:.3g} ± {sd:.2g}, less than none"
    least = f"below about {3.5 * sd:.2g} this log would not show it"
    return f"{value:.3g} ± {sd:.2g} beside all others, not told from 0: {least}"


def _robot(robot, sought, values, sd):
    try:
        return replace(robot, **(dict.fromkeys(sought, 0.0) | values))
    except ValueError as error:
        unsure = [
            f"{name} = {value:.3g} ± {sd[name]:.2g}"
            for name, value in values.items()
            if name in ladder(robot)["masses"] and -SURE * sd[name] < value < 0
        ]
        if unsure:
            raise ValueError(
                f"this log does not tell {', '.join(unsure)} from what no robot has, less than 0:"
                " log longer or faster motions, or name only what the robot has as unknown"
            ) from None
        raise ValueError(
            f"the log asks for parameters that no robot has ({error}): its torques, modes or"
            " lengths are not this robot's"
        ) from None


def _shown(rows, values):
    """Return a row's torque as the mean of its samples, nan where none counts."""
    cover = np.where(rows.counts, rows.cover, 1.0)
    return np.where(rows.counts, values / np.sqrt(cover), np.nan)


def _validation(found, rows):
    theta = np.array([getattr(found.robot, name) for name in linear_names(found.given)])
    predicted = rows.W @ theta
    missed = (np.where(rows.counts, rows.tau - predicted, 0.0) ** 2).sum(axis=0)
    power = np.maximum((np.where(rows.counts, rows.tau, 0.0) ** 2).sum(axis=0), 1e-300)
    rms = np.sqrt(missed / np.maximum(rows.counts.sum(axis=0), 1))
    return Validation(
        misfit=float(np.sqrt(np.mean(missed / power))),
        ratio=tuple((rms / np.array(found.noise)).tolist()),
        t=rows.t,
        tau=_shown(rows, rows.tau),
        predicted=_shown(rows, predicted),
    )
