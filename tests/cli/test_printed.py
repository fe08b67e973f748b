"""The lines that commands print of results, of results that are made up."""

from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import certify, design, draw


def test_the_table_of_a_drawing(capsys):
    figures = {
        "middle": (0.01, 0.12),
        "lower_bound_s": 2.0,
        "duration_s": 2.02,
        "drawn_m": 0.25,
        "strokes": 3,
        "page": None,
        "working": [-1, 1],
        "smallest_margin": 0.25,
        "certified": False,
        "max_error_m": 2.5e-5,
        "backlash_error_m": 1e-4,
        "period_s": 0.004,
        "peak_acceleration": 1.5,
        "peak_torque_Nm": [0.0125, 0.02],
        "lines": 40,
        "lines_per_s": 20.0,
        "speed_error": 0.005,
    }
    for asked, words in ((None, "within 1 % of the least possible"), (2.02, "the least is 2 s")):
        arguments = SimpleNamespace(duration=asked)
        draw._print(arguments, fb.Machine(fb.FiveBar()), figures)
        rows = dict(line.strip().split("  ", 1) for line in capsys.readouterr().out.splitlines())
        rows = {name: text.strip() for name, text in rows.items()}
        assert words in rows["time"]
        assert rows["drawn"] == "250 mm in 3 strokes" and rows["middle of it"] == "(10, 120) mm"
        assert rows["working modes"] == "-1, +1" and rows["certified"] == "no"
        assert rows["peak torque"] == "12.500, 20.000 mN m"
        assert rows["tracker's period"] == "4 ms, for 1.5 m/s²"
        assert rows["largest error"] == "25.00 µm" and "100.00 µm more" in rows["of backlash"]
        assert rows["G-code"] == "40 lines, at most 20 a second" and "0.5 %" in rows["speeds in it"]


def test_stretches_that_are_not_proved(capsys):
    stretch = dict(start=0.0, stop=0.1, at=0.05, lengths={"l11": 0.09}, why="because")
    unproved = [SimpleNamespace(false=is_false, **stretch) for is_false in (False, True)]
    certify._print(SimpleNamespace(proved=False, unproved=unproved))
    assert capsys.readouterr().out.splitlines() == [
        "from s = 0 to 0.1 m: not proved: because",
        "from s = 0 to 0.1 m: false at s = 0.05 m for l11 = 0.09: because",
    ]


def test_the_modes_of_a_claim():
    robot = {"l11": 0.09}
    claim = dict(robot=robot, tolerances={}, working=[-1, -1], margin=0.0)
    words = "l11 = 0.09 +- 0 m, working [-1, -1], assembly {}, margin 0"
    for assembly, mode in ((1, "1"), (-1, "-1"), (0, "none")):  # 0: no point is reached
        assert certify._claim(claim | {"assembly": assembly}) == words.format(mode)


def test_the_table_of_a_front(capsys):
    binding = ["l11 is at its bound", "reach is at its limit"]
    designs = [
        SimpleNamespace(parameters={"l11": 0.1}, values={"bars": 0.5}, binding=binding),
        SimpleNamespace(parameters={"l11": 0.2}, values={"bars": 0.75}, binding=[]),
    ]
    design._print_front(designs)
    assert capsys.readouterr().out.splitlines() == [
        "l11  bars  active constraints",
        "0.1   0.5          l11; reach",
        "0.2  0.75             nothing",
    ]


@pytest.mark.parametrize("leaves", (None, 0.25))
def test_where_a_path_meets_a_singularity(leaves):
    path = fb.path([(0.0, 0.1), (1.0, 0.1)])
    check = SimpleNamespace(everywhere=False, leaves=leaves, time=0.25, type=2)
    machine = fb.Machine(fb.FiveBar(), frame=fb.Placement((0.1, 0.0)))
    what = "meets Type 2" if leaves is None else "leaves the workspace"
    words = f"it {what} at (350, 100) mm in the measuring frame, 250 mm along it"
    assert draw._met(machine, path, check) == words
    assert np.isclose(path.drawn(0.25)[0], (0.25, 0.1)).all()
