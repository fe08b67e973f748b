"""Logs of robots whose truth is known: exact torques of smooth motions, by the models, with noise on both."""

import io
from dataclasses import dataclass, replace

import numpy as np

import fivebar as fb

RUNGS = {  # what a robot on the ladder has beyond its masses
    "plain": (),
    "viscous": ("viscous",),
    "dry": ("dry",),
    "friction": ("viscous", "dry"),
    "gravity": ("gravity",),
    "gravity, friction": ("gravity", "viscous", "dry"),
    "heavy bars": ("heavy",),
    "heavy bars, gravity, friction": ("heavy", "gravity", "viscous", "dry"),
    "all": ("heavy", "gravity", "viscous", "dry", "elbows"),
}


@dataclass(frozen=True, eq=False)
class Case:
    """A robot, what is known of it, and a log as a mapping."""

    robot: fb.FiveBar
    known: fb.FiveBar
    log: dict

    @property
    def named(self):
        """The parameters that it has beyond its masses."""
        own = "l11", "l12", "l21", "l22", "d", "zz1", "zz2", "m", "gravity"
        return {name for name in self.robot.parameters if name not in own}


def robot_with(rng, has):
    """A robot of random bars, and of a rung's physics."""
    while True:
        lengths = rng.uniform(0.08, 0.2, 4)
        d = rng.uniform(0.05, 0.2)
        try:
            fb.FiveBar(*lengths, d)
            break
        except ValueError:
            continue
    links = {}
    for leg, (proximal, distal) in zip("12", (lengths[:2], lengths[2:])):
        m1, m2 = rng.uniform(0.2, 0.6, 2)
        side = rng.choice([-1, 1], 2) * rng.uniform(0.01, 0.03, 2)
        links[f"{leg}1"] = fb.Link.about_centre(
            m1, rng.uniform(0.3, 0.7) * proximal, side[0], m1 * 0.002
        )
        if "heavy" in has:
            links[f"{leg}2"] = fb.Link.about_centre(
                m2, rng.uniform(0.3, 0.7) * distal, side[1], m2 * 0.004
            )
    rub = {
        name: rng.uniform(*range_, 2)
        for name, range_ in (("viscous", (0.02, 0.05)), ("dry", (0.02, 0.1)))
    }
    robot = fb.FiveBar.from_links(
        *lengths,
        d,
        links=links,
        payload=rng.uniform(0.2, 1.0),
        gravity=(0.0, -9.81) if "gravity" in has else (0.0, 0.0),
        viscous=rub["viscous"] if "viscous" in has else (0.0, 0.0),
        coulomb=rub["dry"] if "dry" in has else (0.0, 0.0),
        elbows=rng.uniform(0.01, 0.03, 2) if "elbows" in has else (0.0, 0.0),
    )
    return robot if "gravity" in has else replace(robot, mx11=0.0, my11=0.0, mx21=0.0, my21=0.0)


def motion_of(robot, rng, duration=20.0, step=1e-3, harmonics=10, about=None):
    """t, q, q', q'' of a Fourier series away from Type 2, in assembly mode -1, about a pose."""
    t = np.arange(round(duration / step) + 1) * step
    k = 2 * np.pi / (duration / 2) * np.arange(1, harmonics + 1)
    s, c = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
    while True:
        centre = rng.uniform(-np.pi, np.pi, 2) if about is None else about
        pose = fb.dgm(robot, centre, unreachable="nan")
        if (
            not np.isfinite(pose.xi).all()
            or abs(pose.det_A) < 0.5
            or min(map(abs, pose.sines)) < 0.3
        ):
            continue
        a, b = rng.normal(size=(2, 2, harmonics)) / np.sqrt(np.arange(1, harmonics + 1))
        for size in (0.3, 0.25, 0.2, 0.15):
            q = centre + size * (s @ a.T + c @ b.T)
            pose = fb.dgm(robot, q, unreachable="nan")
            if np.isfinite(pose.xi).all() and np.abs(pose.det_A).min() > 0.25:
                q_dot = size * ((c * k) @ a.T - (s * k) @ b.T)
                return t, q, q_dot, -size * ((s * k * k) @ a.T + (c * k * k) @ b.T)


def jerky_motion(robot, rng, duration, step, move=0.3):
    """t, q, q', q'' of moves of `move` s about a pose, each speeding up evenly and slowing down."""
    while True:
        centre = rng.uniform(-np.pi, np.pi, 2)
        pose = fb.dgm(robot, centre, unreachable="nan")
        if abs(pose.det_A) > 0.8 and min(map(abs, pose.sines)) > 0.5:
            break
    t = np.arange(round(duration / step)) * step
    k = (t / move).astype(int)
    ends = centre + rng.uniform(-0.15, 0.15, (k[-1] + 2, 2))
    way = np.diff(ends, axis=0)[k]
    part = (t / move - k)[:, None]
    early = part < 0.5
    q = ends[k] + way * np.where(early, 2 * part**2, 1 - 2 * (1 - part) ** 2)
    q_dot = way * np.where(early, 4 * part, 4 * (1 - part)) / move
    return t, q, q_dot, way * np.where(early, 4.0, -4.0) / move**2


def torques_of(robot, q, q_dot, q_ddot):
    return fb.inverse_dynamics(fb.dkm2(fb.dkm(fb.dgm(robot, q), q_dot), q_ddot))


def noisy(rng, motion, tau, encoder=2e-5, torque=0.005):
    """The log of a motion (t, q, ...): noise of the encoders, rad, and of the torques, as a share of their rms."""
    t, q = motion[:2]
    size = torque * np.sqrt(np.mean(tau**2, axis=0))
    return {
        "t": t,
        "q": q + encoder * rng.normal(size=q.shape),
        "tau": tau + size * rng.normal(size=q.shape),
    }


def case_of(seed, has, duration=20.0, step=1e-3, motion_of=motion_of, **noise):
    """A Case with this rung's physics."""
    rng = np.random.default_rng(seed)
    robot = robot_with(rng, has)
    motion = motion_of(robot, rng, duration, step)
    log = noisy(rng, motion, torques_of(robot, *motion[1:]), **noise)
    known = fb.FiveBar(robot.l11, robot.l12, robot.l21, robot.l22, robot.d, gravity=robot.gravity)
    return Case(robot, known, log)


def ros(run, header, clock):
    """A run's log as ROS's tools export it: a clock since 1970, joint states, velocities that no driver filled."""
    stamp, first, second = header.rsplit(",", 2)
    names = [
        stamp,
        *(
            each.format(kind)
            for kind in ("position", "velocity", "effort")
            for each in (first, second)
        ),
    ]
    rows = np.column_stack([run.q, 0 * run.q, run.tau]).tolist()
    lines = [clock(1.7e9 + t) + ",".join(map(repr, row)) for t, row in zip(run.t, rows)]
    return io.StringIO("\n".join([",".join(names), *lines]))
