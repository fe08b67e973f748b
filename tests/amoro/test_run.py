"""`fivebar run`: scripts in the shapes that the AMORO lab's students write, against independent numbers."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fivebar as fb
from tests import helpers
from tests.helpers import DATA

SCRIPTS = Path(helpers.__file__).parent / "lab_scripts"
LABS = helpers.LABS / "amoro"
HOME = 0.09, 0.06796322535018479
START = """from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *
rclpy.init(args=None)
robot = Robot("five_bar")
start_robot(robot)
left, right, end = robot.active_left_joint, robot.active_right_joint, robot.end_effector
"""


def run(folder, script, *arguments, code=0, **environment):
    """Run a script, given by its path or its text, in this folder; gives what was printed."""
    if not isinstance(script, Path):
        (folder / "script.py").write_text(script, encoding="utf-8")
        script = "script.py"
    command = [sys.executable, "-m", "fivebar", "run", str(script), *map(str, arguments)]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **environment},
    )
    assert done.returncode == code, done.stderr
    return done


@pytest.mark.parametrize(
    "kind, case", [("five_bar", 0), pytest.param("five_bar_stiff", 1, marks=pytest.mark.deep)]
)
def test_computed_torque_on_task_1_has_the_reference_errors(tmp_path, kind, case):
    run(tmp_path, SCRIPTS / "computed_torque.py", kind, "errors.json", "--until", 2.52)
    errors = np.array(json.loads((tmp_path / "errors.json").read_text("utf-8")))
    known = json.loads((DATA / "sampled_control.json").read_text("utf-8"))[
        "computed_torque_lab_task_1"
    ]["runs"][case]
    assert len(errors) == 250
    # The lab's home is 5.4e-9 m off the reference's start, which moves the errors by up to 1e-8 rad.
    for found, name in (
        (np.abs(errors).max(axis=0), "max_abs_joint_error_rad"),
        (np.sqrt(np.mean(errors**2, axis=0)), "rms_joint_error_rad"),
    ):
        assert found == pytest.approx(known[name], rel=1e-5, abs=1e-8)


def redundant(t, state, force, robot):
    """The biglide as a point and two feet in (x, y, q1, q2), with multipliers for the two bars."""
    (x, y, *q), velocity = state[:4], state[4:]
    J, bias = np.zeros((2, 4)), np.zeros(2)
    for k, base in enumerate((-robot.d / 2, robot.d / 2)):
        r, r_dot = (
            np.array([x - base, y - q[k]]),
            np.array([velocity[0], velocity[1] - velocity[2 + k]]),
        )
        J[k, :2], J[k, 2 + k], bias[k] = r, -r[1], -r_dot @ r_dot
    mass = np.diag([robot.m, robot.m, robot.mf1, robot.mf2])
    system = np.block([[mass, J.T], [J, np.zeros((2, 2))]])
    return np.concatenate([velocity, np.linalg.solve(system, [0, 0, *force, *bias])[:4]])


@pytest.mark.deep
def test_computed_torque_on_the_biglide_agrees_with_redundant_coordinates(tmp_path):
    run(
        tmp_path,
        SCRIPTS / "computed_torque.py",
        "biglide",
        "errors.json",
        "--until",
        2.2,
        "--record",
        "run.csv",
    )
    motion, robot = fb.Run.from_csv(tmp_path / "run.csv"), fb.Biglide()
    assert motion.robot == robot and motion.t[-1] == 2.2
    state = np.array([0, np.sqrt(robot.l1**2 - robot.d**2 / 4), 0, 0, 0, 0, 0, 0])
    for k in range(0, 2200, 10):
        assert (motion.tau[k : k + 10] == motion.tau[k]).all()
        options = dict(args=(motion.tau[k], robot), method="DOP853", rtol=1e-12, atol=1e-15)
        state = solve_ivp(redundant, (0, 0.01), state, **options).y[:, -1]
        assert np.abs(state[:2] - motion.xi[k + 10]).max() < 1e-10
        assert np.abs(state[2:4] - motion.q[k + 10]).max() < 1e-10
        assert np.abs(state[6:] - motion.q_dot[k + 10]).max() < 1e-9
    assert np.abs(motion.xi[-1] - (0.06, 0.25)).max() < 1e-5


@pytest.mark.deep
def test_two_runs_are_the_same_to_the_byte(tmp_path):
    noisy = """import random
while True:
    if robot.data_updated():
        robot.apply_efforts(1e-3 * random.gauss(0, 1), 1e-3 * np.random.normal() + 1e-6 * (hash("seed") % 7))
"""
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        run(tmp_path, START + noisy, "--until", 0.3, "--record", f"{name}.csv", "--seed", seed)
    a, b, c = ((tmp_path / f"{name}.csv").read_bytes() for name in "abc")
    assert a == b != c


@pytest.mark.deep
def test_a_state_is_the_labs(tmp_path):
    """Conventions at home and after some steps, against the models; differences, and the true accelerations."""
    script = """import json
print(json.dumps([left.position, right.position, robot.passive_left_joint.position,
                  robot.passive_right_joint.position, end.position_x, end.position_y, robot.get_time()]))
assert robot.data_updated() and not robot.data_updated()
for k in range(25):
    before = left.velocity, robot.passive_right_joint.velocity
    robot.apply_efforts(0.02, -0.016)
    assert robot.data_updated() and not robot.data_updated()
joints = robot.active_left_joint, robot.active_right_joint, robot.passive_left_joint, robot.passive_right_joint
print(json.dumps([[j.position, j.velocity, j.acceleration] for j in joints]))
xy, xy_dot = [end.position_x, end.position_y], [end.velocity_x, end.velocity_y]
print(json.dumps([*xy, *xy_dot, end.acceleration_x, end.acceleration_y]))
print(json.dumps([left.effort, right.effort, robot.get_time()]))
print(json.dumps([(left.velocity - before[0]) / 0.01, (robot.passive_right_joint.velocity - before[1]) / 0.01]))
"""
    for exact in (False, True):
        done = run(tmp_path, START + script, *(["--exact-acceleration"] if exact else []))
        home, joints, end, last, differences = map(json.loads, done.stdout.splitlines())
        assert home == pytest.approx(
            [0, 0, 0.8558782490506787, 2.2857144045391147, *HOME, 0], abs=1e-15
        )
        assert last == [0.02, -0.016, 0.25]
        q, q_dot, q_ddot = np.array(joints).T
        rates = fb.dkm(fb.dgm(fb.FiveBar(), q[:2]), q_dot[:2])
        acc = fb.forward_dynamics(rates, (0.02, -0.016))
        assert q[2:] == pytest.approx(rates.pose.q_passive, abs=1e-13)
        assert q_dot[2:] == pytest.approx(rates.q_passive_dot, abs=1e-12)
        assert end == pytest.approx(
            [*rates.pose.xi, *rates.xi_dot, *acc.xi_ddot], rel=1e-11, abs=1e-12
        )
        true = [*acc.q_ddot, *acc.q_passive_ddot]
        if exact:
            assert q_ddot == pytest.approx(true, rel=1e-10)
        else:
            assert q_ddot[[0, 3]].tolist() == differences
            assert 1e-4 < np.abs(q_ddot - true).max() < 1


@pytest.mark.deep
def test_the_robot_moves_as_simulate_has_it(tmp_path):
    """The forced motion's torques, held for 10 ms each: the same rows as fivebar.simulate's own."""
    loop = """from math import cos, pi
for k in range(150):
    robot.apply_efforts(0.02 * cos(2 * pi * k / 100), -0.016 * cos(2 * pi * k / 100))
"""
    run(tmp_path, START + loop, "--record", "run.csv")
    motion = fb.Run.from_csv(tmp_path / "run.csv")
    own = fb.simulate(
        fb.FiveBar(),
        lambda t, *_: np.array([0.02, -0.016]) * np.cos(2 * np.pi * np.round(100 * t) / 100),
        duration=1.5,
    )
    assert np.abs(motion.xi - own.xi).max() < 1e-14 and motion.events == own.events


@pytest.mark.deep
def test_oscillation_wall_clock_and_reset(tmp_path):
    """A loop on `from time import time`; the efforts turn at the lab's limits; a reset goes home and keeps the run."""
    script = """import time as clock
from time import time, sleep
assert not robot.continue_oscillations() and robot.get_time() == 0
start, efforts, turns = time(), [], []
sleep(0.5)
robot.start_oscillate()
while time() < start + 4:
    if robot.data_updated():
        seen = left.position, right.position, left.effort, right.effort
        robot.continue_oscillations()
        for k, joint in enumerate((left, right)):
            assert abs(joint.effort) == 0.0002
            turned = seen[2 + k] * joint.effort < 0
            assert turned == (seen[2 + k] * seen[k] > 0 and abs(seen[k]) > 0.05)
            turns += [(robot.get_time(), k)] * turned
print(robot.get_time(), time() - start, clock.monotonic(), clock.perf_counter_ns(), len(turns))
robot.stop_oscillate()
assert (left.position, left.velocity, left.effort, robot.get_time()) == (0, 0, 0, 0)
robot.start_oscillate()
assert robot.get_time() == 0.01
robot.reset_simulation()
"""
    done = run(tmp_path, START + script, "--json", "--record", "run.csv")
    assert (
        done.stderr.split()[:4] == ["3.5", "4.0", "4.0", "4000000000"]
        and int(done.stderr.split()[4]) >= 1
    )
    about = json.loads(done.stdout)
    assert (
        about["resets_at_s"] == [3.5, 3.51]
        and not about["recorded_after_reset"]
        and not about["interrupted"]
    )
    assert about["exit_code"] == 0 and fb.Run.from_csv(tmp_path / "run.csv").t[-1] == 0.01


@pytest.mark.deep
def test_real_time_is_not_faster(tmp_path):
    before = time.monotonic()
    loop = "from time import time\nt = time()\nfor k in range(50): robot.apply_efforts(0, 0)\nprint(time() - t)\n"
    done = run(tmp_path, START + loop, "--real-time")
    assert time.monotonic() - before > float(done.stdout) > 0.49


@pytest.mark.deep
def test_ctrl_c_reaches_the_script(tmp_path):
    loop = """try:
    while True:
        if robot.data_updated():
            robot.apply_efforts(0.0, 0.0)
            if robot.get_time() == 0.1:
                print("ready", flush=True)
except KeyboardInterrupt:
    print("summary")
"""
    (tmp_path / "script.py").write_text(START + loop, encoding="utf-8")
    command = [sys.executable, "-m", "fivebar", "run", "--real-time", "--until", "60", "script.py"]
    pipes = dict(stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    child = subprocess.Popen(command, cwd=tmp_path, start_new_session=True, **pipes)
    try:
        assert child.stdout.readline() == "ready\n"
        os.killpg(child.pid, signal.SIGINT)
        out, err = child.communicate(timeout=30)
    finally:
        child.kill()
    assert (
        child.returncode == 0
        and out == "summary\n"
        and "x real time" in err
        and "Traceback" not in err
    )


@pytest.mark.parametrize("kind", ["five_bar", pytest.param("biglide", marks=pytest.mark.deep)])
def test_the_labs_self_checks(tmp_path, kind):
    done = run(tmp_path, LABS / "evaluation.py", kind, "--until", 0.6)
    lines = done.stdout.splitlines()
    assert len(lines) == 10 and all(line.endswith(": OK") for line in lines)
    exact = run(
        tmp_path, LABS / "evaluation.py", kind, "--until", 0.4, "--exact-acceleration"
    ).stdout
    assert all(
        float(word.strip(",:")) < 1e-14 for line in exact.splitlines() for word in line.split()[3:5]
    )


@pytest.mark.deep
def test_the_labs_examples_on_a_students_file(tmp_path):
    """Models drawn over the robot, and control; a student's file with one wrong model is found out."""
    student = """import fivebar as fb
from fivebar.amoro import models
globals().update(vars(models(fb.FiveBar())))
right = dkm2
def dkm2(*arguments):
    xDD, yDD = right(*arguments)
    return xDD + 0.01, yDD
"""
    (tmp_path / "student.py").write_text(student, encoding="utf-8")
    done = run(tmp_path, LABS / "evaluation.py", "five_bar", "student.py", "--until", 1)
    assert [line.split()[0] for line in done.stdout.splitlines() if not line.endswith(": OK")] == [
        "dkm2"
    ]
    about = json.loads(
        run(
            tmp_path, LABS / "direct_models.py", "five_bar", "student.py", "--json", "--until", 1
        ).stdout
    )
    worst = {scope["title"]: scope["largest_difference"] for scope in about["scopes"]}
    assert len(worst) == 12 and worst["Acceleration x"] == pytest.approx(0.01, rel=1e-3)
    assert all(
        apart < 1e-15 for title, apart in worst.items() if not title.startswith("Acceleration")
    )
    about = json.loads(
        run(tmp_path, LABS / "inverse_models.py", "biglide", "--json", "--until", 1).stdout
    )
    assert len(about["scopes"]) == 8 and all(
        scope["largest_difference"] < 1e-4 for scope in about["scopes"]
    )
    about = json.loads(
        run(tmp_path, LABS / "control.py", "five_bar", "--json", "--until", 2.5).stdout
    )
    assert about["scopes"][1]["largest_difference"] == pytest.approx(0.000232451, rel=1e-5)
