"""`fivebar identify`: the table, the robot for --robot, JSON, and mistakes with their exit codes."""

import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from tests.helpers.synthetic_logs import RUNGS, case_of

CASE = case_of(4, RUNGS["friction"], 8.0)


@pytest.fixture
def files(tmp_path):
    """A log as people have them, and the robot's lengths."""
    log, robot = CASE.log, CASE.known
    rows = np.column_stack([1e3 * log["t"], np.degrees(log["q"]), 1e3 * log["tau"]])
    lines = [";".join(f"{value:.9g}".replace(".", ",") for value in row) for row in rows]
    (tmp_path / "log.csv").write_text(
        "Time (ms);q1 (deg);q2 (deg);torque1 [mNm];torque2 [mNm]\n" + "\n".join(lines),
        encoding="utf-8",
    )
    lengths = "".join(
        f"{name} = {getattr(robot, name)!r}\n" for name in ("l11", "l12", "l21", "l22", "d")
    )
    (tmp_path / "robot.toml").write_text(lengths, encoding="utf-8")
    return tmp_path


@pytest.mark.deep
def test_a_log_gives_a_robot_that_robot_reads(files, capsys):
    out = files / "out"
    words = ["identify", str(files / "log.csv"), "--robot", str(files / "robot.toml")]
    assert main([*words, "--validate", str(files / "log.csv"), "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    for part in (
        "value",
        "± 1 sd",
        "fs2",
        "  kg m²\n",
        "second run: misses",
        "without gravity",
        "left out",
        "q1 (deg): read in deg",
    ):
        assert part in shown
    assert all(
        (out / name).is_file() for name in ("robot.toml", "identification.json", "torques.png")
    )
    assert (
        main(["identify", str(files / "log.csv"), "--robot", str(out / "robot.toml"), "--json"])
        == 0
    )
    table = json.loads(capsys.readouterr().out)
    assert table["values"]["m"] == pytest.approx(CASE.robot.m, rel=0.01) and table["files"] == []
    assert set(table["chosen"]) == CASE.named | {"zz1", "zz2", "m"}


@pytest.mark.deep
def test_a_machine_stays_one(files, capsys):
    robot = str(files / "robot.toml")
    with open(robot, "a", encoding="utf-8") as file:
        file.write("[readings]\noffset = [0.01, 0.02]\n[frame]\nshift = [0.1, 0.2]\n")
    words = ["identify", str(files / "log.csv"), "--robot", robot]
    assert main([*words, "--out", str(files)]) == 0
    found = fb.load_machine(robot)
    assert found.offset == (0.01, 0.02) and found.frame.shift == (0.1, 0.2)
    capsys.readouterr()
    # The offset of the file is used, unless another is named.
    assert main([*words, "--offset", "0", "0", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)["values"]
    assert values["zz1"] != pytest.approx(found.robot.zz1, rel=1e-3)
    (files / "counts.toml").write_text("l11 = 0.1\n[readings]\nratio = [0.001, 0.001]\n", "utf-8")
    assert main([*words[:2], "--robot", str(files / "counts.toml")]) == 2
    assert "name --counts-per-turn or --gear-ratio" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["nowhere.csv"], 2, "no file 'nowhere.csv'"),
        (["log.csv", "--units", "furlong"], 2, "--units: furlong: known are"),
        (["log.csv", "--columns", "q1"], 2, "--columns: q1= must be NAME=HEADING"),
        (["log.csv", "--offset", "1", "2", "3"], 2, "--offset takes one number or two"),
        (["log.csv", "--offset", "1deg", "2deg", "3deg"], 2, "--offset takes one number or two"),
        (["log.csv", "--units", "q1=rad"], 1, "is in deg, but its unit is given as rad"),
        (["log.csv", "--unknown", "mass"], 2, "--unknown: no parameter 'mass'"),
    ],
)
def test_mistakes_have_words_and_codes(files, monkeypatch, capsys, words, code, message):
    monkeypatch.chdir(files)
    assert main(["identify", *words, "--robot", "robot.toml"]) == code
    assert message in capsys.readouterr().err
