"""The ladder of physics: its rungs, its chart, its command."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.study.ladder import CASES, Case, climb, figure, table
from fivebar.study.ladder.rungs import KD, KP, PERIOD, RUNGS, SETTLED, _haptic, task_torques
from fivebar.visualization.style import INK


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


def test_each_rung_is_what_a_controller_with_it_does(monkeypatch):
    """A tenth of a second of the upright lab's robot, whose bars are heavy: masses, then gravity."""
    monkeypatch.setattr("fivebar.study.ladder.rungs.CALLS", 4)
    robot = replace(CASES["lab"].robot, fv1=0.01, fs2=0.02)
    case = Case(robot, fb.circle((0.0, 0.11), 0.002, 0.1), "short")
    counted = []
    found = climb(case, lambda: counted.append(1))
    assert [rung.name for rung in found] == list(RUNGS) and len(counted) == len(found)
    assert [rung.named for rung in found] == [True, True, True, True, False]
    assert found[-1].missed == 0.0 and all(0 < rung.step < 1e-2 for rung in found)
    for rung, fields in zip(found, (("gravity", "mx11", "mx21", "fv1", "fs2"), ("fv1", "fs2"))):
        # What the robot has, and the controller does not know.
        zeros = {name: (0.0, 0.0) if name == "gravity" else 0.0 for name in fields}
        model = replace(robot, **zeros)
        law = fb.ComputedTorque(model, KP, KD)
        run = fb.simulate(robot, law, case.reference, control_period=PERIOD)
        error = np.linalg.norm(run.error[run.t >= SETTLED * 0.1], axis=1)
        assert rung.rms == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-6)
        assert rung.largest == pytest.approx(error.max(), rel=1e-6)
        tau = [fb.inverse_dynamics(motion_of(each, case)) for each in (robot, model)]
        missed = np.linalg.norm(tau[0] - tau[1], axis=1)
        assert rung.missed == pytest.approx(np.sqrt(np.mean(missed**2)))
        compiled = fb.compile(model, ["xi", "xi_dot", "xi_ddot"], ["tau"], working=(-1, -1))
        assert rung.instructions == compiled.n_instructions()
    heading, rows = table({"short": found})
    assert len(heading) == len(rows[0]) and rows[0][:3] == ["short", "masses", 1]
    row = dict(zip(heading, rows[1]))
    assert row["rms_um"] == 1e6 * found[1].rms and row["missed_Nm"] == found[1].missed
    made = figure({"lab": found})
    above, below = made.axes
    for axes, values in ((above, [rung.rms for rung in found]), (above, [r.missed for r in found])):
        shown = [1e3 * value if value else np.nan for value in values]  # the axis has no 0
        drawn = [line.get_ydata() for line in axes.lines]
        assert any(np.array_equal(y, shown, equal_nan=True) for y in drawn)
    hollow = [line for line in below.lines if line.get_markerfacecolor() == "white"]
    assert [line.get_xdata()[0] for line in hollow] == [4, 4]  # of both curves, the last rung
    texts = above.title, made.get_suptitle() and made._suptitle
    assert all(text.get_text() and text.get_color() == INK for text in texts)


def motion_of(robot, case):
    xi, xi_dot, xi_ddot = case.reference(np.linspace(0, case.reference.duration, 1001))
    return fb.ikm2(fb.ikm(fb.igm(robot, xi), xi_dot), xi_ddot)


def test_the_haptic_robot_is_of_aluminium_bars():
    """Uniform bars of 15 x 4 mm, 2.7 g a cubic centimetre: half a distal bar's mass goes to each of its ends."""
    robot = _haptic()
    assert robot == CASES["haptic"].robot
    proximal, distal = (2.7e3 * 0.015 * 0.004 * length for length in (0.07, 0.09))
    assert robot.m == pytest.approx(0.02 + distal)
    assert (
        robot.zz1
        == robot.zz2
        == pytest.approx(1e-6 + proximal * 0.07**2 / 3 + distal / 2 * 0.07**2)
    )
    assert robot.zz12 == robot.zz22 == pytest.approx(distal * 0.09**2 / 3 - distal / 2 * 0.09**2)
    assert robot.fs1 == robot.fs2 == 1e-3 and robot.d == 0 and not any(robot.gravity)


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
