"""Exported files in MuJoCo, Pinocchio and Drake: the tree's mass matrix and bias, the loop's accelerations, motions."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.physics import Physics
from tests.benchmarks.simulators.motions import DRIVEN, DURATION

from ..helpers.needs import need
from ..helpers.physics_cases import CASES, numbers, robot_of_case
from .loaded import DRIVES, InDrake, InMujoco, InPinocchio, spread

ROBOTS = {
    "amoro": fb.FiveBar(),
    "uneven": fb.FiveBar(
        l11=0.1, l12=0.13, l21=0.08, l22=0.15, d=0.05, zz1=0.001, zz2=0.003, m=0.2
    ),
    "biglide": fb.Biglide(),
    "vertical": robot_of_case(CASES[0]),
    **{f"random {k}": robot_of_case(CASES[k], elbows=(0.004, 0.007)) for k in (1, 2, 3, 4)},
    "heavy biglide": replace(
        fb.Biglide(),
        zz1=0.02,
        zz2=-0.01,
        my1=0.1,
        my2=-0.05,
        gravity=(1.0, -9.81),
        fv1=2.0,
        fv2=3.0,
        fs1=0.5,
        fs2=0.2,
    ),
}
# Of what the loop's forces change, per condition number of what they act against, J M^-1 J^T: MuJoCo's 1 - 0.9999, and
# twice Drake's (0.1 / 2 pi)^2, the time in steps in which its constraints relax, as it weighs by M's diagonal alone.
IN_MUJOCO, IN_DRAKE = 1e-4, 5e-4


@pytest.fixture(params=ROBOTS)
def robot(request):
    need("other simulators")
    return ROBOTS[request.param]


def joints(rates):
    """Coordinates and rates of all four joints, leg by leg."""
    pose = rates.pose
    return np.ravel([pose.q, pose.q_passive], order="F"), np.ravel(
        [rates.q_dot, rates.q_passive_dot], order="F"
    )


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
    yield from (InMujoco(mjcf), InPinocchio(urdf, robot.gravity))
    yield from (
        InDrake(text, kind, robot.gravity)
        for text, kind in ((urdf, "urdf"), (sdf, "sdf"), (mjcf, "xml"))
    )
    plain = InMujoco(urdf)
    plain.model.opt.gravity[:] = (*robot.gravity, 0.0)
    yield plain


def dry(robot, rates):
    """Coulomb friction, which most of them leave to their users."""
    return np.multiply((robot.physics or Physics()).coulomb, np.sign(rates.q_dot))


@pytest.mark.every(3)
def test_the_opened_tree_in_every_simulator(robot):
    """Seen along the motions that keep the loop closed, its mass matrix and bias are the robot's M and c."""
    for tree in all_trees(robot):
        for rates, _ in states(robot):
            q, v = joints(rates)
            mass, bias = tree.mass(q), tree.bias(q, v)
            along = np.array([joints(fb.dkm(rates.pose, unit))[1] for unit in np.eye(2)]).T
            across = four(fb.dkm2(rates, (0.0, 0.0)))
            M, c = fb.dynamic_model(rates)
            np.testing.assert_allclose(
                along.T @ mass @ along, M, rtol=1e-9, atol=1e-9 * np.abs(M).max()
            )
            scale = np.abs(along.T @ mass).max() * np.abs(across).max() + np.abs(bias).max()
            np.testing.assert_allclose(
                along.T @ (mass @ across + bias),
                c - dry(robot, rates),
                rtol=1e-9,
                atol=1e-11 * scale,
            )


def test_the_tree_is_the_same_in_all(robot):
    first, *others = all_trees(robot)
    for rates, _ in states(robot):
        q, v = joints(rates)
        for other in others:
            np.testing.assert_allclose(other.mass(q), first.mass(q), rtol=1e-9, atol=1e-12)
            np.testing.assert_allclose(other.bias(q, v), first.bias(q, v), rtol=1e-9, atol=1e-9)


def test_friction_is_written_down(robot):
    """Coulomb friction too, in the joints' own order."""
    found = InMujoco(fb.export(robot, "mjcf")).model.dof_frictionloss
    np.testing.assert_array_equal(found, spread((robot.physics or Physics()).coulomb))


def applied(tree, robot, rates, tau):
    """Efforts of all joints with all friction."""
    return spread(tau - dry(robot, rates)) - tree.model.damping * joints(rates)[1]


def test_accelerations_of_the_loop_in_pinocchio(robot):
    loaded = InPinocchio(fb.export(robot, "urdf"), robot.gravity)
    for rates, tau in states(robot):
        expected = four(fb.forward_dynamics(rates, tau))
        found = loaded.closed(*joints(rates), applied(loaded, robot, rates, tau))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("case, row", [(case, row) for case in CASES for row in case["rows"]])
def test_full_bodies_of_40_digits_by_way_of_base_parameters_urdf_and_pinocchio(case, row):
    """The bodies in the file are others than those that the robot was made of, and move as they do."""
    need("other simulators")
    robot = robot_of_case(case)
    loaded = InPinocchio(fb.export(robot, "urdf"), robot.gravity)
    q, q_dot, tau, q_ddot = (
        np.array(numbers(row[name])) for name in ("q", "q_dot", "tau", "q_ddot")
    )
    rates = fb.dkm(fb.dgm(robot, q, int(row["assembly"])), q_dot)
    found = loaded.closed(*joints(rates), applied(loaded, robot, rates, tau))
    np.testing.assert_allclose(found[DRIVES], q_ddot, rtol=1e-9, atol=1e-10 * np.abs(q_ddot).max())


def given_way(robot, rates, tau):
    """What a soft loop may lose: what the loop's forces change of the accelerations, as the masses weigh it, times the
    condition number; and the mass matrix."""
    tree, (q, v) = InPinocchio(fb.export(robot, "urdf"), robot.gravity), joints(rates)
    mass, pose = tree.mass(q), rates.pose
    opened = np.linalg.solve(mass, spread(tau - dry(robot, rates)) - tree.bias(q, v))
    columns = []
    for drive, leg, bar, sign in zip(robot.drives, pose.legs, robot.distal, (1, -1)):
        turn = bar * np.array([-leg.distal[1], leg.distal[0]])
        own = (
            np.array(drive.tangent(leg.direction)) + turn * robot.turns
        )  # q12 counts from the proximal bar
        columns += [sign * own, sign * turn]
    jacobian = np.array(columns).T
    weights = np.linalg.cond(jacobian @ np.linalg.solve(mass, jacobian.T))
    changed = four(fb.forward_dynamics(rates, tau)) - opened
    return weights * weighed(mass, changed), mass


def weighed(mass, accelerations):
    return np.sqrt(accelerations @ mass @ accelerations)


@pytest.mark.every(3)
def test_accelerations_of_the_loop_in_mujoco_to_its_compliance(robot):
    """Its constraint obeys J a = held - R f: with that gap taken in, nothing else is left."""
    loaded, count = InMujoco(fb.export(robot, "mjcf")), 0
    for rates, tau in states(robot, count=20):
        q, v = joints(rates)
        slow = np.abs(rates.q_dot) < 0.005 * np.abs(fb.forward_dynamics(rates, tau).q_ddot)
        if (dry(robot, rates) != 0).any() and slow.any():
            continue  # its friction is as soft: it brakes less what stands soon
        count += 1
        expected, (changed, mass) = (
            four(fb.forward_dynamics(rates, tau)),
            given_way(robot, rates, tau),
        )
        found, jacobian, soft, held = loaded.closed(q, v, tau)
        bias = loaded.bias(q, v)
        assert weighed(mass, found - expected) < IN_MUJOCO * changed
        np.testing.assert_allclose(jacobian @ found, held - soft, rtol=1e-6, atol=1e-6 * changed)
        left = mass @ found + bias - spread(tau - dry(robot, rates))
        force = np.linalg.lstsq(jacobian.T, left, rcond=None)[0]
        np.testing.assert_allclose(jacobian.T @ force, left, atol=1e-9 * np.abs(left).max())
    assert count > 5


def test_accelerations_of_the_loop_in_drake_from_rest(robot):
    robot = replace(robot, fs1=0.0, fs2=0.0)  # dry friction it does not know
    loaded = InDrake(fb.export(robot, "sdf"), "sdf", robot.gravity, step=1e-5)
    for rates, tau in states(robot, moving=False):
        expected, (changed, mass) = (
            four(fb.forward_dynamics(rates, tau)),
            given_way(robot, rates, tau),
        )
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
        np.testing.assert_allclose(
            loaded.data.qpos, np.ravel([pose.q, pose.q_passive], order="F"), atol=1e-15
        )
        np.testing.assert_allclose(loaded.data.site_xpos[:, :2], [pose.xi, pose.xi], atol=1e-15)
        assert np.abs(loaded.data.efc_pos).max() < 1e-15


def test_a_vertical_robot_falls_through_both_types_there_as_here():
    need("other simulators")
    robot = ROBOTS["vertical"]
    begin, errors = fb.dkm(fb.dgm(robot, (0.3, 2.6)), (0.0, 0.0)), []
    ours = fb.simulate(robot, None, duration=0.5, start=begin)
    assert [int(event.type) for event in ours.events] == [1, 2]
    for step in (0.001, 0.0005):
        loaded = InMujoco(fb.export(robot, "mjcf", start=begin.pose, step=step))
        for _ in range(round(0.5 / step)):
            loaded.lib.mj_step(loaded.model, loaded.data)
        errors.append(np.abs(loaded.data.qpos[DRIVES] - ours.q[-1]).max())
    assert errors[1] < 3e-5 and 3 < errors[0] / errors[1] < 5
