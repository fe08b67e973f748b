"""Crosses of a test drawing in a photograph of its sheet.

The sheet's four edges give scale and perspective, so that places are in the sheet's own frame, m.
They are straight, and show how the lens bends lines. The drawn grid does not tell that: its errors
are the robot's, and they are what is to be measured.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import (
    binary_fill_holes,
    center_of_mass,
    find_objects,
    gaussian_filter,
    label,
    map_coordinates,
    uniform_filter,
)
from scipy.optimize import least_squares, linear_sum_assignment

from ...base.backend import finite_numbers, pairs
from ...base.checks import one_of, shown, two_numbers
from .sheet import ARM, MARK, PAPERS, Sheet

PIXEL = 1e-4  # m, of the sheet put straight
LEAST = 0.05  # of the photograph, that the sheet fills
CONTRAST = 1.1  # of the sheet's brightness to the ground's, at least
COARSE = 200  # pixels along the shorter side are enough to see the sheet
INK = 0.25  # of the paper's brightness, by which ink is darker
AROUND = 5e-3  # m, side of the squares over which the paper's brightness is averaged
MOST = 400  # marks on the sheet: as many are no drawing, but noise
NEAR = 0.35  # of the distance between crosses, within which one is known again
ROUNDS = 3
LIGHTS = 8  # rounds of the light, from the paper that is known to the whole sheet
BAND = 0.03  # of an edge's length, to either side, in which a bowed edge is searched
CROOKED = 0.7  # pixels, by which edges may be off straight lines
BENDINGS = 5  # of Newton's steps to the point that a lens puts at a place
CUT = 0.02  # of a side, by which a sheet may be cut wrong


def crosses_in(
    photo: ArrayLike, sheet: Sheet, paper: str = "A5", size: ArrayLike | None = None
) -> np.ndarray:
    """Return where the crosses of a sheet are on its paper (n, 2), m; nan where one is not found.

    The x axis is along the longer side, from the corner where the drawing stands upright.

    Parameters
    ----------
    photo : (rows, columns) or (rows, columns, 3 or 4)
        Brightness. The whole sheet is on it, on a darker ground.
    sheet : Sheet
    paper : "A4" or "A5"
    size : (2,), optional
        Longer and shorter side of this very sheet, m, by a ruler. Sheets are cut to 0.5 %, and all
        lengths are as wrong as their scale.

    Raises
    ------
    ValueError
        There is no sheet, or its marks are not on it, or its sides are not those of the paper; the
        message says which.

    References
    ----------
    Brown, Close-range camera calibration, 1971 (lenses by straight lines).
    """
    image = finite_numbers(photo, "photo")
    if image.ndim == 3:
        image = image[..., :3].mean(axis=2)
    if image.ndim != 2 or min(image.shape) < 100:
        raise ValueError(f"photo must be (rows, columns), 100 at least, not {shown(image.shape)}")
    smooth = gaussian_filter(image, 1.0)
    measured = _sides(paper, size)
    corners, lens = _corners(smooth)
    edges = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    if edges[::2].sum() < edges[1::2].sum():  # opposite ones together, as a tilt changes each
        corners = np.roll(corners, 1, axis=0)
    straight = _straightened(image, corners, measured, lens)
    centres, sides = _marks(straight)
    return _known_again(sheet, measured, centres, sides)


def _corners(image):
    """Return the corners (4, 2) of the sheet, as row and column of a straight lens, in order along
    its edge; and the Lens.
    """
    step = max(1, min(image.shape) // COARSE)
    mask = _paper(image[::step, ::step])
    inside = mask[1:-1, 1:-1]
    if inside.sum() < mask.sum():
        raise ValueError("photo: the sheet is cut off: all four corners must be on it")
    rough = step * _rough_corners(np.argwhere(mask).astype(float))
    after = np.roll(rough, -1, axis=0)
    edges = [_edge(image, start, end) for start, end in zip(rough, after)]
    lens = Lens.of(edges, image.shape)
    lines = []
    for edge in edges:
        middle, normal = _line_through(lens.straight(edge))
        lines.append([*normal, normal @ middle])
    before = np.roll(lines, 1, axis=0)
    pairs = np.stack([before, lines], axis=1)
    normals = pairs[..., :2]
    distances = pairs[..., 2:]
    return np.linalg.solve(normals, distances)[..., 0], lens


def _paper(image):
    """Return where the sheet is, bool.

    The light may change over it: its logarithm is a polynomial of degree 2, which the paper
    tells, all of one brightness. Halfway to the ground's brightness the sheet ends.
    """
    darkest = 1e-2 * abs(np.quantile(image, 0.98)) + 1e-300
    even = brightness = np.log(np.maximum(image, darkest))
    row, column = np.meshgrid(*(np.linspace(-1, 1, n) for n in image.shape), indexing="ij")
    terms = np.stack([row**0, row, column, row**2, row * column, column**2], axis=-1)
    level = np.quantile(even, (0.02, 0.98)).mean()
    for _ in range(LIGHTS):
        bright = even > level
        # The drawing's frame parts its inside from the border: so holes are filled.
        parts, _ = label(binary_fill_holes(bright))
        sizes = np.bincount(parts.ravel())
        sizes[0] = 0
        sheet = parts == sizes.argmax()
        paper = sheet & bright
        light, *_ = np.linalg.lstsq(terms[paper], brightness[paper], rcond=None)
        even = brightness - terms @ light
        level = np.median(even[~bright]) / 2
        if sizes.max() < LEAST * image.size or level > -np.log(CONTRAST) / 2:
            raise ValueError("photo: no sheet, bright on a darker ground, fills a part of it")
    return sheet


def _rough_corners(points):
    """Return the corners (4, 2) of a quadrilateral among its points, in order along its edge."""
    z = points @ (1, 1j)
    first = np.abs(z - z.mean()).argmax()
    away = z - z[first]
    third = np.abs(away).argmax()
    side = (away.conj() * away[third]).imag
    return points[[first, side.argmax(), third, side.argmin()]]


def _sides(paper, size):
    """Return the longer and the shorter side, m, of a sheet."""
    known = PAPERS[one_of(*PAPERS)(paper, "paper")]
    if size is None:
        return known
    sides = two_numbers(size, "size")
    if max(abs(side / own - 1) for side, own in zip(sides, known)) > CUT:
        long, short = (1e3 * side for side in known)
        raise ValueError(
            f"size: {1e3 * sides[0]:g} x {1e3 * sides[1]:g} mm is no sheet of {paper}, which is"
            f" about {long:g} x {short:g} mm, its longer side first"
        )
    return sides


def _edge(image, start, end):
    """Return points (n, 2) of the edge from start to end, to a part of a pixel.

    There the brightness is halfway between the sheet's and the ground's beside it. A lens bows an
    edge, so that it is searched in a wide band; a polynomial leaves out what is far from the
    others.
    """
    along = end - start
    row, column = along
    length = np.linalg.norm(along)
    across = np.array([-column, row]) / length
    share = np.linspace(0.04, 0.96, 240)
    places = start + share[:, None] * along
    half = max(BAND * length, 8.0)
    offsets = np.linspace(-half, half, int(8 * half) + 1)
    samples = places[:, None] + offsets[:, None] * across
    values = map_coordinates(image, np.moveaxis(samples, -1, 0), order=1, mode="nearest")
    if values[:, 0].mean() > values[:, -1].mean():  # from outside, where the ground is dark
        values = values[:, ::-1]
        offsets = offsets[::-1]
    level = np.quantile(values, (0.1, 0.9), axis=1).mean(axis=0)
    over = values > level[:, None]
    change = over[:, 1:] & ~over[:, :-1]
    found = change.any(axis=1)
    first = change.argmax(axis=1)[found]
    profiles = values[found]
    profile = np.arange(len(first))
    before = profiles[profile, first]
    after = profiles[profile, first + 1]
    part = (level[found] - before) / (after - before)
    step = offsets[1] - offsets[0]
    at = offsets[first] + part * step
    near = np.ones(len(at), dtype=bool)
    for _ in range(ROUNDS):
        bow = np.polynomial.Polynomial.fit(share[found][near], at[near], 4)
        off = np.abs(at - bow(share[found]))
        near = off < max(2.0 * np.median(off), 0.5)
    return places[found][near] + at[near][:, None] * across


class Lens(NamedTuple):
    """Radial distortion about the middle of a photograph: where a straight lens would have put a
    point is 1 + k1 r^2 + k2 r^4 times as far from the middle, r in half diagonals.
    """

    middle: np.ndarray
    radius: float
    k1: float = 0.0
    k2: float = 0.0

    @classmethod
    def of(cls, edges: list[np.ndarray], shape: tuple[int, int]) -> Lens:
        """Return the lens through which these edges (n, 2) of a sheet are straight."""
        middle = (np.array(shape) - 1) / 2
        radius = float(np.linalg.norm(middle))

        def bows(k):
            lens = cls(middle, radius, *k)
            away = []
            for edge in edges:
                straight = lens.straight(edge)
                centre, normal = _line_through(straight)
                away.append((straight - centre) @ normal)
            return np.concatenate(away)

        found = least_squares(bows, (0.0, 0.0))
        off = float(np.sqrt(np.mean(found.fun**2)))
        if off > CROOKED or np.abs(found.x).max() > 1.0:
            raise ValueError(
                f"photo: the sheet's edges are not straight, but {off:.3g} pixels off: lay it flat,"
                " and take the whole photograph, not cut out of a larger one"
            )
        return cls(middle, radius, *found.x.tolist())

    def _factor(self, points):
        square = np.sum(points**2, axis=-1, keepdims=True) / self.radius**2
        return 1 + square * (self.k1 + square * self.k2)

    def straight(self, points: np.ndarray) -> np.ndarray:
        """Return where a straight lens would have put points (..., 2)."""
        away = points - self.middle
        return self.middle + away * self._factor(away)

    def bent(self, points: np.ndarray) -> np.ndarray:
        """Return where on the photograph points (..., 2) of a straight lens are."""
        goal = points - self.middle
        square = np.sum(goal**2, axis=-1, keepdims=True) / self.radius**2
        share = np.ones_like(square)  # of the straight distance, at which a point is bent to
        for _ in range(BENDINGS):
            r2 = square * share**2
            factor = 1 + r2 * (self.k1 + r2 * self.k2)
            slope = 1 + r2 * (3 * self.k1 + 5 * r2 * self.k2)
            share -= (share * factor - 1) / slope
        return self.middle + share * goal


def _line_through(points):
    """Return the middle (2,) and the unit normal (2,) of the line that is nearest to points."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    return middle, axes[1]


def _straightened(image, corners, size, lens):
    """Return the sheet, a pixel for each PIXEL of it, by the perspective of its corners."""
    width, height = size
    known = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    equations = []
    for (x, y), (row, column) in zip(known, corners):
        equations.append([x, y, 1, 0, 0, 0, -row * x, -row * y])
        equations.append([0, 0, 0, x, y, 1, -column * x, -column * y])
    unknowns = np.linalg.solve(equations, corners.ravel())
    homography = np.append(unknowns, 1.0).reshape(3, 3)
    x, y = np.meshgrid(
        np.arange(PIXEL / 2, width, PIXEL), np.arange(PIXEL / 2, height, PIXEL), indexing="ij"
    )
    grid = np.stack([x, y, np.ones_like(x)])
    row, column, scale = np.einsum("ij,jxy->ixy", homography, grid)
    places = lens.bent(np.stack([row / scale, column / scale], axis=-1))
    return map_coordinates(image, np.moveaxis(places, -1, 0), order=1)


def _marks(straight):
    """Return the middles (k, 2), m, of all marks, and the larger sides of their boxes, m."""
    paper = uniform_filter(straight, int(AROUND / PIXEL))
    ink = np.clip(1 - straight / paper, 0.0, None)
    border = int(2e-3 / PIXEL)
    inner = slice(border, -border)
    ink = np.pad(ink[inner, inner], border)
    dark = gaussian_filter(ink, 1.0) > INK / 2
    parts, count = label(dark)
    if not 0 < count < MOST:
        return np.empty((0, 2)), np.empty(0)
    centres = center_of_mass(ink, parts, np.arange(1, count + 1))
    sides = []
    for rows, columns in find_objects(parts):
        sides.append(max(rows.stop - rows.start, columns.stop - columns.start))
    return PIXEL * (np.array(centres) + 0.5), PIXEL * np.array(sides)


def _known_again(sheet, size, centres, sides):
    """Return where which cross is: the marked one, A1, and the one farthest from it begin.

    A sheet has two corners from which its longer side is the x axis; the photograph does not tell
    one from the other, but the drawing does.
    """
    cross = 2 * ARM
    is_cross = (sides > 0.7 * cross) & (sides < 1.4 * cross)
    is_mark = (sides > 0.8 * MARK) & (sides < 1.25 * MARK)
    # In complex numbers, a turn with a scale is one factor.
    candidates = centres[is_cross] @ (1, 1j)
    marks = centres[is_mark] @ (1, 1j)
    wanted = sheet.crosses @ (1, 1j)
    if len(candidates) < 4 or len(marks) != 1:
        raise ValueError(
            f"photo: {len(candidates)} crosses and {len(marks)} marks of the first one are on the"
            f" sheet, of {len(wanted)} and 1: draw it again, or photograph it larger and"
            " sharper"
        )
    from_mark = np.abs(candidates - marks[0])
    first = candidates[from_mark.argmin()]
    from_first = np.abs(candidates - first)
    last = candidates[from_first.argmax()]
    spacing = np.abs(wanted[1:] - wanted[0]).min()
    turned = (last - first) / (wanted[-1] - wanted[0])
    shift = first - turned * wanted[0]
    for _ in range(ROUNDS):
        guess = shift + turned * wanted
        apart = np.abs(guess[:, None] - candidates)
        crosses, matches = linear_sum_assignment(apart)
        near = apart[crosses, matches] < NEAR * spacing
        crosses = crosses[near]
        matches = candidates[matches[near]]
        if len(crosses) < 4:
            raise ValueError("photo: the crosses on the sheet are not those of this drawing")
        known = wanted[crosses]
        columns = np.stack([known, np.ones_like(known)], axis=1)
        solution, *_ = np.linalg.lstsq(columns, matches, rcond=None)
        turned, shift = solution
    found = np.full(len(wanted), np.nan * (1 + 1j))
    found[crosses] = matches
    if turned.real < 0:
        width, height = size
        found = complex(width, height) - found
    return pairs(found)
