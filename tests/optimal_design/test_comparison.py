"""Designs side by side: their figures are those of the functions that give each alone; their maps have one scale."""

import numpy as np
import pytest

import fivebar as fb

ROBOTS = {"lab": fb.FiveBar(), "unequal": fb.FiveBar(0.1, 0.13, 0.08, 0.12, 0.09)}


@pytest.mark.deep
def test_usual_figures_are_those_of_the_regions():
    compared = fb.compare(ROBOTS)
    for name, robot in ROBOTS.items():
        own = compared.figures[name]
        assert own["bars"] == pytest.approx(robot.l11 + robot.l12 + robot.l21 + robot.l22)
        parts = [part for part in fb.aspects(robot) if part.working == (1, -1)]
        radius = max(fb.largest_disc(part).radius for part in parts)
        assert own["largest_disc"] == pytest.approx(radius, rel=1e-12)
    lines = str(compared).splitlines()
    assert lines[0].split() == ["lab", "unequal"] and lines[1].split() == [
        "bars",
        "(m)",
        "0.36",
        "0.43",
    ]
    figure = compared.plot()
    panels = figure.axes[:2]
    assert [axes.get_title().split()[0] for axes in panels] == ["lab", "unequal"]
    assert panels[0].get_xlim() == panels[1].get_xlim()
    assert "bars = 430 mm" in panels[1].get_title()


def test_robots_by_name_are_those_of_the_table():
    with pytest.warns(UserWarning, match="fb.compare leaves out .*tool") as said:
        compared = fb.compare({"a": "plotclock", "b": fb.ROBOTS["plotclock"]}, "bars")
    assert {warning.filename for warning in said} == {__file__}
    robot = fb.ROBOTS["plotclock"].robot
    length = robot.l11 + robot.l12 + robot.l21 + robot.l22
    assert compared.figures == {"a": {"bars": length}, "b": {"bars": length}}


@pytest.mark.deep
def test_designs_bring_their_task_and_place():
    table, space = (0.06, 0.04), {"l1": (0.08, 0.12), "l2": (0.1, 0.14), "task_y": (0.08, 0.14)}
    best = fb.design("det_A", space, table=table, step=0.01, effort=0.02, poses=(3, 3))
    compared = fb.compare({"lab": ROBOTS["lab"], "best": best})
    assert compared.figures["best"] == pytest.approx(best.values, rel=1e-12)
    of_place = fb.compare({"best": best}, "det_A", table=table, poses=(3, 3))
    assert of_place.figures["best"]["det_A"] == pytest.approx(best.values["det_A"], rel=1e-12)
    points = np.stack(np.meshgrid([-0.03, 0.0, 0.03], [0.1, 0.11, 0.12]), axis=-1)
    of_lab = np.abs(fb.igm(ROBOTS["lab"], points, (1, -1)).det_A).min()
    there = fb.compare(ROBOTS, "det_A", table=(-0.03, 0.03, 0.1, 0.12), poses=(3, 3))
    assert np.isnan(compared.figures["lab"]["det_A"])  # Type 2 crosses that table
    assert there.figures["lab"]["det_A"] == pytest.approx(of_lab, rel=1e-12)
    title, row, note = str(fb.compare(ROBOTS, "inscribed_circle")).splitlines()
    assert row.endswith("-") and note.startswith("unequal: inscribed_circle: ValueError: ")


def test_what_does_not_compare_is_refused():
    with pytest.raises(TypeError, match=r"compare: runs\['b'\] must be a robot, .*, not 3"):
        fb.compare({"a": fb.FiveBar(), "b": 3})
    with pytest.raises(ValueError, match="figures: det_A needs table="):
        fb.compare(ROBOTS, "det_A")
    with pytest.raises(ValueError, match="figures: bars is of five-bars"):
        fb.compare({"a": fb.Biglide()})
    with pytest.raises(TypeError, match=r"compare: runs must be a dict \{name: Run\}"):
        fb.compare(3)
    run = fb.simulate(ROBOTS["lab"], reference=fb.line((0.09, 0.068), (0.08, 0.075), 0.1))
    with pytest.raises(
        ValueError, match="compare: table, figures: of designs only, these are runs"
    ):
        fb.compare({"a": run}, "det_A", table=(0.1, 0.1))
