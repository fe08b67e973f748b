"""What the options of a command are to the function that does its work."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.cli.draw_place import page_row

MM = 1e-3
DEG = np.pi / 180


class Reached(Exception):
    """The function that does the work was called."""


# Words of a command, its function, and what is given to it by name or, with a number, by place.
CASES = [
    (
        "design bars reach=max --bound l11=0.08:0.1 --bound l21=90mm --limit bars=:0.5"
        " --limit reach=0.3 --step-mm 5 --points 7 --seed 3 --effort 0.5 --disc 0.02",
        "optimal_design.optimum.design",
        {
            0: {"bars": None, "reach": "max"},
            1: {"l11": (0.08, 0.1), "l21": 0.09},
            "limits": {"bars": (None, 0.5), "reach": 0.3},
            "step": 5 * MM,
            "points": 7,
            "seed": 3,
            "effort": 0.5,
            "disc": 0.02,
            "executor": None,
        },
    ),
    (
        "design bars --bound l11=0.08:0.1 --disc 0.01 0.1 0.02 --motor 0.5 60rpm --table 0.1 0.05"
        " --tolerance q=1deg d=0.1mm --stiffness 20 --det-A 0.2 --sin 0.1 --margin 2mm"
        " --poses 5 6 --working 1 -1",
        "optimal_design.optimum.design",
        {
            "disc": [0.01, 0.1, 0.02],
            "motor": pytest.approx([0.5, 2 * np.pi]),
            "table": [0.1, 0.05],
            "tolerances": pytest.approx({"q": DEG, "d": 0.1 * MM}),
            "stiffness": 20.0,
            "det_A": 0.2,
            "sin": 0.1,
            "margin": 2 * MM,
            "poses": [5, 6],
            "working": [1, -1],
        },
    ),
    (
        "sweep bars=max reach --grid l11=0.08:0.1:3 l21=0.09 --workers 2 --out folder",
        "optimal_design.sweeping.sweep",
        {0: ["bars", "reach"], 2: None, "workers": 2, "robot": fb.FiveBar()},
    ),
    (
        "calibrate data.csv --unknown l11 offset1,x0 --start l11=91mm x0=0.1 --sigma 0.1mm"
        " --prior l12=0.3mm offset1=1deg --loss huber --units deg x=mm"
        " --mistakes keep --tool-leg 2 --columns x=East",
        "estimation.calibration.calibrate.calibrate",
        {
            0: fb.FiveBar(),
            1: Path("data.csv"),
            2: ("l11", "offset1", "x0"),
            "tool": fb.Tool(2),
            "start": pytest.approx({"l11": 0.091, "x0": 0.1}),
            "sigma": 0.1 * MM,
            "priors": pytest.approx({"l12": 0.3 * MM, "offset1": DEG}),
            "loss": "huber",
            "units": ["deg", "x=mm"],
            "columns": ["x=East"],
            "mistakes": "keep",
        },
    ),
    (
        "identify data.csv data.csv --validate data.csv --unknown m zz1 --assembly 1 --cutoff 20"
        " --units q1=deg --counts-per-turn 4096 --torque-constant 0.5 0.6",
        "estimation.identification.identify.identify",
        {
            1: [Path("data.csv"), Path("data.csv")],
            "validate": Path("data.csv"),
            "unknown": ["m", "zz1"],
            "assembly": 1,
            "cutoff": 20.0,
            "units": ["q1=deg"],
            "offset": (0.0, 0.0),
            "counts_per_turn": 4096.0,
            "torque_constant": (0.5, 0.6),
        },
    ),
    (
        "certify data.csv --units m --deviation 1mm --working 1 -1 --tolerance 0.1mm d=0.2mm"
        " --margin 0.05",
        "paths.certificates.certify.certify",
        {
            2: {name: 0.1 * MM for name in ("l11", "l12", "l21", "l22")} | {"d": 0.2 * MM},
            3: fb.Constraints(det_A=0.05, sin=0.05),
            4: [1, -1],
        },
    ),
    (
        "plan --from 0.05 0.09 --to 60mm 0.09 --via 0.05 0.08 0.06 0.08 --duration 0.4 --objective"
        " jerk --torque-limit 0.1 --joint-speed-limit 60rpm --acceleration-limit 2 --workspace 0 0.1"
        " 0.05 0.1 --serial-margin 0.1 --parallel-margin 0.2 --max-time 3",
        "planning.plan.plan",
        {
            1: pytest.approx([0.05, 0.09]),
            2: pytest.approx([0.06, 0.09]),
            3: 0.4,
            "objective": "jerk",
            "constraints": fb.Constraints(
                torque=0.1,
                joint_speed=2 * np.pi,
                acceleration=2.0,
                region=[(0.0, 0.05), (0.1, 0.05), (0.1, 0.1), (0.0, 0.1)],
                sin=0.1,
                det_A=0.2,
            ),
        },
    ),
    (
        "linkage four-bar 0.2 0.06 0.16 0.14 --speed 60rpm --turns 2 --drive turn --branch -1"
        " --csv table.csv",
        "cli.linkage.study",
        {"branch": -1, "speed": pytest.approx(2 * np.pi), "turns": 2.0, "drive": "turn"},
    ),
    (
        "export --to c --name mine --functions dgm igm --out mine.h",
        "exporters.export.export",
        {1: "c", "name": "mine", "functions": ["dgm", "igm"]},
    ),
    (
        "export --to reprapfirmware --working 1 -1 --homing-deg 90 80 --steps-per-turn 3200",
        "exporters.export.export",
        {
            1: "reprapfirmware",
            "working": [1, -1],
            "homing_deg": [90.0, 80.0],
            "steps_per_turn": 3200.0,
        },
    ),
    (
        "track --from 0.09 0.068 --to 0.08 0.08 --duration 0.5 --controller mpc --period 0.02"
        " --torque-limit 0.2",
        "control.tracker.Tracker",
        {"period": 0.02, "constraints": fb.Constraints(torque=0.2), "assembly": -1},
    ),
    (
        "track --from 0.09 0.068 --to 0.08 0.08 --duration 0.5 --controller pd --kp 3 --period 0.02",
        "simulation.simulate.simulate",
        {"control_period": 0.02, "step": pytest.approx(MM), "torque_limit": None},
    ),
]


@pytest.mark.parametrize("words, function, expected", CASES)
def test_options_reach_the_function(words, function, expected, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data.csv").write_text("x,y\n0.05,0.09\n0.06,0.09\n", "utf-8")
    given = {}

    def reached(*places, **names):
        given.update(enumerate(places), **names)
        raise Reached

    monkeypatch.setattr(f"fivebar.{function}", reached)
    with pytest.raises(Reached):
        main(words.split())
    for name, value in expected.items():
        found = given[name]
        assert (found.tolist() if isinstance(found, np.ndarray) else found) == value, name


REFUSED = {
    "track --case task-1 --from 0 0.1": "--case brings its own path, robot and controller",
    "track --case task-1 --l11 0.1": "--case brings its own path, robot and controller",
    "track --case task-1 --torque-limit 1e-4": "--case brings its own path, robot and controller",
    "track --case task-1 --units mm": "--case brings its own path, robot and controller",
    "track here.csv --duration 3": "--from, --to and --duration make a line, which goes without",
    "track here.csv --from 0 0.1": "--from, --to and --duration make a line, which goes without",
    "track --from 0 0.1 --to 0 0.11 --duration 1 --units mm": "goes without a CSV file, --units",
    "track --from 0 0.1 --to 0 0.11": "track needs a CSV file, or all of --from",
    "linkage five-bar --motors 3 4 --page page.html --live live.html": "--live moves a five-bar",
    "certify here.csv --out here.csv/a.json": "here.csv: File exists",
    "design bars --plot here.csv/a.png": "here.csv: File exists",
    "export --to c --out here.csv/a.h": "here.csv: File exists",
    "grade lab1 here.csv --csv here.csv/a.csv": "here.csv: File exists",
    "grade lab1 here.csv --gradescope here.csv/a.json": "here.csv: File exists",
    "grade lab1 here.csv --html here.csv/a.html": "here.csv: File exists",
    "linkage four-bar 0.2 0.06 0.16 0.14 --csv here.csv/a.csv": "here.csv: File exists",
    "linkage four-bar 0.2 0.06 0.16 0.14 --plot here.csv/a.png": "here.csv: File exists",
    "map --data here.csv/a.csv": "here.csv: File exists",
    "map --out here.csv/a.png": "here.csv: File exists",
    "play --out here.csv/a.html": "here.csv: File exists",
    "sweep bars --csv here.csv/a.csv": "here.csv: File exists",
    "sweep bars --plot here.csv/a.png": "here.csv: File exists",
    "track here.csv --page here.csv/a.html": "here.csv: File exists",
    "calibrate none.csv": "no file none.csv",
    "calibrate here.csv --from-drawing A5": "it goes without measured data",
    "calibrate --sides 100 50": "give --photo PICTURE",
    "identify here.csv --offset 1 2 3": "--offset takes one number or two, not 3",
    "linkage six-bar-press none": "no press none; the known ones are",
    "run none.py": "no script none.py",
    "run here.csv --until 0": "--until must be finite and > 0, not 0",
    "run here.csv --timeout -1": "--timeout must be finite and > 0, not -1",
    "run here.csv --until 20000": "--until must be finite and from 0 to 10000, not 20000",
    "run here.csv --seed -1": "--seed must be a whole number >= 0, not -1",
    "run here.csv --plot here.csv/a.png": "here.csv: File exists",
    "run here.csv --plot a.txt": "--plot must end in .png, .svg or .pdf, not 'a.txt'",
    "run here.csv --plots none": "--plots none: no such folder",
    "sweep bars": "not none",
    "sweep bars --grid l11=0.1 --triangle 5": "not --grid and --triangle",
    "sweep bars --grid l11=0.1 --bound l21=0.1:0.2": "--bound is of --sample N",
    "sweep bars --triangle 0": "--triangle: its count must be a whole number >= 2, not 0",
    "sweep bars --sample 9": "--sample needs --bound NAME=LOW:HIGH, as --bound l1=0.05:0.2",
    "sweep bars --sample 0 --bound l1=0.1:0.2": "--sample: its count must be a whole number >= 1",
    "sweep bars --sample 9 --bound l1=0.2:0.1": "l1 = (0.2, 0.1) is the wrong way round",
    "sweep bars --grid l1=0.1:0.2:9 --best 0": "--best: its count must be a whole number >= 1",
    "sweep bars --grid l1=.1:.2:100000 l2=.1:.2:100000": "10000000000 designs are 3e+10 numbers,"
    " more than 2e+08 in memory; give --out",
    "design bars": "design needs --bound NAME=LOW:HIGH, as --bound l1=0.05:0.2",
    "draw --example --scale 0": "--scale must be finite and > 0, not 0",
    "draw --example --fit --scale 0": "--fit chooses scale and place: it goes without --scale",
    "draw --example --at 0 0.1 --margin 0": "it goes without --margin",
    "map --torque-limit 0": "it goes with --load FX FY",
    "plan --from 0 0.1 --to 0 0.11 --duration 0": "--duration must be finite and > 0, not 0",
    "track --from 0 0.1 --to 0 0.11 --duration 1 --torque-limit 0": "torque must be finite and",
    "sweep bars --grid l11=0.1:0.2:1.5": "grid: l11's count must be a whole number",
    "sweep bars --grid l11=0.1::3": "--grid: '' is not a number",
    "map --space joint --det-A 0.1": "are of task space only",
    "map --window 0.2 -0.2 0.2 0.1": "finite min < max, not [0.2, -0.2, 0.2, 0.1]",
    "map --window -0.2 0.2 inf 0.1": "finite min < max, not [-0.2, 0.2, inf, 0.1]",
    "map --fits 0.1 -0.1": "--fits takes two sizes > 0",
    "map --load 0 -1": "--load needs the motors' torque",
    "map --torque-limit 0.5": "it goes with --load FX FY",
    "certify": "certify needs a path's file, or --check and a proof",
    "certify --check here.csv --margin 0.1": "--check goes alone",
    "certify --check none.json": "no file none.json",
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_does_not_fit_is_refused_by_name(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "here.csv").write_text("q1,q2,x,y\n0,0,0.09,0.068\n", "utf-8")
    assert main(words.split()) == 2
    printed, said = capsys.readouterr()
    said = re.sub(r"'(none[.\w]*)'", r"\1", said)
    assert said.startswith("fivebar: ") and REFUSED[words] in said
    assert not printed and [path.name for path in tmp_path.iterdir()] == ["here.csv"]


def test_run_starts_the_script_with_its_own_words(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("", "utf-8")

    def reached(command, env, pass_fds):
        assert command[-4:] == ["mine.py", "--own", "x", "--plot"]
        assert '"until": 3.0' in command[-5] and '"exact_acceleration": true' in command[-5]
        assert env["PYTHONHASHSEED"] == "7" and "MPLBACKEND" in env
        raise Reached

    monkeypatch.setattr(subprocess, "Popen", reached)
    words = "run --until 3 mine.py --own x --seed 7 --exact-acceleration -- --plot"
    with pytest.raises(Reached):
        main(words.split())


def test_a_page_is_said_with_its_corner_and_turn():
    corners = fb.Placement((0.02, 0.03), np.pi / 6)(
        np.array([(0, 0), (0.2, 0), (0.2, 0.1), (0, 0.1), (0, 0)])
    )
    words = "its lower left corner at (20, 30) mm, turned by 30°"
    assert page_row(corners) == [("page", words)] and page_row(None) == []
