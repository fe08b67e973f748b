"""`fivebar run` on scripts that cannot work: what it says, with the exit code, and the script's own traceback alone."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.amoro.test_run import START, run
from tests.helpers import ROOT

LOOP = "while True:\n    if robot.data_updated():\n        "
ROS = "fivebar run has no '{}': it runs the lab's scripts without ROS and Qt"


@pytest.mark.parametrize(
    "script, message",
    [
        (LOOP + "pass", "the script never called apply_efforts (or start_oscillate)"),
        ("robot.apply_efforts(0, 0)\n" + LOOP + "pass", "the last apply_efforts was at t = 0.01 s"),
        (
            "import time\nwhile time.time() < 2e9:\n    robot.data_updated()",
            "the script never called apply_efforts",
        ),
    ],
)
@pytest.mark.deep
def test_spinning_without_a_step_is_ended(tmp_path, script, message):
    done = run(tmp_path, START + script, code=1)
    assert "ended: data_updated() was called 100000 times with no new state: " in done.stderr
    assert (
        message in done.stderr
        and "Traceback" not in done.stderr
        and "at script.py, line " in done.stderr
    )


@pytest.mark.deep
def test_an_error_has_the_scripts_own_traceback(tmp_path):
    done = run(
        tmp_path,
        START + LOOP + "robot.apply_efforts(0.0, 0.3 / (0.3 - robot.get_time()) and np.nan)",
        code=1,
    )
    first, *rest = done.stderr.splitlines()
    assert first == "Traceback (most recent call last):" and "ros_free" not in done.stderr
    assert rest[0].endswith('script.py", line 9, in <module>') and rest[1].strip().startswith(
        "robot.apply_efforts(0.0"
    )
    assert rest[2] == "ValueError: apply_efforts at t = 0 s: the right effort is nan"


REFUSED = [
    (
        "robot.apply_efforts(0.0, float('nan'))",
        "ValueError: apply_efforts at t = 0.3 s: the right effort is nan",
    ),
    (
        "robot.apply_efforts(float('inf'), 0.0)",
        "apply_efforts at t = 0.3 s: the left effort is inf",
    ),
    (
        "robot.apply_efforts('1', 0.0)",
        "TypeError: apply_efforts at t = 0.3 s: the left effort is '1', not one number",
    ),
    ("robot.apply_efforts(0.0, None)", "the right effort is None, not one number"),
    ("robot.apply_efforts(0.0, 1j)", "the right effort is 1j, not one number"),
    (
        "robot.apply_efforts(np.zeros(2), 0.0)",
        "the left effort is an array of shape (2,), not one number",
    ),
    ("Robot('biglide')", "RuntimeError: Robot('biglide'): there is a Robot already"),
    ("robot.get_logger()", "AttributeError: Robot has no 'get_logger' in fivebar run"),
    ("start_robot(3)", "TypeError: start_robot needs a Robot, not 3"),
    ("rclpy.init()", "RuntimeError: rclpy.init was called twice"),
    ("rclpy.spin(robot)", "AttributeError: fivebar run has no rclpy.spin"),
    ("from rclpy.node import Node", "ModuleNotFoundError: " + ROS.format("rclpy.node")),
    ("from rclpy import spin", "ModuleNotFoundError: " + ROS.format("rclpy.spin")),
    ("from geometry_msgs.msg import Twist", "ModuleNotFoundError: " + ROS.format("geometry_msgs")),
    ("import ament_index_python", ROS.format("ament_index_python")),
    ("from lab_amoro.parallel_robot import Node", ROS.format("lab_amoro.parallel_robot.Node")),
    (
        "Scope('s', -1, 1).update(0, 1, 'a')",
        "TypeError: Scope 's': update needs three numbers, not 0, 1, 'a'",
    ),
    ("from PyQt5.QtWidgets import QApplication", ROS.format("PyQt5")),
    ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
    (
        "robot.apply_efforts(50.0, -1e10)",
        "ArithmeticError: apply_efforts at t = 0.3 s: efforts [ 5.e+01 -1.e+10] "
        "N m drive the robot faster than can be followed (the ",
    ),
]


@pytest.mark.deep
def test_what_is_refused(tmp_path):
    """Each statement in turn, in one script."""
    script = f"""for k in range(30):
    robot.apply_efforts(0.0, 0.0)
for statement in {[statement for statement, _ in REFUSED]}:
    try:
        exec(statement)
    except Exception as error:
        print(f"{{type(error).__name__}}: {{error}}")
"""
    lines = run(tmp_path, START + script).stdout.splitlines()
    assert len(lines) == len(REFUSED)
    for line, (statement, message) in zip(lines, REFUSED):
        assert message in line, statement


@pytest.mark.parametrize(
    "script, message",
    [
        (
            "from lab_amoro.parallel_robot import *\nrclpy.init()\nRobot('delta')",
            "ValueError: Robot('delta'): no such robot; the known ones are 'five_bar', 'biglide'",
        ),
        (
            "from lab_amoro.parallel_robot import *\nRobot('biglide')",
            "RuntimeError: Robot('biglide') before rclpy.init(args=args)",
        ),
        (
            START.replace("start_robot(robot)", "") + LOOP + "pass",
            "start_robot(robot) was never called",
        ),
    ],
)
@pytest.mark.deep
def test_what_comes_before_a_robot(tmp_path, script, message):
    assert message in run(tmp_path, script, code=1).stderr


@pytest.mark.parametrize("swallowing", ["except KeyboardInterrupt", "except"])
@pytest.mark.deep
def test_a_script_that_ignores_its_interrupt_is_ended_and_recorded(tmp_path, swallowing):
    script = f"""{START}
while True:
    try:
        if robot.data_updated():
            robot.apply_efforts(1e-4, 0.0)
    {swallowing}:
        pass
"""
    done = run(tmp_path, script, "--until", 0.5, "--record", "run.csv", code=1)
    assert (
        "got its KeyboardInterrupt at 0.5 s of simulated time, as from Ctrl-C, and was still stepping 1 s"
        in done.stderr
    )
    assert (tmp_path / "run.csv").read_text("utf-8").splitlines()[-1].startswith("1.5,")


@pytest.mark.parametrize(
    "script",
    ["while True: pass", "while True:\n    try:\n        while True: pass\n    except: pass"],
)
@pytest.mark.deep
def test_a_script_that_does_nothing_is_ended(tmp_path, script):
    done = run(tmp_path, script, "--timeout", 0.5, code=1)
    assert (
        "the script did not step for 0.5 s of wall time (--timeout); it never called apply_efforts"
        in done.stderr
    )


@pytest.mark.deep
def test_an_interrupt_left_to_python_is_a_quiet_end(tmp_path):
    done = run(tmp_path, START + LOOP + "robot.apply_efforts(0.0, 0.0)\n", "--until", 0.2)
    assert (
        "0.2 s simulated (then its KeyboardInterrupt, --until)" in done.stderr
        and "Traceback" not in done.stderr
    )


@pytest.mark.deep
def test_a_failed_motion_stays_failed(tmp_path):
    script = """for efforts in ((0, 0), (1e9, 0), (0, 0), (0, 0)):
    try:
        robot.apply_efforts(*efforts)
    except ArithmeticError as error:
        print(str(error)[:28])
"""
    done = run(tmp_path, START + script, "--record", "run.csv")
    assert done.stdout == 3 * "apply_efforts at t = 0.01 s:\n"
    assert (
        (tmp_path / "run.csv")
        .read_text("utf-8")
        .splitlines()[-1]
        .startswith("0.01,0.0,0.0,0.0,0.0,0.09")
    )


@pytest.mark.deep
def test_task_2_is_told_with_its_singularity(tmp_path):
    """Computed torque into Type 2: the crossing with time and type."""
    script = f"""{START}
import fivebar as fb
control = fb.ComputedTorque(fb.FiveBar(), 100, 20)
path = fb.line((0.09, 0.06796322), (0.05, 0.0), 4.0)
{LOOP}q, q_dot = np.array([left.position, right.position]), np.array([left.velocity, right.velocity])
        robot.apply_efforts(*control(robot.get_time(), q, q_dot, path))
"""
    done = run(tmp_path, script, "--until", 3.2)
    assert "fivebar run: singularity: Type 2 (det A = 0) crossed at 3.17" in done.stderr


@pytest.mark.parametrize(
    "options, message",
    [
        (["none.py"], "no script 'none.py'"),
        (["script.py", "--until", "0"], "--until must be finite and > 0, not 0"),
        (["script.py", "--until", "1e5"], "--until must be finite and from 0 to 10000, not 100000"),
        (["script.py", "--timeout", "nan"], "argument --timeout: 'nan' is not a number"),
        (["script.py", "--seed", "-1"], "--seed must be a whole number >= 0, not -1"),
        (["script.py", "--record", "script.py/run.csv"], "script.py: File exists"),
        (["script.py", "--record", "."], ". is a folder already"),
        (["script.py", "--plot", "run.xyz"], "--plot must end in .png, .svg or .pdf"),
        (["script.py", "--animate", "run"], "--animate must end in .html"),
        (["script.py", "--plots", "none"], "--plots none: no such folder"),
        (["--until", "x", "script.py"], "argument --until: 'x' is not a number"),
        (["script.py", "--until", "x"], "argument --until: 'x' is not a number"),
    ],
)
def test_wrong_usage(tmp_path, monkeypatch, capsys, options, message):
    from fivebar.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.py").write_text("raise RuntimeError", encoding="utf-8")
    try:
        code = main(["run", *options])
    except SystemExit as stop:  # argparse's own
        code = stop.code
    assert code == 2 and message in capsys.readouterr().err


@pytest.mark.deep
def test_what_cannot_be_written_is_said(tmp_path):
    done = run(tmp_path, START, "--record", "run.csv", code=1)
    assert "--record run.csv: nothing to write, as nothing was stepped" in done.stderr
    os.symlink("none/run.csv", tmp_path / "lost.csv")
    done = run(tmp_path, START + "robot.apply_efforts(0, 0)", "--record", "lost.csv", code=1)
    assert (
        "No such file or directory: 'lost.csv'" in done.stderr and "0.01 s simulated" in done.stderr
    )


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="processes are looked up in /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_command_leaves_no_script_behind(tmp_path, number):
    """Not even one that never gives way."""
    file = tmp_path / "endless.py"
    file.write_text(
        f"import os\nopen({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid()) + '\\n')\nwhile True: pass\n",
        encoding="utf-8",
    )
    command = subprocess.Popen(
        [sys.executable, "-m", "fivebar", "run", file], cwd=ROOT, start_new_session=True
    )
    end = time.monotonic() + 60
    while not (
        (tmp_path / "pid").exists() and (tmp_path / "pid").read_text("utf-8").endswith("\n")
    ):
        assert command.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    place = Path("/proc", (tmp_path / "pid").read_text("utf-8").strip())
    command.send_signal(number)
    command.wait()
    while place.exists() and ") Z" not in (place / "stat").read_text("utf-8"):
        assert time.monotonic() < end, "the script outlives the command"
        time.sleep(0.02)
