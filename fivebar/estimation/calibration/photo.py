"""Crosses of a test drawing in a photograph of its sheet.

The sheet's four edges give scale and perspective, so that places are in the sheet's own frame, m.
The lens must be straight: a phone's distortion is not corrected.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import binary_fill_holes, gaussian_filter, label, map_coordinates
from scipy.optimize import linear_sum_assignment

from ...base.backend import finite_numbers
from ...base.checks import shown
from .sheet import ARM, MARK, PAPERS, Sheet

PIXEL = 1e-4  # m, of the sheet put straight
LEAST = 0.05  # of the photograph, that the sheet fills
INK = 0.25  # of the paper's brightness, by which ink is darker
NEAR = 0.35  # of the distance between crosses, within which one is known again
ROUNDS = 3


def crosses_in(photo: ArrayLike, sheet: Sheet, paper: str = "A5") -> np.ndarray:
    """Return where the crosses of a sheet are on its paper (n, 2), m; nan where one is not found.

    Parameters
    ----------
    photo : (rows, columns) or (rows, columns, 3 or 4)
        Brightness. The whole sheet is on it, on a darker ground.
    sheet : Sheet
    paper : "A4" or "A5"

    Raises
    ------
    ValueError
        There is no sheet, or its marks are not on it; the message says which.
    """
    image = finite_numbers(photo, "photo")
    if image.ndim == 3:
        image = image[..., :3].mean(axis=2)
    if image.ndim != 2 or min(image.shape) < 100:
        raise ValueError(f"photo must be (rows, columns), 100 at least, not {shown(image.shape)}")
    corners = _corners(gaussian_filter(image, 1.0))
    size = np.array(PAPERS[paper])
    if np.linalg.norm(corners[1] - corners[0]) < np.linalg.norm(corners[2] - corners[1]):
        corners = np.roll(corners, 1, axis=0)
    straight = _straightened(image, corners, size)
    centres, sides = _marks(straight)
    return _known_again(sheet, centres, sides)


def _corners(image):
    """Return the corners (4, 2) of the sheet, as row and column, in order along its edge."""
    dark, bright = np.quantile(image, (0.02, 0.98))
    level = (dark + bright) / 2
    parts, _ = label(binary_fill_holes(image > level))  # the frame parts its inside from the border
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    if bright - dark < 0.1 * abs(bright) or sizes.max() < LEAST * image.size:
        raise ValueError("photo: no sheet, bright on a darker ground, fills a part of it")
    mask = parts == sizes.argmax()
    if mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any():
        raise ValueError("photo: the sheet is cut off: all four corners must be on it")
    rows, columns = np.nonzero(mask)
    points = np.stack([rows, columns], axis=1).astype(float)
    rough = []
    for direction in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        rough.append(points[(points @ direction).argmax()])
    lines = [_edge(image, a, b, level) for a, b in zip(rough, np.roll(rough, -1, axis=0))]
    return np.array([_crossing(a, b) for a, b in zip(np.roll(lines, 1, axis=0), lines)])


def _edge(image, a, b, level):
    """Return the line (3,), n . x = c, of the edge from a to b, to a part of a pixel."""
    along = b - a
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    places = a + np.linspace(0.08, 0.92, 200)[:, None] * along
    offsets = np.linspace(-8.0, 8.0, 65)
    samples = places[:, None] + offsets[:, None] * across
    values = map_coordinates(image, np.moveaxis(samples, -1, 0), order=1, mode="nearest")
    over = values > level
    change = over[:, 1:] != over[:, :-1]
    found = change.any(axis=1)
    k = change.argmax(axis=1)[found]
    before, after = (values[found][np.arange(len(k)), j] for j in (k, k + 1))
    at = offsets[k] + (level - before) / (after - before) * (offsets[1] - offsets[0])
    edge = places[found] + at[:, None] * across
    middle = edge.mean(axis=0)
    _, _, axes = np.linalg.svd(edge - middle, full_matrices=False)
    normal = axes[1]
    near = np.abs((edge - middle) @ normal) < 2.0
    middle = edge[near].mean(axis=0)
    normal = np.linalg.svd(edge[near] - middle, full_matrices=False)[2][1]
    return np.array([*normal, normal @ middle])


def _crossing(one, other):
    return np.linalg.solve(np.stack([one[:2], other[:2]]), [one[2], other[2]])


def _straightened(image, corners, size):
    """Return the sheet, a pixel for each PIXEL of it, by the perspective of its corners."""
    width, height = size
    known = np.array([(0, 0), (width, 0), (width, height), (0, height)])
    equations = []
    for (x, y), (row, column) in zip(known, corners):
        equations.append([x, y, 1, 0, 0, 0, -row * x, -row * y])
        equations.append([0, 0, 0, x, y, 1, -column * x, -column * y])
    h = np.append(np.linalg.solve(np.array(equations), corners.ravel()), 1.0).reshape(3, 3)
    x, y = (np.arange(PIXEL / 2, side, PIXEL) for side in size)
    grid = np.stack([*np.meshgrid(x, y, indexing="ij"), np.ones((len(x), len(y)))])
    row, column, scale = np.einsum("ij,jxy->ixy", h, grid)
    return map_coordinates(image, [row / scale, column / scale], order=1, mode="nearest")


def _marks(straight):
    """Return the middles (k, 2), m, of all marks, and the larger sides of their boxes, m."""
    paper = gaussian_filter(np.quantile(straight, 0.9, axis=0), 20)
    ink = np.clip(1 - straight / paper, 0.0, None)
    border = int(2e-3 / PIXEL)
    ink[:border], ink[-border:], ink[:, :border], ink[:, -border:] = 0, 0, 0, 0
    parts, count = label(gaussian_filter(ink, 1.0) > INK / 2, structure=np.ones((3, 3)))
    centres, sides = [], []
    for k in range(1, count + 1):
        places = np.argwhere(parts == k) if count < 400 else np.empty((0, 2))
        if len(places) < 9:
            continue
        weights = ink[places[:, 0], places[:, 1]]
        centres.append((places * weights[:, None]).sum(axis=0) / weights.sum() + 0.5)
        sides.append(np.ptp(places, axis=0).max() + 1)
    return PIXEL * np.array(centres).reshape(-1, 2), PIXEL * np.array(sides)


def _known_again(sheet, centres, sides):
    """Return which mark is which cross: the marked one, A1, and the one farthest from it begin."""
    cross = 2 * ARM
    is_cross = (sides > 0.7 * cross) & (sides < 1.4 * cross)
    is_mark = (sides > 0.8 * MARK) & (sides < 1.25 * MARK)
    candidates = centres[is_cross] @ (1, 1j)
    marks = centres[is_mark] @ (1, 1j)
    if len(candidates) < 4 or len(marks) != 1:
        raise ValueError(
            f"photo: {len(candidates)} crosses and {len(marks)} marks of the first one are on the"
            f" sheet, of {len(sheet.crosses)} and 1: draw it again, or photograph it larger and"
            " sharper"
        )
    wanted = sheet.crosses @ (1, 1j)
    first = candidates[np.abs(candidates - marks[0]).argmin()]
    last = candidates[np.abs(candidates - first).argmax()]
    spacing = np.abs(wanted[1:] - wanted[0]).min()
    turned = (last - first) / (wanted[-1] - wanted[0])
    shift = first - turned * wanted[0]
    for _ in range(ROUNDS):
        guess = shift + turned * wanted
        apart = np.abs(guess[:, None] - candidates)
        one, other = linear_sum_assignment(apart)
        near = apart[one, other] < NEAR * spacing
        one, other = one[near], other[near]
        if len(one) < 4:
            raise ValueError("photo: the crosses on the sheet are not those of this drawing")
        a = np.stack([wanted[one], np.ones(len(one))], axis=1)
        (turned, shift), *_ = np.linalg.lstsq(a, candidates[other], rcond=None)
    found = np.full(len(wanted), np.nan + 0j)
    found[one] = candidates[other]
    return np.stack([found.real, found.imag], axis=-1)
