"""Figures as files: text stays text, in fonts that journals take, in whatever figure it stands."""

import matplotlib.pyplot as plt
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()


@pytest.mark.parametrize("own", [False, True])
def test_files_have_text_in_fonts_that_journals_take(tmp_path, own):
    pose = fb.igm(ROBOT, (0.05, 0.09))
    if own:
        figure, axes = plt.subplots()
        fb.plot.pose(pose, axes=axes)
        plt.close(figure)
    else:
        figure = fb.plot.pose(pose)
    figure.savefig(tmp_path / "a.pdf")
    figure.savefig(tmp_path / "a.svg")
    assert b"Type3" not in (tmp_path / "a.pdf").read_bytes()
    assert "x (mm)</text>" in (tmp_path / "a.svg").read_text("utf-8")
