"""Tables of setpoints are read back as the motions that they were."""

import io

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.setpoints import setpoints
from tests.helpers.twins import twin

STROKES = [[(0.0, 0.0), (0.02, 0.0), (0.02, 0.01)], [(0.0, 0.01), (0.01, 0.02)]]
LIMITS = fb.Constraints(torque=0.3, speed=0.2)
TOOL = fb.Tool(leg=2, along=0.012, across=-0.007)
FRAME = fb.Placement((0.3, -0.1), 0.7, 1.002)


def robot_of(seed):
    lengths = twin(np.random.default_rng(seed), spread=8.0)
    return fb.FiveBar(*(lengths[name] for name in ("l11", "l12", "l21", "l22", "d")))


def motion_of(robot, tool=None):
    path = fb.Placement((0.0, 0.1))(fb.path(STROKES, deviation=2e-4))
    working = (1, -1)
    led = path if tool is None else tool.path(robot, path, working)
    limits = LIMITS if tool is None else fb.Constraints(speed=0.1, acceleration=0.5)
    return fb.time_path(robot, led, constraints=limits, working=working)


def written(table, *arguments):
    file = io.StringIO()
    table.to_csv(file, *arguments)
    file.seek(0)
    return file


def restarted(file):
    file.seek(0)
    return file


@pytest.mark.parametrize("seed", [1, 2])
def test_a_timed_path_comes_back_exactly_at_its_rows(seed):
    motion = motion_of(robot_of(seed))
    file = written(motion, 500.0)
    again, plain = fb.TimedPath.from_csv(file), fb.from_csv(restarted(file))
    assert again.robot == motion.robot and again.working == motion.working
    assert again.duration == motion.duration == plain.duration
    t = again.rows
    for one, two, three in zip(motion(t), again(t), plain(t)):
        assert (one == two).all() and (one == three).all()
    assert (again.pen(t) == motion.pen(t)).all()
    head, *lines = file.getvalue().splitlines()
    bare = "\n".join([head, *(line.rpartition(",")[0] for line in lines)])  # without the pen
    assert fb.TimedPath.from_csv(io.StringIO(bare)).pen(t).tolist() == [True] * len(t)
    t = np.random.default_rng(seed).uniform(0, motion.duration, 2000)
    # Between rows 2 ms apart: where the acceleration jumps by a, about a h^2 / 50.
    jump = 2 * np.abs(motion(np.linspace(0, motion.duration, 5000))[2]).max()
    assert np.abs(again(t)[0] - motion(t)[0]).max() < jump * 0.002**2 / 50


@pytest.mark.every(5)
@pytest.mark.parametrize("tool", [None, TOOL], ids=["joint C", "tool"])
@pytest.mark.parametrize("angles", ["rad", "deg", "counts"])
def test_setpoints_of_a_calibrated_robot_come_back_in_its_own_frame(tool, angles):
    robot = robot_of(3)
    motion = motion_of(robot, tool)
    machine = fb.Machine(robot, (0.1, -0.2), (1.01, -0.99), FRAME, tool=tool)
    table = setpoints(robot, motion, 500.0)
    file = written(table, angles, machine, 4096 if angles == "counts" else None)
    again, plain = fb.TimedPath.from_csv(file), fb.from_csv(restarted(file))
    for one, two in zip(motion(table.t), again(table.t)):
        np.testing.assert_allclose(two, one, rtol=0, atol=3e-12 * max(1.0, np.abs(one).max()))
    assert (again.pen(table.t) == motion.pen(table.t)).all()
    # The file's own points are those of the pen, in the frame of the table.
    pen = motion(table.t)[0]
    if tool is not None:
        pen = tool.point(fb.igm(robot, pen, motion.working))
    np.testing.assert_allclose(plain(table.t)[0], machine.frame(pen), atol=1e-14)
    h = 1e-5  # velocities are those of the points
    t = np.linspace(0.1, 0.9, 7) * motion.duration
    change = (plain(t + h)[0] - plain(t - h)[0]) / (2 * h)
    np.testing.assert_allclose(plain(t)[1], change, atol=1e-4)


def test_it_is_simulated_and_written_again():
    motion = motion_of(fb.FiveBar())
    again = fb.TimedPath.from_csv(written(motion, 1000.0))
    law = fb.ComputedTorque(motion.robot, 400.0, 40.0, working=(1, -1))
    runs = [fb.simulate(motion.robot, law, each, control_period=0.005) for each in (motion, again)]
    assert np.abs(runs[0].xi - runs[1].xi).max() < 1e-6
    once, twice = (setpoints(motion.robot, each, 250.0) for each in (motion, again))
    np.testing.assert_allclose(once.q, twice.q, atol=1e-6)
    assert (once.pen == twice.pen).all()


def test_velocities_of_another_unit_are_not_taken():
    rows = "\n".join(f"{k / 10},{k},{k},100,100,0,0" for k in range(8))
    head = "t (s),x (mm),y (mm),x_dot{0},y_dot{0},x_ddot{1},y_ddot{1}\n"
    bare = fb.from_csv(io.StringIO(head.format("", "") + rows))
    known = fb.from_csv(io.StringIO(head.format(" (mm/s)", " (mm/s2)") + rows))
    assert known(0.2)[1].tolist() == [0.1, 0.1]
    np.testing.assert_allclose(bare(0.2)[1], [0.01, 0.01], atol=1e-9)


@pytest.mark.parametrize(
    "text, words",
    [
        ("t,x,y\n0,0,0\n", "line 1: not a file of setpoints"),
        ('# fivebar setpoints, SI units: {"robot": {}}\nt,x,y\n0,0,0\n', "not a file of setpoints"),
        (
            '# fivebar setpoints, SI units: {"robot": {"l11": 0.1}, "working": [1, 1]}\nt,x,y\n0,0,0\n',
            "no column x_dot",
        ),
    ],
)
def test_other_files_are_refused(text, words):
    with pytest.raises(ValueError, match=words):
        fb.TimedPath.from_csv(io.StringIO(text))
