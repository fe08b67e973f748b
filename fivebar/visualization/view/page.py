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

from ..document import as_json, document, library_folder, script
from .layers import PIECES, SWEEP, TurningArrows
from .machine import SHADOW_OFFSET
from .solids import at
from .tracks import Part, clips, node

if TYPE_CHECKING:
    from .scenes import Scene

HERE = Path(__file__).parent
FIELD_OF_VIEW = 8  # degrees: narrow, so that a height hardly shifts anything on the screen
MOST_EVENTS = 200  # marks on the time line: more could not be told apart


def page(scene: Scene) -> str:
    """Return the page of a Scene, complete. Raises ImportError without meshcat."""
    viewer = library_folder("meshcat", "an animation needs the viewer in meshcat") / "viewer"
    (left, low), (right, high) = scene.window
    # About the origin at unit size: there the viewer's lights and the centre of its orbit are right
    # for any mechanism.
    span = right - left, high - low
    scale = 1 / max(span)
    messages = [*_stage()]
    animations = []
    entries: dict = {}
    events = []
    labels = []
    tips = []
    bands = []
    for k, (machine, offset) in enumerate(zip(scene.machines, scene.offsets)):
        root = f"/m{k}"
        x = scale * (offset - (left + right) / 2)
        y = -scale * (low + high) / 2
        messages.append({"type": "set_transform", "path": root, "matrix": at(x, y, scale=scale)})
        animations += _machine(root, machine, messages, entries)
        for number, layer in enumerate(machine.layers):
            path = f"{root}/moving/{layer.name}/{number}"
            if layer.sign:
                sign = {"path": f"{path}/tip", "text": layer.sign}
                tips.append(sign | layer.place_of_sign(machine))
            if isinstance(layer, TurningArrows):
                bands.append(path)
        events += [{**event._asdict(), "root": root} for event in machine.events]
        if scene.names:
            middle = float(machine.box[0][0] + machine.box[1][0]) / 2
            labels.append({"text": scene.names[k], "x": x + scale * middle, "y": y + scale * low})
    messages.append({"type": "set_animation", "options": {"play": True}, "animations": animations})
    notes = list(scene.notes)
    if len(events) > MOST_EVENTS:
        notes.append(f"{MOST_EVENTS} of {len(events)} events are marked.")
    data = {
        "duration": scene.duration,
        "start": scene.machines[0].frames.start,
        "events": events[:MOST_EVENTS],
        "labels": labels,
        "tips": tips,
        "entries": list(entries.values()),
        "gaps": sum((machine.frames.gaps for machine in scene.machines), ()),
        "half": [scale * side / 2 for side in span],
        "field": FIELD_OF_VIEW,
        "pieces": PIECES / SWEEP,
        "bands": bands,
    }
    names = "LICENSE", "dist/main.min.js.THIRD_PARTY_LICENSES.json"
    licences = "\n".join((viewer / name).read_text("utf-8") for name in names)
    # Messages in msgpack, each after its length in 4 bytes.
    import umsgpack  # a dependency of meshcat

    packets = [umsgpack.packb(message) for message in messages]
    packed = b"".join(struct.pack("<I", len(packet)) + packet for packet in packets)
    return document(
        HERE,
        scene.title,
        notes="".join(f"<p>{html.escape(note)}</p>" for note in notes),
        content=as_json(data),
        viewer=_packed_viewer(viewer),
        scene=_in_letters(packed, 6),
        script=script(HERE.parent, "parts", "timeline") + "\n" + script(HERE, "page", "flat"),
        licences=html.escape(licences),
    )


@lru_cache(maxsize=1)
def _packed_viewer(viewer):
    """Return the viewer's script, compressed: a quarter of its size, even in letters."""
    return _in_letters((viewer / "dist" / "main.min.js").read_bytes(), 9)


def _in_letters(data, level):
    return b64encode(gzip.compress(data, level, mtime=0)).decode()


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
        yield _property(path, name, value)


def _property(path, name, value):
    return {"type": "set_property", "path": path, "property": name, "value": value}


def _machine(root, machine, messages, entries):
    """Adds a machine's messages, and to the key's entries what can be hidden; gives its
    animations.
    """
    animations = []
    times = machine.frames.t
    w = machine.width
    for path, part in machine.groups:
        if part.meshes:
            messages.append(node(f"{root}/{path}/{part.path}", part.meshes))
        animations += clips(f"{root}/{path}", part, times)
    for name, colours in machine.body.key.items():
        bar = {"key": name, "glyph": "bar", "colours": colours, "nodes": []}
        entries.setdefault((name, *colours), bar)
    for layer in machine.layers:
        empty = {"key": layer.key, "glyph": layer.glyph, "colours": [], "nodes": []}
        entry = entries.setdefault(layer.name, empty)
        path = f"{root}/{'still' if layer.still else 'moving'}/{layer.name}"
        for name, value in (("colours", layer.colour), ("nodes", path)):
            if value not in entry[name]:
                entry[name].append(value)
    shadows = at(*SHADOW_OFFSET * w)
    messages.append({"type": "set_transform", "path": f"{root}/moving/shadows", "matrix": shadows})
    if machine.frames.gaps:
        animations += clips(root, Part("moving", [], shown=machine.frames.switches), times)
    if machine.events:
        messages.append(node(f"{root}/flash", machine.flash))
        messages.append(_property(f"{root}/flash", "visible", False))
    return animations
