"""Pieces of the runtime by themselves: marks, the confined lab, clocks, windows and words."""

import io
import json
import random
import sys
import time
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

import fivebar as fb
from fivebar.amoro.ros_free import (
    _confined,
    child,
    clock,
    figures,
    lenient,
    names,
    outputs,
    parallel_robot,
    plot_tools,
    rclpy,
    report,
    tracking,
)
from fivebar.amoro.ros_free import world as place
from fivebar.amoro.ros_free.marking import MarkedRobot, confined_program
from tests.helpers import ROOT


@pytest.mark.parametrize("kind, task", [("five_bar", "1"), ("five_bar", "2"), ("biglide", "1")])
def test_a_task_is_the_labs_line(kind, task):
    start, goal, duration = tracking.TASKS[kind][task]
    line = fb.line(start, goal, duration)
    t = np.linspace(-0.5, duration + 0.5, 41)
    expected = [line(min(max(each, 0.0), duration))[0] for each in t]
    np.testing.assert_allclose(tracking.reference((start, goal, duration), t), expected, atol=1e-12)


def moved(late, off, duration=2.2):
    """A motion along task 1 that begins some samples late, and lies beside it, at right angles."""
    t = np.arange(0, duration, clock.STEP)
    start, goal, _ = line = tracking.TASKS["five_bar"]["1"]
    xi = tracking.reference(line, t - late * clock.STEP)
    x, y = np.subtract(goal, start) / np.linalg.norm(np.subtract(goal, start))
    return SimpleNamespace(t=t, xi=xi + off * np.array([-y, x]))


@pytest.mark.parametrize(
    "off, points", [(0.0, 20.0), (1e-3, 20.0), (np.sqrt(20) * 1e-3, 10.0), (20e-3, 0.0), (1.0, 0.0)]
)
def test_points_are_by_the_logarithm_of_the_largest_error(off, points):
    for late in (0, tracking.MOST_LATE):
        marks = tracking.tracking("1", "five_bar", moved(late, off))
        assert marks["points"] == pytest.approx(points) and marks["of"] == 20
        for name in ("largest_error_m", "rms_error_m", "error_at_the_end_m"):
            assert marks[name] == pytest.approx(off, abs=1e-12)
    late = tracking.tracking("1", "five_bar", moved(tracking.MOST_LATE + 3, 0.0))
    assert late["largest_error_m"] > 1e-3 > late["error_at_the_end_m"]
    words = tracking.words(marks | {"largest_error_m": 2e-3, "rms_error_m": 1e-3})
    assert words.startswith("control task 1: errors at most 2 mm, RMS 1 mm, at the end ")
    assert f" mm: {marks['points']:g} of 20 points (1 mm or less is worth all, 20 mm none" in words


def test_what_cannot_be_marked_is_said():
    for task, kind, run, message in (
        ("1", "five_bar", None, "the robot did not move"),
        ("2", "biglide", moved(0, 0.0), "the biglide has no control task 2"),
        ("1", "five_bar", moved(0, 0.0, 2.03), r"the motion ends at 2.02 s, before the 2 s"),
    ):
        with pytest.raises(ValueError, match=message):
            tracking.tracking(task, kind, run)
    tracking.tracking("1", "five_bar", moved(0, 0.0, 2.055))


def test_a_marked_robot_moves_by_what_is_asked_of_it():
    robot = MarkedRobot(0.03)
    assert robot.answer([1, 0.0, 0.0]) is None  # none is made
    (home,) = robot.answer([0, 0, 0])
    pose = fb.dgm(fb.FiveBar(), (0.0, 0.0))
    assert home[:2] == [0.0, 0.0] and home[12:14] == pytest.approx(pose.xi.tolist())
    assert home[18:] == [0.0, 0.0]
    for efforts in ((0.01, -0.02), (0.02, 0.0)):
        (state,) = robot.answer([1, *efforts])
        assert state[18:] == list(efforts)
    assert state[0] != 0.0 and robot.run().tau[-1] == pytest.approx((0.02, 0.0))
    (reset,) = robot.answer([2, 0, 0])
    assert reset[:2] == [0.0, 0.0]
    assert robot.answer([1, 0.0, 0.0]) is not None and robot.answer([1, 0.0, 0.0]) is None
    assert not robot.trouble
    marks, why = robot.tracking("1")
    assert marks is None and why.startswith("the motion ends at ")
    for wrong in ([0, 5, 0], [0, 0, 0], [1]):
        assert robot.answer(wrong) is None
    first = robot.trouble
    assert first and MarkedRobot(1.0).tracking("1")[0] is None
    biglide = MarkedRobot(1.0)
    biglide.answer([0, 1, 0])
    assert biglide.tracking("9")[1] == "the robot did not move"


@pytest.fixture
def confined(monkeypatch):
    """Runs a script as the confined process does, on a robot that is simulated for so long."""
    program, modules = confined_program()
    assert "def run(source, name, arguments, beside)" in program
    for name in ("lab_amoro", "lab_amoro.parallel_robot", "lab_amoro.plot_tools", "__main__"):
        monkeypatch.setitem(sys.modules, name, sys.modules.get(name))
    for name in ("matplotlib", "matplotlib.pyplot", "pyqtgraph", "pyqtgraph.Qt"):
        monkeypatch.setitem(sys.modules, name, sys.modules.get(name))
    monkeypatch.syspath_prepend(ROOT / "fivebar" / "grading" / "worker" / "cell")
    for name in sorted(modules, key=lambda name: name != "_lab_world"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setitem(sys.modules, "rclpy", ModuleType("rclpy"))
    monkeypatch.setattr(sys, "argv", [])

    def run(source, until=0.05, arguments=()):
        robot = MarkedRobot(until)
        for name, text in sorted(modules.items(), key=lambda each: "parallel" in each[0]):
            exec(compile(text, name, "exec"), vars(sys.modules[name]))
        monkeypatch.setattr(_confined, "lab", lambda *row: robot.answer(list(row)))
        return _confined.run(source, "mine.py", list(arguments), []), robot

    return run


SCRIPT = """import sys, time
import matplotlib.pyplot as plt
from lab_amoro.parallel_robot import *
from lab_amoro.plot_tools import *
rclpy.init(args=None)
robot = Robot(sys.argv[1])
start_robot(robot)
figure, axes = plt.subplots(2)
axes[0].plot([1, 2])
begin = time.time()
while True:
    if robot.data_updated():
        time.sleep(0.5)
        robot.apply_efforts(0.01, -0.02)
        slept = time.time() - begin
        if len(sys.argv) > 2 and slept > 1.4:
            raise ValueError(f"{sys.argv[2]} {slept:.3f}")
"""


def test_a_confined_script_has_the_lab_and_nothing_else(confined):
    before = time.time, time.sleep
    for kind in ("five_bar", "biglide"):
        ended, robot = confined(SCRIPT, arguments=[kind])
        run = robot.run()
        assert ended == 0.0 and not robot.trouble and robot.world.kind == kind
        assert run.t[-1] == pytest.approx(0.05)
        np.testing.assert_allclose(run.tau[1:], [(0.01, -0.02)] * (len(run.tau) - 1))
    assert (time.time, time.sleep) == before
    # Each step takes 10 ms and what was slept: 1.53 s after the third.
    ended, robot = confined(SCRIPT, arguments=["five_bar", "boom"])
    assert ended == "line 17: ValueError: boom 1.530" and robot.run().t[-1] == pytest.approx(0.03)
    ended, _ = confined(SCRIPT, arguments=["delta"])
    assert ended.startswith("line 6: ValueError: Robot('delta'): the known ones are five_bar, ")
    assert confined("raise SystemExit(3)")[0] == 0.0
    told = confined("raise ValueError(__name__ + __file__)\n")[0]
    assert told == "line 1: ValueError: __main__mine.py"
    assert confined("1 / 0\n")[0] == "line 1: ZeroDivisionError: division by zero"
    assert confined("raise KeyError\n")[0] == "line 1: KeyError"


def test_a_confined_script_that_waits_for_ever_ends(confined):
    text = SCRIPT.replace("        robot.apply_efforts(0.01, -0.02)\n", "")
    ended, robot = confined(text, arguments=["five_bar"])
    assert ended == 0.0 and robot.run() is None


def test_a_real_step_ends_when_its_time_is_over(monkeypatch):
    now, slept = [5.0], []
    monkeypatch.setattr(clock, "real_monotonic", lambda: now[0])
    monkeypatch.setattr(clock, "real_sleep", slept.append)
    real = clock.RealClock()
    # The second step is early, the third late by less than a step, the fourth by far.
    for t, wait in ((5.0, 0.01), (5.012, 0.008), (5.035, 0.0), (6.0, 0.0), (6.001, 0.0)):
        now[0] = t
        slept.clear()
        real.tick()
        assert sum(slept) == pytest.approx(wait, abs=1e-12)
    assert real.due == pytest.approx(6.0)


def test_a_script_sleeps_on_its_own_clock():
    simulated = clock.SimulatedClock()
    for seconds in (0.25, 0.0, 1.5):
        simulated.sleep(seconds)
    simulated.tick()
    assert simulated.elapsed() == 1_760_000_000
    with pytest.raises(ValueError, match="sleep length must be non-negative"):
        simulated.sleep(-1e-9)


def test_a_window_is_written_when_it_closes(tmp_path, monkeypatch):
    monkeypatch.setattr(outputs, "folder", tmp_path)
    monkeypatch.setattr(outputs, "start", tmp_path)
    monkeypatch.setattr(outputs, "stem", "mine")
    monkeypatch.setattr(outputs, "written", [])
    monkeypatch.setattr(figures, "shown", 2)
    canvas = figures.FigureCanvas(Figure())
    closed = []
    canvas.mpl_connect("close_event", closed.append)
    manager = figures.FigureManager(canvas, 1)
    manager.destroy()  # it was never shown
    assert not closed and not outputs.written
    for _ in range(2):
        manager.show()
        manager.destroy()
    assert outputs.written == ["mine_figure_3.png", "mine_figure_4.png"]
    assert (tmp_path / "mine_figure_3.png").read_bytes()[1:4] == b"PNG"
    assert [event.name for event in closed] == ["close_event"] * 2
    assert all(event.canvas is canvas for event in closed)


def test_timers_run_on_the_scripts_clock(monkeypatch):
    now, calls = [10.0], []
    monkeypatch.setattr(
        figures,
        "time",
        SimpleNamespace(
            monotonic=lambda: now[0], sleep=lambda seconds: now.__setitem__(0, now[0] + seconds)
        ),
    )
    monkeypatch.setattr(figures, "timers", {})
    monkeypatch.setattr(place, "world", SimpleNamespace(steps=0), raising=False)
    often, once = figures.Timer(interval=20), figures.Timer(interval=50)
    often.add_callback(lambda: calls.append(("often", round(now[0], 9))) or True)
    once.add_callback(lambda: calls.append(("once", round(now[0], 9))))
    once.single_shot = True
    often.start()
    once.start()
    figures._run_timers(10.07)
    assert calls == [("often", 10.02), ("often", 10.04), ("once", 10.05), ("often", 10.06)]
    assert now[0] == pytest.approx(10.07) and list(figures.timers) == [often]
    # Nobody looks for ever: it ends after so many frames in which the robot rests.
    monkeypatch.setattr(figures, "MOST_FRAMES", 7)
    calls.clear()
    figures._run_timers(np.inf)
    assert len(calls) == 7
    # Frames in which the robot moves are not counted.
    calls.clear()

    def step():
        place.world.steps += len(calls) < 20
        return True

    often.add_callback(step)
    figures._run_timers(np.inf)
    assert len(calls) == 26
    often.add_callback(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        figures._run_timers(np.inf)
    assert not figures.timers


def about(**more):
    usual = {"robot": "five_bar", "simulated_s": 2.0, "wall_s": 0.5, "real_time_factor": 4.0}
    usual |= {"interrupted": False, "resets_at_s": [], "scopes": [], "files": ["a.csv"]}
    return usual | {"recorded_after_reset": False} | more


def test_the_words_of_a_run(capsys):
    report.print_words(about(robot=None, simulated_s=0.0))
    report.print_words(about(simulated_s=0.0, files=[]))
    moved = {"start_xi_m": (0.09, 0.068), "end_xi_m": (0.0, 0.1), "resets_at_s": [0.5, 1.0]}
    moved |= {"singularity_crossings": [(1.25, 2, "det_A")], "interrupted": True}
    scope = {"title": "x", "largest_difference": 2e-3, "rms_difference": 1e-3}
    report.print_words(about(**moved, scopes=[scope]))
    report.print_words(about(**moved | {"recorded_after_reset": True}))
    printed = capsys.readouterr()
    lines = [line.removeprefix("fivebar run: ") for line in printed.err.splitlines()]
    assert not printed.out and lines[:11] == [
        "the script made no Robot",
        "wrote a.csv",
        "five_bar: nothing moved, as apply_efforts was not called",
        "five_bar: from (0.090000, 0.068000) m to (0.000000, 0.100000) m",
        "reset at 1 s: said and recorded is what was before it",
        "singularity: Type 2 (det_A = 0) crossed at 1.250000 s",
        "scope 'x': curves at most 0.002 apart, RMS 0.001",
        "2 s simulated (then its KeyboardInterrupt, --until) in 0.50 s, 4 x real time",
        "wrote a.csv",
        lines[3],
        "reset at 1 s: said and recorded is what was after it",
    ]


def test_a_run_as_json_has_null_for_what_is_no_number():
    scopes = [
        {"title": "x", "largest_difference": 2e-3, "rms_difference": 1e-3},
        {"title": "y", "largest_difference": float("nan"), "rms_difference": float("inf")},
    ]
    stream = io.StringIO()
    report.print_json(about(scopes=scopes), stream)
    nothing = {"title": "y", "largest_difference": None, "rms_difference": None}
    assert json.loads(stream.getvalue()) == about(scopes=[scopes[0], nothing])


def test_scopes_are_drawn_and_measured(monkeypatch):
    monkeypatch.setattr(plot_tools, "scopes", [])
    monkeypatch.setattr(report, "scopes", plot_tools.scopes)
    for k in range(6):
        scope = plot_tools.Scope(f"s{k}", -1.0, np.inf if k else 1.0)
        for t in range(0 if k == 5 else 4):
            scope.update(t, np.array([0.1 * t]), 0.1 * t + 0.02 * (k + 1) * (t == 3))
    assert [scope.title for scope in report.drawn()] == [f"s{k}" for k in range(5)]
    found = [report._difference(scope) for scope in report.drawn()]
    for k, each in enumerate(found):
        assert each["largest_difference"] == pytest.approx(0.02 * (k + 1))
        assert each["rms_difference"] == pytest.approx(0.01 * (k + 1))
    figure = report.draw_scopes(Figure)
    assert len(figure.axes) == 5 and figure.get_size_inches() == pytest.approx((15.8, 4.9))
    first = figure.axes[0]
    assert first.get_title() == "s0 (at most 0.02 apart)"
    (one, two) = first.lines
    assert one.get_ydata() == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert two.get_ydata()[-1] == pytest.approx(0.32) and two.get_linestyle() == "--"
    first.autoscale_view()
    assert first.get_ylim()[0] <= -1.0 and first.get_ylim()[1] >= 1.0
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels == ["", "time (s)", "time (s)", "time (s)", "time (s)"]
    with pytest.raises(TypeError, match="Scope 's0': update needs three numbers"):
        plot_tools.scopes[0].update(1.0, [1, 2], 3.0)
    application = plot_tools.QtGui.QApplication([])
    assert application.exec_() == 0 and application.processEvents() is None


def test_the_labs_names_are_put_in_place(monkeypatch):
    for name in ("lab_amoro", *names.OFFERED):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    names.install()
    package = sys.modules["lab_amoro"]
    for name, module in names.OFFERED.items():
        stand_in = sys.modules[name]
        assert stand_in.__name__ == name and stand_in.__all__ == list(module.__all__)
        for each in set(module.__all__) - {"rclpy"}:
            assert getattr(stand_in, each) is getattr(module, each)
        with pytest.raises(AttributeError, match=f"fivebar run has no {name}.nothing"):
            stand_in.nothing  # noqa: B018
        if name != "rclpy":
            assert getattr(package, name.removeprefix("lab_amoro.")) is stand_in
    assert package.parallel_robot.rclpy is sys.modules["rclpy"]
    for name in ("rclpy.node", "lab_amoro.other", "std_msgs", "tf2_ros", "PyQt5"):
        with pytest.raises(ModuleNotFoundError, match=f"fivebar run has no '{name}'"):
            names.Refusals().find_spec(name)
    assert names.Refusals().find_spec("launchpad") is None
    assert names.KeepBackend().find_spec("json") is None


OPTIONS = {"real_time": False, "until": 1.0, "exact_acceleration": True, "lenient": False}


@pytest.fixture
def session(tmp_path, monkeypatch):
    """A script's session in this process, whose world is put back afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(place, "world", None, raising=False)
    monkeypatch.setattr(sys, "argv", [])
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setitem(sys.modules, "__main__", None)

    def make(source, *rest, **options):
        (tmp_path / "mine.py").write_text(source, encoding="utf-8")
        return child.Session(OPTIONS | options, "mine.py", list(rest), None)

    return make


@pytest.mark.parametrize(
    "source, code, said",
    [
        ("pass", 0, ""),
        ("raise SystemExit", 0, ""),
        ("raise SystemExit(0)", 0, ""),
        ("raise SystemExit(3)", 3, ""),
        ("raise SystemExit('too late')", 1, "too late\n"),
        ("1 / 0", 1, "line 1, in <module>\n    1 / 0\n"),
        ("import sys\nraise ValueError(sys.argv[1], __name__)", 1, "('own', '__main__')"),
        ("raise KeyboardInterrupt", 130, "KeyboardInterrupt"),
        (
            "import numpy as np\nx = np.float(1)",
            1,
            "fivebar run: at mine.py, line 2: x = np.float(1)",
        ),
        ("import numpy as np\nx = np.float(1)", 1, "mend: write float (or run with --lenient"),
    ],
)
def test_how_a_script_ends_is_the_code_of_its_session(source, code, said, session, capsys):
    assert session(source, "own")._script() == code
    printed = capsys.readouterr().err
    assert said in printed if said else not printed
    assert "ros_free" not in printed and (sys.argv == ["mine.py", "own"])


def test_a_session_has_the_world_of_its_options(session, monkeypatch, capsys):
    made = session("raise KeyboardInterrupt", until=0.25)
    assert place.world is made.world and made.world.until == 25 and made.world.exact is True
    assert isinstance(made.world.clock, clock.SimulatedClock)
    made.world.interrupted = True  # by the runtime: the script may leave it to Python
    assert made._script() == 0 and capsys.readouterr().err == ""
    real = session(
        "import fivebar.amoro.ros_free.world as w\nraise w.Stopped('slow')", real_time=True
    )
    assert isinstance(real.world.clock, clock.RealClock) and real._script() == 1
    ended, where = capsys.readouterr().err.splitlines()
    assert ended == "fivebar run: ended: slow" and where.endswith("line 2: raise w.Stopped('slow')")
    # An older NumPy's reading of it is asked for by `lenient` alone.
    older = compile("raise SystemExit(9)", "mine.py", "exec")
    monkeypatch.setattr(child.old_numpy, "compiled", lambda source, file: older)
    assert session("pass", lenient=True)._script() == 9 and session("pass")._script() == 0


def test_the_names_and_numbers_of_a_script(tmp_path, monkeypatch, capsys):
    installed = []
    monkeypatch.setattr(names, "install", lambda: installed.append("names"))
    monkeypatch.setattr(lenient, "install", lambda: installed.append("lenient"))
    monkeypatch.setattr(sys, "meta_path", list(sys.meta_path))
    monkeypatch.setattr(outputs, "start", tmp_path)
    monkeypatch.setattr(outputs, "folder", None)
    monkeypatch.setattr(outputs, "stem", None)
    state = random.getstate(), np.random.get_state()
    drawn = []
    options = {"plots": "windows", "show": False, "seed": 7, "lenient": True}
    for more in ({}, {"show": True, "lenient": False}):
        child.with_names(options | more, "folder/mine.py")
        drawn.append((random.random(), np.random.random()))
    random.setstate(state[0])
    np.random.set_state(state[1])
    assert drawn == [(random.Random(7).random(), np.random.RandomState(7).random())] * 2
    assert (outputs.folder, outputs.stem) == (tmp_path / "windows", "mine")
    assert installed == ["names", "lenient", "names"]
    assert isinstance(sys.meta_path[0], names.KeepBackend)
    assert not isinstance(sys.meta_path[1], names.KeepBackend)
    said = "fivebar run: lenient: arrays of one element pass for numbers, as they did in an older NumPy"
    assert capsys.readouterr().err.splitlines() == [said]


def test_a_robot_before_ros_is_refused(monkeypatch):
    monkeypatch.setattr(rclpy, "_initialised", False)
    with pytest.raises(RuntimeError, match=r"Robot\('biglide'\)"):
        parallel_robot.Robot("biglide")
