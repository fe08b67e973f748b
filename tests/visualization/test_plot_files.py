"""Figures as files and onto panels of one's own: text stays text, widths and letters are those asked for."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import fivebar as fb
from fivebar.optimal_design import grid
from fivebar.visualization.plot.panels import PALETTES
from fivebar.visualization.style import robot_title

ROBOT = fb.FiveBar()
MAP = fb.singularity_map(ROBOT, shape=(21, 21))
RUN = fb.simulate(ROBOT, fb.PD(ROBOT, 2, 0.2), fb.line((0.09, 0.068), (0.08, 0.075), 0.1))


@pytest.fixture
def own():
    """A figure of one's own with three panels."""
    figure, axes = plt.subplots(1, 3)
    yield figure, axes
    plt.close(figure)


@pytest.mark.parametrize("is_own", [False, True])
def test_files_have_text_in_fonts_that_journals_take(tmp_path, own, is_own):
    figure, axes = own
    drawn = fb.plot.pose(fb.igm(ROBOT, (0.05, 0.09)), axes=axes[0] if is_own else None)
    assert (drawn is figure) == is_own
    drawn.savefig(tmp_path / "a.pdf")
    drawn.savefig(tmp_path / "a.svg")
    assert b"Type3" not in (tmp_path / "a.pdf").read_bytes()
    assert "x (mm)</text>" in (tmp_path / "a.svg").read_text("utf-8")


def test_results_are_drawn_onto_given_panels(own):
    figure, axes = own
    assert RUN.plot(axes=axes) is figure
    assert [panel.get_ylabel() for panel in axes] == ["y (mm)", "error (mm)", "torque (mN m)"]
    axes[0].clear()
    assert RUN.plot(axes={"error": axes[0]}) is figure
    assert axes[0].get_title() == "tracking error of the end-effector"
    for panels, words in (
        (axes[:2], r"axes: 2 of them for 3 panels: path, error, torques; axes=\{'path': ...\}"),
        ({}, "no panel is given; the panels are path"),
        ({"speed": axes[0]}, "no panel speed; the panels are path, error, torques"),
    ):
        with pytest.raises(ValueError, match=words):
            RUN.plot(axes=panels)
    with pytest.raises(TypeError, match="plot of a Run has no option 'mark'; it has path, axes, w"):
        RUN.plot(mark=1)
    with pytest.raises(ValueError, match="width is of a new figure"):
        RUN.plot(axes=axes, width="column")


@pytest.mark.parametrize("width, mm", [("column", 88), ("page", 181), (120, 120)])
def test_figures_have_the_width_that_is_asked_for(width, mm):
    for figure in (RUN.plot(width=width), fb.plot.singularity_map(MAP, width=width)):
        assert figure.get_figwidth() == pytest.approx(mm / 25.4)
        assert figure.get_figheight() < 240 / 25.4
        sizes = [text.get_fontsize() for legend in figure.legends for text in legend.get_texts()]
        assert set(sizes) <= {7.0}


@pytest.mark.parametrize("width", ["columns", 0.088, -3, np.nan, [88]])
def test_a_width_that_is_none_says_what_is_one(width):
    with pytest.raises(
        ValueError, match='width must be "column" .88 mm., "page" .181 mm. or a numb'
    ):
        fb.plot.singularity_map(MAP, width=width)


def test_units_and_letters_are_those_of_the_paper():
    labels = {"x": "$x_P$", "parallel": "det A", "base joint": "A, E"}
    figure = fb.plot.singularity_map(MAP, modes=[(1, -1)], unit="m", labels=labels)
    panel, bar = figure.axes
    assert (panel.get_xlabel(), panel.get_ylabel(), bar.get_ylabel()) == (
        "$x_P$ (m)",
        "y (m)",
        "det A",
    )
    assert panel.get_xlim() == pytest.approx((MAP.x[0], MAP.x[-1]))
    assert "A, E" in {text.get_text() for text in figure.legends[0].get_texts()}
    with pytest.raises(ValueError, match="labels: nothing is called z; the map has .*x, y"):
        fb.plot.singularity_map(MAP, labels={"z": "z"})
    with pytest.raises(ValueError, match="unit must be 'mm', 'cm' or 'm'|unit must be .*mm"):
        fb.plot.singularity_map(MAP, unit="deg")


@pytest.mark.parametrize(
    "size, metre, unit", [(1e-4, 1e6, "µm"), (1.0, 1e3, "mm"), (20.0, 1e3, "mm"), (100.0, 1.0, "m")]
)
def test_pictures_have_the_unit_of_the_robots_size(size, metre, unit):
    robot = fb.FiveBar(*size * np.array([0.1, 0.12, 0.09, 0.11, 0.07]))
    data = fb.singularity_map(robot, shape=(21, 21))
    panel = fb.plot.singularity_map(data, modes=[(1, -1)]).axes[0]
    assert panel.get_xlabel() == f"x ({unit})"
    assert panel.get_xlim() == pytest.approx((metre * data.x[0], metre * data.x[-1]))
    bars = ", ".join(f"{metre * size * x:.4g}" for x in (0.1, 0.12, 0.09, 0.11))
    assert robot_title(robot).endswith(
        f", bars {bars} {unit}, base {metre * size * 0.07:.4g} {unit}"
    )
    both = fb.compare({"other": fb.FiveBar(), "robot": robot}, "bars").plot().axes[:2]
    assert {each.get_xlabel() for each in both} == {f"x ({unit if size > 1 else 'mm'})"}
    given = fb.plot.singularity_map(data, modes=[(1, -1)], unit="µm").axes[0]
    assert given.get_ylabel() == "y (µm)" and given.get_xlim()[0] == pytest.approx(1e6 * data.x[0])


def test_maps_printed_in_grey_keep_their_signs():
    grey = PALETTES["diverging"](np.linspace(0, 1, 65))[:, :3] @ (0.299, 0.587, 0.114)
    assert (np.diff(grey) > 0).all() and grey[-1] - grey[0] > 0.45


def test_labels_of_narrow_maps_do_not_overlap():
    joint = fb.singularity_map(ROBOT, space="joint", shape=(21, 21))
    for data, options in ((joint, {}), (MAP, {"modes": [(1, -1)]})):
        figure = fb.plot.singularity_map(data, width="column", **options)
        figure.draw_without_rendering()
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                shown = [text for text in axis.get_ticklabels() if text.get_text()]
                boxes = [text.get_window_extent() for text in shown if text.get_visible()]
                assert not any(a.overlaps(b) for a, b in zip(boxes, boxes[1:]))
        left = figure.axes[0].yaxis.label.get_window_extent().x0
        assert left < 0.1 * figure.bbox.width


def swept(names, **axes):
    task = dict(table=(-0.01, 0.01, 0.1, 0.12), poses=(3, 3), motor=(1.0, 5.0))
    return fb.sweep(names, grid(axes), workers=1, **task)


def test_a_figure_that_no_design_has_is_drawn_without_a_value():
    result = swept(["tip_speed", "reach", "bars"], task_y=(1.0, 2.0, 3), task_x=(0.0, 1.0, 3))
    assert not len(result.best("tip_speed")) and (result["reach"] < 0).all()
    figure = result.plot()
    speed, _, bars, *of_colours = figure.axes
    assert not speed.lines and len(bars.lines) == 1
    labels = [axes.get_ylabel() for axes in of_colours]
    assert labels == ["tip speed (m/s)", "reach (m)", "bars (mm)"]
    low, high = of_colours[2].get_ylim()  # of one value
    assert 300 < low < 360 < high < 420


def test_contours_end_where_a_corner_has_no_value():
    result = swept("det_A", l1=(0.06, 0.14, 9), l2=(0.06, 0.16, 11))
    panel = result.plot(mark={"l1": 0.1, "l2": 0.13}).axes[0]
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("$l_{1}$ (mm)", "$l_{2}$ (mm)")
    value = result["det_A"].reshape(9, 11)
    whole = (
        (value[1:, 1:] > 0) & (value[1:, :-1] > 0) & (value[:-1, 1:] > 0) & (value[:-1, :-1] > 0)
    )
    assert 10 < whole.sum() < whole.size - 10
    fills = [each for each in panel.collections if each.get_facecolor().size and each.get_paths()]
    areas = [path for fill in fills[1:2] for path in fill.get_paths()]
    for i, j in np.ndindex(whole.shape):
        x, y = 60 + 10 * (i + 0.5), 60 + 10 * (j + 0.5)
        assert any(area.contains_point((x, y)) for area in areas) == whole[i, j], (x, y)
    marks = {
        line.get_label(): line.get_xydata()[0] for line in panel.lines if line.get_marker() in "oD"
    }
    np.testing.assert_allclose(marks["chosen"], (100, 130))
    with pytest.raises(
        ValueError, match=r"mark must be \{'l1': ..., 'l2': ...\}, a design's number"
    ):
        result.plot(mark={"l1": 0.1})
    with pytest.raises(ValueError, match="figure must be .*det_A.*, not 'speed'"):
        result.plot(figure="speed")


def test_three_parameters_are_small_multiples():
    result = swept(["det_A"], l1=(0.06, 0.12, 4), l2=(0.1, 0.16, 4), d=[0.06, 0.1, 0.14])
    figure = result.plot(mark={"l1": 0.08, "l2": 0.12, "d": 0.1})
    panels = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title() for axes in panels] == [f"det A, d = {d} mm" for d in (60, 100, 140)]
    marked = [[line.get_label() for line in axes.lines].count("chosen") for axes in panels]
    assert marked == [0, 1, 0]
    assert len(figure.axes) == 4  # and one colour bar


@pytest.mark.parametrize(("between", "width"), [([], None), ([0.08], "page")])
def test_panels_of_several_figures_stand_in_rows_with_a_bar_each(between, width):
    distances = [0.06, *between, 0.1]
    result = swept(["bars", "det_A"], l1=(0.06, 0.12, 3), l2=(0.1, 0.16, 3), d=distances)
    figure = result.plot(width=width)
    figure.draw_without_rendering()
    boxes = [axes.get_window_extent() for axes in figure.axes]
    titles = [axes.get_title() for axes in figure.axes[:4]]
    names = ["bars", "bars", "det A", "det A"]
    assert titles == [f"{name}, d = {d} mm" for name, d in zip(names, (60, 100, 60, 100))]
    assert boxes[0].y0 == boxes[1].y0 > boxes[2].y1
    bars = {axes.get_ylabel(): box for axes, box in zip(figure.axes[4:], boxes[4:])}
    assert bars.keys() == {"bars (mm)", "det A"}
    for bar, panel in zip(bars.values(), boxes[::2]):
        assert bar.y0 == pytest.approx(panel.y0, abs=2) and bar.y1 == pytest.approx(panel.y1, abs=2)


def test_designs_side_by_side_have_one_bar_and_a_legend():
    compared = fb.compare({"lab": ROBOT, "narrow": fb.FiveBar(d=0.1)}, "workspace_area")
    figure = compared.plot(width="page")
    assert len(figure.axes) == 3 and figure.legends
    assert "workspace area = 600.8 cm²" in figure.axes[0].get_title()
    figure.draw_without_rendering()
    panel, bar = (figure.axes[k].get_window_extent() for k in (0, 2))
    assert bar.height == pytest.approx(panel.height, rel=0.05)


def test_the_graph_keeps_to_its_panel(own):
    figure, axes = own
    fb.plot.aspect_graph(ROBOT, axes=axes[1])
    figure.canvas.draw()
    boxes = [text.get_window_extent() for text in axes[1].texts[:4]]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    assert axes[1].get_legend() is None and len(axes[1].get_legend_handles_labels()[1]) >= 5
