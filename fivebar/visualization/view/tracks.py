"""Parts of a scene with their tracks, and the messages in which the viewer takes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .solids import packed


class Part(NamedTuple):
    """A node of the scene: its path, its meshes, its tracks {property: (type, values (m, ...))},
    and when it is shown.

    shown: (times, flags) or None for always.
    """

    path: str
    meshes: list
    tracks: dict = {}
    shown: tuple | None = None


def placed(points: np.ndarray, angle: np.ndarray | None = None) -> dict:
    """Tracks that move a part along points (m, 2) and turn it to angle (m,)."""
    tracks = {"position": ("vector3", np.pad(points, [(0, 0), (0, 1)]))}
    # The angle itself and not a quaternion: made continuous it interpolates rightly, in a quarter
    # of the numbers.
    return tracks if angle is None else tracks | {"rotation[z]": ("number", angle)}


def angles_of(vectors: np.ndarray) -> np.ndarray:
    """Continuous angles (m,) of vectors (m, 2)."""
    return np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0]))


def node(path: str, meshes: list) -> dict:
    """The message that puts meshes at a path: one as it is, several as a group."""
    children = [
        {"type": "Mesh", "geometry": f"g{i}", "material": f"m{i}", "matrix": mesh["matrix"]}
        for i, mesh in enumerate(meshes)
    ]
    return {
        "type": "set_object",
        "path": path,
        "object": {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": [{"uuid": f"g{i}", **mesh["geometry"]} for i, mesh in enumerate(meshes)],
            "materials": [{"uuid": f"m{i}", **mesh["material"]} for i, mesh in enumerate(meshes)],
            "object": (
                children[0] if len(children) == 1 else {"type": "Group", "children": children}
            ),
        },
    }


def clips(root: str, part: Part, times: np.ndarray) -> Iterator[dict]:
    """The animations of a part under `root`; times (m,) s. A track of one value holds it."""
    tracks = [
        _track(name, kind, times[: len(values)], values)
        for name, (kind, values) in part.tracks.items()
    ]
    if part.shown is not None:
        tracks.append(
            {
                "name": ".visible",
                "type": "bool",
                "times": packed(part.shown[0]),
                "values": [bool(flag) for flag in part.shown[1]],
            }
        )
    if tracks:
        # at 1 frame a second the viewer's frame numbers are seconds, and need not be whole
        yield {
            "path": f"{root}/{part.path}",
            "clip": {"name": "default", "fps": 1, "tracks": tracks},
        }


def _track(name, kind, times, values):
    return {"name": "." + name, "type": kind, "times": packed(times), "values": packed(values)}
