"""What the calibration promises, on many synthetic twins: `python -m tests.benchmarks.calibration [sets]`."""

import sys
import time

import numpy as np

import fivebar as fb
from tests.helpers.twins import LAB, measured, poses, robot_of, seen, twin

UNKNOWN = ("l11", "l12", "l21", "l22", "d", "offset1", "offset2", "x0", "y0")
SIGMA = 1e-4


def coverage(sets, rng, given, n=20, unknown=UNKNOWN):
    """Share of 95 % intervals that hold the truth, and of values off by more than 3 sd, over all unknowns of all sets.

    Twenty measured poses, drawn anew every hundred sets; given: whether sigma is told or has to be found.
    """
    inside, beyond, count = 0, 0, 0
    for k in range(sets):
        if k % 100 == 0:
            true = twin(rng, LAB, unknown)
            q, points, *_ = seen(true, poses(true, n, rng))
        noisy = points + SIGMA * rng.standard_normal(points.shape)
        data = dict(q1=q[:, 0], q2=q[:, 1], x=noisy[:, 0], y=noisy[:, 1])
        found = fb.calibrate(LAB, data, unknown, sigma=SIGMA if given else None)
        intervals = found.intervals()
        inside += sum(low <= true[name] <= high for name, (low, high) in intervals.items())
        beyond += sum(abs(found.values[name] - true[name]) > 3 * found.sd[name] for name in unknown)
        count += len(unknown)
    return inside / count, beyond / count


def seconds(rng, n=50, repeats=20):
    """Least time of one calibration of 50 poses and 9 unknowns, with standard deviations."""
    data = measured(twin(rng, LAB, UNKNOWN), n, rng, SIGMA)
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        fb.calibrate(LAB, data, UNKNOWN, sigma=SIGMA).sd  # noqa: B018
        best = min(best, time.perf_counter() - began)
    return best


BOX = np.stack(
    np.meshgrid(np.linspace(-0.05, 0.05, 13), np.linspace(0.07, 0.125, 13)), axis=-1
).reshape(-1, 2)
GRID = np.stack(
    np.meshgrid(np.linspace(-0.05, 0.05, 3), np.linspace(0.07, 0.125, 3)), axis=-1
).reshape(-1, 2)
DISTURBED = {
    "tilted plane": (1.0, 0.0, 0.0),
    "arm off its plane": (0.0, 2e-4, 0.0),
    "backlash": (0.0, 0.0, 0.1),
    "all three": (1.0, 2e-4, 0.1),
}


def disturbed(true, q, assembly, rng, tilt, off, backlash):
    """Points (n, 2) of a robot that the model is not: plane tilted (deg), distal bars rising by `off` (m), motors with
    backlash (deg) on either side."""
    robot = robot_of(true)
    l12, l22 = (np.sqrt(bar**2 - off**2) for bar in (robot.l12, robot.l22))
    built = fb.FiveBar(robot.l11, l12, robot.l21, l22, robot.d)
    angles = (
        q
        + (true["offset1"], true["offset2"])
        + np.radians(backlash) / 2 * rng.choice([-1, 1], q.shape)
    )
    xi = fb.dgm(built, angles, assembly).xi
    return xi * (1.0, np.cos(np.radians(tilt)))


def quadratic(q, points):
    """Who corrects the nominal robot by a quadratic polynomial in x, y, fitted at nine points."""

    def terms(xi):
        x, y = 10 * xi.T
        return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)

    nominal = fb.dgm(LAB, q, -1).xi
    weights = np.linalg.lstsq(terms(nominal), points - nominal, rcond=None)[0]
    return lambda q: fb.dgm(LAB, q, -1).xi + terms(fb.dgm(LAB, q, -1).xi) @ weights


def against_quadratic(rng, name, sets=100, sigma=1e-5):
    """RMS of the worst error of the tip in the box, of the quadratic correction on nine points of a grid and of the
    calibration on nine chosen poses, m; and the share of calibrations that say that the model does not fit."""
    chosen = fb.measurement_poses(LAB, 9, UNKNOWN[:7])
    worst, notes = [], []
    box = fb.igm(LAB, BOX, (-1, -1))
    grid = fb.igm(LAB, GRID, (-1, -1))
    for _ in range(sets):
        true = twin(rng, LAB, UNKNOWN[:7])
        parts = {}
        for key, q, mode in (
            ("grid", grid.q, -1),
            ("chosen", chosen.q, chosen.assembly),
            ("box", box.q, -1),
        ):
            parts[key] = disturbed(true, q, mode, rng, *DISTURBED[name])
        truth = fb.dgm(robot_of(true), box.q + (true["offset1"], true["offset2"]), -1).xi
        truth = truth * (1.0, np.cos(np.radians(DISTURBED[name][0])))
        correct = quadratic(
            grid.q, parts["grid"] + sigma * rng.standard_normal(parts["grid"].shape)
        )
        points = parts["chosen"] + sigma * rng.standard_normal(parts["chosen"].shape)
        data = dict(
            q1=chosen.q[:, 0],
            q2=chosen.q[:, 1],
            x=points[:, 0],
            y=points[:, 1],
            assembly=chosen.assembly,
        )
        found = fb.calibrate(LAB, data, UNKNOWN[:7], sigma=sigma, mistakes="keep")
        notes.append(not found.fits)
        worst.append(
            [np.hypot(*(each(box.q) - truth).T).max() for each in (correct, found.predict)]
        )
    return (*np.sqrt(np.mean(np.square(worst), axis=0)), np.mean(notes))


def main():
    sets = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rng = np.random.default_rng(16)
    print(f"50 poses, 9 unknowns: {1e3 * seconds(rng):.1f} ms")
    for name in DISTURBED:
        old, new, notes = against_quadratic(rng, name)
        print(
            f"{name}: worst error {1e6 * old:.1f} um quadratic, {1e6 * new:.1f} um calibrated; not fitting: {notes:.0%}"
        )
    for given in (True, False):
        inside, beyond = coverage(sets, rng, given)
        print(
            f"sigma {'given' if given else 'found'}: {inside:.2%} of 95 % intervals hold, {beyond:.3%} beyond 3 sd"
        )


if __name__ == "__main__":
    main()
