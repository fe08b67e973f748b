"""What commands make of a robot's file: frames, tools, modes that are singular everywhere."""

import json
import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main

FRAME = fb.Placement((0.3, 0.1), 0.4)
TOOL = fb.Tool(1, 0.015, -0.01)


@pytest.fixture
def robot_file(tmp_path):
    """Return a maker of a robot file out of the rest of a Machine."""

    def make(robot=None, **rest):
        path = tmp_path / "robot.toml"
        fb.Machine(robot or fb.FiveBar(), **rest).save(path)
        return str(path)

    return make


def table_of(tmp_path, name, columns):
    rows = np.column_stack([*columns.values()]).tolist()
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows)]
    (tmp_path / name).write_text("\n".join(lines), "utf-8")
    return str(tmp_path / name)


def test_commands_name_modes_that_are_singular_everywhere(robot_file, tmp_path, capsys):
    robot = fb.FiveBar(0.1, 0.12, 0.1, 0.12, d=0.0)
    line = table_of(tmp_path, "line.csv", {"x": [0.05, 0.06], "y": [0.1, 0.1]})
    ends = "--from 0.05 0.1 --to 0.06 0.1 --duration 1".split()
    for words in (["track", *ends], ["plan", *ends], ["certify", line, "--units", "m"]):
        assert main([*words, "--robot", robot_file(robot), "--working", "1", "1"]) in (1, 2)
        assert (
            f"{words[0]}: in these modes the robot is singular everywhere"
            in capsys.readouterr().err
        )


def test_a_half_plane_and_the_point_beyond_it_are_in_the_measuring_frame(
    robot_file, tmp_path, capsys
):
    # Of joint C, in the measuring frame: x >= 0.36 m, which in the robot's own frame is oblique.
    own = FRAME.inverse([(0.36, 0.0), (1.36, 0.0)])
    a, b = own[1] - own[0]
    limits = fb.Constraints(half_planes=[(a, b, own[0] @ (a, b))])
    points = FRAME(np.array([(0.04, 0.09), (0.06, 0.09)]))
    x, y = points.T
    line = table_of(tmp_path, "line.csv", {"x": x, "y": y})
    words = ["draw", line, "--units", "m", "--as-drawn", "--out", str(tmp_path / "out")]
    file = robot_file(frame=FRAME, constraints=limits)
    assert main([*words, "--working", "-1", "-1", "--robot", file]) == 1
    said = capsys.readouterr().err
    plane, by, at = re.search(
        r"constraint (.*), which is violated by (\S+) m at \((\S+),", said
    ).groups()
    assert plane == "1 x + 0 y >= 0.36 m" and said.rstrip().endswith("mm in the measuring frame")
    assert 1e-3 * float(at) == pytest.approx(min(x), abs=1e-4)
    assert float(by) == pytest.approx(0.36 - min(x), abs=1e-5)


@pytest.mark.deep
def test_a_map_checks_the_path_of_a_tool_in_the_measuring_frame(robot_file, tmp_path, capsys):
    machine = fb.Machine(fb.FiveBar(), frame=FRAME, tool=TOOL)
    t = np.linspace(0, 1, 9)
    places = FRAME(np.column_stack([0.02 + 0.03 * t, 0.1 + 0.02 * t * t]))
    path = table_of(tmp_path, "path.csv", {"t": t, "x": places[:, 0], "y": places[:, 1]})
    names = {name: str(tmp_path / f"{name}.png") for name in ("out", "graph")}
    words = [
        "map",
        "--nodes",
        "5",
        "--path",
        path,
        "--out",
        names["out"],
        "--graph",
        names["graph"],
    ]
    file = robot_file(frame=FRAME, tool=TOOL)
    assert main([*words, "--json", "--robot", file]) == 0
    printed = capsys.readouterr()
    assert "of the aspects of joint C, without the tool" in printed.err
    for row in json.loads(printed.out)["path"]:
        pose = TOOL.pose(machine.robot, FRAME.inverse(places), row["working"], unreachable="nan")
        reached = np.isfinite(pose.q).all()
        assert row["reachable"] == reached
        if row["singularity_free"]:
            least = np.abs([*pose.sines, pose.det_A]).min()
            assert row["min_margin"] == pytest.approx(least, abs=0.02)


@pytest.mark.deep
def test_files_in_the_robots_own_frame_are_named(robot_file, tmp_path, capsys):
    machine = fb.Machine(fb.FiveBar(), frame=FRAME)
    (x, y), (u, v) = FRAME(np.array([(0.05, 0.09), (0.06, 0.09)])).tolist()
    words = f"track --from {x} {y} --to {u} {v} --duration 0.1 --out {tmp_path / 'out'}".split()
    for choice, is_named in ((), True), (("--frame", "robot"), False):
        if not is_named:
            words[2:4], words[5:7] = ("0.05", "0.09"), ("0.06", "0.09")
        assert main([*words, "--robot", robot_file(frame=FRAME), *choice]) == 0
        assert ("robot's own frame    " in capsys.readouterr().out) == is_named
        run = fb.Run.from_csv(tmp_path / "out" / "run.csv")
        np.testing.assert_allclose(run.xi[0], machine.frame.inverse((x, y)), atol=1e-9)


def test_what_bounds_the_joint_and_not_the_tool_is_said():
    kept = fb.Constraints(half_planes=((0.0, 1.0, 0.05),), clearance=0.01)
    tool = fb.Tool(1, along=0.02)
    note = "draw: half_planes bound joint C, not the tool"
    assert fb.Machine(fb.FiveBar(), constraints=kept, tool=tool).used_by("draw")[1] == note
    assert fb.Machine(fb.FiveBar(), constraints=kept).used_by("draw")[1] == ""
    assert "bound" not in fb.Machine(fb.FiveBar(), tool=tool).used_by("draw")[1]


def test_what_changes_no_answer_is_not_said():
    machine = fb.Machine(fb.FiveBar(), offset=(0.1, 0.0), measured=((-1, -1, -1),))
    for user in ("map", "map --load", "certify", "fb.check_path", "fb.place"):
        assert machine.used_by(user)[1] == "", user
    # The axes of joint space are angles of the model.
    used, note = machine.used_by("map --space joint")
    assert note.startswith("map --space joint leaves out [readings]: ") and "measured" not in note
    assert used == fb.Machine(fb.FiveBar())
