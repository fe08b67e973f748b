"""What `plan` is asked, checked: stops, weights of the objective, limits."""

import math

import numpy as np

from ..errors import SingularityError, UnreachableError
from ..models.geometry import igm
from ..models.kinematics import ikm
from .plans import PlanError, listed

OBJECTIVES = ("effort", "time", "jerk")


def refuse_stops(problem):
    """Raise where a stop is out of reach or breaks a limit by itself."""
    names = ["start", *(f"via[{i}]" for i in range(len(problem.stops) - 2)), "goal"]
    for name, (conditions, _) in zip(names, problem.stops):
        try:
            pose = igm(problem.robot, conditions[0], problem.working)
        except (UnreachableError, SingularityError) as error:
            error.args = (f"plan: {name}: {error}",)
            raise
        found = problem.violations(pose.xi, sines=problem.signed_sines(pose))
        if found["serial"] <= 0:
            q_dot = ikm(pose, conditions.get(1, (0.0, 0.0))).q_dot
            found |= problem.violations(q_dot=q_dot, xi_ddot=np.array(conditions.get(2, (0.0, 0.0))))
        found = {key: max(float(value), 0.0) for key, value in found.items()}
        if any(value > 1e-9 * problem.unit(key) for key, value in found.items()):
            raise PlanError(f"plan: infeasible: {name} itself breaks limits{listed(problem, found)}", found)


def checked_stops(start, goal, duration, via):
    """((conditions, time or None), ...), checked."""
    try:
        via = [(t, point) for t, point in via]
    except (TypeError, ValueError):
        raise ValueError(f"plan: via must be [(time or None, (x, y)), ...], not {via!r}") from None
    times = [0.0, *(t for t, _ in via), duration]
    given = [start, *(point for _, point in via), goal]
    last, stops = -1.0, []
    for i, (t, point) in enumerate(zip(times, given)):
        name = "start" if i == 0 else "goal" if i == len(given) - 1 else f"via[{i - 1}]"
        if t is not None:
            words = "duration" if name == "goal" else f"the time of {name}"
            t = 0.0 if name == "start" else number(t, words, max(last, 0.0), math.inf)
            last = t
        if not isinstance(point, dict):
            point = {0: point} if name.startswith("via") else {0: point, 1: (0.0, 0.0)}
        if 0 not in point or not set(point) <= {0, 1, 2}:
            raise ValueError(f"plan: {name} needs a position under order 0, and no other orders than 1 and 2")
        conditions = {}
        for order, value in point.items():
            array = floats(value)
            if array.shape != (2,) or not np.isfinite(array).all():
                raise ValueError(f"plan: {name}, order {order}, must be two finite numbers (x, y), not {value!r}")
            conditions[order] = tuple(array.tolist())
        stops.append((conditions, t))
    if duration is None and all(conditions[0] == stops[0][0][0] for conditions, _ in stops):
        raise ValueError("plan: start and goal are the same point: a free duration would be 0")
    return tuple(stops)


def checked_weights(objective):
    weights = {objective: 1.0} if isinstance(objective, str) else objective
    if not isinstance(weights, dict) or not weights or not set(weights) <= set(OBJECTIVES):
        raise ValueError(f"plan: objective must be of {', '.join(OBJECTIVES)}, not {objective!r}")
    weights = {
        name: number(weights.get(name, 0.0), f"the weight of {name}", 0.0, math.inf, True) for name in OBJECTIVES
    }
    if not any(weights.values()):
        raise ValueError("plan: one weight of the objective must be > 0")
    return weights


def floats(value):
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return np.array(np.nan)  # fails every check of shape


def number(value, name, low, high, closed=False):
    ok = np.ndim(value) == 0 and isinstance(value, (int, float, np.number)) and math.isfinite(value)
    if not (ok and (value > low or (closed and value == low)) and value < high):
        above = f"finite and {'>=' if closed else '>'} {low:g}" + (f" and < {high:g}" if math.isfinite(high) else "")
        raise ValueError(f"plan: {name} must be {above}, not {value!r}")
    return float(value)


def limit_of(value, name, sizes):
    if value is None:
        return None
    values = [number(v, name, 0.0, math.inf) for v in np.ravel(value).tolist()]
    if len(values) not in sizes:
        raise ValueError(f"plan: {name} must be one number{' or one per joint' if 2 in sizes else ''}, not {value!r}")
    return tuple(values * (3 - len(values))) if 2 in sizes else values[0]


def box(workspace):
    if workspace is None:
        return None
    box = floats(workspace)
    if box.shape != (2, 2) or not np.isfinite(box).all() or (box[:, 0] >= box[:, 1]).any():
        raise ValueError(f"plan: workspace must be ((x low, x high), (y low, y high)), finite, not {workspace!r}")
    return tuple(map(tuple, box.tolist()))
