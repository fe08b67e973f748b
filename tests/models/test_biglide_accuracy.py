"""Every model of the biglide against 50 digits: |error| <= 16 eps kappa |f|, as test_accuracy.py has it.

2000 poses of 10 robots, half of them within 1e-6 to 1e-2 of Type 1 or Type 2, each reached from its q and its xi.
"""

from functools import lru_cache

import mpmath
import numpy as np
import pytest

import fivebar as fb
from tests.helpers import biglide_oracle
from tests.helpers.biglide_oracle import LENGTHS, MODES, models
from tests.helpers.oracle import EPS, GIVEN, OTHER, circle, cross, dot, exact, keys, norm
from tests.models.test_accuracy import label, package

pytestmark = pytest.mark.deep  # half a minute of 50 digits
ROBOTS, POSES, SEED, BOUND = 10, 200, 5, 16
STARTS = ("q", "xi")


@lru_cache
def poses():
    return biglide_oracle.draw_all(ROBOTS, POSES, SEED)


@lru_cache
def expected(start):
    _, p = poses()
    with mpmath.workdps(50):
        return models({name: exact(x) for name, x in p.items()}, start), biglide_oracle.condition(
            p, start
        )


def given(start, chosen):
    _, p = poses()
    return p[MODES[start]][..., chosen].T, {name: p[name][:, chosen].T for name in (start, *GIVEN)}


@lru_cache
def batches(start):
    """The package on all poses, a batch per robot: outputs (components, poses) by key; xi and feet; the Poses."""
    outs, points, found = [], [], []
    for k, robot in enumerate(poses()[0]):
        pose, out = package(
            robot, start, *given(start, slice(k * POSES, (k + 1) * POSES)), fb.Biglide
        )
        outs.append({key: np.reshape(x, (POSES, -1)).T for key, x in out.items()})
        points.append(np.concatenate([pose.xi, np.reshape(pose.elbows, (POSES, 4))], axis=1).T)
        found.append(pose)
    return {key: np.hstack([out[key] for out in outs]) for key in outs[0]}, np.hstack(points), found


def ratios(key, got, chosen=slice(None)):  # noqa: B008
    """The measured error / (eps kappa |f|) of outputs (components, poses)."""
    value, kappa = expected(key[1])
    with mpmath.workdps(50):
        got = exact(np.asarray(got, dtype=float))
        error = norm(
            (circle(got).reshape(4, -1) if key[0] == "q_passive" else got) - value[key][:, chosen]
        )
    return np.where(np.isfinite(error), error, np.inf) / (EPS * kappa[key][chosen])


def check(name, ratio, bound=BOUND, chosen=slice(None)):  # noqa: B008
    worst = np.argmax(ratio)
    pose = {name: x[..., chosen][..., worst].tolist() for name, x in poses()[1].items()}
    text = f"{name}: {ratio[worst]:.3g} > {bound} times eps kappa |f|, {np.sum(ratio > bound)} of {ratio.size} poses"
    assert ratio[worst] <= bound, f"{text}; worst: {pose}"


@pytest.mark.parametrize("key", keys("q") + keys("xi"), ids=label)
def test_error(key):
    check(label(key), ratios(key, batches(key[1])[0][key]))


@pytest.mark.parametrize("start", STARTS)
def test_closure_and_modes(start):
    """Bars between the feet and the end-effector have their lengths; feet are on their guides; modes are kept."""
    _, p = poses()
    with mpmath.workdps(50):
        bars = [exact(p[name]) for name in ("l1", "l2")]
        xi, *feet = exact(batches(start)[1]).reshape(3, 2, -1)
        residuals = [abs(dot(xi - foot, xi - foot) ** 0.5 - bar) for foot, bar in zip(feet, bars)]
        residuals += [abs(foot[0] - side * exact(p["d"]) / 2) for foot, side in zip(feet, (-1, 1))]
        size = sum(p[name] for name in LENGTHS) + np.abs(p["q"]).max(axis=0)
        check(
            "closure",
            np.concatenate(residuals).astype(float).reshape(4, -1).max(axis=0) / (EPS * size),
            4,
        )
    found = batches(start)[2]
    assert (np.concatenate([pose.assembly for pose in found]) == p["assembly"]).all()
    assert (np.concatenate([pose.working for pose in found]) == p["working"].T).all()
    assert min(pose.reach_margin.min() for pose in found) >= 0


@pytest.mark.parametrize("start", STARTS)
def test_single_poses(start):
    chosen = np.arange(0, ROBOTS * POSES, 40)
    singles = [(poses()[0][i // POSES], *given(start, i)) for i in chosen]
    outs = [
        package(robot, start, mode.tolist(), coordinates, fb.Biglide)[1]
        for robot, mode, coordinates in singles
    ]
    for key in keys(start):
        check(
            label(key),
            ratios(key, np.stack([np.ravel(out[key]) for out in outs], axis=1), chosen),
            chosen=chosen,
        )


@pytest.mark.parametrize("symbols", ("SX", "MX"))
@pytest.mark.parametrize("start", STARTS)
def test_casadi(start, symbols):
    import casadi

    robots, p = poses()
    modes = p[MODES[start]].reshape(-1, ROBOTS, POSES)
    for k in (0, 1):  # unequal bars, equal ones
        for mode in np.unique(modes[:, k], axis=1).T:
            chosen = k * POSES + np.flatnonzero((modes[:, k].T == mode).all(axis=1))
            inputs = {name: getattr(casadi, symbols).sym(name, 2) for name in (start, *GIVEN)}
            _, out = package(
                robots[k],
                start,
                mode.tolist() if start == "xi" else int(mode[0]),
                inputs,
                fb.Biglide,
            )
            function = casadi.Function(
                "f", [*inputs.values()], [casadi.vec(out[key].T) for key in keys(start)]
            )
            for key, got in zip(
                keys(start), function(*(x.T for x in given(start, chosen)[1].values()))
            ):
                check(f"{symbols} {label(key)}", ratios(key, got, chosen), chosen=chosen)


@pytest.mark.parametrize("start", STARTS)
def test_oracle(start):
    """Its rates and accelerations by differences along a motion, its forces by virtual work and by the energy."""
    floats = {name: x[..., ::40] for name, x in poses()[1].items()}
    rate, acc, other = start + "_dot", start + "_ddot", OTHER[start]

    def same(got, wanted):
        assert (norm(got - wanted) <= 1e-20 * norm(wanted)).all()

    with mpmath.workdps(150):
        p, h = {name: exact(x) for name, x in floats.items()}, mpmath.mpf(10) ** -40
        moves = ({start: p[start] + t * p[rate] + t**2 / 2 * p[acc]} for t in (-h, 0, h))
        before, f, after = (models(p | move, start) for move in moves)
        for name in (other, "q_passive"):
            x, y, z = (g[name, start] for g in (before, f, after))
            first, second = (z - x) / (2 * h), (z - 2 * y + x) / h**2
            if name == "q_passive":
                first, second = (
                    cross(y.reshape(2, 2, -1), w.reshape(2, 2, -1)) for w in (first, second)
                )
            same(first, f[name + "_dot", start, rate])
            same(second, f[name + "_ddot", start, rate, acc])
        force = {other: f[f"{other}_ddot", start, rate, acc], start: p[acc]}
        speed = {other: f[f"{other}_dot", start, rate], start: p[rate]}
        feet = np.stack([p["mf1"], p["mf2"]])
        power = (f["tau", start, rate, acc] * speed["q"]).sum(axis=0)
        gained = (feet * force["q"] * speed["q"]).sum(axis=0) + p["m"] * (
            force["xi"] * speed["xi"]
        ).sum(axis=0)
        same(power[None], gained[None])
        M = f["M", start, rate].reshape(2, 2, -1)
        same((M * force["q"]).sum(axis=1) + f["c", start, rate], f["tau", start, rate, acc])
        again = models(p | {"tau": f["tau", start, rate, acc]}, start)
        same(again["forward q_ddot", start, rate], force["q"])
        same(again["forward xi_ddot", start, rate], force["xi"])
