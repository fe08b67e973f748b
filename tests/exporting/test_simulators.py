"""Exported files in MuJoCo, Pinocchio and Drake: the tree's mass matrix and bias, the loop's accelerations, motions."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.study.speed_accuracy.charts.motions import DRIVEN, DURATION

from ..helpers.needs import need
from .loaded import DRIVES, InDrake, InMujoco, InPinocchio, spread

ROBOTS = {
    "amoro": fb.FiveBar(),
    "uneven": fb.FiveBar(l11=0.1, l12=0.13, l21=0.08, l22=0.15, d=0.05, zz1=0.001, zz2=0.003, m=0.2),
    "biglide": fb.Biglide(),
}
# Of what the loop's forces change, per condition number of what they act against, J M^-1 J^T: MuJoCo's 1 - 0.9999, and
# Drake's (0.1 / 2 pi)^2, the time in which its constraints relax, in steps.
IN_MUJOCO, IN_DRAKE = 1e-4, 2.54e-4


@pytest.fixture(params=ROBOTS)
def robot(request):
    need("other simulators")
    return ROBOTS[request.param]


def joints(rates):
    """Coordinates and rates of all four joints, leg by leg."""
    pose = rates.pose
    return np.ravel([pose.q, pose.q_passive], order="F"), np.ravel([rates.q_dot, rates.q_passive_dot], order="F")


def four(acc):
    return np.ravel([acc.q_ddot, acc.q_passive_ddot], order="F")


def states(robot, count=8, moving=True):
    """Rates of random poses in all modes that close, away from singularities, and torques."""
    rng = np.random.default_rng(4)
    size = 1.0 if robot.turns else sum(robot.distal)
    while count:
        q = rng.uniform(-3, 3, 2) * size if robot.turns else rng.uniform(-size, size, 2)
        pose = fb.dgm(robot, q, rng.choice([-1, 1]), unreachable="nan")
        if np.isnan(pose.q_passive).any() or abs(pose.det_A) < 0.2:
            continue
        count -= 1
        yield fb.dkm(pose, rng.normal(size=2) * moving), rng.normal(size=2) * 0.1


def all_trees(robot):
    urdf, sdf, mjcf = (fb.export(robot, name) for name in ("urdf", "sdf", "mjcf"))
    yield from (InMujoco(mjcf), InMujoco(urdf), InPinocchio(urdf))
    yield from (InDrake(text, kind) for text, kind in ((urdf, "urdf"), (sdf, "sdf"), (mjcf, "xml")))


def test_the_opened_tree_in_every_simulator(robot):
    """Seen along the motions that keep the loop closed, its mass matrix and bias are the robot's M and c."""
    for tree in all_trees(robot):
        for rates, _ in states(robot):
            q, v = joints(rates)
            mass, bias = tree.mass(q), tree.bias(q, v)
            pose = rates.pose
            along = np.array([joints(fb.dkm(pose, unit))[1] for unit in np.eye(2)]).T
            across = four(fb.dkm2(rates, (0.0, 0.0)))
            M, c = fb.dynamic_model(rates)
            np.testing.assert_allclose(along.T @ mass @ along, M, rtol=1e-9, atol=1e-9 * np.abs(M).max())
            scale = np.abs(along.T @ mass).max() * np.abs(across).max()
            np.testing.assert_allclose(along.T @ (mass @ across + bias), c, rtol=1e-9, atol=1e-11 * scale)


def test_the_tree_is_the_same_in_all(robot):
    first, *others = all_trees(robot)
    for rates, _ in states(robot):
        q, v = joints(rates)
        for other in others:
            np.testing.assert_allclose(other.mass(q), first.mass(q), rtol=1e-9, atol=1e-12)
            np.testing.assert_allclose(other.bias(q, v), first.bias(q, v), rtol=1e-9, atol=1e-9)


def test_accelerations_of_the_loop_in_pinocchio(robot):
    loaded = InPinocchio(fb.export(robot, "urdf"))
    for rates, tau in states(robot):
        expected = four(fb.forward_dynamics(rates, tau))
        np.testing.assert_allclose(loaded.closed(*joints(rates), tau), expected, rtol=1e-9, atol=1e-9)


def given_way(robot, rates, tau):
    """What a soft loop may lose: what the loop's forces change of the accelerations, as the masses weigh it, times the
    condition number; and the mass matrix."""
    tree, (q, v) = InPinocchio(fb.export(robot, "urdf")), joints(rates)
    mass, pose = tree.mass(q), rates.pose
    opened = np.linalg.solve(mass, spread(tau) - tree.bias(q, v))
    columns = []
    for drive, leg, bar, sign in zip(robot.drives, pose.legs, robot.distal, (1, -1)):
        turn = bar * np.array([-leg.distal[1], leg.distal[0]])
        own = np.array(drive.tangent(leg.direction)) + turn * robot.turns  # q12 counts from the proximal bar
        columns += [sign * own, sign * turn]
    jacobian = np.array(columns).T
    weights = np.linalg.cond(jacobian @ np.linalg.solve(mass, jacobian.T))
    changed = four(fb.forward_dynamics(rates, tau)) - opened
    return weights * weighed(mass, changed), mass


def weighed(mass, accelerations):
    return np.sqrt(accelerations @ mass @ accelerations)


def test_accelerations_of_the_loop_in_mujoco_to_its_compliance(robot):
    """Its constraint obeys J a = held - R f: with that gap taken in, nothing else is left."""
    loaded = InMujoco(fb.export(robot, "mjcf"))
    for rates, tau in states(robot):
        q, v = joints(rates)
        expected, (changed, mass) = four(fb.forward_dynamics(rates, tau)), given_way(robot, rates, tau)
        found, jacobian, soft, held = loaded.closed(q, v, tau)
        bias = loaded.bias(q, v)
        assert weighed(mass, found - expected) < IN_MUJOCO * changed
        np.testing.assert_allclose(jacobian @ found, held - soft, rtol=1e-6, atol=1e-6 * changed)
        force = np.linalg.lstsq(jacobian.T, mass @ found + bias - spread(tau), rcond=None)[0]
        np.testing.assert_allclose(jacobian.T @ force, mass @ found + bias - spread(tau), atol=1e-9 * changed)


def test_accelerations_of_the_loop_in_drake_from_rest(robot):
    loaded = InDrake(fb.export(robot, "sdf"), "sdf", step=1e-5)
    for rates, tau in states(robot, moving=False):
        expected, (changed, mass) = four(fb.forward_dynamics(rates, tau)), given_way(robot, rates, tau)
        assert weighed(mass, loaded.closed(*joints(rates), tau) - expected) < IN_DRAKE * changed


def mujoco_end(step, begin, torque):
    import mujoco

    loaded = InMujoco(fb.export(fb.FiveBar(), "mjcf", step=step))
    loaded.set(*joints(begin))

    def drive(_, data):
        data.ctrl[:] = torque(data.time)

    mujoco.set_mjcb_control(drive)
    try:
        for _ in range(round(DURATION / step)):
            mujoco.mj_step(loaded.model, loaded.data)
    finally:
        mujoco.set_mjcb_control(None)
    mujoco.mj_kinematics(loaded.model, loaded.data)
    tips = loaded.data.site_xpos
    return loaded.data.qpos[DRIVES].copy(), np.linalg.norm(tips[0] - tips[1])


def test_two_seconds_in_mujoco():
    need("other simulators")
    motion, errors = DRIVEN["forced"], []
    for step in (0.002, 0.001):
        q, gap = mujoco_end(step, motion.begin(), motion.torque)
        errors.append(np.abs(q - motion.end).max())
        assert gap < 1e-8
    assert errors[1] < 1e-8 and 3 < errors[0] / errors[1] < 5  # of order 2, by the time constant


def test_two_seconds_in_drake():
    need("other simulators")
    motion, errors = DRIVEN["forced"], []
    for step in (0.002, 0.001):
        loaded = InDrake(fb.export(fb.FiveBar(), "sdf"), "sdf", step=step)
        q, _ = loaded.moved(*joints(motion.begin()), motion.torque, round(DURATION / step))
        errors.append(np.abs(q[DRIVES] - motion.end).max())
    assert errors[1] < 2e-4 and 1.8 < errors[0] / errors[1] < 2.2


def test_what_is_loaded_stands_closed():
    need("other simulators")
    for robot, start in ((fb.FiveBar(), fb.dgm(fb.FiveBar(), (0.3, -0.2))), (fb.Biglide(), None)):
        loaded = InMujoco(fb.export(robot, "mjcf", start=start))
        loaded.lib.mj_forward(loaded.model, loaded.data)
        pose = start or fb.dgm(robot, (0.0, 0.0))
        np.testing.assert_allclose(loaded.data.qpos, np.ravel([pose.q, pose.q_passive], order="F"), atol=1e-15)
        np.testing.assert_allclose(loaded.data.site_xpos[:, :2], [pose.xi, pose.xi], atol=1e-15)
        assert np.abs(loaded.data.efc_pos).max() < 1e-15
