"""Robots with a hidden truth, and what would be measured on them; the truth's own equations are `fivebar.dgm`'s."""

import numpy as np

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import FRAME, LENGTHS, READING

NOMINAL = fb.FiveBar(0.09, 0.1, 0.085, 0.095, 0.118)
LAB = fb.FiveBar()
HOME = ((-1, -1),)
MODES = ((-1, -1), (-1, 1), (1, -1), (1, 1))


def twin(rng, nominal=LAB, unknown=(*LENGTHS, *READING, *FRAME), spread=1.0):
    """{name: value} of a robot as built: what is unknown is off by about 0.5 mm, 0.5 degrees, 1 in 1000."""
    sizes = dict.fromkeys((*LENGTHS, "x0", "y0"), 5e-4) | dict.fromkeys(
        ("offset1", "offset2", "turn"), 9e-3
    )
    true = {name: getattr(nominal, name) for name in LENGTHS}
    true |= dict(
        offset1=0.0, offset2=0.0, ratio1=1.0, ratio2=1.0, x0=0.0, y0=0.0, turn=0.0, scale=1.0
    )
    for name in unknown:
        true[name] += spread * sizes.get(name, 1e-3) * rng.uniform(-1, 1)
    return true


def robot_of(true):
    return fb.FiveBar(**{name: true[name] for name in LENGTHS})


def poses(true, n, rng, modes=MODES, margin=0.3):
    """n regular poses of the true robot all over its workspace."""
    robot, found = robot_of(true), []
    reach = robot.l11 + robot.l12
    while len(found) < n:
        xi, mode = rng.uniform(-reach, reach, 2), modes[rng.integers(len(modes))]
        pose = fb.igm(robot, xi, mode, unreachable="nan")
        if np.isfinite(pose.q).all() and min(*np.abs(pose.sines), abs(pose.det_A)) > margin:
            found.append(pose)
    return found


def seen(true, poses):
    """Readings (n, 2), points (n, 2) in the measuring frame, assembly (n,) and working modes (n, 2) of these poses."""
    angles, xi = np.array([pose.q for pose in poses]), np.array([pose.xi for pose in poses])
    q = (angles - (true["offset1"], true["offset2"])) / (true["ratio1"], true["ratio2"])
    z = true["x0"] + 1j * true["y0"] + true["scale"] * np.exp(1j * true["turn"]) * (xi @ (1, 1j))
    points = np.stack([z.real, z.imag], axis=-1)
    return (
        q,
        points,
        np.array([int(pose.assembly) for pose in poses]),
        np.array([pose.working for pose in poses]),
    )


def measured(true, n, rng, sigma=0.0, modes=MODES, margin=0.3):
    """Data for `calibrate`: n random poses, their points measured to sigma, m; no modes noted."""
    q, points, _, _ = seen(true, poses(true, n, rng, modes, margin))
    points = points + sigma * rng.standard_normal(points.shape)
    return dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])
