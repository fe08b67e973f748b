"""Solids and flat figures as three.js takes them, each with its outlines seen from above.

Matrices are listed column by column; z is the height over the drawing plane. Materials are shaded
by the vertex, not by the pixel, and nothing casts a shadow map: on a computer without a graphics
card that is most of a picture's cost.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

SHADED = {"type": "MeshLambertMaterial"}
PLAIN = {"type": "MeshBasicMaterial", "side": 2}
SQUARE = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])


def packed(numbers: ArrayLike, dtype: str = "<f4") -> object:
    """Return numbers in the msgpack extension that the viewer reads as a typed array."""
    import umsgpack  # a dependency of meshcat

    return umsgpack.Ext({"<f4": 0x17, "<u4": 0x16}[dtype], np.asarray(numbers, dtype).tobytes())


def unit_vectors(angle: ArrayLike) -> np.ndarray:
    """Return (cos, sin) of angles, (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def circle(centre: ArrayLike, radius: float, points: int) -> np.ndarray:
    """Return a closed circle, (points, 2)."""
    return centre + radius * unit_vectors(np.linspace(0, 2 * np.pi, points))


def at(
    x: float = 0.0, y: float = 0.0, z: float = 0.0, angle: float = 0.0, scale: float = 1.0
) -> list[float]:
    """Return the matrix of a place, a turn about z and a scale."""
    c, s = scale * unit_vectors(angle)
    return [float(entry) for entry in (c, s, 0, 0, -s, c, 0, 0, 0, 0, scale, 0, x, y, z, 1)]


def mesh(
    geometry: dict, matrix: list[float], colour: str, outlines: list, top: float, **material
) -> dict:
    """Return a mesh; outlines, (n, 2) each, and top, its height, are for pictures without WebGL."""
    material = {**SHADED, "color": int(colour[1:], 16), **material}
    return dict(geometry=geometry, matrix=matrix, material=material, outlines=outlines, top=top)


def box(
    centre: ArrayLike,
    length: float,
    width: float,
    low: float,
    high: float,
    colour: str,
    angle: float = 0.0,
) -> dict:
    """Return a box about a centre (x, y) between two heights."""
    length, width = float(length), float(width)
    geometry = {"type": "BoxGeometry", "width": length, "height": width, "depth": high - low}
    along, across = unit_vectors([angle, angle + np.pi / 2])
    outline = centre + SQUARE * (length, width) @ [along, across]
    return mesh(geometry, at(*centre, (low + high) / 2, angle), colour, [outline], high)


def triangles(
    faces: ArrayLike, colour: str, outlines: list, top: float, attributes: dict, **material
) -> dict:
    """Return a surface of triangles; attributes: position and, where it is shaded, normal."""
    arrays = {
        name: {"itemSize": 3, "type": "Float32Array", "array": packed(values)}
        for name, values in attributes.items()
    }
    index = {"itemSize": 1, "type": "Uint32Array", "array": packed(faces, "<u4")}
    geometry = {"type": "BufferGeometry", "data": {"attributes": arrays, "index": index}}
    return mesh(geometry, at(), colour, outlines, top, **material)


def _lifted(points, height):
    return np.insert(points, 2, height, axis=1)


def flat(
    points: np.ndarray, faces: ArrayLike, height: float, colour: str, outlines: list, **material
) -> dict:
    """Return a flat figure of triangles between points (n, 2)."""
    position = {"position": _lifted(points, height)}
    return triangles(faces, colour, outlines, height, position, **PLAIN | material)


def link(
    length: float,
    width: float,
    low: float,
    high: float,
    colour: str,
    start: float = 0.0,
    **material,
) -> dict:
    """Return a bar with round ends and broken edges, from (start, 0) to (start + length, 0)."""
    out = unit_vectors(np.linspace(0.5 * np.pi, 1.5 * np.pi, 17))
    n, out = 34, np.concatenate([out, -out])
    ends = np.repeat([(start, 0.0), (start + length, 0.0)], 17, axis=0)
    bevel = min(0.18 * width, 0.5 * (high - low))
    rings = [  # (height, radius, outward and upward part of the normal)
        (low, width / 2, 1, 0),
        (high - bevel, width / 2, 1, 0),
        (high - bevel, width / 2, 0.7, 0.7),
        (high, width / 2 - bevel, 0.7, 0.7),
        (high, width / 2 - bevel, 0, 1),
    ]
    position = [_lifted(ends + radius * out, height) for height, radius, *_ in rings]
    normal = [_lifted(outward * out, upward) for *_, outward, upward in rings]
    here = np.arange(n)
    after = np.roll(here, -1)
    wall = np.stack([here, after, after + n, here, after + n, here + n], axis=1)
    cap = 4 * n + np.stack([0 * here, here, after], axis=1)
    faces = np.concatenate([wall.ravel(), 2 * n + wall.ravel(), cap.ravel()])
    attributes = {"position": np.concatenate(position), "normal": np.concatenate(normal)}
    outline = position[0][:, :2]
    return triangles(faces, colour, [outline], high, attributes, **material)


def cylinder(radius: float, low: float, high: float, colour: str) -> dict:
    """Return an upright cylinder at the origin."""
    return link(0.0, 2 * radius, low, high, colour)


def _band_faces(rows):
    """Triangles of a band of so many rows, each a left and a right point."""
    return 2 * np.arange(rows - 1)[:, None] + (0, 2, 1, 1, 2, 3)


def _around(left, right):
    return np.concatenate([left, right[::-1]])


def ribbon(paths: list, width: float, height: float, colour: str, **material) -> dict | None:
    """Return flat bands along paths (n, 2), None where no path goes anywhere.

    WebGL draws lines one pixel wide, whatever width they are given.
    """
    points, faces, outlines = [np.empty((0, 2))], [], []
    for path in paths:
        step = np.diff(path, axis=0)
        moves = step.any(axis=1)
        if not moves.any():
            continue
        path, step = path[np.append(True, moves)], step[moves]
        along = step / np.hypot(*step.T)[:, None]
        ahead, behind = np.concatenate([along, along[-1:]]), np.concatenate([along[:1], along])
        both = ahead + behind
        square = (both**2).sum(axis=1)[:, None]
        # In a corner the band keeps its width up to 120 degrees; where the path turns back it is
        # blunt.
        mitre = np.where(square > 1, 2 * both / np.maximum(square, 1), ahead)
        across = width / 2 * mitre[:, ::-1] * (-1, 1)
        left, right = path - across, path + across
        faces.append(sum(map(len, points)) + _band_faces(len(path)))
        points.append(np.stack([left, right], axis=1).reshape(-1, 2))
        outlines.append(_around(left, right))
    if not outlines:
        return None
    return flat(np.concatenate(points), np.concatenate(faces), height, colour, outlines, **material)


def dashed(path: np.ndarray, on: float, off: float) -> list[np.ndarray]:
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
    left, right = (radius - width / 2) * unit, (radius + width / 2) * unit
    points = np.stack([left, right], axis=1).reshape(-1, 2)
    return flat(points, _band_faces(pieces + 1), height, colour, [_around(left, right)])


def polygon(corners: ArrayLike, height: float, colour: str, **material) -> dict:
    """Return a convex flat polygon, corners (n, 2)."""
    corners = np.asarray(corners)
    faces = [(0, k, k + 1) for k in range(1, len(corners) - 1)]
    return flat(corners, faces, height, colour, [corners], **material)
