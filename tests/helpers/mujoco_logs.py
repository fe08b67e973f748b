"""Logs of robots that MuJoCo simulates: encoders of 14 bits, torques held for 1 ms and noisy by 1 mN m."""

import numpy as np

import fivebar as fb
from tests.helpers.synthetic_logs import motion_of, torques_of

COUNT = 2 * np.pi / 2**14
STEP = 1e-3


def mujoco_log(seed, viscous, duration):
    """A random robot, and its log under feed-forward and a PD law of the encoders' readings."""
    import mujoco

    rng = np.random.default_rng(500 + seed)
    while True:
        lengths, d = rng.uniform(0.08, 0.2, 4), rng.uniform(0.05, 0.2)
        if d + lengths.max() < lengths.sum() - lengths.max() and d < lengths.sum() / 3:
            break
    inertias = *rng.uniform(1e-3, 4e-3, 2), rng.uniform(0.2, 0.8)
    robot = fb.FiveBar(*lengths, d, *inertias, fv1=viscous, fv2=viscous)
    t, q, q_dot, q_ddot = motion_of(robot, rng, duration, STEP)
    forward = torques_of(robot, q, q_dot, q_ddot)
    model = mujoco.MjModel.from_xml_string(fb.export(robot, "mjcf"))
    model.opt.timestep = STEP / 2
    data = mujoco.MjData(model)
    pose = fb.dgm(robot, q[0])
    rates = fb.dkm(pose, q_dot[0])
    # Of each leg the drive, then the passive joint.
    data.qpos[:] = np.stack([q[0], pose.q_passive], axis=1).ravel()
    data.qvel[:] = np.stack([q_dot[0], rates.q_passive_dot], axis=1).ravel()
    mujoco.mj_forward(model, data)
    readings, torques = np.empty_like(q), np.empty_like(q)
    for k in range(len(t)):
        readings[k] = np.round(data.qpos[[0, 2]] / COUNT) * COUNT
        torques[k] = forward[k] + 4.0 * (q[k] - readings[k])
        torques[k] += 0.05 * (q_dot[k] - data.qvel[[0, 2]])
        data.ctrl[:] = torques[k]
        mujoco.mj_step(model, data, 2)
    return robot, {"t": t, "q": readings, "tau": torques + 1e-3 * rng.normal(size=q.shape)}
