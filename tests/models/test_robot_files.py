"""Robots in files: what is saved comes back, and what could be two robots is none."""

import json
import re

import casadi
import pytest

import fivebar as fb
from fivebar.cli import main
from tests.conftest import UNEQUAL
from tests.helpers import ROOT

LINKS = fb.FiveBar.from_links(
    0.09,
    0.1,
    0.08,
    0.09,
    0.12,
    {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08},
    payload=0.2,
    gravity=(0, -9.81),
)
ROBOTS = [fb.FiveBar(), UNEQUAL, LINKS, fb.Biglide(), fb.Biglide(0.3, 0.2, 0.1, fs1=0.1)]
ROBOTS += [known.robot for known in fb.ROBOTS.values()]


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: type(robot).__name__)
def test_a_saved_robot_comes_back(robot, tmp_path):
    robot.save(tmp_path / "robot.toml")
    assert fb.load_robot(tmp_path / "robot.toml") == robot
    assert fb.load_robot(str(tmp_path / "robot.toml")) == robot
    table = {name: list(v) if isinstance(v, tuple) else v for name, v in robot.parameters.items()}
    (tmp_path / "robot.json").write_text(json.dumps(table), "utf-8")
    assert fb.load_robot(tmp_path / "robot.json") == robot


@pytest.mark.deep
def test_a_saved_robot_is_read_by_the_commands_without_a_word(tmp_path, capsys):
    UNEQUAL.save(tmp_path / "robot.toml")
    out = ["--out", str(tmp_path / "map.png")]
    assert main(["map", "--robot", str(tmp_path / "robot.toml"), "--nodes", "20", *out]) == 0
    assert capsys.readouterr().err == ""


def written(tmp_path, text, name="robot.toml"):
    (tmp_path / name).write_text(text, "utf-8")
    return tmp_path / name


@pytest.mark.parametrize(
    "text", ["l1 = 0.1\nl2 = 0.2\nd = 0.1\n", "l1 = 0.1\n", "l2 = 0.1\nzz1 = 0.002\n"]
)
def test_lengths_that_could_be_of_both_kinds_are_refused_with_both_readings(tmp_path, text, capsys):
    path = written(tmp_path, text)
    with pytest.raises(ValueError, match='robot.toml: .* kind = "biglide", or l11, l12, l21, l22'):
        fb.load_robot(path)
    assert main(["map", "--robot", str(path)]) == 2
    assert 'write kind = "biglide", or l11' in capsys.readouterr().err


def test_a_kind_that_is_named_is_taken(tmp_path):
    text = 'kind = "biglide"\nl1 = 0.1\nl2 = 0.2\nd = 0.1\n'
    assert fb.load_robot(written(tmp_path, text)) == fb.Biglide(0.1, 0.2, 0.1)


def test_what_only_one_kind_has_says_which_it_is(tmp_path):
    assert fb.load_robot(
        written(tmp_path, "l1 = 0.1\nl2 = 0.2\nd = 0.1\nmf1 = 0.3\n")
    ) == fb.Biglide(0.1, 0.2, 0.1, mf1=0.3)
    assert fb.load_robot(written(tmp_path, "l11 = 0.1\n")) == fb.FiveBar(l11=0.1)
    assert fb.load_robot(written(tmp_path, "m = 0.1\n")) == fb.FiveBar(m=0.1)


@pytest.mark.parametrize(
    "text,words",
    [
        ('kind = "gantry"\n', 'kind must be "five-bar" or "biglide", not \'gantry\''),
        ('kind = "biglide"\nl11 = 0.1\n', "no parameter l11 of a biglide robot"),
        ('kind = "five-bar"\nl1 = 0.1\n', "no parameter l1 of a five-bar robot"),
        ("[robot]\nl11 = 0.1\n", "no table robot; .*at the top, before the first table"),
        (
            'kind = "biglide"\nl1 = 0.1\n[links]\n11 = 0.1\n',
            "no parameter links of a biglide robot",
        ),
        ("l11 = -0.1\n", "l11 must be"),
        ("l11 = nan\n", "l11: nan is not a number"),
        ("l11 = 0.1, \n", "robot.toml: "),
        ("l11 = 'short'\n", "l11: 'short' is not a number"),
        ("[links]\n11 = '700 mm'\n", "links.11: '700 mm': its unit must be kg"),
    ],
)
def test_files_that_hold_no_robot(tmp_path, text, words):
    with pytest.raises(ValueError, match=words):
        fb.load_robot(written(tmp_path, text))


def test_the_file_in_the_guide_is_a_robot(tmp_path):
    """The same as by `from_links`, and read again when it is saved."""
    guide = (ROOT / "fivebar" / "guide" / "models.md").read_text("utf-8")
    robot = fb.load_robot(written(tmp_path, re.search("```toml\n(.*?)```", guide, re.DOTALL)[1]))
    links = {"11": 0.1, "21": 0.1, "12": fb.Link(0.08, 0.05, 0.0, 3e-4)}
    links["22"] = fb.Link.about_centre(0.08, x=0.05, inertia=1e-4)
    assert robot == fb.FiveBar.from_links(
        0.1,
        0.12,
        0.1,
        0.12,
        0.08,
        links,
        payload=0.2,
        gravity=(0.0, -9.81),
        viscous=(1e-3, 1e-3),
        coulomb=(0.02, 0.02),
        rotor=((1e-6, 30), (1e-6, 30)),
    )
    robot.save(tmp_path / "again.toml")
    assert fb.load_robot(tmp_path / "again.toml") == robot
    blocks = re.findall("```toml\n(.*?)```", guide, re.DOTALL)
    machine = fb.load_machine(written(tmp_path, "\n".join(blocks)))
    assert machine.robot == robot and machine.offset == (0.011, -0.004)
    assert machine.constraints.joints == ((-0.5, 2.2), None)
    machine.save(tmp_path / "again.toml")
    assert fb.load_machine(tmp_path / "again.toml") == machine


def test_other_files_and_places(tmp_path):
    with pytest.raises(
        ValueError, match="no robot .*robot.txt.*; or a .toml, .json or config.g file"
    ):
        fb.load_robot(written(tmp_path, "l11 = 0.1", "robot.txt"))
    with pytest.raises(ValueError, match="a robot is a table"):
        fb.load_robot(written(tmp_path, "[1, 2]", "robot.json"))
    with pytest.raises(FileNotFoundError):
        fb.load_robot(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="written to a .toml file, not .*robot.json"):
        fb.FiveBar().save(tmp_path / "robot.json")
    with pytest.raises(ValueError, match="CasADi symbols cannot be written: l11"):
        fb.FiveBar(l11=casadi.SX.sym("l11")).save(tmp_path / "robot.toml")
    assert not (tmp_path / "robot.json.part").exists()
