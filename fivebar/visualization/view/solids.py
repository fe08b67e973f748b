"""Solids and flat figures in the words of three.js.

Matrices are listed column by column; z is the height over the drawing plane. Materials are shaded
by the vertex, not by the pixel, and nothing casts a shadow map: on a computer without a graphics
card that is most of a picture's cost.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

SHADED = {"type": "MeshLambertMaterial"}
PLAIN = {"type": "MeshBasicMaterial", "side": 2}


def packed(numbers: ArrayLike, dtype: str = "<f4") -> object:
    """Numbers in the msgpack extension that the viewer reads as a typed array."""
    import umsgpack  # a dependency of meshcat

    return umsgpack.Ext({"<f4": 0x17, "<u4": 0x16}[dtype], np.asarray(numbers, dtype).tobytes())


def at(
    x: float = 0.0, y: float = 0.0, z: float = 0.0, angle: float = 0.0, scale: float = 1.0
) -> list[float]:
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    return [float(entry) for entry in (c, s, 0, 0, -s, c, 0, 0, 0, 0, scale, 0, x, y, z, 1)]


def mesh(geometry: dict, matrix: list[float], colour: str, **material) -> dict:
    return {
        "geometry": geometry,
        "matrix": matrix,
        "material": {**SHADED, "color": int(colour[1:], 16), **material},
    }


def box(
    centre: ArrayLike,
    length: float,
    width: float,
    low: float,
    high: float,
    colour: str,
    angle: float = 0.0,
    **material,
) -> dict:
    geometry = {
        "type": "BoxGeometry",
        "width": float(length),
        "height": float(width),
        "depth": high - low,
    }
    return mesh(geometry, at(*centre, (low + high) / 2, angle), colour, **material)


def cylinder(
    radius: float, low: float, high: float, colour: str, centre: ArrayLike = (0.0, 0.0), **material
) -> dict:
    geometry = {
        "type": "CylinderGeometry",
        "radiusTop": float(radius),
        "radiusBottom": float(radius),
        "height": high - low,
        "radialSegments": 32,
    }
    upright = [
        1,
        0,
        0,
        0,
        0,
        0,
        1,
        0,
        0,
        -1,
        0,
        0,
        *map(float, centre),
        (low + high) / 2,
        1,
    ]  # its axis is along y
    return mesh(geometry, upright, colour, **material)


def triangles(
    vertices: ArrayLike, faces: ArrayLike, colour: str, normals: ArrayLike | None = None, **material
) -> dict:
    attributes = {"position": {"itemSize": 3, "type": "Float32Array", "array": packed(vertices)}}
    if normals is not None:
        attributes["normal"] = {"itemSize": 3, "type": "Float32Array", "array": packed(normals)}
    data = {
        "attributes": attributes,
        "index": {"itemSize": 1, "type": "Uint32Array", "array": packed(faces, "<u4")},
    }
    return mesh({"type": "BufferGeometry", "data": data}, at(), colour, **material)


def link(length: float, width: float, low: float, high: float, colour: str, **material) -> dict:
    """A bar with round ends and broken edges, from the origin to (length, 0)."""
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 17)
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    out = np.concatenate([out, -out])
    centres = np.repeat([(0.0, 0.0), (length, 0.0)], len(turn), axis=0)
    bevel = min(0.18 * width, 0.5 * (high - low))
    rings = [  # (height, radius, outward and upward part of the normal)
        (low, width / 2, 1, 0),
        (high - bevel, width / 2, 1, 0),
        (high - bevel, width / 2, 0.7, 0.7),
        (high, width / 2 - bevel, 0.7, 0.7),
        (high, width / 2 - bevel, 0, 1),
    ]
    n, vertices, normals, faces = len(out), [], [], []
    for height, radius, outward, upward in rings:
        vertices.append(np.column_stack([centres + radius * out, np.full(n, height)]))
        normals.append(np.column_stack([outward * out, np.full(n, upward)]))
    here, after = np.arange(n), np.roll(np.arange(n), -1)
    for ring in (0, 2):
        a, b = ring * n, (ring + 1) * n
        faces += [(here + a, after + a, after + b), (here + a, after + b, here + b)]
    top = 4 * n
    faces.append((np.full(n, top), here + top, after + top))
    faces = np.concatenate([np.stack(face, axis=1) for face in faces])
    return triangles(np.concatenate(vertices), faces, colour, np.concatenate(normals), **material)


def ribbon(paths: list, width: float, height: float, colour: str, **material) -> dict | None:
    """Flat bands along paths (n, 2): WebGL draws lines one pixel wide, whatever width they are
    given.
    """
    vertices, faces, count = [], [], 0
    for path in paths:
        step = np.diff(path, axis=0)
        keep = np.hypot(*step.T) > 0
        path, step = path[np.concatenate([[True], keep])], step[keep]
        if not len(step):
            continue
        along = step / np.hypot(*step.T)[:, None]
        ahead, behind = np.concatenate([along, along[-1:]]), np.concatenate([along[:1], along])
        square = ((ahead + behind) ** 2).sum(axis=1)[:, None]
        # In a corner the band keeps its width up to 120 degrees; where the path turns back it is
        # blunt.
        mitre = np.where(square > 1, 2 * (ahead + behind) / np.maximum(square, 1), ahead)
        across = width / 2 * mitre[:, ::-1] * (-1, 1)
        n = len(path)
        vertices.append(np.stack([path - across, path + across], axis=1).reshape(-1, 2))
        faces.append(count + 2 * np.arange(n - 1)[:, None] + (0, 2, 1, 1, 2, 3))
        count += 2 * n
    if not count:
        return None
    vertices = np.concatenate(vertices)
    flat = np.column_stack([vertices, np.full(len(vertices), height)])
    return triangles(flat, np.concatenate(faces), colour, **{**PLAIN, **material})


def dashed(path: np.ndarray, on: float, off: float) -> list[np.ndarray]:
    """The pieces of a path (n, 2) that a dash `on` long and a space `off` long leave."""
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    if s[-1] == 0:
        return [path]
    count = max(1, round((s[-1] + off) / (on + off)))
    scale = s[-1] / (count * (on + off) - off)  # so that it begins and ends with a dash
    pieces = []
    for k in range(count):
        low = k * (on + off) * scale
        high = low + on * scale
        cut = np.concatenate([[low], s[(s > low) & (s < high)], [high]])
        pieces.append(np.stack([np.interp(cut, s, path[:, k]) for k in (0, 1)], axis=1))
    return pieces


def arc(radius: float, width: float, sweep: float, pieces: int, height: float, colour: str) -> dict:
    """A flat band on a circle about the origin from angle 0 to `sweep`; its first 6 k indices are k
    pieces of it.
    """
    angle = np.linspace(0.0, sweep, pieces + 1)[:, None]
    unit = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.stack([(radius - width / 2) * unit, (radius + width / 2) * unit], axis=1).reshape(
        -1, 2
    )
    faces = 2 * np.arange(pieces)[:, None] + (0, 1, 2, 2, 1, 3)
    return triangles(
        np.column_stack([vertices, np.full(len(vertices), height)]), faces, colour, **PLAIN
    )


def polygon(corners: np.ndarray, height: float, colour: str, **material) -> dict:
    """A convex flat polygon, corners (n, 2)."""
    n = len(corners)
    faces = [(0, k, k + 1) for k in range(1, n - 1)]
    return triangles(
        np.column_stack([corners, np.full(n, height)]), faces, colour, **{**PLAIN, **material}
    )
