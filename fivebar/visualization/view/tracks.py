"""Parts of a scene with their tracks, and the messages in which the viewer takes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .solids import at, packed


class Part(NamedTuple):
    """A node of the scene: its path, its meshes and its tracks {property: (type, values (m, ...))}.

    shown: (times, flags), or None for always; drawn: the share (m,) of its band that is drawn.
    """

    path: str
    meshes: list
    tracks: dict = {}
    shown: tuple | None = None
    drawn: np.ndarray | None = None


def place_tracks(points: np.ndarray, vectors: np.ndarray | None = None) -> dict:
    """Return tracks that move a part along points (m, 2) and turn it along vectors (m, 2)."""
    tracks = {"position": ("vector3", np.insert(points, 2, 0.0, axis=1))}
    if vectors is None:
        return tracks
    # The angle itself and not a quaternion: made continuous it interpolates rightly, in a quarter
    # of the numbers.
    angle = np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0]))
    return tracks | {"rotation[z]": ("number", angle)}


def scale_track(x: np.ndarray | float, y: np.ndarray | float) -> dict:
    """Return the track of a part's size in its own frame."""
    return {"scale": ("vector3", np.column_stack(np.broadcast_arrays(x, y, 1.0)))}


def node(path: str, meshes: list) -> dict:
    """Return the message that puts meshes at a path: one as it is, several as a group."""
    children = [
        {"type": "Mesh", "geometry": f"g{i}", "material": f"m{i}", "matrix": at()}
        for i in range(len(meshes))
    ]
    whole = {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": f"g{i}", **mesh["geometry"]} for i, mesh in enumerate(meshes)],
        "materials": [{"uuid": f"m{i}", **mesh["material"]} for i, mesh in enumerate(meshes)],
        "object": children[0] if len(meshes) == 1 else {"type": "Group", "children": children},
    }
    return {"type": "set_object", "path": path, "object": whole}


def clips(root: str, part: Part, times: np.ndarray) -> Iterator[dict]:
    """Yield the animation of a part under `root`; times (m,) s. A track of one value holds it."""
    tracks = [
        _track(name, kind, times[: len(values)], packed(values))
        for name, (kind, values) in part.tracks.items()
    ]
    if part.shown is not None:
        since, flags = part.shown
        tracks.append(_track("visible", "bool", since, list(map(bool, flags))))
    if tracks:
        # At 1 frame a second the viewer's frame numbers are seconds, and need not be whole.
        clip = {"name": "default", "fps": 1, "tracks": tracks}
        yield {"path": f"{root}/{part.path}", "clip": clip}


def _track(name, kind, times, values):
    return {"name": "." + name, "type": kind, "times": packed(times), "values": values}
