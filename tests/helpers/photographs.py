"""Synthetic photographs of a sheet that a robot drew: tilt, turn, blur, noise; the truth is known."""

import numpy as np
from scipy.ndimage import gaussian_filter

from fivebar.estimation.calibration.sheet import PAPERS

PEN = 0.0003  # m, half of a line's width


def photograph(
    strokes,
    paper,
    rng,
    *,
    turn=0.05,
    tilt=0.1,
    blur=1.0,
    noise=0.02,
    zoom=4800.0,
    shape=(1000, 1360),
    lens=(0.0, 0.0),
    cut=(1.0, 1.0),
):
    """Brightness (rows, columns) of a sheet with strokes (k, 2, 2), m of its frame, from its corner.

    zoom: pixels a metre in the middle; tilt: change of the scale along the sheet, a share; lens: a
    and b of Brown's model, by which a ray at r half diagonals from the middle is put to
    r (1 + a r^2 + b r^4); cut: sides of the sheet, as shares of the paper's.
    """
    width, height = np.array(PAPERS[paper]) * cut
    column, row = np.meshgrid(
        np.arange(shape[1]) - (shape[1] - 1) / 2, np.arange(shape[0]) - (shape[0] - 1) / 2
    )
    far = np.hypot(column, row) / np.hypot(shape[0] / 2, shape[1] / 2)
    ray = far
    for _ in range(60):  # the model goes from the ray to the picture, and is inverted
        ray = far / (1 + lens[0] * ray**2 + lens[1] * ray**4)
    turned = ray / np.maximum(far, 1e-12)
    column, row = turned * column, turned * row
    u, v = column / zoom, -row / zoom
    depth = 1 - 3 * tilt * u + 1.5 * tilt * v
    u, v = u / depth, v / depth
    c, s = np.cos(turn), np.sin(turn)
    x, y = c * u + s * v + width / 2, c * v - s * u + height / 2
    image = np.where((x > 0) & (x < width) & (y > 0) & (y < height), 0.9, 0.25)
    ink = np.zeros(shape)
    for a, b in strokes:
        low, high = np.minimum(a, b) - 0.002, np.maximum(a, b) + 0.002
        near = (x > low[0]) & (x < high[0]) & (y > low[1]) & (y < high[1])
        way = b - a
        t = np.clip(((x[near] - a[0]) * way[0] + (y[near] - a[1]) * way[1]) / (way @ way), 0, 1)
        far = np.hypot(x[near] - a[0] - t * way[0], y[near] - a[1] - t * way[1])
        ink[near] = np.maximum(ink[near], np.clip((PEN - far) * zoom + 0.5, 0, 1))
    return gaussian_filter(image * (1 - 0.8 * ink), blur) + noise * rng.standard_normal(shape)
