"""A student's script as it is run: its windows, its options, and what it finds around it."""

import json
import os
import subprocess
import sys

import pytest

from .test_run import START, run


@pytest.mark.deep
def test_windows_and_scopes_are_files(tmp_path):
    """A loop that draws, shows at the end, and closes; nothing is drawn that nobody sees."""
    script = """import matplotlib
matplotlib.use("TkAgg")
import matplotlib.pyplot as plt
plt.ion()
figure, axes = plt.subplots()
line, = axes.plot([], [])
app = QtGui.QApplication([])
scope = Scope("Joint 1", -1.0, 1.0)
draws, times, xs = [], [], []
figure.canvas.mpl_connect("draw_event", draws.append)
try:
    while True:
        if robot.data_updated():
            robot.apply_efforts(1e-3, -1e-3)
            times.append(robot.get_time())
            xs.append(end.position_x)
            line.set_data(times, xs)
            axes.relim()
            axes.autoscale_view()
            figure.canvas.draw()
            figure.canvas.flush_events()
            plt.pause(0.001)
            scope.update(times[-1], 1.0, 0.75)
except KeyboardInterrupt:
    assert not draws
    plt.ioff()
    plt.figure()
    plt.plot(times, xs)
    plt.show()
    assert plt.get_fignums() == []
    plt.figure(); plt.plot([1, 2]); plt.savefig("own.png"); plt.close("all")
app.exec_()
"""
    (tmp_path / "windows").mkdir()
    options = "--plots", "windows", "--plot", "run.png", "--animate", "run.html"
    done = run(tmp_path, START + script, "--json", "--until", 1, *options)
    about = json.loads(done.stdout)
    pictures = ["script_figure_1.png", "script_figure_2.png", "script_scopes.png"]
    assert about["files"] == [
        *(os.path.join("windows", name) for name in pictures),
        "run.png",
        "run.html",
    ]
    assert all((tmp_path / file).stat().st_size > 5000 for file in about["files"])
    assert {path.name for path in tmp_path.iterdir()} == {
        "script.py",
        "windows",
        "own.png",
        "run.png",
        "run.html",
    }
    assert about["scopes"] == [
        {"title": "Joint 1", "largest_difference": 0.25, "rms_difference": 0.25}
    ]


@pytest.mark.deep
def test_show_leaves_matplotlib_alone(tmp_path):
    script = "import matplotlib.pyplot as plt\nprint(plt.get_backend())\n"
    assert run(tmp_path, script, "--show", MPLBACKEND="svg").stdout == "svg\n"
    assert (
        run(tmp_path, script, MPLBACKEND="svg").stdout
        == "module://fivebar.amoro.ros_free.figures\n"
    )


@pytest.mark.deep
def test_a_script_is_run_as_python_would(tmp_path):
    """Path, arguments, names, output, exit codes and tracebacks: against `python3 script.py` itself."""
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "helper.py").write_text(
        "def fail():\n    raise ValueError('of the helper')\n", encoding="utf-8"
    )
    script = """import sys, helper, random
print(__name__, __file__, __spec__, __package__, sys.argv, sys.path[0], sys.modules["__main__"].__dict__ is globals())
print("to stderr", file=sys.stderr)
if sys.argv[1] == "exit":
    sys.exit(3)
if sys.argv[1] == "word":
    sys.exit("a word")
if sys.argv[1] == "syntax":
    exec(compile("x = (", "inner.py", "exec"))
try:
    helper.fail()
except ValueError as error:
    raise KeyError("chained") from error
"""
    (tmp_path / "sub" / "case.py").write_text(script, encoding="utf-8")
    for arguments in (["exit"], ["word", "--own", "2"], ["syntax"], ["chain"]):
        plain = subprocess.run(
            [sys.executable, "sub/case.py", *arguments],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        command = [sys.executable, "-m", "fivebar", "run", "sub/case.py", *arguments]
        ours = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        messages = "".join(
            line for line in ours.stderr.splitlines(True) if not line.startswith("fivebar run: ")
        )
        assert (ours.stdout, messages, ours.returncode) == (
            plain.stdout,
            plain.stderr,
            plain.returncode,
        )


@pytest.mark.deep
def test_options_stand_anywhere_and_the_rest_is_the_scripts(tmp_path):
    script = "import sys\nprint(sys.argv[1:])\n"
    done = run(tmp_path, script, "a", "--until", 2, "--gain", 3, "b", "--", "--until", 4)
    assert done.stdout == "['a', '--gain', '3', 'b', '--until', '4']\n"


@pytest.mark.deep
def test_nothing_is_shadowed_outside(tmp_path):
    for name in ("lab_amoro", "rclpy"):
        code = f"import fivebar.cli.script, fivebar.amoro, {name}"
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
        )
        assert f"No module named '{name}'" in done.stderr
    (tmp_path / "rclpy.py").write_text("raise RuntimeError('a real one')", encoding="utf-8")
    assert "nothing moved" in run(tmp_path, START).stderr
