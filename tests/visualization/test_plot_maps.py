"""Pictures of maps: what is on them, not how they look."""

import subprocess
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import fivebar as fb
from fivebar.singularities.aspects import aspects
from fivebar.singularities.maps import singularity_map
from fivebar.singularities.passages import passages
from fivebar.visualization.plot import aspect_graph
from fivebar.visualization.plot import maps as pictures

AMORO = fb.FiveBar()
UNEQUAL = fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)


def panels(figure):
    return [axes for axes in figure.axes if axes.images]


def legend(figure):
    (found,) = [*figure.legends, *filter(None, (axes.get_legend() for axes in figure.axes))]
    return {text.get_text() for text in found.get_texts()}


@pytest.mark.deep
@pytest.mark.parametrize("kind, start", [("png", b"\x89PNG"), ("svg", b"<?xml")])
def test_four_panels_in_a_file(tmp_path, kind, start):
    figure = pictures.singularity_map(singularity_map(AMORO), path=[(0.09, 0.068), (0.05, 0.0)])
    figure.savefig(tmp_path / f"map.{kind}")
    assert (tmp_path / f"map.{kind}").read_bytes().startswith(start)
    titles = [axes.get_title() for axes in panels(figure)]
    assert titles == [
        "working modes (+1, +1): aspects 1 to 2",
        "working modes (+1, −1): aspects 3 to 5",
        "working modes (−1, +1): aspects 6 to 8",
        "working modes (−1, −1): aspects 9 to 10",
    ]
    assert legend(figure) == {
        "Type 1: a leg in line",
        "Type 1 in a point: a leg folded on its base",
        "Type 2: distal bars stretched",
        "Type 2: elbows coincide, self-motion",
        "Type 3",
        "base joint",
        "path, from ● to ■",
    }
    assert {axes.get_xlabel() for axes in panels(figure)} == {"", "x (mm)"}
    assert {axes.get_ylabel() for axes in panels(figure)} == {"", "y (mm)"}
    assert all(axes.get_aspect() == 1 for axes in panels(figure))


def test_dexterous_regions_take_the_place_of_the_aspects():
    regions = fb.dexterous(AMORO, 0.3, 0.2)
    figure = pictures.singularity_map(singularity_map(AMORO, shape=(31, 31)), dexterous=regions)
    assert panels(figure)[1].get_title() == "working modes (+1, −1): regions 3 to 5"
    assert "region that is left, inside its border" in legend(figure)
    for axes, working in zip(panels(figure), [(1, 1), (1, -1), (-1, 1), (-1, -1)]):
        for patch, region in zip(
            axes.patches, [r for r in regions if r.working == working], strict=True
        ):
            assert patch.get_path().contains_point(1e3 * region.point)
    empty = pictures.singularity_map(singularity_map(AMORO, shape=(31, 31)), dexterous=())
    assert panels(empty)[0].get_title() == "working modes (+1, +1): no region"


def test_numbers_stand_in_their_aspects():
    parts = aspects(UNEQUAL)
    figure = pictures.singularity_map(singularity_map(UNEQUAL))
    texts = [text for axes in panels(figure) for text in axes.texts]
    assert sorted(int(text.get_text()) for text in texts) == [part.number for part in parts]
    for text in texts:
        part = parts[int(text.get_text()) - 1]
        assert part.contains(np.array(getattr(text, "xy", text.get_position())) / 1e3)


def test_lines_lie_where_the_field_changes_sign():
    figure = pictures.singularity_map(singularity_map(UNEQUAL))
    for axes, mode in zip(panels(figure), ((1, 1), (1, -1), (-1, 1), (-1, -1))):
        lines = [line for line in axes.lines if line.get_label().startswith("Type 2")]
        assert lines
        for line in lines:
            xi = line.get_xydata()[1:-1] / 1e3
            assert np.abs(fb.igm(UNEQUAL, xi, mode).det_A).max() < 1e-6
    styles = {line.get_label(): line.get_linestyle() for line in figure.legends[0].get_lines()}
    dashes = {
        str(line._dash_pattern)
        for line in figure.legends[0].get_lines()
        if line.get_linestyle() != "None"
    }
    assert len(dashes) == 3 and len(styles) == 5  # told apart without colours


def test_joint_space():
    figure = pictures.singularity_map(
        singularity_map(AMORO, "serial_left", "joint", shape=(60, 60))
    )
    assert [axes.get_title() for axes in panels(figure)] == ["assembly mode +1", "assembly mode −1"]
    assert panels(figure)[0].get_xlim() == pytest.approx((-180, 180))
    assert panels(figure)[0].get_xlabel() == "$q_{11}$ (deg)"
    assert "Type 1: a leg in line" in legend(figure) and "Type 2: distal bars stretched" in legend(
        figure
    )
    for axes, mode in zip(panels(figure), (1, -1)):
        for line in axes.lines:
            q = np.radians(line.get_xydata())[
                2:-2
            ]  # they end where the elbows coincide and the legs may turn
            if line.get_label() == "Type 1: a leg in line":
                sines = fb.dgm(AMORO, q, mode, unreachable="nan").sines
                assert np.nanmax(np.min(np.abs(sines), axis=0)) < 1e-6


@pytest.mark.deep
@pytest.mark.parametrize(
    "field", ["serial_right", "transmission_angle", "manipulability", "condition_J"]
)
def test_every_field_has_a_picture(tmp_path, field):
    for space in ("task", "joint"):
        data = singularity_map(UNEQUAL, field, space, shape=(40, 40))
        figure = pictures.singularity_map(data)
        figure.savefig(tmp_path / "map.png", dpi=40)
        assert any(axes.get_ylabel().startswith(data.description[:8]) for axes in figure.axes)


@pytest.mark.deep
@pytest.mark.parametrize("name", ["hoang-2015", "liu-2006-e"])
def test_degenerate_robots(tmp_path, name):
    figure = pictures.singularity_map(singularity_map(fb.ROBOTS[name].robot, shape=(101, 101)))
    figure.savefig(tmp_path / "map.png", dpi=40)
    if name == "liu-2006-e":
        assert panels(figure)[0].get_title() == "working modes (+1, +1): no aspect"
    else:
        assert not any("Type 2" in words for words in legend(figure))


@pytest.mark.deep
def test_no_pyplot_and_nothing_at_import():
    code = (
        "import sys, fivebar; assert 'matplotlib' not in sys.modules;"
        "import fivebar.singularities.maps;"
        "assert 'matplotlib' not in sys.modules and 'scipy' not in sys.modules; from fivebar.visualization.plot import maps;"
        "maps.singularity_map(fivebar.singularities.maps.singularity_map(fivebar.FiveBar(), shape=(9, 9)));"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("robot", [AMORO, UNEQUAL], ids=["amoro", "unequal"])
def test_the_graph_has_every_aspect_and_every_passage(robot):
    figure = aspect_graph(robot)
    (axes,) = figure.axes
    at = {text.get_text(): np.array(text.get_position()) for text in axes.texts}
    assert all(str(a.number) in at for a in aspects(robot))
    for aspect in aspects(robot):  # in the quarter of its working modes
        assert (np.sign(at[str(aspect.number)]) == aspect.working).all()
    ends = {frozenset(map(tuple, patch._posA_posB)) for patch in axes.patches}
    assert ends == {
        frozenset(tuple(at[str(number)]) for number in p.between) for p in passages(robot)
    }
    folds = any(passage.fold for passage in passages(robot))
    assert any("folded" in words for words in legend(figure)) == folds == (robot is AMORO)


def test_a_graph_and_a_drawing_share_a_figure():
    own = Figure(layout="constrained")
    mine = own.subplots(2, 2).ravel()
    stroke = np.array([(0.05, 0.09), (0.06, 0.09), (0.06, 0.1)])
    drawn = [stroke + 1e-5], [np.full(3, 1.4e-5)]
    assert aspect_graph(AMORO, axes=mine[0]) is own
    assert fb.plot.drawing(AMORO, (-1, -1), [stroke], *drawn, axes=mine[1:]) is own
    assert [panel.get_title().partition(",")[0] for panel in mine] == [
        "",
        "the robot",
        "desired drawing",
        "drawn by the simulated robot",
    ]
    with pytest.raises(ValueError, match="axes: 3 of them for 2 panels"):
        fb.plot.drawing(AMORO, (-1, -1), [stroke], [], [], axes=mine[1:])


@pytest.mark.parametrize("robot", [AMORO, UNEQUAL], ids=["amoro", "unequal"])
def test_no_line_of_the_graph_passes_behind_a_node(robot):
    (axes,) = aspect_graph(robot).axes
    nodes = [np.array(t.get_position()) for t in axes.texts if t.get_text().isdigit()]
    assert len(nodes) == len(aspects(robot)) and axes.patches
    for patch in axes.patches:
        ends = np.array(patch._posA_posB)
        (first, middle, last) = patch.get_connectionstyle()(*ends).vertices
        s = np.linspace(0, 1, 200)[:, None]
        line = (1 - s) ** 2 * first + 2 * s * (1 - s) * middle + s**2 * last
        for node in nodes:
            if not (ends == node).all(axis=1).any():
                assert np.hypot(*(line - node).T).min() > 0.08  # a node's radius is 0.05


def test_text_in_files_is_text(tmp_path):
    """Not outlines: IEEE's check refuses Type 3, and what is an outline cannot be searched."""
    path = fb.path([(0.05, 0.09), (0.0, 0.1)])
    path.plot(tmp_path / "path.pdf")
    path.plot(tmp_path / "path.svg")
    streams = (tmp_path / "path.pdf").read_bytes()
    assert b"/CIDFontType2" in streams and b"/Type3" not in streams
    assert "x (mm)</text>" in (tmp_path / "path.svg").read_text("utf-8")


def test_a_map_for_a_journals_column_and_for_a_figure_of_ones_own():
    data = singularity_map(AMORO, shape=(21, 21))
    figure = pictures.singularity_map(data, modes=[(1, -1)], width="column")
    assert figure.get_figwidth() * 25.4 == pytest.approx(88)
    (panel,) = panels(figure)
    assert panel.get_title().startswith("working modes (+1, −1)")
    figure.draw_without_rendering()
    texts = [
        *panel.get_xticklabels(),
        panel.title,
        panel.xaxis.label,
        *figure.legends[0].get_texts(),
    ]
    assert {5.5 < text.get_fontsize() <= 7 for text in texts} == {True}
    own = Figure()
    mine = own.subplots(1, 3)
    assert pictures.singularity_map(data, modes=[(1, -1), (-1, 1)], axes=mine[:2]) is own
    assert fb.plot.pose(fb.igm(AMORO, (0.05, 0.09)), axes=mine[2]) is own and not own.legends
    assert all(axes.get_title() for axes in mine)
    with pytest.raises(ValueError, match="axes: 3 of them for 4 panels"):
        pictures.singularity_map(data, axes=mine)
    with pytest.raises(ValueError, match="modes: .*, where the map has"):
        pictures.singularity_map(data, modes=[(1, 0)])
