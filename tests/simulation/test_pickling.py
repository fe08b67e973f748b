"""References, poses, plans, trackers, runs and regions go to other processes, and are the same there."""

import io
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
HOME, NEAR = (0.09, 0.068), (0.08, 0.075)
SAMPLES = "t_s,x_m,y_m\n" + "".join(f"{k / 9},{0.09 - k * 0.001},{0.068}\n" for k in range(10))
REFERENCES = {
    "line": lambda: fb.line(HOME, NEAR, 0.3),
    "circle": lambda: fb.circle((0.0, 0.11), 0.03, 0.3),
    "polynomial": lambda: fb.polynomial([(0.0, {0: HOME}), (0.3, {0: NEAR, 1: (0.0, 0.1)})]),
    "spline": lambda: fb.from_csv(io.StringIO(SAMPLES)),
    "polyline": lambda: fb.from_csv(io.StringIO(SAMPLES), kind="polyline", deviation=1e-4),
    "plan": lambda: fb.plan(ROBOT, HOME, NEAR, 0.3),
    "timed path": lambda: fb.time_path(
        ROBOT, fb.path([HOME, NEAR]), constraints=fb.Constraints(torque=0.1)
    ),
    "exciting": lambda: fb.exciting_trajectory(
        ROBOT, period=2.0, torque=0.2, unknown=["m"], harmonics=2, starts=2
    ),
}


@pytest.mark.every(2)
@pytest.mark.parametrize("name", REFERENCES)
def test_a_reference_is_the_same_elsewhere(name):
    reference = REFERENCES[name]()
    again = pickle.loads(pickle.dumps(reference))
    t = reference.start + np.linspace(-0.1, 1.1, 31) * reference.duration
    for one, other in zip(reference(t), again(t)):
        assert np.array_equal(one, other)
    assert repr(again) == repr(reference)


def test_poses_and_regions_are_the_same_elsewhere():
    xi = np.array([HOME, NEAR])
    pose = fb.igm(ROBOT, xi)
    for one in (pose, fb.dgm(ROBOT, pose.q), fb.ikm(pose, (0.1, 0.2)).pose):
        other = pickle.loads(pickle.dumps(one))
        for name in ("q", "xi", "q_passive", "working", "assembly", "A", "B"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    for part in fb.aspects(ROBOT):
        again = pickle.loads(pickle.dumps(part))
        assert again.area == part.area and np.array_equal(again.contains(xi), part.contains(xi))


def simulated(controller, reference):
    return fb.simulate(ROBOT, controller, reference)


@pytest.mark.deep
def test_a_pool_of_processes_simulates():
    """With a plan, and a tracker that begins anew there."""
    plan = REFERENCES["plan"]()
    tracker = fb.Tracker(ROBOT, constraints=fb.Constraints(torque=0.5))
    here = [
        simulated(controller, plan) for controller in (fb.ComputedTorque(ROBOT, 100, 20), tracker)
    ]
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        there = [
            pool.submit(simulated, controller, plan).result()
            for controller in (fb.ComputedTorque(ROBOT, 100, 20), tracker)
        ]
    for one, other in zip(here, there):
        assert np.array_equal(one.q, other.q) and np.array_equal(one.tau, other.tau)
