"""`fivebar sweep` and `fivebar design` as they are typed."""

import json
import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main

GRID = ["--grid", "l1=0.08:0.12:3", "--grid", "l2=0.1:0.14:3"]
TABLE = ["--table", "0.06", "0.04", "--poses", "5", "5"]
BOUNDS = [
    "--bound",
    "l1=0.05:0.2",
    "--bound",
    "l2=0.05:0.2",
    "--bound",
    "d=0.05",
    "--bound",
    "task_y=0.05:0.3",
]


def ran(words, capsys, code=0):
    assert main([str(word) for word in words]) == code
    return capsys.readouterr()


def test_a_sweep_its_folder_and_its_table(tmp_path, capsys):
    words = [
        "sweep",
        "workspace_area",
        "bars",
        *GRID,
        "--out",
        tmp_path / "out",
        "--csv",
        tmp_path / "all.csv",
    ]
    notes = ran([*words, "--plot", tmp_path / "picture.png", "--best", 2], capsys)
    lines = notes.out.splitlines()
    assert lines[0].split() == ["design", "l1", "l2", "workspace_area", "bars"] and len(lines) == 3
    assert lines[1].split()[:3] == ["8", "0.12", "0.14"]
    assert notes.err.split() == [str(tmp_path / name) for name in ("all.csv", "picture.png", "out")]
    again = json.loads(ran([*words, "--json", "--best", 1], capsys).out)
    assert again["designs"] == 9 and again["best"][0]["design"] == 8
    done = fb.optimal_design.Sweep.load(tmp_path / "out")
    assert again["best"][0]["workspace_area"] == done["workspace_area"].max()
    assert ran(["sweep", "bars", *GRID, "--out", tmp_path / "out"], capsys, 2).err.startswith(
        "fivebar: --out: "
    )


def test_the_other_designs_and_choices(tmp_path, capsys):
    file = tmp_path / "own.py"
    file.write_text("def thickest(robot):\n    return robot.l11 / robot.d\n", encoding="utf-8")
    rows = ran(
        ["sweep", f"{file}:thickest", "--sample", 20, "--bound", "d=0.1:0.2", "--best", 1], capsys
    ).out
    assert 0.85 < float(rows.split()[-1]) <= 0.9
    csv = tmp_path / "designs.csv"
    csv.write_text("l1,task_y\n0.1,0.12\n0.1,9\nnan,0.1\n", encoding="utf-8")
    notes = ran(
        ["sweep", "det_A", "worst_tip_error", "--designs", csv, *TABLE, "--tolerance", "q=0.001"],
        capsys,
    )
    assert [line.split()[0] for line in notes.out.splitlines()] == ["design", "0"]
    lines = notes.err.splitlines()
    assert lines[0] == "design 2: l1 must be finite, not nan" and len(lines) == 2
    assert lines[1].startswith(
        "det_A is finite in 1 of 3 designs; table = [-0.03, 0.03, -0.02, 0.02]"
    )
    path = tmp_path / "path.csv"
    path.write_text(
        "t,x,y\n" + "".join(f"{k / 10},{0.002 * k},0.12\n" for k in range(8)), encoding="utf-8"
    )
    words = [
        "sweep",
        "time",
        "worst_torque",
        "--grid",
        "l2=0.1:0.12:2",
        "--motion",
        path,
        "--motor",
        1.0,
        5.0,
    ]
    found = json.loads(ran([*words, "--json", "--working", "1", "-1", "--zz1", 0.003], capsys).out)[
        "best"
    ]
    assert all(0 < each["time"] < 2 for each in found)
    assert "xh430-w350: 3.4 N m" in ran(["sweep", "--list"], capsys).out
    assert "det_A, max" in ran(["design", "--list"], capsys).out
    circle = ran(
        ["sweep", "inscribed_circle", "--grid", "r1=0.7", "--grid", "r2=1.7", "--grid", "r3=0.6"],
        capsys,
    ).out
    assert circle.split()[-1] == "0.7"


@pytest.mark.parametrize(
    "words, notes",
    [
        (["sweep"], "which figure. It goes before the options, .* fivebar sweep --list names them"),
        (["sweep", "bars"], "designs come from one of --grid, --sample, --triangle, --designs"),
        (["sweep", "bars", *GRID, "--triangle", "4"], "from one of .*, not --grid and --triangle"),
        (
            ["sweep", "bars", "--grid", "l1=0.1:0.2"],
            "--grid must be NAME=VALUE or LOW:HIGH:COUNT, not 'l1=0.1:0.2'",
        ),
        (["sweep", "bars", "--grid", "l1=0.1:x:3"], "--grid: 'x' is not a number"),
        (["sweep", "bars", "--grid", "l1=0.1:0.2:2.5"], "grid: l1's count must be a whole number"),
        (["sweep", "bars", "--bound", "l1=0.1:0.2", *GRID], "--bound is of --sample N"),
        (
            ["sweep", "tip_speed", *GRID, *TABLE, "--motor", "big"],
            "motor: no motor 'big'; the known ones are ax-12a, xh430-w350",
        ),
        (
            ["sweep", "numpy.py:f", *GRID],
            "numpy is the name of a module that is in use: give the file another",
        ),
        (
            ["sweep", "no.py:f", *GRID],
            "a figure of your own is FILE.py:FUNCTION, and there is no such file",
        ),
        (
            ["sweep", "bars", *GRID, "--plot", "x.doc"],
            "--plot must end in .png, .svg or .pdf, not 'x.doc'",
        ),
        (
            ["sweep", "bars", *GRID, "--dask", "a:1", "--workers", "2"],
            "--workers are processes here",
        ),
        (["sweep", "bars", *GRID, "--motion", "none.csv"], "none.csv"),
        (["sweep", "bars=min", "bars=max", *GRID], "=min or =max goes with one figure"),
        (["design"], "which goal. It goes before the options"),
        (["sweep", "--motor", "xl430-w250", "path_time", *GRID], "It goes before the options"),
        (["design", "bars", "--bound", "l1"], "--bound must be NAME=VALUE or LOW:HIGH, not 'l1'"),
        (["design", "bars=least", *BOUNDS], "bars is to be"),
        (["design", "bars", *BOUNDS, "--limit", "det_A=0.4"], "limits: det_A needs --table"),
        (["design", "bars", "--bound", "l1=0.2:0.1"], "is the wrong way round"),
    ],
)
def test_wrong_usage(words, notes, capsys):
    error = ran(words, capsys, 2).err
    assert re.search(notes, error), error


def test_a_motion_without_times_is_no_option_away(tmp_path, capsys):
    file = tmp_path / "points.csv"
    file.write_text("x,y\n0,0\n0.01,0\n", encoding="utf-8")
    error = ran(["sweep", "worst_torque", *GRID, "--motion", file], capsys, 2).err
    assert error.endswith("no column t; found 'x', 'y': write these names into its header\n")


def test_a_table_that_is_given_twice_is_the_last_one(capsys):
    words = ["sweep", "det_A", "--grid", "task_y=0.1:0.12:3", "--poses", 5, 5, "--json"]
    once = ran([*words, *TABLE[:3]], capsys).out
    assert ran([*words, "--table", 0.2, 0.2, *TABLE[:3]], capsys).out == once


def test_a_length_on_the_command_line_is_that_of_the_file(tmp_path, capsys):
    """Of a robot from links the masses and inertias follow, here and in a sweep."""
    text = "l12 = 0.16\nl21 = 0.1\nl22 = 0.15\nd = 0.07\n[links]\n11 = 0.12\n12 = 0.08\n"
    for length in (0.11, 0.2):
        file = tmp_path / f"{length}.toml"
        file.write_text(f"l11 = {length}\n{text}", encoding="utf-8")
    motion = tmp_path / "motion.csv"
    rows = [f"{k / 10},{0.002 * k},0.12" for k in range(8)]
    motion.write_text("\n".join(["t,x,y", *rows]), encoding="utf-8")
    words = ["sweep", "worst_torque", "--motion", motion, "--json", "--robot"]
    ways = (
        [tmp_path / "0.2.toml", "--grid", "l11=0.2"],
        [tmp_path / "0.11.toml", "--grid", "l11=0.2"],
        [tmp_path / "0.11.toml", "--l11", "200 mm", "--grid", "l22=0.15"],
    )
    found = []
    for way in ways:
        [best] = json.loads(ran([*words, *way], capsys).out)["best"]
        found.append(best["worst_torque"])
    assert found == pytest.approx([found[0]] * 3, rel=1e-12)


def test_inertias_that_stay_are_said_in_a_plain_line(tmp_path, capsys):
    motion = tmp_path / "motion.csv"
    rows = [f"{k / 10},{0.002 * k},0.12" for k in range(8)]
    motion.write_text("\n".join(["t,x,y", *rows]), encoding="utf-8")
    notes = ran(["sweep", "worst_torque", "--motion", motion, "--grid", "l1=0.1"], capsys)
    [line] = notes.err.splitlines()
    assert line.startswith(
        "fivebar: worst_torque: the robot's masses and inertias stay as they are"
    )


def test_the_best_by_any_of_the_figures_over_places_with_a_unit(capsys):
    over = ["--grid", "task_y=100mm:120mm:3", "l1=80mm:0.12:3"]
    words = ["sweep", "bars", "workspace_area=max", *over, "--json", "--best", 9]
    best = json.loads(ran(words, capsys).out)["best"]
    assert [row["l1"] for row in best] == pytest.approx([0.12] * 3 + [0.1] * 3 + [0.08] * 3)
    assert [row["task_y"] for row in best[:3]] == pytest.approx([0.1, 0.11, 0.12])
    areas = [row["workspace_area"] for row in best]
    assert areas == sorted(areas, reverse=True)


def test_a_task_that_no_design_does(tmp_path, capsys):
    """Between the motors, where a table without a place lies: a singularity is in it."""
    table = ["--table", 0.1, 0.1, "--poses", 5, 5]
    words = ["sweep", "det_A", "reach", *GRID, *table, "--plot", tmp_path / "a.png"]
    notes = ran(words, capsys)
    assert notes.out.split() == ["design", "l1", "l2", "det_A", "reach"]
    why = "det_A is finite in none of 9 designs; table = [-0.05, 0.05, -0.05, 0.05] m"
    assert f"\n{why} is out of reach, or a singularity is in it: task_x and task_y" in notes.err
    best = json.loads(ran(["sweep", "reach", "det_A", *GRID, *table, "--json"], capsys).out)["best"]
    assert len(best) == 9 and best[0]["reach"] > 0 and best[0]["det_A"] is None
    nothing = ran(["sweep", "det_A", *GRID, *table, "--plot", tmp_path / "b.png"], capsys, 1).err
    assert nothing.startswith(f"fivebar: there is nothing to draw: {why}")


@pytest.mark.deep
def test_a_design_and_a_front(tmp_path, capsys):
    words = [
        "design",
        "bars",
        *BOUNDS,
        *TABLE,
        "--limit",
        "det_A=0.5",
        "--step-mm",
        1,
        "--effort",
        0.2,
    ]
    text = ran([*words, "--out", tmp_path / "one"], capsys).out
    assert "det_A = 0.5" in text and "no robot within the bounds passes bars = 0.2" in text
    robot = json.loads((tmp_path / "one" / "robot.json").read_text("utf-8"))
    assert robot["l11"] == robot["l21"] == round(robot["l11"], 3) and robot["d"] == 0.05
    # The file is a robot to every command.
    csv = ["sweep", "bars", "--robot", tmp_path / "one" / "robot.json", "--grid", "m=0.5", "--json"]
    assert json.loads(ran(csv, capsys).out)["best"][0]["bars"] == pytest.approx(
        2 * (robot["l11"] + robot["l12"])
    )
    words = [
        "design",
        "bars",
        "global_conditioning=max",
        *BOUNDS,
        *TABLE,
        "--points",
        4,
        "--effort",
        0.2,
    ]
    notes = ran([*words, "--out", tmp_path / "front", "--plot", tmp_path / "front.svg"], capsys)
    assert (
        notes.out.splitlines()[0].split()[-2:] == ["active", "constraints"]
        and len(notes.out.splitlines()) > 2
    )
    front = fb.optimal_design.Front.load(tmp_path / "front")
    assert (np.diff(front["bars"]) > 0).all() and (tmp_path / "front.svg").stat().st_size > 10_000
    found = json.loads(ran([*words, "--json"], capsys).out)
    assert [each["values"] for each in found] == [dict(each.values) for each in front.designs]
    nothing = ran(["design", "bars", *BOUNDS, "--table", 2, 2, "--effort", 0.1], capsys, 1)
    assert "nothing within the bounds was found that keeps the limits" in nothing.err
