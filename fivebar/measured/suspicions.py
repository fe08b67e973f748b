"""What may be wrong with a log that the model misses: signs, motors and joints exchanged, units, modes, time, gravity.

Each suspicion is tried: the one under which the model fits is named. Where it fits well, effects that it does not have
are tried beside it: a torque that comes late, a sensor's zero, another gravity.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from ..models.dynamics import gravity_torques
from ..models.geometry import dgm
from ..models.robots import Robot
from .regression import fit
from .regressor import linear_names
from .rows import filtered
from .samples import samples
from .told import NEARLY, independent

CLEARER, GOOD, SURE = 0.4, 0.3, 6.0  # of the misfit as it is; of the torque; standard deviations
RELEVANT = 2e-3  # of the torque's rms, less than which no effect is worth a word


def explain(robot: Robot, logs: list, assembly: int, cutoff, misfit: float, impossible) -> None:
    """Raise the ValueError that names what is wrong with the log, if one suspicion stands out."""
    best, why = CLEARER * misfit if misfit > GOOD else np.inf, None
    for motion, change, mode in _motions(robot, assembly):
        try:
            found = [samples(replace(log, **change(log)), held, robot, mode, cutoff) for log, held in logs]
        except ValueError:
            continue
        rows = [each.rows for each in found]
        first = max(rows, key=lambda each: len(each.t))
        told, _ = independent(first.W, list(range(first.W.shape[2])), NEARLY)
        labels = [linear_names(robot)[k] for k in told]
        for exchanged, signs in product((False, True), product((1, -1), repeat=2)):
            torque = _torques(robot, exchanged, signs)
            if not (motion or torque):
                continue
            tau = (first.tau[:, ::-1] if exchanged else first.tau) * np.array(signs)
            own = fit(first, told, np.where(first.counts, tau, 0.0))
            score = own.misfit * (1 + 0.05 * (len(motion) > 0) + 0.05 * len(torque))
            if own.misfit < min(GOOD, 0.9 * max(misfit, 1e-9)) and score < best and not impossible(robot, labels, own):
                best, why = score, (" and ".join([*motion, *torque]), own.misfit)
            if own.misfit <= 1.001 * misfit and misfit < GOOD and not impossible(robot, labels, own) and why is None:
                why = " and ".join([*motion, *torque]), own.misfit
    if why is not None:
        raise ValueError(
            f"the model misses {100 * misfit:.3g} % of this log's {robot.words.effort}s"
            f"{'' if misfit > GOOD else ', but with masses or friction below 0'}; it misses {100 * why[1]:.3g} % if {why[0]}"
        )


def _motions(robot, assembly):
    """([words], log -> changed fields, assembly mode) of what may be wrong with the positions."""
    left, right = robot.words.joints
    yield [], lambda log: {}, assembly
    yield [f"the assembly mode is {-assembly:+d}"], lambda log: {}, -assembly
    yield [f"the columns of {left} and {right} are exchanged"], _exchanged, assembly
    if robot.turns:
        yield ["q is in degrees"], lambda log: _scaled(log, np.pi / 180), assembly
        yield [f"{left} and {right} turn the other way"], lambda log: _scaled(log, -1.0), assembly


def _exchanged(log):
    return {
        name: None if getattr(log, name) is None else getattr(log, name)[:, ::-1] for name in ("q", "q_dot", "q_ddot")
    }


def _scaled(log, factor):
    return {
        name: None if getattr(log, name) is None else factor * getattr(log, name) for name in ("q", "q_dot", "q_ddot")
    }


def _torques(robot, exchanged, signs):
    words = [f"the {robot.words.effort}s of the two motors are exchanged"] if exchanged else []
    wrong = [f"tau{k + 1}" for k, each in enumerate(signs) if each < 0]
    return words + ([f"the sign of {' and '.join(wrong)} is the other one"] if wrong else [])


def beyond_the_model(
    robot: Robot, result: Robot, found: list, known: np.ndarray, labels: list, theta: np.ndarray, last
) -> list[str]:
    """Sentences on effects beside the model that the log shows."""
    names = linear_names(robot)
    whole = known.copy()
    for name, value in zip(labels, theta):
        whole[names.index(name)] = value
    chosen, said = [names.index(name) for name in labels], []
    sample = max(found, key=lambda each: len(each.pieces[0][0]))
    extra = [_effects(result, sample, piece, rates, whole) for piece, rates in zip(sample.pieces, sample.motion)]
    rows = filtered(
        [(t, np.concatenate([W[:, :, chosen], more], axis=2), tau - W @ known, counts) for (t, W, tau, counts), more in zip(sample.pieces, extra)],
        sample.step, sample.cutoff,
    )  # fmt: skip
    size = np.sqrt((rows.tau**2).sum() / max(rows.counts.sum(), 1))
    count, own = len(chosen), list(range(len(chosen)))
    for k, word in enumerate(_WORDS):
        column = rows.W[:, :, count + k]
        if not np.any(column):
            continue
        told, _ = independent(rows.W, [*own, count + k], 1e-3)
        if told != [*own, count + k]:
            continue
        each = fit(rows, told)
        value, sd = each.theta[-1], np.sqrt(each.cov[-1, -1])
        brings = abs(value) * np.sqrt((column**2).sum() / max(rows.counts.sum(), 1))
        if abs(value) > SURE * sd and brings > RELEVANT * size:
            said.append(word(robot, value, sd))
    return said


def _late(robot, value, sd):
    late = "late" if value < 0 else "early"
    return f"the {robot.words.effort}s come {1e3 * abs(value):.3g} ± {1e3 * sd:.1g} ms too {late} for the motion: shift their times"


def _zero(side):
    def words(robot, value, sd):
        unit = robot.words.effort_unit
        return f"tau{side} is off by {value:.3g} ± {sd:.1g} {unit} throughout, as by its sensor's zero: take that away"

    return words


def _gravity(axis):
    def words(robot, value, sd):
        has = robot.gravity["xy".index(axis)]
        return f"gravity along {axis} looks like {has + value:.3g} ± {sd:.1g} m/s^2, and the robot has {has:g}"

    return words


_WORDS = _late, _zero(1), _zero(2), _gravity("x"), _gravity("y")


def _effects(robot, sample, piece, rates, theta):
    """Columns (n, 2, 5): the torque's rate, a constant for each motor, gravity along x and y."""
    t, W, tau, counts = piece
    columns = np.zeros((*tau.shape, 5))
    predicted = W @ theta
    columns[..., 0] = np.gradient(predicted, sample.step, axis=0) if len(t) > 2 else 0.0
    columns[:, 0, 1] = columns[:, 1, 2] = 1.0
    used = counts.any(axis=1)
    pose = dgm(robot, rates[0][used], sample.assembly)
    held = [
        gravity_torques(replace(pose, robot=replace(robot, gravity=g))) for g in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    ]
    columns[used, :, 3], columns[used, :, 4] = held[1] - held[0], held[2] - held[0]
    return columns
