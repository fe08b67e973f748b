"""What a robot's masses and friction are, by logs of its motion and torques; and what these cannot
tell.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from ...base.checks import flag, modes, optional, positive, strings, takes
from ...base.checks import robot as must_be_robot
from ...models.geometry import dgm
from ...models.robots import Robot
from ..logs.logs import Gauges
from .bodies import consistent as nearest_bodies
from .dependent_columns import EXACT, NEARLY, any_motion, independent, words
from .filtering import Rows
from .noisy_columns import bias
from .regression import fit, left_out_cost, price, smallest, spread
from .regressor import ladder, linear_names
from .result import Identification, Validation
from .samples import log_of, samples
from .suspicions import POOR, beyond_the_model, explain

BIASED, LOWERED, LOWER, ENOUGH = (
    0.3,
    0.7,
    8,
    8,
)  # sd; of the cut-off, so often; rows of a motor for each unknown
SURE = 4.0  # standard deviations, below 0 by which no friction and no mass can be


@takes(
    robot=must_be_robot,
    unknown=optional(strings),
    assembly=modes(1),
    cutoff=optional(positive),
    consistent=flag,
)
def identify(
    robot: Robot,
    log: object,
    *,
    validate: object | None = None,
    unknown: Sequence[str] | None = None,
    assembly: int = -1,
    cutoff: float | None = None,
    consistent: bool = False,
    units: Mapping[str, str] | None = None,
    counts_per_turn: object = None,
    gear_ratio: object = 1.0,
    offset: object = (0.0, 0.0),
    torque_constant: object = None,
) -> Identification:
    """Inertial parameters and friction of a robot from logs of its motion and torques; gives an
    Identification.

    robot: of known lengths and gravity; its masses and friction count where they are not unknown.
    log: a Run, a CSV file, a mapping of arrays t, q1, q2, tau1, tau2, perhaps q1_dot, ...; or a
    list of these. Torques are those at their times, or held from row to row where that fits better,
    as a drive's commands are.
    validate: a second run, only predicted. unknown: names, None: all that the torque is linear in;
    the masses stay in the model, of the others the smallest set that the data do not reject
    (extended BIC, see `regression`); deviations count that what is left out need not be 0
    (`spread`): name what the robot has, and they are smaller.
    assembly: the mode of all logs, throughout: cut a log where it crosses Type 2. cutoff: Hz, of
    all filters; None: where the motion sinks into its noise (`derivatives`), or lower, until that
    noise bends no value by more than 0.3 sd (`noisy_columns`). consistent: hold to what bodies can
    have (`bodies`). units: {"q1": "deg"} of columns without one; counts_per_turn, gear_ratio,
    offset, torque_constant: as `Run.from_log`. ValueError for a log that says nothing or is not of
        this robot: what is wrong with it, as far as it can be told.
    """
    gauges = Gauges(counts_per_turn, gear_ratio, offset, torque_constant)
    logs = [
        log_of(each, robot, units, gauges)
        for each in (log if isinstance(log, (list, tuple)) else [log])
    ]
    if not logs:
        raise ValueError("identify needs at least one log")
    names = linear_names(robot)
    sought = sought_names(robot, unknown)
    known = np.array([0.0 if name in sought else getattr(robot, name) for name in names])
    columns = [k for k, name in enumerate(names) if name in sought]

    def prepared(at):
        return [samples(own, held, robot, assembly, at) for own, held in logs]

    def joined(found):
        rows = _joined([each.rows for each in found])
        return replace(rows, tau=rows.tau - rows.W @ known)

    found = prepared(cutoff)
    rows = joined(found)
    _must_say(rows, found, 2 * len(sought))
    base, folded = independent(
        any_motion(robot, assembly, _working(robot, found[0])), columns, EXACT
    )
    sentences = words(robot, folded, everywhere=True)
    told, more = independent(rows.W, base, NEARLY)
    full, notes, by_hold = fit(rows, told), [], False
    if full.misfit < POOR and not all(held for _, held in logs):
        as_held = [each.as_held() for each in found]
        others = joined(as_held)
        better, count = fit(others, told), rows.counts.sum(axis=0)
        if 2 * count @ np.log(full.sigma / better.sigma) > price(int(count.sum()), 1):
            logs, found, rows, full, by_hold = (
                [(own, True) for own, _ in logs],
                as_held,
                others,
                better,
                True,
            )
            notes = [
                "each torque is taken as held from its row to the next: so it fits the motion"
                " better"
            ]
    for _ in range(LOWER if cutoff is None and full.misfit < POOR else 0):
        if bias(found, told, full).max() < BIASED:
            break
        lower = prepared(LOWERED * min(each.cutoff for each in found))
        if (fewer := joined(lower)).counts.sum(axis=0).min() < ENOUGH * len(columns):
            break
        found, rows = lower, fewer
        told, more = independent(rows.W, base, NEARLY)
        full = fit(rows, told)
    sentences += words(robot, more, everywhere=False)
    own = ladder(robot)["masses"]
    if full.misfit > POOR or _impossible(robot, [names[k] for k in told], full):
        explain(robot, logs, assembly, cutoff, columns, known, full.misfit, _impossible)
    optional_ = [k for k, column in enumerate(told) if names[column] not in own]
    never = [k for k in optional_ if names[told[k]][0] == "f" and full.theta[k] < 0]
    while True:
        kept = smallest(
            full.theta, full.cov, optional_, price(int(rows.counts.sum()), len(optional_)), never
        )
        out = [k for k in optional_ if k not in kept]
        chosen = [column for k, column in enumerate(told) if k not in out]
        last = fit(rows, chosen)
        below = [c for c, value in zip(chosen, last.theta) if names[c][0] == "f" and value < 0]
        if not below:
            break
        never += [told.index(c) for c in below if told.index(c) in optional_]
    p_value = float(chi2.sf(left_out_cost(full.theta, full.cov, out), max(len(out), 1)))
    theta = last.theta
    labels = [names[k] for k in chosen]
    if consistent:
        theta = nearest_bodies(robot, labels, theta, last.cov)
    result = _robot(robot, sought, labels, theta)
    cov = spread(full, [told.index(column) for column in chosen], last) if out else last.cov
    sd = np.sqrt(np.diag(cov))
    values = dict(zip(labels, map(float, theta)))
    notes += [sentence for each in found for sentence in each.notes]
    notes += beyond_the_model(robot, result, found, known, labels, theta, last)
    identified = Identification(
        robot=result,
        given=robot,
        values=values,
        sd=dict(zip(labels, map(float, sd))),
        chosen=tuple(labels),
        rejected={names[told[k]]: _why(names[told[k]], full, k) for k in out},
        indistinguishable=tuple(sentences),
        notes=tuple(dict.fromkeys(notes)),
        noise=tuple(map(float, last.sigma)),
        misfit=last.misfit,
        p_value=p_value,
        cutoff=min(each.cutoff for each in found),
        correlation=cov / np.outer(sd, sd),
        t=rows.t,
        tau=_shown(rows, rows.tau + rows.W @ known),
        predicted=_shown(rows, rows.W @ known + rows.W[:, :, chosen] @ theta),
        bodies=consistent,
    )
    if validate is None:
        return identified
    second, held = log_of(validate, robot, units, gauges)
    return replace(
        identified, validation=_validated(identified, second, held or by_hold, assembly, cutoff)
    )


def sought_names(robot, unknown):
    names = linear_names(robot)
    if unknown is None:
        return names
    if wrong := [name for name in unknown if name not in names]:
        raise ValueError(
            f"unknown: no parameter {', '.join(map(repr, wrong))}; the torque is linear in"
            f" {', '.join(names)}"
        )
    if not unknown:
        raise ValueError(f"unknown is empty: name some of {', '.join(names)}")
    return tuple(name for name in names if name in unknown)


def _working(robot, first):
    """The working modes in which the first log spends most of its time."""
    q = np.concatenate([rates[0] for rates in first.motion])
    pose = dgm(robot, q[np.isfinite(q).all(axis=1)], first.assembly, unreachable="nan")
    return tuple(-1 if np.nanmedian(sine) > 0 else 1 for sine in pose.sines)


def _joined(parts: Iterable[Rows]) -> Rows:
    parts, breaks, n = list(parts), [], 0
    for each in parts:
        breaks += [n + k for k in each.breaks]
        n += len(each.t)
    share = np.mean([each.share for each in parts], axis=0)
    whole = (
        np.concatenate([getattr(each, name) for each in parts])
        for name in ("W", "tau", "counts", "t", "cover")
    )
    return Rows(*whole, tuple(breaks), (float(share[0]), float(share[1])), parts[0].gain)


def _must_say(rows, found, least):
    count = rows.counts.sum(axis=0)
    if count.min() < least:
        why = " ".join(s for each in found for s in each.notes)
        raise ValueError(
            f"only {count[0]} and {count[1]} independent rows of the two motors are left, and at"
            f" least {least} of each are needed: log longer, or faster"
            f" motions{'. ' + why if why else ''}"
        )


def _impossible(robot, labels, found):
    """Names of masses and friction that come out surely below 0."""
    sd = np.sqrt(np.diag(found.cov))
    heavy = any(name in robot.turning_names for name in labels)
    own = () if heavy and len(labels) > 5 else ladder(robot)["masses"]
    own = own or ladder(robot)["masses"][:2]
    return [
        name
        for name, value, each in zip(labels, found.theta, sd)
        if (name in own or name[0] == "f") and value < -SURE * each
    ]


def _why(name, full, k):
    value, sd = full.theta[k], np.sqrt(full.cov[k, k])
    if name[0] == "f" and value < 0:
        return f"friction would be {value:.3g} ± {sd:.2g}, less than none"
    least = f"below about {3.5 * sd:.2g} this log would not show it"
    return f"{value:.3g} ± {sd:.2g} beside all others, not told from 0: {least}"


def _robot(robot, sought, labels, theta):
    values = dict.fromkeys(sought, 0.0) | dict(zip(labels, map(float, theta)))
    try:
        return replace(robot, **values)
    except ValueError as error:
        raise ValueError(
            f"the log asks for parameters that no robot has ({error}): its torques, modes or"
            " lengths are not this robot's; or consistent=True holds to what bodies can have"
        ) from None


def _shown(rows, values):
    """A row's torque as the mean of its samples, nan where none counts."""
    return np.where(rows.counts, values / np.sqrt(np.where(rows.counts, rows.cover, 1.0)), np.nan)


def _validated(found: Identification, log, held, assembly, cutoff) -> Validation:
    rows = samples(
        log, held, found.given, assembly, found.cutoff if cutoff is None else cutoff
    ).rows
    theta = np.array([getattr(found.robot, name) for name in linear_names(found.given)])
    predicted = rows.W @ theta
    missed = np.where(rows.counts, rows.tau - predicted, 0.0)
    count = np.maximum(rows.counts.sum(axis=0), 1)
    size = np.maximum((np.where(rows.counts, rows.tau, 0.0) ** 2).sum(axis=0), 1e-300)
    misfit = float(np.sqrt(np.mean((missed**2).sum(axis=0) / size)))
    ratio = np.sqrt((missed**2).sum(axis=0) / count) / np.array(found.noise)
    return Validation(
        misfit,
        (float(ratio[0]), float(ratio[1])),
        rows.t,
        _shown(rows, rows.tau),
        _shown(rows, predicted),
    )
