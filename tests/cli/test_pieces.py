"""Pieces of commands by themselves, against numbers of their own: the whole commands take seconds."""

import argparse
import csv
import io
import json
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.amoro.ros_free.marking import confined_program
from fivebar.base.errors import UsageError
from fivebar.cli import (
    COMMANDS,
    _parser,
    draw,
    draw_gcode,
    draw_place,
    grade,
    grade_folder,
    main,
    mark,
)
from fivebar.cli import linkage as linkage_command
from fivebar.cli import map as map_command
from fivebar.grading.intake.hand_in import look_into
from fivebar.grading.intake.students_robots import draw_for, hidden_seed, robot_for
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.replies import Reply
from fivebar.grading.worker.submission import Submission
from fivebar.linkages import Study
from fivebar.linkages.six_bar_press import PRESSES
from fivebar.study.ladder import Rung

ROBOT = fb.FiveBar()
LAB = fb.load_machine("amoro")


def amoro(**more):
    """The lab's robot as a Machine."""
    return replace(LAB, **more)


def test_each_file_of_a_run_is_named(tmp_path, capsys):
    page = tmp_path / "page.html"
    line = "track --from 0.09 0.068 --to 0.08 0.075 --duration 0.1".split()
    assert main([*line, "--page", str(page), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["files"] == [str(page)]
    assert "<svg" in page.read_text("utf-8")


def test_a_number_that_is_none_is_named_with_its_option(capsys):
    with pytest.raises(SystemExit):
        main(["track", "--duration", "long"])
    said = capsys.readouterr().err
    assert "argument --duration" in said and "long" in said and "None" not in said


def test_a_linkage_needs_its_kind_and_turns_at_its_speed(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["linkage"])
    assert ended.value.code == 2 and "KIND" in capsys.readouterr().err
    file = tmp_path / "study.csv"
    four_bar = ["linkage", "four-bar", "0.2", "0.06", "0.16", "0.14"]
    for speed in (-0.25, 4.0):
        assert main([*four_bar, "--speed", str(speed), "--csv", str(file)]) == 0
        study = Study.from_csv(file)
        turned = np.ptp(study.t) * abs(speed)
        assert turned == pytest.approx(2 * np.pi, rel=0.01)
    for speed, wanted in (("0", "finite and not 0"), ("inf", "finite, not inf")):
        assert main([*four_bar, "--speed", speed, "--csv", str(file)]) == 2
        assert f"--speed must be {wanted}" in capsys.readouterr().err


def test_a_path_on_a_map_is_all_of_it(tmp_path, monkeypatch, capsys):
    """From its first point to its last, in the frame of the robot."""
    rows = [f"{t},{50 + 5 * t},{90 + 2.5 * t}" for t in range(0, 9)]
    (tmp_path / "path.csv").write_text("\n".join(["t (s),x (mm),y (mm)", *rows]), encoding="utf-8")
    drawn = []
    monkeypatch.setattr(
        "fivebar.visualization.plot.maps.singularity_map",
        lambda data, points, regions, **_: drawn.append(points),
    )
    monkeypatch.setattr("fivebar.visualization.plot.panels.in_frame", lambda *_: None)
    monkeypatch.setattr(map_command, "saved", lambda *_: None)
    words = ["--path", str(tmp_path / "path.csv"), "--nodes", "9", "--json"]
    assert main(["map", *words, "--out", str(tmp_path / "map.png")]) == 0
    (points,) = drawn
    assert points[0] == pytest.approx((0.05, 0.09)) and points[-1] == pytest.approx((0.09, 0.11))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.sum() == pytest.approx(np.hypot(0.04, 0.02), rel=1e-3) and len(points) > 200
    assert len(json.loads(capsys.readouterr().out)["path"]) == 4


def test_the_load_of_a_map_is_in_the_robots_frame():
    """A frame that is turned by a right angle turns the force back; a tool gives its own Jacobian."""
    options = Namespace(load=(3.0, 4.0), torque_limit=0.2)
    load = map_command._load(options, amoro())
    assert (
        load.force == pytest.approx((3.0, 4.0))
        and map_command._load(Namespace(load=None), LAB) is None
    )
    turned = map_command._load(options, amoro(frame=fb.Placement(turn=np.pi / 2)))
    assert turned.force == pytest.approx((4.0, -3.0))
    tool = fb.Tool(1, 0.03)
    with_tool = map_command._load(options, amoro(tool=tool))
    pose = fb.igm(ROBOT, (0.05, 0.1))
    np.testing.assert_array_equal(with_tool.jacobian(pose), tool.jacobian(pose))
    at_end = np.linalg.solve(pose.A, np.diag(pose.B)) if pose.A.ndim == 1 else pose.J
    np.testing.assert_allclose(load.jacobian(pose), at_end, atol=1e-15)


def test_the_largest_board_of_all_places_is_named(monkeypatch):
    """Of two as large that of the lowest number; places in which none is found do not count."""
    widths = {1: None, 2: 0.12, 3: 0.18, 4: 0.18}

    def largest(part, margin, ratio):
        if widths[part.number] is None:
            raise ValueError("none")
        width = widths[part.number]
        return SimpleNamespace(
            x_min=0.01, x_max=0.01 + width, y_min=0.02, y_max=0.02 + width / ratio
        )

    monkeypatch.setattr("fivebar.constraints.rectangle.largest_rectangle", largest)
    parts = [SimpleNamespace(number=number) for number in widths]
    found = map_command._board(LAB, parts, None, (0.2, 0.1))
    assert found["scale"] == pytest.approx(0.9) and found["number"] == 3 and not found["fits"]
    assert found["rectangle_m"] == pytest.approx([0.18, 0.09])
    assert found["corner_m"] == pytest.approx([0.01, 0.02])
    assert map_command._board(LAB, parts, None, (0.15, 0.1))["fits"]
    with pytest.raises(ValueError, match="no aspect holds a board"):
        map_command._board(LAB, parts[:1], None, (0.2, 0.1))


def test_the_largest_disc_of_all_regions_is_named(monkeypatch):
    """And the largest rectangle of its region; regions in which none keeps the clearance do not count."""
    radii = {1: 0.01, 2: None, 3: 0.03}

    def disc(region, margin):
        assert margin == "margin"
        if radii[region.number] is None:
            raise ValueError("none")
        return SimpleNamespace(radius=radii[region.number], center=(0.01 * region.number, 0.1))

    def rectangle(region, margin):
        assert margin == "margin" and region.number == 3
        return SimpleNamespace(x_min=0.0, x_max=0.02, y_min=0.1, y_max=0.11)

    monkeypatch.setattr("fivebar.constraints.disc.largest_disc", disc)
    monkeypatch.setattr("fivebar.constraints.rectangle.largest_rectangle", rectangle)
    regions = [SimpleNamespace(number=number) for number in radii]
    found = map_command._largest(amoro(frame=fb.Placement((1.0, 0.0), 0.0, 2.0)), regions, "margin")
    disc_found = found["largest_disc"]
    assert disc_found["region"] == 3 and disc_found["radius_m"] == pytest.approx(0.06)
    assert disc_found["center_m"] == pytest.approx([1.06, 0.2])
    assert found["largest_rectangle"]["rectangle_m"] == pytest.approx([0.04, 0.02])
    none = map_command._largest(LAB, regions[1:2], "margin")
    assert none == {"largest_disc": None, "largest_rectangle": None}


def test_an_identified_robot_is_saved_with_its_deviations(tmp_path, capsys):
    circle = fb.circle((0.06, 0.09), 0.02, 0.5)
    run = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), circle, step=2e-3)
    run.to_csv(tmp_path / "log.csv")
    words = ["identify", str(tmp_path / "log.csv"), "--unknown", "zz1", "zz2", "m", "--json"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    told = json.loads(capsys.readouterr().out)
    text = (tmp_path / "out" / "robot.toml").read_text("utf-8")
    assert "identified; SI units" in text
    robot = fb.load_robot(tmp_path / "out" / "robot.toml")
    for name in ("zz1", "zz2", "m"):
        assert getattr(robot, name) == pytest.approx(told["values"][name], rel=1e-9)
        assert getattr(robot, name) == pytest.approx(getattr(ROBOT, name), rel=1e-3)


def test_axes_have_the_zeros_and_directions_of_the_options():
    options = dict.fromkeys(("sign", "zero_deg", "approach_deg", "mm_per_turn"))
    options["robot"] = "robot.toml"
    dialect = fb.Gcode()
    zeros = draw_gcode.machine_of_axes(
        Namespace(**options | {"zero_deg": (90.0, -45.0)}), LAB, dialect
    )
    assert zeros.offset == pytest.approx((np.pi / 2, -np.pi / 4)) and zeros.ratio == (1.0, 1.0)
    signs = draw_gcode.machine_of_axes(Namespace(**options | {"sign": (-1.0, 1.0)}), LAB, dialect)
    assert signs.ratio == (-1.0, 1.0) and signs.offset == (0.0, 0.0)
    assert draw_gcode.machine_of_axes(Namespace(**options), LAB, dialect) is LAB
    with pytest.raises(UsageError, match="--zero-deg: robot.toml has a table readings"):
        options |= {"zero_deg": (90.0, 0.0)}
        draw_gcode.machine_of_axes(Namespace(**options), amoro(offset=(0.1, 0.2)), dialect)
    for option in ("--zero-deg", "--approach-deg", "--mm-per-turn"):
        name = option[2:].replace("-", "_")
        with pytest.raises(UsageError, match=f"{option}: the joints of a biglide slide; their"):
            given = options | {"zero_deg": None, name: 1.0}
            draw_gcode.machine_of_axes(Namespace(**given), fb.Machine(fb.Biglide()), dialect)


def test_the_modes_of_a_drawing_keep_farthest_from_singularities():
    path = fb.path([(0.03, 0.1), (0.05, 0.1), (0.05, 0.11)])
    options = Namespace(working=None, through=False)
    chosen = draw_place._modes(options, LAB, path)
    margins = {}
    for mode in [(a, b) for a in (-1, 1) for b in (-1, 1)]:
        check = fb.check_path(ROBOT, path.at_unit_speed, mode)
        if check.singularity_free:
            margins[mode] = check.min_margin
    assert chosen == max(margins, key=margins.get) and len(margins) > 1
    # Modes in which the robot was measured go before, if the path is free there.
    other = min(margins, key=margins.get)
    assembly = int(fb.igm(ROBOT, (0.03, 0.1), other).assembly)
    measured = amoro(measured=((*other, assembly),))
    assert draw_place._modes(options, measured, path) == other
    assert draw_place._modes(Namespace(working=(1, -1), through=False), LAB, path) == (1, -1)


def test_backlash_moves_the_tip_by_the_worst_of_its_corners():
    """Both joints off by half of it, either way: the tip by the direct model, of what is drawn only."""
    xi = np.linspace((0.03, 0.1), (0.06, 0.09), draw.SAMPLES)
    poses = fb.igm(ROBOT, xi)
    drawn = np.arange(draw.SAMPLES) < draw.SAMPLES // 2

    def accelerations(t):
        rows = np.round(t * (draw.SAMPLES - 1)).astype(int)
        return SimpleNamespace(rates=SimpleNamespace(pose=fb.igm(ROBOT, xi[rows])))

    def motion(tool):
        held = None if tool is None else SimpleNamespace(tool=tool)
        return SimpleNamespace(
            duration=1.0,
            accelerations=accelerations,
            pen=lambda t: drawn,
            path=SimpleNamespace(tool=held),
        )

    backlash = 1e-6
    for tool in (None, fb.Tool(2, 0.04, 0.01)):
        tip = (lambda pose: pose.xi) if tool is None else tool.point
        off = []
        for corner in ((1, 1), (1, -1)):
            q = poses.q[drawn] + backlash / 2 * np.array(corner)
            moved = fb.dgm(ROBOT, q, poses.assembly[drawn])
            here = fb.dgm(ROBOT, poses.q[drawn], poses.assembly[drawn])
            off.append(np.linalg.norm(tip(moved) - tip(here), axis=1).max())
        assert draw._tip_error(motion(tool), backlash / 2) == pytest.approx(max(off), rel=1e-4)
    assert draw._tip_error(motion(None), 0.0) == 0.0


def test_a_certificate_is_told_as_json(tmp_path, capsys):
    np.savetxt(
        tmp_path / "path.csv",
        [(0.05, 0.09), (0.04, 0.09)],
        delimiter=",",
        header="x,y",
        comments="",
    )
    assert main(["certify", str(tmp_path / "path.csv"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    pose = fb.igm(ROBOT, (0.05, 0.09))
    assert told["proved"] is True and told["assembly"] == pose.assembly and told["unproved"] == []


class FakeStudent:
    """A worker whose script ends with a reply."""

    reply = Reply("value", "")

    def __init__(self, submission, isolate, *, limit, total, modules):
        FakeStudent.modules = modules
        FakeStudent.made = submission, isolate, limit, total

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    output = "said"

    def ask(self, kind, calls, given):
        assert kind == "run"
        FakeStudent.asked = calls
        FakeStudent.given = given
        return [FakeStudent.reply]


@pytest.mark.parametrize(
    "reply, trouble",
    [
        (Reply("value", "it ended early"), "it ended early"),
        (Reply("value", None), ""),
        (Reply("value", 3), ""),
        (Reply("exception", None, "boom"), "boom"),
    ],
)
def test_how_a_script_ended_is_its_trouble(reply, trouble, tmp_path, monkeypatch):
    """Its last words, or how it failed; its own arguments and modules go to it."""
    monkeypatch.setattr("fivebar.grading.worker.student.Student", FakeStudent)
    monkeypatch.setattr(FakeStudent, "reply", reply)
    script, gains = tmp_path / "control.py", tmp_path / "gains.py"
    script.write_text("import gains\n", encoding="utf-8")
    gains.write_text("KP = 1\n", encoding="utf-8")
    models, data = tmp_path / "other" / "models.py", tmp_path / "data.txt"
    models.parent.mkdir()
    models.write_text("M = 2\n", encoding="utf-8")
    data.write_text("1 2\n", encoding="utf-8")
    # Of its arguments the .py files that are there can be imported, too.
    words = ["--fast", str(models), str(data), "none.py"]
    tried = mark._of_script(script, words, ("task1", 1.0, "process"))
    assert FakeStudent.modules["models"] == "M = 2\n"
    assert not {"data", "none"} & set(FakeStudent.modules)
    assert tried.said == "said" and tried.student == "control" and tried.name == "control.py"
    assert FakeStudent.modules["gains"] == "KP = 1\n"
    assert sorted(FakeStudent.asked[0][3]) == ["gains", "models"]
    ((text, name, rest, modules),) = FakeStudent.asked
    assert (text, name, rest) == ("import gains\n", "control.py", words)
    submission, isolate, *limits = FakeStudent.made
    program, lab = confined_program()
    assert submission == Submission("control.py", program) and isolate == "process"
    assert limits == [mark.LIMIT, mark.LIMIT] and lab.items() <= FakeStudent.modules.items()
    # The script's robot is simulated here: a five-bar is made, and moves for so many steps.
    answer = FakeStudent.given["lab"]
    assert len(answer([0, 0, 0])[0]) == 20 and answer([1, 0.0, 0.0]) is not None
    # It is not marked, as it has moved too little, which is said as well.
    assert tried.tracking is None and tried.trouble
    told = [part for part in tried.trouble.split("; ") if part]
    ends = [part for part in told if trouble and trouble in part]
    assert bool(ends) == bool(trouble) and "None" not in tried.trouble and "3" not in told


def test_one_script_is_marked_with_its_own_arguments(tmp_path, monkeypatch, capsys):
    script = tmp_path / "control.py"
    script.write_text("", encoding="utf-8")
    tracking = {"points": 3.0, "of": 5.0, "largest_error_m": 2e-3}
    asked = []

    def tried(*given):
        asked.append(given)
        run = SimpleNamespace(to_csv=None, plot=None, animate=None)
        return mark.Tried("control", "control.py", tracking, said="hello\n", run=run)

    monkeypatch.setattr(mark, "_tried", tried)
    files = dict.fromkeys(("record", "plot", "animate"))
    options = Namespace(script=str(script), mark="task1", until=2.0, json=True, **files)
    mark.mark(options, ["--own", "x"])
    told = capsys.readouterr()
    assert json.loads(told.out) == {"tracking": tracking, "trouble": ""} and told.err == "hello\n"
    ((student, name, text, rest, modules, how),) = asked
    assert (student, name, text, rest, modules) == ("control", "control.py", "", ["--own", "x"], {})
    assert how[:2] == ("task1", 2.0)


def test_marks_of_a_course_are_a_table(tmp_path, capsys):
    tracking = {"points": 3.0, "of": 5.0, "largest_error_m": 2.00004e-3}
    mark._print_table(
        [mark.Tried("anna", "control.py", tracking), mark.Tried("=bob", "", None, "no controller")]
    )
    head, anna, bob = csv.reader(io.StringIO(capsys.readouterr().out))
    assert tuple(head) == mark.COLUMNS and anna == ["anna", "control.py", "3.0", "5.0", "2.0", ""]
    # A name that a spreadsheet would take for a formula is none.
    assert (
        bob[0] != "=bob"
        and bob[0].endswith("=bob")
        and bob[1:] == ["", "", "", "", "no controller"]
    )
    folder = tmp_path / "carla"
    folder.mkdir()
    (folder / "control.py").write_text("", encoding="utf-8")
    (folder / "notes.txt").write_text("x", encoding="utf-8")
    (hand_in,) = mark._hand_ins(folder)
    programs, left = look_into(folder)
    assert hand_in.student == "carla" and hand_in.paths == (folder,)
    assert hand_in.programs == tuple(programs) and hand_in.left == tuple(left) and left
    course = tmp_path / "course"
    for student in ("dora", "emil"):
        (course / student).mkdir(parents=True)
        (course / student / "control.py").write_text("", encoding="utf-8")
    assert [each.student for each in mark._hand_ins(course)] == ["dora", "emil"]


def test_what_a_gradebook_lacks_is_told(capsys):
    course = SimpleNamespace(graded=[], without_mark=dict)
    filled = SimpleNamespace(count=2, no_hand_in=1, no_row=["anna", "bob"])
    grade_folder._print_course(course, filled)
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "gradebook.csv: marks: 2; rows without a hand-in: 1",
        "gradebook.csv: no row, or several, for anna, bob",
    ]
    grade_folder._print_course(course, None)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["lab1", "lab8"])
def test_each_student_gets_a_robot_of_his_own(name, tmp_path, capsys):
    """In student.py, or by the files of a lab that has him find it."""
    (tmp_path / "ids.txt").write_text("anna\nbob\nANNA\n", encoding="utf-8")
    lab = find_lab(name)
    arguments = Namespace(hand_out=tmp_path / "ids.txt", out=tmp_path / "out")
    grade_folder.hand_out(arguments, lab, b"a long secret")
    written = capsys.readouterr().out.split()
    assert sorted(path.name for path in arguments.out.iterdir()) == ["anna", "bob"]
    texts = []
    for student in ("anna", "bob"):
        folder = arguments.out / student
        robot = robot_for(student, b"a long secret", lab.robot())
        files = lab.files_for(robot, draw_for(b"a long secret", student, lab.name))
        expected = {"student.py": lab.template(None if files else robot)} | (files or {})
        found = {path.name: path.read_text("utf-8") for path in folder.iterdir()}
        assert found == expected and (name == "lab8") == bool(files)
        assert all(str(folder / each) in written for each in expected)
        texts.append(found)
    assert texts[0] != texts[1]


def parsers_of(parser, words):
    """Yield a command's words and parser, and those below it."""
    yield words, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from parsers_of(below, [*words, name])


GROUPS = {
    "calibrate": ["robot"],
    "certify": ["robot"],
    "design": ["task", "robot"],
    "draw": ["place", "speed", "drives", "proof", "G-code", "robot"],
    "export": ["robot"],
    "grade": ["a folder of submissions"],
    "identify": ["what was logged", "robot"],
    "linkage five-bar": ["study"],
    "linkage four-bar": ["study"],
    "linkage six-bar-press": ["study"],
    "linkage slider-crank": ["study"],
    "linkage straight-line": ["study"],
    "map": ["robot"],
    "plan": ["from where to where", "problem", "robot"],
    "play": ["robot"],
    "sweep": ["designs", "task", "robot"],
    "track": ["path", "robot"],
}
WITHOUT_WORDS = "problem", "a folder of submissions"  # groups
UNEXPLAINED = "branch", "path", "data", "name", "script"


@pytest.mark.parametrize("command", COMMANDS)
def test_each_option_is_explained_and_names_its_value(command):
    """In its group; a value has a name in capitals, or a list of choices; a command that has others
    needs one.
    """
    (commands,) = (
        a for a in _parser(command)._actions if isinstance(a, argparse._SubParsersAction)
    )
    for words, parser in parsers_of(commands.choices[command], [command]):
        groups = {g.title: g.description for g in parser._action_groups[2:]}
        assert list(groups) == GROUPS.get(" ".join(words), [])
        for title, text in groups.items():
            assert (title in WITHOUT_WORDS) != bool(text), title
        for action in parser._actions:
            name = action.option_strings or action.dest
            if isinstance(action, argparse._SubParsersAction):
                assert action.required and action.metavar and action.dest != argparse.SUPPRESS
            elif action.help != argparse.SUPPRESS:
                assert action.metavar or action.choices or action.nargs == 0, (words, name)
                assert action.help or action.dest in UNEXPLAINED, (words, name)


@pytest.mark.parametrize(
    "words, message",
    [
        ("export --format stl", "invalid choice: 'stl'"),
        ("study", "STUDY"),
        ("study ladder --robots none", "'none' (choose from 'lab', 'vertical', 'haptic')"),
        ("track --case none", "argument --case: invalid choice: 'none' (choose from 'task-1',"),
        ("calibrate --loss none", "'none' (choose from 'linear', 'huber',"),
        ("linkage four-bar 2 1 2 2 --branch 0", "argument --branch: invalid choice: 0 (choose"),
        ("linkage four-bar 2 1 2 2 --drive none", "'none' (choose from 'turn', 'until-lock',"),
        ("calibrate . --from-drawing A5", "it goes without measured data"),
        ("draw --example --page 0 0.1", "--page must be finite and > 0"),
    ],
)
def test_what_cannot_be_chosen_is_refused(words, message, capsys):
    try:
        code = main(words.split())
    except SystemExit as ended:
        code = ended.code
    assert code == 2 and message in capsys.readouterr().err


def test_the_ladder_is_a_table_with_its_heading(tmp_path, monkeypatch, capsys):
    rungs = [
        Rung("masses", True, 121, 1.5e-5, 0.9, 0.01, 0.02),
        Rung("gravity", False, 133, 2e-5, 0.0, 1e-4, 2e-4),
    ]
    monkeypatch.setattr("fivebar.study.ladder.climb", lambda case, progress: rungs)
    for _ in range(2):  # the folder may be there
        assert main(["study", "ladder", "--robots", "lab", "--out", str(tmp_path / "a" / "b")]) == 0
    told = capsys.readouterr()
    head, first, second, *_ = told.out.splitlines()
    names = "robot rung named instructions step_us missed_Nm rms_um largest_um".split()
    assert head.split() == names and first.split()[:4] == ["lab", "masses", "1", "121"]
    assert second.split()[:3] == ["lab", "gravity", "0"] and len(head) == len(first)
    assert first.split()[4:] == ["15", "0.9", "1e+04", "2e+04"]
    assert (tmp_path / "a" / "b" / "ladder.csv").exists() and "ladder.png" in told.err


def test_a_comparison_has_null_where_there_is_no_number(monkeypatch, capsys):
    line = fb.line((0.09, 0.068), (0.08, 0.075), 0.1)
    run = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), line)
    monkeypatch.setattr(
        "fivebar.study.control_cases.run_case",
        lambda name: {"ctc": run} if name == "task-1" else None,
    )
    assert main(["track", "--case", "task-1", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)["controllers"]["ctc"]
    size = np.linalg.norm(run.error, axis=1)
    assert figures["max_error_m"] == size.max() and figures["final_error_m"] == size[-1]
    assert figures["saturated_s"] is None and figures["median_solve_s"] is None


def test_a_track_keeps_its_torque_limit_and_names_its_file(tmp_path, capsys):
    line = "track --from 0.09 0.068 --to 0.08 0.075 --duration 0.1 --torque-limit 0.02 --json"
    assert main(line.split()) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["peak_torque_Nm"] == [0.02, 0.02] and 0 < figures["saturated_fraction"] <= 1
    file = tmp_path / "line.csv"
    file.write_text("t [ms];X (mm);Y (mm)\n0;80;75\n50;82;75\n100;84;75\n", encoding="utf-8")
    assert main(["track", str(file), "--polyline", "1e-4", "--json"]) == 0
    notes = capsys.readouterr().err.splitlines()
    assert notes and all(str(file) in note for note in notes)


def test_an_area_is_told_with_its_error_where_it_has_one(capsys):
    exact = SimpleNamespace(number=1, working=(-1, 1), assembly=1, area=2.5e-3)
    rough = SimpleNamespace(**vars(exact) | {"number": 2, "area_error": 3e-9})
    map_command._print_regions("region", [exact, rough], 1e3, "mm")
    first, second = capsys.readouterr().out.splitlines()[1:]
    assert first.split() == ["1", "-+", "+", "2500.0000"]
    assert second.split() == ["2", "-+", "+", "2500.0000", "±", "0.003"]
    map_command._print_regions("region", [], 1e3, "mm")
    assert "no pose keeps these margins" in capsys.readouterr().err


def test_a_page_begins_with_the_pose_that_is_asked_for(tmp_path, monkeypatch, capsys):
    shown = []

    def play(robot, pose, tool):
        shown.append((robot, pose, tool))
        return SimpleNamespace(save=lambda path: path.write_text("page", "utf-8"))

    monkeypatch.setattr("fivebar.visualization.play.play", play)
    out = str(tmp_path / "play.html")
    assert main(["play", "--xi", "0.05", "0.1", "--working", "1", "-1", "--out", out]) == 0
    ((robot, pose, tool),) = shown
    assert robot == fb.ROBOTS["amoro"].robot and tool is None and out in capsys.readouterr().out
    assert pose.xi == pytest.approx((0.05, 0.1)) and tuple(pose.working) == (1, -1)
    assert main(["play", "--working", "1", "-1", "--out", out]) == 2
    assert "--working goes with --xi X Y" in capsys.readouterr().err


def test_a_press_is_loaded_along_its_slide():
    options = Namespace(name=next(iter(PRESSES)), load=-120.0, no_gravity=True)
    vars(options).update(dict.fromkeys(linkage_command.PRESS_LENGTHS), l3=0.3)
    linkage, asked, lines = linkage_command._press(options)
    assert asked["load"] == {"E": (0.0, -120.0)} and asked["gravity"] == (0.0, 0.0)
    assert linkage.l3 == 0.3 and len(lines) == 1


def test_a_seed_comes_from_the_courses_secret(tmp_path, monkeypatch):
    (tmp_path / "secret").write_text("a long secret\n", encoding="utf-8")
    (tmp_path / "anna.py").write_text("", encoding="utf-8")
    asked = []

    def graded(arguments, lab, how):
        asked.append(how(lab))
        raise Reached

    monkeypatch.setattr(grade, "_graded", graded)
    words = ["grade", "lab1", str(tmp_path / "anna.py")]
    for more in (["--secret-file", str(tmp_path / "secret")], ["--seed", "mine"], [], []):
        with pytest.raises(Reached):
            main([*words, *more])
    secret, own, first, second = (each["seed"] for each in asked)
    assert (
        secret == hidden_seed(b"a long secret", find_lab("lab1").name)
        and own == "mine"
        and first != second
    )
    assert asked[0]["robot"] == robot_for("anna", b"a long secret", find_lab("lab1").robot())
    assert all(each["student"] == "anna" for each in asked)


class Reached(BaseException):
    """What is asked for is known."""


def test_torques_in_reserve_are_the_trackers(monkeypatch):
    """The motion has a share of the weaker motor's torque, the tracker all of it."""
    asked = []

    def timed(robot, path, duration, constraints, working):
        asked.append((duration, constraints, working))
        return SimpleNamespace(gap=0.0)

    monkeypatch.setattr("fivebar.paths.timing.time_path.time_path", timed)
    limits = dict.fromkeys(
        ("torque_limit", "speed_limit", "acceleration_limit", "joint_speed_limit")
    )
    options = Namespace(reserve=0.2, motor=None, duration=None, accept_slow=False, **limits)
    machine = amoro(constraints=fb.Constraints(torque=(0.05, 0.04)))
    _, drives = draw._timed(options, machine, None, (1, -1))
    ((duration, constraints, working),) = asked
    assert duration is None and working == (1, -1)
    assert drives.torque == (0.04, 0.04) and constraints.torque == pytest.approx((0.032, 0.032))


def test_a_sheet_to_draw_says_its_files(tmp_path, monkeypatch, capsys):
    path = fb.path([(0.0, 0.1), (0.04, 0.12)])
    written = []
    drawn = SimpleNamespace(
        path=path,
        working=(1, -1),
        pairs=[None] * 7,
        drawing_to_csv=written.append,
        distances_to_csv=written.append,
    )
    monkeypatch.setattr("fivebar.estimation.calibration.sheet.sheet", lambda *_: drawn)
    folder = tmp_path / "sheet"
    assert main(["calibrate", "--from-drawing", "A5", "--out", str(folder)]) == 0
    first, second, third, fourth, *_ = capsys.readouterr().out.splitlines()
    assert (
        written == [folder / "sheet.csv", folder / "distances.csv"] == [Path(first), Path(second)]
    )
    assert "--at 0.02 0.11 --working 1 -1" in third and "the 7 distances between crosses" in fourth
