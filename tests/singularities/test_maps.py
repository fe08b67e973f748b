"""Maps against the models node by node, their files, their limits."""

import csv
import os
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.locus import MODES
from fivebar.singularities.maps import FIELDS, Map, singularity_map, turned_into, workspace_window
from fivebar.singularities.margins import singularity_margins

UNEQUAL = fb.FiveBar(l11=0.11, l12=0.14, l21=0.08, l22=0.12, d=0.09)
TOP = np.sqrt(0.18**2 - 0.059**2)  # of the lens that AMORO's robot reaches


@pytest.mark.parametrize("field", FIELDS)
def test_nodes_are_the_margins_of_igm(field):
    data = singularity_map(UNEQUAL, field, shape=(37, 300))
    assert data.values.shape == (4, 300, 37) and data.modes == MODES
    x, y = np.meshgrid(data.x, data.y)
    for mode, layer in zip(data.modes, data.values):
        pose = fb.igm(UNEQUAL, np.stack([x, y], axis=-1), mode, unreachable="nan")
        np.testing.assert_array_equal(layer, FIELDS[field][1](singularity_margins(pose)))


def test_joint_space_is_the_margins_of_dgm():
    data = singularity_map(UNEQUAL, "serial_right", "joint", shape=(61, 40))
    q = np.stack(np.meshgrid(data.x, data.y), axis=-1)
    assert data.modes == (1, -1) and data.x[0] == -np.pi and data.y[-1] == np.pi
    for mode, layer in zip(data.modes, data.values):
        pose = fb.dgm(UNEQUAL, q, mode, unreachable="nan")
        np.testing.assert_allclose(layer, np.sin(pose.q_passive[..., 1]), atol=1e-12)
        assert 0.5 < np.isfinite(layer).mean() < 1


@pytest.mark.parametrize("name", ["amoro", "hoang-2015", "liu-2006-a", "liu-2006-e"])
def test_default_window_fits_the_workspace(name):
    robot = fb.ROBOTS[name].robot
    closes = np.isfinite(singularity_map(robot, shape=(301, 301)).values[0])
    rows, columns = np.flatnonzero(closes.any(axis=1)), np.flatnonzero(closes.any(axis=0))
    for first, last in (rows[[0, -1]], columns[[0, -1]]):
        assert 5 <= first <= 75 and 225 <= last <= 295
    assert min(rows[0], columns[0]) <= 13  # a border of 4 % of the longer side


def test_npz_comes_back(tmp_path):
    for space in ("task", "joint"):
        data = singularity_map(UNEQUAL, "condition_J", space, shape=(20, 30))
        data.to_npz(tmp_path / "map.npz")
        back = Map.from_npz(tmp_path / "map.npz")
        assert (back.robot, back.field, back.space, back.modes) == (
            data.robot,
            data.field,
            data.space,
            data.modes,
        )
        for name in ("x", "y", "values"):
            np.testing.assert_array_equal(getattr(back, name), getattr(data, name))


def test_csv_has_all_nodes_that_close(tmp_path):
    data = singularity_map(fb.FiveBar(), shape=(21, 30))
    data.to_csv(tmp_path / "map.csv")
    assert b"\r" not in (tmp_path / "map.csv").read_bytes()
    with open(tmp_path / "map.csv", newline="", encoding="utf-8") as file:
        assert file.readline().startswith("# fivebar map, SI units: {")
        header, *rows = csv.reader(file)
    assert header == ["x", "y", *(f"parallel({a:+d},{b:+d})" for a, b in MODES)]
    closes = ~np.isnan(data.values).all(axis=0)
    table = np.array(rows, dtype=float)
    assert len(table) == closes.sum() < closes.size
    np.testing.assert_array_equal(table[:, 2:], data.values[:, closes].T)
    np.testing.assert_array_equal(table[:, 0], np.broadcast_to(data.x, closes.shape)[closes])


@pytest.mark.parametrize("content", [b"", b"no map", b"PK\x03\x04"])
def test_other_files_are_refused(tmp_path, content):
    (tmp_path / "other.npz").write_bytes(content)
    with pytest.raises(ValueError, match="is not a map written by to_npz"):
        Map.from_npz(tmp_path / "other.npz")
    with pytest.raises(TypeError, match="to read, a path"):
        Map.from_npz(3)


def test_a_map_of_another_shape_than_its_grid_is_refused(tmp_path):
    data = singularity_map(UNEQUAL, shape=(4, 5))
    replace(data, values=data.values[:, 1:]).to_npz(tmp_path / "map.npz")
    with pytest.raises(
        ValueError, match=r"to_npz: parallel \(4, 4, 4\) on a grid of \(4,\) x \(5,\) nodes"
    ):
        Map.from_npz(tmp_path / "map.npz")
    replace(data, field="none").to_npz(tmp_path / "map.npz")
    with pytest.raises(ValueError, match="to_npz: none "):
        Map.from_npz(tmp_path / "map.npz")


def test_a_page_has_its_path_and_title(tmp_path):
    singularity_map(UNEQUAL, shape=(4, 5)).page(tmp_path / "map.html", title="Far and near")
    assert "<title>Far and near</title>" in (tmp_path / "map.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "arguments, message",
    [
        (
            dict(field="determinant"),
            "field must be one of parallel, serial_left, .*, not 'determinant'",
        ),
        (dict(space="work"), "must be one of task, joint"),
        (dict(window=(1, 2, 0, 1)), "the end-effector reaches .-0.121, 0.121, -0.170"),
        (dict(window=(0, 1, 2)), "window must be four numbers"),
        *((dict(window=w), "finite min < max") for w in ((1, 0, 0, 1), (1, 1, 0, 1), (0, 1, 1, 1))),
        (dict(window=(0, np.nan, 0, 1)), "finite min < max"),
        (
            dict(window=(-3, -2.9, 0, 0.1), space="joint"),
            "no pose closes at the .* of the joint space",
        ),
        (
            dict(window=(-5, 10.01 * 2 * np.pi - 5, -5, 20 * np.pi - 5), space="joint"),
            "10.01 x 10 turns, .* loci 100 times",
        ),
        (dict(shape=(1, 5)), "two whole numbers"),
        (dict(shape=(5, 5, 5)), "two whole numbers"),
        (dict(shape=(10.5, 5)), "two whole numbers"),
        (dict(shape=100), "two whole numbers"),
        (dict(shape=(10**6, 10**6)), "1000000 x 1000000 nodes in 4 modes needs 2.98e.04 GiB"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(ValueError, match=message):
        singularity_map(fb.FiveBar(), **arguments)


@pytest.mark.parametrize("window", [(-7, 20 * np.pi - 7, 1, 1 + 20 * np.pi), (-30, 5, -10, 50)])
def test_points_are_turned_into_a_window(window):
    """By just those turns that bring one of them into it, of a window of up to a hundred turns."""
    wide = singularity_map(fb.FiveBar(), space="joint", window=window, shape=(9, 5))
    points = np.random.default_rng(3).uniform((-9, -2), (9, 16), (3, 2))
    shifts = (
        2
        * np.pi
        * np.stack(np.meshgrid(*[np.arange(-15, 16)] * 2, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    )
    low, high = (wide.x[0], wide.y[0]), (wide.x[-1], wide.y[-1])
    # As a box of all points, so that what joins them is drawn too.
    every = points + shifts
    meets = ((every.max(axis=1) >= low) & (every.min(axis=1) <= high)).all(axis=-1)
    np.testing.assert_allclose(list(turned_into(wide, points)), every[meets], atol=1e-13)


def test_a_map_takes_half_of_the_memory_at_most(monkeypatch):
    """Two by two nodes in four modes are 128 bytes."""
    memory, few = {"SC_PHYS_PAGES": 16, "SC_PAGE_SIZE": 16}, dict(window=(-0.03, 0.03, 0.08, 0.1))
    monkeypatch.setattr(os, "sysconf", memory.__getitem__)
    assert singularity_map(fb.FiveBar(), **few, shape=(2, 2)).values.shape == (4, 2, 2)
    with pytest.raises(
        ValueError,
        match="2 x 3 nodes in 4 modes needs 1.79e-07 GiB; 50% of this .* are 1.19e-07 GiB",
    ):
        singularity_map(fb.FiveBar(), **few, shape=(2, 3))
    monkeypatch.delattr(os, "sysconf")
    with pytest.raises(ValueError, match="50% of this machine's memory are 4 GiB"):
        singularity_map(fb.FiveBar(), shape=(10**6, 10**6))


@pytest.mark.parametrize(
    "robot, border, window",
    [
        (fb.FiveBar(), 0.1, (-0.121 - 0.1 * 2 * TOP, 0.121 + 0.1 * 2 * TOP, -1.2 * TOP, 1.2 * TOP)),
        (fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4), 0, (0, 0, 0, 0)),
        (fb.FiveBar(0.1, 0.15, 0.05, 0.1, 0.4), 0.04, (0.05 - 1e-8, 0.05 + 1e-8, -1e-8, 1e-8)),
        (
            fb.Biglide(l1=0.4, l2=0.25, d=0.3),
            0.1,
            (-0.19, 0.29, -0.24, 0.24),
        ),  # reaches beyond the left guide
        (fb.Biglide(l1=0.25, l2=0.4, d=0.3), 0.1, (-0.29, 0.19, -0.24, 0.24)),
        (fb.Biglide(l1=0.3, l2=0.35, d=0.6), 0.0, (-0.3, 0.3, -0.3, 0.3)),
    ],
)
def test_the_window_is_what_is_reached_and_a_border(robot, border, window):
    assert workspace_window(robot, border) == pytest.approx(
        window, rel=0, abs=1e-9 if border == 0.04 else 1e-5
    )


def test_workspace_of_one_point():
    robot = fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4)
    assert np.isfinite(singularity_map(robot).values[:, 200, 200]).all()


def test_a_million_nodes_in_four_modes():
    robot = fb.FiveBar()
    tracemalloc.start()
    singularity_map(robot, shape=(1000, 1000))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 50e6  # 32 MB are the map itself
