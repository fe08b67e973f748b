"""A scene as one web page: meshcat's viewer and the packed scene in a single file, without a
server.
"""

from __future__ import annotations

import gzip
import html
import struct
from base64 import b64encode
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..document import as_json, document, library
from .layers import PIECES, SWEEP, Turning
from .machine import flash, parts
from .solids import at
from .tracks import Part, clips, node

if TYPE_CHECKING:
    from .scenes import Scene

HERE = Path(__file__).parent
FIELD_OF_VIEW = 8  # degrees: narrow, so that a height hardly shifts anything on the screen
MOST_EVENTS = 200  # marks on the time line: more could not be told apart


def page(scene: Scene) -> str:
    """The page of a Scene, complete. ImportError without meshcat."""
    viewer = library("meshcat", "an animation needs the viewer in meshcat") / "viewer"
    (left, low), (right, high) = scene.window
    # About the origin at unit size: there the viewer's lights and the centre of its orbit are right
    # for any mechanism.
    span = right - left, high - low
    scale = 1 / max(span)
    messages, animations, entries, events, labels, tips = [*_stage()], [], {}, [], [], []
    for k, (machine, offset) in enumerate(zip(scene.machines, scene.offsets)):
        root, x, y = f"/m{k}", scale * (offset - (left + right) / 2), -scale * (low + high) / 2
        messages.append({"type": "set_transform", "path": root, "matrix": at(x, y, scale=scale)})
        animations += _machine(root, machine, messages, entries)
        tips += [
            {"path": f"{root}/moving/{layer.name}/{number}/tip", "text": layer.sign}
            | layer.place_of_sign(machine)
            for number, layer in enumerate(machine.layers)
            if layer.sign
        ]
        events += [{**event._asdict(), "root": root} for event in machine.events[:MOST_EVENTS]]
        if scene.names:
            middle = float(machine.box[0][0] + machine.box[1][0]) / 2
            labels.append({"text": scene.names[k], "x": x + scale * middle, "y": y + scale * low})
    messages.append({"type": "set_animation", "options": {"play": True}, "animations": animations})
    count = sum(len(machine.events) for machine in scene.machines)
    notes = list(scene.notes) + (
        [f"{len(events)} of {count} events are marked."] if count > len(events) else []
    )
    data = {
        "duration": scene.duration,
        "start": scene.machines[0].frames.start,
        "events": events,
        "labels": labels,
        "tips": tips,
        "entries": list(entries.values()),
        "gaps": [gap for machine in scene.machines for gap in machine.frames.gaps],
        "half": [scale * side / 2 for side in span],
        "field": FIELD_OF_VIEW,
        "pieces": PIECES / SWEEP,
        "bands": [
            f"/m{k}/moving/{layer.name}/{number}"
            for k, machine in enumerate(scene.machines)
            for number, layer in enumerate(machine.layers)
            if isinstance(layer, Turning)
        ],
    }
    script = "\n".join((HERE / f"{name}.js").read_text("utf-8") for name in ("page", "flat"))
    return document(
        HERE,
        scene.title,
        notes="".join(f"<p>{html.escape(note)}</p>" for note in notes),
        data=as_json(data),
        viewer=_packed_viewer(viewer),
        scene=_packed(messages),
        script=script,
        licences=html.escape(_licences(viewer)),
    )


@lru_cache(maxsize=1)
def _packed_viewer(viewer):
    """The viewer's script, compressed: a quarter of its size, even in letters."""
    return b64encode(
        gzip.compress((viewer / "dist" / "main.min.js").read_bytes(), 9, mtime=0)
    ).decode()


def _licences(viewer):
    return "\n".join(
        (viewer / name).read_text("utf-8")
        for name in ("LICENSE", "dist/main.min.js.THIRD_PARTY_LICENSES.json")
    )


def _packed(messages):
    """Messages in msgpack, each after its length in 4 bytes, compressed, in letters."""
    import umsgpack  # a dependency of meshcat

    packets = [umsgpack.packb(message) for message in messages]
    return b64encode(
        gzip.compress(
            b"".join(struct.pack("<I", len(packet)) + packet for packet in packets), 6, mtime=0
        )
    ).decode()


def _stage():
    """Light, and none of the viewer's grid, axes and sky: the page's own colours are seen behind
    the scene.
    """
    for path in ("/Grid", "/Axes", "/Lights/PointLightNegativeX", "/Lights/PointLightPositiveX"):
        yield {"type": "delete", "path": path}
    for path, name, value in (
        ("/Background", "visible", False),
        ("/Lights/SpotLight", "visible", True),
        ("/Lights/SpotLight/<object>", "position", [-1.2, 1.6, 3]),
        ("/Lights/SpotLight/<object>", "intensity", 0.5),
    ):
        yield {"type": "set_property", "path": path, "property": name, "value": value}


def _machine(root, machine, messages, entries):
    """Adds a machine's messages, and to the key's entries what can be hidden; gives its
    animations.
    """
    animations, times = [], machine.frames.t

    def add(part, path):
        if part.meshes:
            messages.append(node(f"{path}/{part.path}", part.meshes))
        animations.extend(clips(path, part, times))

    for part in parts(machine):
        add(part, f"{root}/still" if part.path == "base" else f"{root}/moving")
    for name, colours in machine.body.key.items():
        entries.setdefault(
            (name, *colours), {"key": name, "glyph": "bar", "colours": colours, "nodes": []}
        )
    w = machine.width  # the light comes from the upper left
    messages.append(
        {"type": "set_transform", "path": f"{root}/moving/shadows", "matrix": at(0.3 * w, -0.4 * w)}
    )
    if machine.frames.switches is not None:
        animations += clips(root, Part("moving", [], shown=machine.frames.switches), times)
    for number, layer in enumerate(machine.layers):
        group = f"{root}/still" if layer.still else f"{root}/moving"
        for part in layer.parts(machine, number):
            add(part, group)
        entry = entries.setdefault(
            layer.name, {"key": layer.key, "glyph": layer.glyph, "colours": [], "nodes": []}
        )
        for known, own in (
            (entry["colours"], layer.colour),
            (entry["nodes"], f"{group}/{layer.name}"),
        ):
            if own not in known:
                known.append(own)
    if machine.events:
        messages.append(node(f"{root}/flash", flash(machine).meshes))
        messages.append(
            {"type": "set_property", "path": f"{root}/flash", "property": "visible", "value": False}
        )
    return animations
