"""The ladder of physics: its rungs, its chart, its command."""

import csv
import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.study.ladder import CASES, climb, figure
from fivebar.study.ladder.rungs import RUNGS, task_torques


@pytest.fixture(scope="module")
def found():
    return {name: climb(CASES[name]) for name in CASES}


@pytest.mark.deep
def test_the_top_misses_nothing_and_what_is_not_named_costs_nothing(found):
    for name, rungs in found.items():
        assert [rung.name for rung in rungs] == list(RUNGS)
        assert rungs[-1].missed == 0.0 and rungs[-1].rms < 0.02 * rungs[0].rms
        for below, rung in zip(rungs, rungs[1:]):
            if not rung.named:
                assert rung.instructions == below.instructions and rung.missed == below.missed
            else:
                assert rung.instructions > below.instructions and rung.missed <= below.missed, (
                    name,
                    rung.name,
                )


@pytest.mark.deep
def test_what_is_missed_is_what_the_models_differ_by(found):
    case = CASES["vertical"]
    light = fb.FiveBar(
        **{
            k: v
            for k, v in case.robot.parameters.items()
            if k[0] in "ldm" and k[:2] != "mx" or k in ("zz1", "zz2")
        }
    )
    missed = task_torques(case.robot, case) - task_torques(light, case)
    assert found["vertical"][0].missed == pytest.approx(
        float(np.sqrt((missed**2).sum(axis=1).mean())), rel=1e-12
    )


@pytest.mark.deep
def test_the_chart_has_a_panel_for_each_robot(found, tmp_path):
    made = figure(found)
    made.savefig(tmp_path / "ladder.png")
    assert len(made.axes) == 2 * len(CASES) and (tmp_path / "ladder.png").stat().st_size > 20_000


@pytest.mark.deep
def test_the_command_prints_and_writes(tmp_path, capsys):
    assert main(["study", "ladder", "--robots", "lab", "--json", "--out", str(tmp_path)]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["rung"] for row in rows] == list(RUNGS) and rows[0]["instructions"] == 121
    with open(tmp_path / "ladder.csv", encoding="utf-8") as file:
        assert [row["rung"] for row in csv.DictReader(file)] == list(RUNGS)
    assert main(["study", "ladder", "--robots", "moon"]) == 2
    assert "no robot moon; the known ones are lab, vertical, haptic" in capsys.readouterr().err
