"""Parts of reading a photograph by themselves: lens, edges, perspective, marks, names of crosses."""

from types import SimpleNamespace

import numpy as np
import pytest

from fivebar.estimation.calibration.photo import (
    Lens,
    _corners,
    _edge,
    _known_again,
    _line_through,
    _marks,
    _paper,
    _sides,
    _straightened,
    crosses_in,
)
from fivebar.estimation.calibration.sheet import ARM, MARK


def test_a_lens_bends_what_it_makes_straight():
    lens = Lens(np.array([299.5, 399.5]), 499.0, -0.12, 0.03)
    points = np.random.default_rng(1).uniform((0, 0), (600, 800), (50, 2))
    assert lens.straight(lens.bent(points)) == pytest.approx(points, abs=1e-9)
    away = points - lens.middle
    square = (away**2).sum(axis=1) / 499.0**2
    factor = 1 - 0.12 * square + 0.03 * square**2
    assert lens.straight(points) == pytest.approx(lens.middle + away * factor[:, None])


def test_a_lens_is_found_by_edges_that_it_bends():
    true = Lens((np.array([600, 800]) - 1) / 2, np.hypot(299.5, 399.5), -0.08, 0.02)
    corners = np.array([[60.0, 70.0], [80.0, 720.0], [540.0, 740.0], [520.0, 50.0]])
    edges = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        edges.append(true.bent(a + np.linspace(0.04, 0.96, 80)[:, None] * (b - a)))
    found = Lens.of(edges, (600, 800))
    assert (found.k1, found.k2) == pytest.approx((-0.08, 0.02), abs=1e-4)
    assert found.radius == pytest.approx(true.radius) and found.middle == pytest.approx(true.middle)
    rng = np.random.default_rng(2)
    rough = [edge + rng.normal(scale=2.0, size=edge.shape) for edge in edges]
    with pytest.raises(ValueError, match=r"not straight, but [12]\.\d+ pixels off"):
        Lens.of(rough, (600, 800))


def test_the_line_through_points():
    rng = np.random.default_rng(3)
    along = rng.normal(size=(30, 1))
    points = np.array([3.0, -2.0]) + along * (0.6, 0.8)
    middle, normal = _line_through(points)
    assert middle == pytest.approx(points.mean(axis=0))
    assert np.abs(normal @ (0.6, 0.8)) < 1e-12 and normal @ normal == pytest.approx(1.0)


@pytest.mark.parametrize("way", [1, -1])
def test_an_edge_that_is_bowed_is_found_to_a_part_of_a_pixel(way):
    """A bright half, its border a parabola, with ink on it and a speck before it."""
    rows, columns = np.meshgrid(np.arange(200.0), np.arange(300.0), indexing="ij")
    border = 90.0 + 5.0 * ((columns - 150) / 150) ** 2
    image = np.clip(0.5 + way * (rows - border), 0.0, 1.0)
    image[100:104, 120:140] = 0.5 - 0.5 * way
    image[88:90, 200:203] = 0.5 + 0.5 * way
    start, end = np.array([95.0, 10.0]), np.array([95.0, 290.0])
    found = _edge(image, start, end)
    expected = 90.0 + 5.0 * ((found[:, 1] - 150) / 150) ** 2
    assert len(found) > 190
    assert np.abs(found[:, 0] - expected).max() < 0.3
    assert np.median(np.abs(found[:, 0] - expected)) < 0.1
    assert found[0, 1] == pytest.approx(10 + 0.04 * 280, abs=0.1)
    assert found[-1, 1] == pytest.approx(290 - 0.04 * 280, abs=0.1)


def test_sides_of_a_sheet():
    assert _sides("A4", None) == (0.297, 0.21)
    assert _sides("A5", (0.2099, 0.1478)) == (0.2099, 0.1478)
    assert _sides("A5", (0.21 * 1.019, 0.148)) == (0.21 * 1.019, 0.148)
    with pytest.raises(ValueError, match="148 x 210 mm is no sheet of A5, .* 210 x 148 mm"):
        _sides("A5", (0.148, 0.21))
    with pytest.raises(ValueError, match="no sheet of A5"):
        _sides("A5", (0.21 * 1.03, 0.148))


def test_a_sheet_is_put_straight_by_its_corners():
    """Brightness that is a plane of the sheet's own places comes back as that plane."""
    size = (0.03, 0.02)
    corners = np.array([[25.0, 30.0], [260.0, 45.0], [245.0, 215.0], [35.0, 200.0]])
    places = np.array([(0.0, 0.0), (0.03, 0.0), (0.03, 0.02), (0.0, 0.02)])
    matrix = []
    for (x, y), (row, column) in zip(places, corners):
        matrix.append([row, column, 1, 0, 0, 0, -x * row, -x * column])
        matrix.append([0, 0, 0, row, column, 1, -y * row, -y * column])
    back = np.append(np.linalg.solve(matrix, places.ravel()), 1.0).reshape(3, 3)
    rows, columns = np.meshgrid(np.arange(300.0), np.arange(250.0), indexing="ij")
    lens = Lens(np.array([149.5, 124.5]), 195.0, -0.05, 0.0)
    straight = np.moveaxis(lens.straight(np.stack([rows, columns], axis=-1)), -1, 0)
    x, y, scale = np.einsum("ij,jrc->irc", back, np.stack([*straight, np.ones_like(rows)]))
    found = _straightened(10 * x / scale - 5 * y / scale, corners, size, lens)
    assert found.shape == (300, 200)
    own_x, own_y = np.meshgrid(
        1e-4 * (np.arange(300) + 0.5), 1e-4 * (np.arange(200) + 0.5), indexing="ij"
    )
    assert found == pytest.approx(10 * own_x - 5 * own_y, abs=2e-3)


def test_marks_are_found_with_their_middles_and_sides():
    """In 10 pixels a millimetre; what touches the border, and specks, are none."""
    straight = 0.9 * np.ones((600, 500)) * np.linspace(0.9, 1.1, 500)
    squares = [(100, 130, 40), (300, 250, 30), (450, 401, 50)]
    for row, column, side in squares:
        straight[row : row + side, column : column + side] *= 0.2
    straight[10:12, 200:202] = 0.0
    straight[:15, 300:330] = 0.0
    straight[590:, :] = 0.0
    straight[:, :12] = 0.0
    middles, sides = _marks(straight)
    assert len(middles) == 3
    for (row, column, side), middle, found in zip(squares, middles, sides):
        assert middle == pytest.approx(
            1e-4 * np.array([row + side / 2, column + side / 2]), abs=1e-5
        )
        assert found == pytest.approx(1e-4 * side, abs=3e-4)
    noise = np.random.default_rng(4).uniform(size=(40, 40)) < 0.5
    middles, sides = _marks(0.9 - 0.8 * np.kron(noise, np.ones((15, 15))))
    assert middles.shape[1] == 2
    specks = np.full((600, 500), 0.9)
    for row in range(4):
        for column in range(4):
            specks[30 + row : 570 : 20, 30 + column : 470 : 20] = 0.0
    middles, sides = _marks(specks)
    assert middles.shape == (0, 2) and sides.shape == (0,)


def drawing():
    x, y = np.meshgrid(np.linspace(-0.08, 0.08, 4), np.linspace(-0.05, 0.05, 3))
    return SimpleNamespace(crosses=np.stack([x.ravel(), y.ravel()], axis=1))


@pytest.mark.parametrize("turn", [0.0, 3.1, -1.2])
def test_crosses_are_known_again_however_the_sheet_lies(turn):
    sheet = drawing()
    rng = np.random.default_rng(5)
    c, s = np.cos(turn), np.sin(turn)
    there = sheet.crosses @ np.array([[c, s], [-s, c]]) * 1.01 + (0.1, 0.07)
    there += rng.normal(scale=3e-4, size=there.shape)
    size = 0.2, 0.14
    read = np.array(size) - there if c < 0 else there  # from the corner where it stands upright
    order = rng.permutation(12)
    centres = np.concatenate([there[order], [there[0]], [[0.0, 0.3], [0.2, 0.3]]])
    sides = np.array([2 * ARM] * 12 + [MARK] + [0.3 * ARM, 8 * MARK])
    assert _known_again(sheet, size, centres, sides) == pytest.approx(read, abs=1e-12)
    seen = np.isin(order, [0, 2, 4, 5, 7, 11])
    few = np.concatenate([seen, np.ones(3, bool)])
    found = _known_again(sheet, size, centres[few], sides[few])
    for k in range(12):
        if k in (0, 2, 4, 5, 7, 11):
            assert found[k] == pytest.approx(read[k], abs=1e-12)
        else:
            assert np.isnan(found[k]).all()
    with pytest.raises(ValueError, match="3 crosses and 1 marks .* of 12 and 1"):
        few = np.isin(np.append(order, [99] * 3), [0, 2, 4]) | (np.arange(15) > 11)
        _known_again(sheet, size, centres[few], sides[few])
    with pytest.raises(ValueError, match="12 crosses and 0 marks"):
        _known_again(sheet, size, centres[:12], sides[:12])
    with pytest.raises(ValueError, match="not those of this drawing"):
        other = [(0.0, 0.0), (0.2, 0.2), (0.02, 0.15), (0.15, 0.01), (0.1, 0.19), (0.0, 0.0)]
        _known_again(sheet, size, np.array(other), np.array([2 * ARM] * 5 + [MARK]))


def sheet_on_ground(corners, shape=(300, 400), dark=0.1, bright=0.9):
    """A bright quadrilateral with sharp edges, its corners in order around it, and a dark frame."""
    rows, columns = np.meshgrid(np.arange(shape[0] * 1.0), np.arange(shape[1] * 1.0), indexing="ij")
    inside = np.full(shape, np.inf)
    middle = corners.mean(axis=0)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        normal = np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
        normal *= np.sign(normal @ (middle - a))
        inside = np.minimum(inside, (rows - a[0]) * normal[0] + (columns - a[1]) * normal[1])
    image = dark + (bright - dark) * np.clip(inside + 0.5, 0.0, 1.0)
    image[(inside > 20) & (inside < 23)] = dark
    return image


@pytest.mark.parametrize(
    "corners",
    [
        [(40.0, 60.0), (60.0, 350.0), (250.0, 330.0), (240.0, 40.0)],
        [(30.0, 200.0), (150.0, 370.0), (270.0, 190.0), (140.0, 30.0)],
    ],
)
def test_corners_of_a_sheet_are_found_to_a_part_of_a_pixel(corners):
    corners = np.array(corners)
    found, lens = _corners(sheet_on_ground(corners))
    distances = np.linalg.norm(found[:, None] - corners, axis=2)
    assert distances.min(axis=1).max() < 0.2
    # In order along the edge, one way around or the other.
    nearest = distances.argmin(axis=1)
    assert set(np.diff(nearest) % 4) in ({1}, {3})
    assert abs(lens.k1) < 0.01 and abs(lens.k2) < 0.01
    assert lens.middle.tolist() == [149.5, 199.5]


LIGHTS = {
    "a slope": lambda x, y: 1 - 0.5 * x,
    "two slopes": lambda x, y: (1 + 0.4 * x) * (1 - 0.3 * y),
    "vignetting": lambda x, y: (1 + 0.3 * (x**2 + y**2)) ** -2,
    "a soft shadow": lambda x, y: 1 - 0.4 / (1 + np.exp(8 * (x + 0.5 * y))),
}


@pytest.mark.parametrize("light", LIGHTS)
def test_a_sheet_and_its_marks_are_found_in_uneven_light(light):
    """Where the paper is darker in one place than the ground is in another."""
    corners = np.array([(40.0, 60.0), (60.0, 350.0), (250.0, 330.0), (240.0, 40.0)])
    image = sheet_on_ground(corners, dark=0.4)
    y, x = np.meshgrid(np.linspace(-1, 1, 300), np.linspace(-1, 1, 400), indexing="ij")
    lit = image * LIGHTS[light](x, y)
    assert np.mean(_paper(lit) == _paper(image)) > 0.99
    found, _ = _corners(lit)
    distances = np.linalg.norm(found[:, None] - corners, axis=2)
    assert distances.min(axis=1).max() < 0.4
    straight = np.full((600, 400), 0.9)
    straight[100:130, 350:380] = straight[450:490, 40:80] = 0.2
    y, x = np.meshgrid(np.linspace(-1, 1, 600), np.linspace(-1, 1, 400), indexing="ij")
    middles, sides = _marks(straight * LIGHTS[light](x, y))
    assert middles == pytest.approx(np.array([(115, 365), (470, 60)]) * 1e-4, abs=3e-5)
    assert sides == pytest.approx([3e-3, 4e-3], abs=3e-4)


def test_pictures_without_a_whole_sheet_are_refused():
    corners = np.array([(40.0, 60.0), (60.0, 350.0), (250.0, 330.0), (240.0, 40.0)])
    with pytest.raises(ValueError, match="no sheet, bright on a darker ground"):
        _corners(sheet_on_ground(corners, dark=0.85))
    small = corners.mean(axis=0) + (corners - corners.mean(axis=0)) * 0.2
    with pytest.raises(ValueError, match="no sheet, bright on a darker ground"):
        _corners(sheet_on_ground(small))
    with pytest.raises(ValueError, match="the sheet is cut off"):
        _corners(sheet_on_ground(corners - (45.0, 0.0)))


@pytest.mark.parametrize("shape", [(99, 300), (300, 99), (300,), (2, 300, 300, 3)])
def test_what_is_no_photograph_is_refused(shape):
    with pytest.raises(ValueError, match=r"photo must be \(rows, columns\), 100 at least, not"):
        crosses_in(np.zeros(shape), None)


@pytest.mark.parametrize("shape", [(100, 100), (100, 100, 3), (100, 100, 4)])
def test_a_black_photograph_has_no_sheet(shape):
    with pytest.raises(ValueError, match="no sheet, bright on a darker ground"):
        crosses_in(np.zeros(shape), None)
