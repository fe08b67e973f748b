"""The linked page of a singularity map: the models in its script against Python's, and what pointing at it shows."""

import csv
import io
import json
import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.visualization.pages.linked import map_page
from fivebar.visualization.style import TYPE_2

from ..conftest import UNEQUAL
from ..helpers.browsing import settle, until
from ..helpers.pages import (  # noqa: F401  fixtures
    bars,
    browser,
    chain,
    contrast,
    download,
    hover,
    opened,
    seen,
)

ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": UNEQUAL,
    "hoang": fb.ROBOTS["hoang-2015"].robot,
    "biglide": fb.Biglide(l2=0.3),
}


def written(tmp_path, robot=fb.FiveBar(), field="parallel", space="task", shape=(41, 57)):  # noqa: B008  frozen
    data = fb.singularity_map(robot, field, space, shape=shape)
    path = tmp_path / "page.html"
    data.page(path)
    return data, path


def columns(page, names):
    """{name: (n, ...)} of what the page's model gave for many poses, nan where it has no number."""
    return {
        name: np.array(page.evaluate(f"poses.map(pose => pose.{name})"), dtype=float)
        for name in names
    }


@pytest.mark.deep
@pytest.mark.parametrize("name", ["unequal", "biglide"])
def test_models_of_the_page_are_those_of_python(opened, tmp_path, name):  # noqa: F811
    robot = ROBOTS[name]
    page = opened(written(tmp_path, robot)[1])
    rng = np.random.default_rng(5)
    size = sum(robot.distal) + robot.d
    xi, working = rng.uniform(-size, size, (500, 2)), rng.choice([-1, 1], (500, 2))
    q, assembly = rng.uniform(-np.pi, np.pi, (500, 2)), rng.choice([-1, 1], 500)
    for code, points, modes, pose in [
        ("igm", xi, working, fb.igm(robot, xi, working, unreachable="nan")),
        ("dgm", q, assembly, fb.dgm(robot, q, assembly, unreachable="nan")),
    ]:
        page.evaluate(
            f"([points, modes]) => {{ globalThis.poses = points.map((point, k) => {code}(point, modes[k])); }}",
            [points.tolist(), modes.tolist()],
        )
        found = columns(
            page,
            [
                "q",
                "xi",
                "elbows",
                "serial",
                "parallel",
                "transmission",
                "working",
                "assembly",
                "closes",
            ],
        )
        closes = np.isfinite(pose.reach_margin) & np.isfinite(pose.det_A)
        assert closes.sum() > 10
        np.testing.assert_array_equal(found["closes"], closes)
        margins = fb.singularity_margins(pose)
        for key, expected in {
            "q": pose.q,
            "xi": pose.xi,
            "elbows": pose.elbows,
            "serial": margins.serial,
            "parallel": margins.parallel,
            "transmission": margins.transmission_angle,
            "working": pose.working,
            "assembly": pose.assembly,
        }.items():
            np.testing.assert_allclose(
                found[key][closes], expected[closes], atol=1e-9, err_msg=f"{code} {key}"
            )


def test_pointing_at_the_map_shows_the_pose(opened, tmp_path):  # noqa: F811
    data, path = written(tmp_path)
    page = opened(path)
    for layer, (across, up) in [(3, (0.5, 0.8)), (0, (0.55, 0.75)), (1, (0.45, 0.2))]:
        page.get_by_role("radio").nth(layer).check()
        hover(page, 0, across, up)
        xi = page.evaluate("at")
        span = page.evaluate("[ranges.x.start, ranges.x.end, ranges.y.start, ranges.y.end]")
        width, height = span[1] - span[0], span[3] - span[2]
        np.testing.assert_allclose(
            np.multiply(1e3, xi), [span[0] + across * width, span[2] + up * height], atol=1
        )
        box = page.locator(".glass").bounding_box()
        assert box["width"] / box["height"] == pytest.approx(
            width / height, rel=1e-3
        )  # a metre is as long across as up
        pose = fb.igm(data.robot, xi, data.modes[layer])
        np.testing.assert_allclose(bars(page), chain(pose), atol=1e-9)
        for row, mode in enumerate(data.modes):
            own = fb.igm(data.robot, xi, mode)
            cells = page.locator("tbody tr").nth(row).locator("td").all_text_contents()
            margins = fb.singularity_margins(own)
            expected = [
                own.assembly,
                *np.degrees(own.q),
                *margins.serial,
                margins.parallel,
                np.degrees(margins.transmission_angle),
            ]
            shown = [float(cell.replace("−", "-")) for cell in cells[1:]]
            decimals = np.array([0, 2, 2, 4, 4, 4, 2])
            assert np.all(np.abs(np.subtract(shown, expected)) <= 0.51 * 10.0**-decimals)
            assert seen(page, row) == (
                row != layer
            )  # the other modes are pale behind the chosen one
        nearest = data.values[
            layer, np.abs(data.y - xi[1]).argmin(), np.abs(data.x - xi[0]).argmin()
        ]
        assert (
            f"sin(φ2 − φ1) at the nearest node: {nearest:.5g}".replace("-", "−")
            in page.locator(".state").text_content()
        )


@pytest.mark.deep
def test_the_map_of_a_biglide(opened, tmp_path):  # noqa: F811
    data, path = written(tmp_path, ROBOTS["biglide"])
    page = opened(path)
    hover(page, 0, 0.52, 0.7)
    xi = page.evaluate("at")
    pose = fb.igm(data.robot, xi)
    np.testing.assert_allclose(bars(page), chain(pose), atol=1e-9)
    assert page.locator("th").all_text_contents()[2:6] == [
        "q1 (mm)",
        "q2 (mm)",
        "sin phi1",
        "sin phi2",
    ]
    cells = page.locator("tbody tr").nth(3).locator("td").all_text_contents()
    shown = [float(c.replace("−", "-")) for c in cells[2:6]]
    np.testing.assert_allclose(
        shown, [*(1e3 * pose.q), *fb.singularity_margins(pose).serial], rtol=1e-4
    )
    assert "Type 1: a bar across its guide" in page.locator("figcaption").text_content()


@pytest.mark.deep
def test_out_of_reach_is_said(opened, tmp_path):  # noqa: F811
    page = opened(written(tmp_path)[1])
    hover(page, 0, 0.03, 0.03)
    assert not seen(page) and "out of reach" in page.locator(".state").text_content()
    xi = np.array(page.evaluate("at"))
    with pytest.raises(fb.UnreachableError) as refused:
        fb.igm(fb.FiveBar(), xi)
    notes = page.locator(".state").text_content().rsplit("a gap of ", 1)[1].split(" mm")[0]
    assert float(notes) == pytest.approx(1e3 * refused.value.gap, rel=1e-4)


@pytest.mark.deep
def test_keys_click_and_numbers(opened, tmp_path):  # noqa: F811
    data, path = written(tmp_path, UNEQUAL)
    page = opened(path)
    hover(page, 0, 0.5, 0.7)
    before = np.array(page.evaluate("at"))
    width = page.evaluate("ranges.x.end - ranges.x.start") / 1e3
    for key in ("ArrowRight", "ArrowUp", "ArrowUp", "Shift+ArrowLeft"):
        page.keyboard.press(key)
    page.keyboard.press("2")
    settle(page)
    now = np.array(page.evaluate("at"))
    np.testing.assert_allclose(now - before, [(1 / 100 - 1 / 2000) * width, 2 / 100 * width])
    np.testing.assert_allclose(bars(page), chain(fb.igm(UNEQUAL, now, data.modes[1])), atol=1e-9)
    until(page, "document.getElementById('status').textContent.includes('sin(φ2 − φ1)')")
    # the keys have taken hold of the point: the pointer does not move it before it is let go
    hover(page, 0, 0.4, 0.6)
    np.testing.assert_array_equal(page.evaluate("at"), now)
    page.get_by_role("button", name="Follow the pointer").click()
    hover(page, 0, 0.45, 0.6)
    assert page.evaluate("at[0]") < now[0]
    page.locator(".glass").click(position={"x": 200, "y": 150})
    assert page.get_by_role("button", name="Follow the pointer").count() == 1
    page.get_by_role("spinbutton", name="x (mm)").fill("21.5")
    page.keyboard.press("Tab")
    settle(page)
    assert page.evaluate("at[0]") == pytest.approx(0.0215, abs=1e-15)
    # zoomed in about the point, the link holds
    page.evaluate("zoom(0.25)")
    page.get_by_role("button", name="Follow the pointer").click()
    hover(page, 0, 0.5, 0.5)
    middle = np.array(
        page.evaluate("[(ranges.x.start + ranges.x.end) / 2, (ranges.y.start + ranges.y.end) / 2]")
    )
    np.testing.assert_allclose(page.evaluate("at"), middle / 1e3, atol=3e-4)


@pytest.mark.deep
@pytest.mark.parametrize("name", ["amoro", "biglide"])
def test_joint_space(opened, tmp_path, name):  # noqa: F811
    data, path = written(tmp_path, ROBOTS[name], field="condition_J", space="joint")
    page = opened(path)
    for layer in (0, 1):
        page.keyboard.press(str(layer + 1))
        hover(page, 0, 0.56, 0.62)
        q = page.evaluate("at")
        pose = fb.dgm(data.robot, q, data.modes[layer])
        np.testing.assert_allclose(bars(page), chain(pose), atol=1e-9)
        cells = page.locator("tbody tr").nth(layer).locator("td").all_text_contents()
        assert [float(c.replace("−", "-")) for c in cells[2:4]] == pytest.approx(
            (1e3 * pose.xi).tolist(), abs=5.1e-3
        )
        assert cells[1].replace("−", "-") == ", ".join(f"{mode:+d}" for mode in pose.working)


@pytest.mark.deep
def test_loci_are_the_exact_ones_and_aspects_have_their_numbers(opened, tmp_path):  # noqa: F811
    data, path = written(tmp_path)
    along = np.array([(0.0, 0.1), (0.01, 0.11), (0.03, 0.12)])
    map_page(data, path, along=along)
    page = opened(path)
    loci, aspects = fb.singularity_loci(data.robot), fb.aspects(data.robot)
    for layer, mode in enumerate(data.modes):
        page.keyboard.press(str(layer + 1))
        numbers = page.evaluate(
            "[[...numbered.data.text], [...numbered.data.x], [...numbered.data.y]]"
        )
        own = [aspect for aspect in aspects if aspect.working == mode]
        assert numbers[0] == [str(aspect.number) for aspect in own] and own
        np.testing.assert_allclose(
            np.transpose(numbers[1:]), [1e3 * aspect.point for aspect in own], rtol=1e-15
        )
        kinds = page.evaluate(
            "drawn.map(({kind, source}) => [kind, [...source.data.x], [...source.data.y]])"
        )
        shown = {kind: 1e-3 * np.array([x, y], dtype=float).T for kind, x, y in kinds}
        for kind, own in [
            ("stretched", TYPE_2["stretched"]),
            ("self-motion", TYPE_2["self-motion"]),
        ]:
            expected = [
                p.points
                for p in loci.task
                if p.kind == kind and mode in p.working and len(p.points) > 1
            ]
            points = shown[own][np.isfinite(shown[own]).all(axis=1)]
            np.testing.assert_allclose(
                points, np.concatenate(expected) if expected else np.empty((0, 2)), atol=1e-15
            )
        np.testing.assert_allclose(shown["path, from ● to ■"][:-1], along, rtol=1e-15)
    in_picture = page.evaluate("scene.curves.map(({xs, ys}) => [[...xs], [...ys]])")
    np.testing.assert_allclose(np.transpose(in_picture[-1]), along, rtol=1e-15)


@pytest.mark.deep
def test_csv_and_png(opened, tmp_path):  # noqa: F811
    data, path = written(tmp_path, field="manipulability", shape=(21, 30))
    page = opened(path)
    name, content = download(page, "CSV")
    first, head, *rows = content.decode().splitlines()
    assert name.startswith("singularity-map-five-bar") and "Map.to_csv writes all" in first
    assert next(csv.reader([head])) == list(data.columns)
    table = np.array([row.split(",") for row in rows], dtype=float)
    data.to_csv(tmp_path / "map.csv")
    expected = np.loadtxt(tmp_path / "map.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(table[:, :2], expected[:, :2])
    np.testing.assert_array_equal(table[:, 2:], expected[:, 2:].astype(np.float32))

    from matplotlib.image import imread

    picture = imread(io.BytesIO(download(page, "PNG")[1]))[..., :3]
    assert picture.shape[1] == 2200 and (np.ptp(picture[:, 1000:], axis=2) > 0.2).mean() > 0.01


@pytest.mark.deep
@pytest.mark.parametrize("field", ["transmission_angle", "sigma_min_B"])
def test_every_kind_of_field(opened, tmp_path, field):  # noqa: F811
    page = opened(written(tmp_path, UNEQUAL, field)[1])
    low, high = page.evaluate("[mapper.low, mapper.high]")
    assert low < high and page.evaluate("new Set(mapper.palette).size") > 100
    assert page.locator("h2").text_content().endswith("working modes −1, −1")


@pytest.mark.deep
def test_phone_in_the_dark(opened, tmp_path):  # noqa: F811
    page = opened(
        written(tmp_path)[1],
        width=390,
        height=844,
        has_touch=True,
        is_mobile=True,
        color_scheme="dark",
    )
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    box = page.locator(".glass").bounding_box()
    assert box["width"] > 200 and box["y"] > page.locator("svg.scene").bounding_box()["y"]
    page.touchscreen.tap(box["x"] + box["width"] / 2, box["y"] + 0.3 * box["height"])
    settle(page)
    assert seen(page) and abs(page.evaluate("at[0]")) < 2e-3
    colours = page.evaluate(
        "['td', 'body', '.state'].map(e => getComputedStyle(document.querySelector(e)))"
        ".map(style => [style.color, style.backgroundColor])"
    )
    paper = colours[1][1]
    assert contrast(colours[0][0], paper) > 7 and contrast(colours[2][0], paper) > 4.5


def test_size_and_notes(tmp_path, monkeypatch):
    data, path = written(tmp_path, shape=(401, 401))
    assert path.stat().st_size < 6e6 and "nodes; Map.to_csv has all" not in path.read_text("utf-8")
    data, path = written(tmp_path, shape=(1000, 600))
    assert (
        path.stat().st_size < 6e6
        and "holds 500 x 300 of 1000 x 600 nodes; Map.to_csv has all" in path.read_text("utf-8")
    )
    with pytest.raises(ValueError, match="the map's own margin: leave out show"):
        fb.page(data, tmp_path / "other.html", show="parallel")


@pytest.mark.deep
def test_from_the_command_line(tmp_path, capsys):
    page = tmp_path / "page.html"
    (tmp_path / "path.csv").write_text(
        "t_s,x,y\n" + "".join(f"{t},{0.01 * t},0.1\n" for t in range(7)), encoding="utf-8"
    )
    track = ["--path", str(tmp_path / "path.csv"), "--sin", "0.3"]
    assert (
        main(
            [
                "map",
                "--nodes",
                "31",
                "--out",
                str(tmp_path / "map.png"),
                "--page",
                str(page),
                *track,
            ]
        )
        == 0
    )
    assert capsys.readouterr().out.rstrip().endswith(str(page)) and page.stat().st_size > 1e6
    content = json.loads(
        re.search(
            r'<script type="application/json" id="content">(.*?)</script>', page.read_text("utf-8")
        )[1]
    )
    kinds = [locus["kind"] for locus in content["loci"]]
    assert (
        kinds.count("path, from ● to ■") == 1 and "region that is left, inside its border" in kinds
    )
    regions = fb.dexterous(fb.FiveBar(), sin=0.3)
    assert [number for number, *_ in content["numbers"]] == [region.number for region in regions]
