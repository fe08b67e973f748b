"""Solids and flat figures as three.js takes them, each with its outlines seen from above.

Matrices are listed column by column; z is the height over the drawing plane. Materials are shaded
by the vertex, not by the pixel, and nothing casts a shadow map: on a computer without a graphics
card that is most of a picture's cost.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

SHADED = {"type": "MeshLambertMaterial"}
PLAIN = {"type": "MeshBasicMaterial", "side": 2}
SQUARE = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
QUAD = np.array([0, 2, 1, 1, 2, 3])  # the triangles between two rows of a band


def packed(numbers: ArrayLike, dtype: str = "<f4") -> object:
    """Return numbers in the msgpack extension that the viewer reads as a typed array."""
    import umsgpack  # a dependency of meshcat

    return umsgpack.Ext({"<f4": 0x17, "<u4": 0x16}[dtype], np.asarray(numbers, dtype).tobytes())


def unit_vectors(angle: ArrayLike) -> np.ndarray:
    """Return (cos, sin) of angles, (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def circle(centre: Any, radius: float, points: int) -> np.ndarray:
    """Return a closed circle, (points, 2)."""
    return centre + radius * unit_vectors(np.linspace(0, 2 * np.pi, points))


def at(x: float = 0.0, y: float = 0.0, scale: float = 1.0) -> list[float]:
    """Return the matrix of a place and a scale."""
    matrix = scale * np.eye(4)
    matrix[3] = x, y, 0.0, 1.0
    return matrix.ravel().tolist()


def surface(
    position: np.ndarray,
    faces: ArrayLike,
    colour: str,
    outlines: list,
    normal: ArrayLike | None = None,
    **material,
) -> dict:
    """Return a surface of triangles between points (n, 3); without normals it is not shaded.

    outlines, (k, 2) each, seen from above, and top, its height, are for pictures without WebGL.
    """
    arrays = {"position": position} if normal is None else {"position": position, "normal": normal}
    attributes = {
        name: {"itemSize": 3, "type": "Float32Array", "array": packed(values)}
        for name, values in arrays.items()
    }
    index = {"itemSize": 1, "type": "Uint32Array", "array": packed(faces, "<u4")}
    kind = PLAIN if normal is None else SHADED
    return {
        "geometry": {"type": "BufferGeometry", "data": {"attributes": attributes, "index": index}},
        "material": {**kind, "color": int(colour[1:], 16), **material},
        "outlines": outlines,
        "top": position[:, 2].max(),
    }


def _lifted(points, height):
    return np.insert(points, 2, height, axis=1)


def flat(
    points: np.ndarray, faces: ArrayLike, height: float, colour: str, outlines: list, **material
) -> dict:
    """Return a flat figure of triangles between points (n, 2)."""
    return surface(_lifted(points, height), faces, colour, outlines, **material)


def prism(
    outline: np.ndarray, out: np.ndarray, low: float, high: float, colour: str, **material
) -> dict:
    """Return an upright solid of a convex outline (n, 2), its upper edge broken.

    out: (n, 2), from each point outwards.
    """
    bevel = min(0.18 * np.ptp(outline, axis=0).min(), 0.5 * (high - low))
    rings = [  # (height, inset, outward and upward part of the normal)
        (low, 0, 1, 0),
        (high - bevel, 0, 1, 0),
        (high - bevel, 0, 0.7, 0.7),
        (high, bevel, 0.7, 0.7),
        (high, bevel, 0, 1),
    ]
    position = [_lifted(outline - inset * out, height) for height, inset, *_ in rings]
    normal = [_lifted(outward * out, upward) for *_, outward, upward in rings]
    n = len(outline)
    here = np.arange(n)
    after = np.roll(here, -1)
    wall = np.stack([here, after, after + n, here, after + n, here + n], axis=1)
    cap = 4 * n + np.stack([0 * here, here, after], axis=1)
    faces = np.concatenate([wall.ravel(), 2 * n + wall.ravel(), cap.ravel()])
    position = np.concatenate(position)
    normal = np.concatenate(normal)
    return surface(position, faces, colour, [outline], normal, **material)


def link(
    length: float, width: float, low: float, high: float, colour: str, start=0.0, **material
) -> dict:
    """Return a bar with round ends from (start, 0) to (start + length, 0)."""
    out = unit_vectors(np.linspace(0.5 * np.pi, 1.5 * np.pi, 17))
    out = np.concatenate([out, -out])
    ends = np.repeat([(start, 0.0), (start + length, 0.0)], 17, axis=0)
    return prism(ends + width / 2 * out, out, low, high, colour, **material)


def cylinder(radius: float, low: float, high: float, colour: str) -> dict:
    """Return an upright cylinder at the origin."""
    return link(0.0, 2 * radius, low, high, colour)


def box(
    centre: ArrayLike,
    length: float,
    width: float,
    low: float,
    high: float,
    colour: str,
    angle: float = 0.0,
) -> dict:
    """Return a box about a centre (x, y), turned by an angle."""
    axes = unit_vectors([angle, angle + np.pi / 2])
    return prism(centre + SQUARE * (length, width) @ axes, SQUARE @ axes, low, high, colour)


def _band_faces(rows):
    """Triangles of a band of so many rows, each a left and a right point."""
    return 2 * np.arange(rows - 1)[:, None] + QUAD


def _around(left, right):
    return np.concatenate([left, right[::-1]])


def ribbon(paths: list, width: float, height: float, colour: str, **material) -> dict | None:
    """Return flat bands along paths (n, 2), None where no path goes anywhere.

    WebGL draws lines one pixel wide, whatever width they are given.
    """
    points = [np.empty((0, 2))]
    faces = []
    outlines = []
    for path in paths:
        step = np.diff(path, axis=0)
        moves = step.any(axis=1)
        if not moves.any():
            continue
        path = path[np.append(True, moves)]
        step = step[moves]
        along = step / np.hypot(*step.T)[:, None]
        ahead = np.concatenate([along, along[-1:]])
        behind = np.concatenate([along[:1], along])
        both = ahead + behind
        square = (both**2).sum(axis=1)[:, None]
        # In a corner the band keeps its width up to 120 degrees; where the path turns back it is
        # blunt.
        mitre = np.where(square > 1, 2 * both / np.maximum(square, 1), ahead)
        across = width / 2 * mitre[:, ::-1] * (-1, 1)
        left = path - across
        right = path + across
        faces.append(sum(map(len, points)) + _band_faces(len(path)))
        points.append(np.stack([left, right], axis=1).reshape(-1, 2))
        outlines.append(_around(left, right))
    if not outlines:
        return None
    return flat(np.concatenate(points), np.concatenate(faces), height, colour, outlines, **material)


def dash_pieces(path: np.ndarray, on: float, off: float) -> list[np.ndarray]:
    """Return the pieces of a path (n, 2) that a dash `on` long and a space `off` long leave."""
    s = np.append(0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T)))
    if s[-1] == 0:
        return [path]
    count = max(1, round((s[-1] + off) / (on + off)))
    scale = s[-1] / (count * (on + off) - off)  # so that it begins and ends with a dash
    pieces = []
    for low in np.arange(count) * (on + off) * scale:
        high = low + on * scale
        cut = np.concatenate([[low], s[(s > low) & (s < high)], [high]])
        pieces.append(np.column_stack([np.interp(cut, s, column) for column in path.T]))
    return pieces


def arc(radius: float, width: float, sweep: float, pieces: int, height: float, colour: str) -> dict:
    """Return a flat band on a circle about the origin from angle 0 to `sweep`.

    Its first 6 k indices are k pieces of it.
    """
    unit = unit_vectors(np.linspace(0.0, sweep, pieces + 1))
    left = (radius - width / 2) * unit
    right = (radius + width / 2) * unit
    points = np.stack([left, right], axis=1).reshape(-1, 2)
    return flat(points, _band_faces(pieces + 1), height, colour, [_around(left, right)])


def polygon(corners: ArrayLike, height: float, colour: str, **material) -> dict:
    """Return a convex flat polygon, corners (n, 2)."""
    corners = np.asarray(corners)
    faces = [(0, k, k + 1) for k in range(1, len(corners) - 1)]
    return flat(corners, faces, height, colour, [corners], **material)
