"""Every model against 50 digits: |error| <= 16 eps kappa |f|, kappa |f| = sum_j |df/dp_j| |p_j| over all parameters.

10 000 poses of 50 robots (2000 of 10 in the tests), a third of them within 1e-6 to 1e-2 of a singularity, each reached from its q and its xi.
`python -m tests.models.test_accuracy` prints the largest measured error / (eps kappa |f|) of each function.
"""

from functools import lru_cache

import mpmath
import numpy as np
import pytest

import fivebar as fb
from tests.helpers import oracle
from tests.helpers.oracle import (
    ACCELERATIONS,
    ANGLES,
    EPS,
    GIVEN,
    LENGTHS,
    MODES,
    OTHER,
    RATES,
    circle,
    cross,
    exact,
    norm,
)

pytestmark = pytest.mark.deep  # half a minute of 50 digits
ROBOTS = 50 if __name__ == "__main__" else 10  # the tests take a fifth of the poses
POSES, SEED, BOUND, CLOSURE_BOUND = 200, 20, 16, 4
STARTS = ("q", "xi")
NEAR = np.tile(np.arange(POSES) >= POSES - POSES // 3, ROBOTS)


def label(key):
    return f"{key[0]} of {', '.join(key[1:])}"


@lru_cache
def poses():
    return oracle.draw_all(ROBOTS, POSES, SEED)


@lru_cache
def expected(start):
    _, p = poses()
    with mpmath.workdps(50):  # the floats are taken as exact numbers
        return oracle.models({name: exact(x) for name, x in p.items()}, start), oracle.condition(
            p, start
        )


def package(robot, start, sign, given, kind=fb.FiveBar):
    """The pose and the package's outputs by the oracle's keys: floats, arrays or CasADi expressions, as given."""
    model = kind(**robot)
    pose = (
        fb.dgm(model, given["q"], assembly=sign)
        if start == "q"
        else fb.igm(model, given["xi"], working=sign)
    )
    out = {(name, start): getattr(pose, name) for name in (OTHER[start], "q_passive", "A", "B")}
    for r, first in zip(RATES, (fb.dkm, fb.ikm)):
        rates = first(pose, given[r])
        forward = fb.forward_dynamics(rates, given["tau"])
        out |= {(name, start, r): getattr(rates, name) for name in (OTHER[r], "q_passive_dot", "d")}
        out |= {(f"forward {name}", start, r): getattr(forward, name) for name in ACCELERATIONS}
        out["M", start, r], out["c", start, r] = fb.dynamic_model(rates)
        out["energy", start, r] = fb.energy(rates)
        for a, second in zip(ACCELERATIONS, (fb.dkm2, fb.ikm2)):
            acc = second(rates, given[a])
            out |= {
                (name, start, r, a): getattr(acc, name) for name in (OTHER[a], "q_passive_ddot")
            }
            out["tau", start, r, a] = fb.inverse_dynamics(acc)
    return pose, out


def given(start, chosen):
    """The modes and the coordinates that the package takes."""
    _, p = poses()
    return p[MODES[start]][..., chosen].T, {name: p[name][:, chosen].T for name in (start, *GIVEN)}


@lru_cache
def batches(start):
    """The package on all poses, a batch per robot: outputs (components, poses) by key; xi, q and elbows."""
    outs, points = [], []
    for k, robot in enumerate(poses()[0]):
        pose, out = package(robot, start, *given(start, slice(k * POSES, (k + 1) * POSES)))
        outs.append({key: np.reshape(x, (POSES, -1)).T for key, x in out.items()})
        points.append(
            np.concatenate([pose.xi, pose.q, np.reshape(pose.elbows, (POSES, 4))], axis=1).T
        )
    return {key: np.hstack([out[key] for out in outs]) for key in outs[0]}, np.hstack(points)


def ratios(key, got, chosen=slice(None)):  # noqa: B008
    """The measured error / (eps kappa |f|) of outputs (components, poses)."""
    value, kappa = expected(key[1])
    with mpmath.workdps(50):
        got = exact(np.asarray(got, dtype=float))
        error = norm(
            (circle(got).reshape(4, -1) if key[0] in ANGLES else got) - value[key][:, chosen]
        )
    return np.where(np.isfinite(error), error, np.inf) / (EPS * kappa[key][chosen])


def closure(start):
    """Residuals in units of eps (l11 + l12 + l21 + l22 + d): the worst of both legs, from the elbows and from q."""
    _, p = poses()
    with mpmath.workdps(50):
        l1, l2, base = oracle.bars({name: exact(p[name]) for name in LENGTHS})
        xi, q, *elbows = exact(batches(start)[1]).reshape(4, 2, -1)
        pairs = [
            pair
            for e in (elbows, base + l1[:, None] * circle(q))
            for pair in ((xi - e, l2), (e - base, l1))
        ]
        residuals = [abs(oracle.dot(v, v) ** 0.5 - bar) for v, bar in pairs]
        return np.concatenate(residuals).astype(float).max(axis=0) / (
            EPS * sum(p[name] for name in LENGTHS)
        )


def round_trip(start):
    """igm(dgm(q)) - q or dgm(igm(xi)) - xi, over eps times the second model's bound and the first one's carried on."""
    robots, p = poses()
    middle, model, (out, _) = OTHER[start], {"q": fb.igm, "xi": fb.dgm}[start], batches(start)
    back = []
    for k, robot in enumerate(robots):
        chosen = slice(k * POSES, (k + 1) * POSES)
        pose = model(
            fb.FiveBar(**robot), out[middle, start][:, chosen].T, p[MODES[middle]][..., chosen].T
        )
        back.append(getattr(pose, start).T)
    error = np.hstack(back) - p[start]
    error = np.angle(np.exp(1j * error)) if start == "q" else error
    A, B = (expected(start)[0][name, start].astype(float).T.reshape(-1, 2, 2) for name in "AB")
    slope = np.linalg.norm(np.linalg.solve(*((A, B) if start == "xi" else (B, A))), axis=(1, 2))
    return norm(error) / (
        EPS * (expected(middle)[1][start, middle] + slope * expected(start)[1][middle, start])
    )


def check(name, ratio, bound=BOUND, chosen=slice(None)):  # noqa: B008
    worst = np.argmax(ratio)
    pose = {name: x[..., chosen][..., worst].tolist() for name, x in poses()[1].items()}
    text = f"{name}: {ratio[worst]:.3g} > {bound} times eps kappa |f|, {np.sum(ratio > bound)} of {ratio.size} poses"
    assert ratio[worst] <= bound, (
        f"{text}; worst (near a singularity: {NEAR[chosen][worst]}): {pose}"
    )


@pytest.mark.parametrize("key", oracle.keys("q") + oracle.keys("xi"), ids=label)
def test_error(key):
    check(label(key), ratios(key, batches(key[1])[0][key]))


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("measure, bound", [(closure, CLOSURE_BOUND), (round_trip, BOUND)])
def test_loop(measure, bound, start):
    check(f"{measure.__name__} from {start}", measure(start), bound)


@pytest.mark.parametrize("start", STARTS)
def test_single_poses(start):
    chosen = np.arange(0, ROBOTS * POSES, 40)
    singles = [(poses()[0][i // POSES], *given(start, i)) for i in chosen]
    outs = [
        package(robot, start, mode.tolist(), coordinates)[1] for robot, mode, coordinates in singles
    ]
    for key in oracle.keys(start):
        ratio = ratios(key, np.stack([np.ravel(out[key]) for out in outs], axis=1), chosen)
        check(f"single {label(key)}", ratio, chosen=chosen)


@pytest.mark.parametrize("symbols", ("SX", "MX"))
@pytest.mark.parametrize("start", STARTS)
def test_casadi(start, symbols):
    import casadi

    robots, p = poses()
    modes = p[MODES[start]].reshape(-1, ROBOTS, POSES)
    for k in (0, 1, 4, 5):  # two with equal bars, two with unequal ones
        for mode in np.unique(modes[:, k], axis=1).T:
            chosen = k * POSES + np.flatnonzero((modes[:, k].T == mode).all(axis=1))
            inputs = {name: getattr(casadi, symbols).sym(name, 2) for name in (start, *GIVEN)}
            _, out = package(
                robots[k], start, mode.tolist() if start == "xi" else int(mode[0]), inputs
            )
            function = casadi.Function(
                "f", [*inputs.values()], [casadi.vec(out[key].T) for key in oracle.keys(start)]
            )
            for key, got in zip(
                oracle.keys(start), function(*(x.T for x in given(start, chosen)[1].values()))
            ):
                check(f"{symbols} {label(key)}", ratios(key, got, chosen), chosen=chosen)


@pytest.mark.parametrize("start", STARTS)
def test_oracle(start):
    """Its rates and accelerations by differences along a motion, torques by virtual work, kappa by differences."""
    floats = {name: x[..., ::120] for name, x in poses()[1].items()}
    rate, acc, other = start + "_dot", start + "_ddot", OTHER[start]

    def same(got, wanted):
        assert (norm(got - wanted) <= 1e-20 * norm(wanted)).all()

    def by_leg(x):
        return x.reshape(2, 2, -1)

    def slope(name, step, unit):  # of a result; of an angle where it is held as a unit vector
        return cross(by_leg(unit), by_leg(step)) if name in ANGLES else step

    with mpmath.workdps(150):
        p, h = {name: exact(x) for name, x in floats.items()}, mpmath.mpf(10) ** -40
        moves = ({start: p[start] + t * p[rate] + t**2 / 2 * p[acc]} for t in (-h, 0, h))
        before, f, after = (oracle.models(p | move, start) for move in moves)
        for name in (other, "q_passive"):
            x, y, z = (g[name, start] for g in (before, f, after))
            same(slope(name, (z - x) / (2 * h), y), f[name + "_dot", start, rate])
            same(slope(name, (z - 2 * y + x) / h**2, y), f[name + "_ddot", start, rate, acc])

        # every way through the models agrees with this one, given its results
        ways = ((start,), (start, rate), (start, rate, acc))
        known = {key[0]: x for key, x in f.items() if key[1:] in ways} | {
            name: p[name] for name in (start, rate, acc)
        }
        for key, x in oracle.models(p | {name: known[name] for name in GIVEN}, start).items():
            same(x, known[key[0].removeprefix("forward ")])

        M, q_dot, q_ddot = by_leg(known["M"]), known["q_dot"], known["q_ddot"]
        same((M * q_ddot).sum(axis=1) + known["c"], known["tau"])
        same((M * q_dot * q_dot[:, None]).sum(axis=(0, 1))[None] / 2, known["energy"])
        moved = [(name, x, oracle.models(q, start)) for name, x, q in oracle.perturbed(p, start, h)]
        loads = [known["tau"] - np.stack([p["zz1"], p["zz2"]]) * q_ddot, p["m"] * known["xi_ddot"]]
        own, carried = loads if start == "q" else loads[::-1]
        for load, g in zip(own, (g for name, _, g in moved if name == start), strict=True):
            column = slope(other, (g[other, start] - f[other, start]) / h, f[other, start])
            same((column * carried).sum(axis=0)[None], load[None])

        (l1, l2, base), turn = oracle.bars(p), by_leg(known["q_passive"])
        u = circle(p["q"]) if start == "q" else by_leg(known["q"])
        distal = u * turn[:, :1] + oracle.turned(u) * turn[:, 1:]
        for reached in base + l1[:, None] * u + l2[:, None] * distal:
            same(reached, known["xi"])
        sine = cross(*distal) if start == "q" else turn[:, 1]
        assert (np.sign(sine.astype(float)) == -floats[MODES[start]]).all()

        for key, kappa in oracle.condition(floats, start).items():
            total = sum(np.abs(x.astype(float)) * norm((g[key] - f[key]) / h) for _, x, g in moved)
            np.testing.assert_allclose(kappa, total, rtol=0.05)


def main():
    """Print the largest measured ratio of each function: of all poses, of those near a singularity."""
    rows = {
        label(key): ratios(key, batches(start)[0][key])
        for start in STARTS
        for key in oracle.keys(start)
    }
    rows |= {
        f"{f.__name__} from {start}": f(start) for f in (closure, round_trip) for start in STARTS
    }
    for name, ratio in rows.items():
        print(f"{name:45s} {ratio.max():10.3g} {ratio[NEAR].max():10.3g}")


if __name__ == "__main__":
    main()
