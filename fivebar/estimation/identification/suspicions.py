"""What may be wrong with a log that the model misses: signs, motors and joints exchanged, units,
modes, time, gravity.

Each suspicion is tried: the one under which the model fits is named. Where it fits well, effects
    that it does not have
are tried beside it: a torque that comes late, a sensor's zero, another gravity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from ...models.dynamics import dynamic_model, gravity_torques
from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import Robot
from .dependent_columns import NEARLY, independent
from .filtering import filtered
from .regression import fit
from .regressor import linear_names
from .samples import rough, samples

CLEARER, SURE = 0.4, 6.0  # of the misfit as it is; standard deviations
G = 9.81  # m/s^2
JOINTS = "q", "q_dot", "q_ddot"  # fields of a log
HOPELESS = 0.3  # of the torque
NOISY, POORER = 3.0, 0.01  # times the noise; of the torque
POOR = (
    0.05  # of the torque: where a model misses more, what may be wrong with the log is looked for
)
RELEVANT = 2e-3  # of the torque's rms, less than which no effect is worth a word


def explain(
    robot: Robot,
    logs: list,
    assembly: int,
    cutoff: float | None,
    columns: list[int],
    known: np.ndarray,
    misfit: float,
    impossible: Callable,
) -> None:
    """Raise the ValueError that names what is wrong with the log, if one suspicion stands out.

    columns, known: which parameters are unknown, and the values of the others. impossible(robot,
    names, fit): names of what comes out as it cannot be.
    """
    log, held = max(logs, key=lambda each: len(each[0].t))
    bound = (
        CLEARER * misfit if misfit > POOR else 1.6 * misfit
    )  # else it fits, but with masses or friction below 0
    best, why = bound, None
    for words, mode, own_robot, names, change in _suspicions(robot, assembly):
        changed = {name: change(pair) for name in names if (pair := getattr(log, name)) is not None}
        try:
            rows = samples(replace(log, **changed), held, own_robot, mode, cutoff).rows
        except ValueError:
            continue
        told, _ = independent(rows.W, columns, NEARLY)
        labels = [linear_names(robot)[k] for k in told]
        for signs in product((1, -1), repeat=2):
            named = words + _signs(signs)
            if not named:
                continue
            own = fit(
                rows, told, np.where(rows.counts, rows.tau * np.array(signs) - rows.W @ known, 0.0)
            )
            score = own.misfit * (1 + 0.5 * len(named))
            if score < best and not impossible(robot, labels, own):
                best, why = score, (" and ".join(named), own.misfit)
    if why is not None:
        raise ValueError(
            f"the model misses {100 * misfit:.3g} % of this log's {robot.words.effort}s"
            f"{'' if misfit > POOR else ', but with masses or friction below 0'}; "
            f"it misses {100 * why[1]:.3g} % if {why[0]}"
        )


def _suspicions(robot, assembly):
    """([words], assembly mode, robot, fields of the log, their change) of what may be wrong but the
    torques' signs.
    """
    joints, efforts = " and ".join(robot.words.joints), f"{robot.words.effort}s"
    yield [], assembly, robot, (), None
    yield [f"the {efforts} of the two motors are exchanged"], assembly, robot, ("tau",), _swapped
    yield [f"the assembly mode is {-assembly:+d}"], -assembly, robot, (), None
    yield [f"{joints} are exchanged"], assembly, robot, JOINTS, _swapped
    yield (
        [f"{joints} and both {efforts} are exchanged"],
        assembly,
        robot,
        (*JOINTS, "tau"),
        _swapped,
    )
    if robot.turns:
        yield ["q is in degrees"], assembly, robot, JOINTS, np.radians
        yield [f"{joints} turn the other way"], assembly, robot, JOINTS, np.negative
    for gravity in ((0.0, -G), (0.0, G), (G, 0.0), (-G, 0.0), (0.0, 0.0)):
        if gravity != robot.gravity:
            own = replace(robot, gravity=gravity)
            yield [f"gravity is ({gravity[0]:g}, {gravity[1]:g}) m/s²"], assembly, own, (), None


def _swapped(pair):
    return pair[:, ::-1]


def _signs(signs):
    wrong = [f"tau{k + 1}" for k, each in enumerate(signs) if each < 0]
    return [f"the sign of {' and '.join(wrong)} is the other one"] if wrong else []


def beyond_the_model(
    robot: Robot,
    result: Robot,
    found: list,
    known: np.ndarray,
    labels: list,
    theta: np.ndarray,
    last,
) -> list[str]:
    """Sentences on effects beside the model that the log shows."""
    if last.misfit > HOPELESS:
        missed = f"the model misses {100 * last.misfit:.3g} % of the {robot.words.effort}s"
        return [f"{missed}, and nothing that was tried explains it"]
    chosen, notes, whole = [linear_names(robot).index(name) for name in labels], [], known.copy()
    whole[chosen] = theta
    sample = max(found, key=lambda each: len(each.pieces[0][0]))
    extra = [
        _effects(result, sample, piece, rates, whole)
        for piece, rates in zip(sample.pieces, sample.motion)
    ]
    pieces = [
        (t, np.concatenate([W[:, :, chosen], more], axis=2), tau - W @ known, counts)
        for (t, W, tau, counts), more in zip(sample.pieces, extra)
    ]
    rows = filtered(pieces, sample.step, sample.cutoff)
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
            notes.append(word(robot, value, sd))
    above = last.sigma / np.maximum(_noise(result, sample, rows.gain), 1e-300)
    if last.misfit > POORER and above.max() > NOISY:
        times = " and ".join(f"{each:.3g}" for each in above)
        notes.append(
            f"what the model misses is {times} times the noise of this log: it does not have all of"
            " this robot (lengths, zeros of q, backlash, a bend)"
        )
    return notes


def _noise(robot, sample, gain):
    """N m, of a row of each motor: what its torque's and the encoders' noise make."""
    q = np.concatenate(
        [rates[0][counts.any(axis=1)] for rates, (*_, counts) in zip(sample.motion, sample.pieces)]
    )
    pose = dgm(robot, q[:: max(len(q) // 100, 1)], sample.assembly)
    M, _ = dynamic_model(dkm(pose, (0.0, 0.0)))
    inertia = np.sqrt(np.mean(M**2, axis=0)) @ (
        np.array(sample.noise) * rough(sample.step, sample.cutoff)
    )
    return np.hypot(np.array(sample.tau_noise) * gain, inertia)


def _late(robot, value, sd):
    late = "late" if value < 0 else "early"
    size = f"{1e3 * abs(value):.3g} ± {1e3 * sd:.1g} ms"
    return f"the {robot.words.effort}s come {size} too {late} for the motion: shift their times"


def _zero(side):
    def words(robot, value, sd):
        unit = robot.words.effort_unit
        return (
            f"tau{side} is off by {value:.3g} ± {sd:.1g} {unit} throughout, as by its sensor's"
            " zero: take that away"
        )

    return words


def _gravity(axis):
    def words(robot, value, sd):
        has = robot.gravity["xy".index(axis)]
        return (
            f"gravity along {axis} looks like {has + value:.3g} ± {sd:.1g} m/s², and the robot has"
            f" {has:g}"
        )

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
        gravity_torques(replace(pose, robot=replace(robot, gravity=g)))
        for g in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
    ]
    columns[used, :, 3], columns[used, :, 4] = held[1] - held[0], held[2] - held[0]
    return columns
