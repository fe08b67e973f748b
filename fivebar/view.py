"""A planar mechanism's motion as one web page: meshcat's viewer and the scene in a single file, without a server."""

import html
import json
from base64 import b64encode
from importlib.util import find_spec
from pathlib import Path
from string import Template

import numpy as np

FRAMES_PER_SECOND = 60
REFERENCE_POINTS = 2000  # as many are drawn at most: a reference on a simulator's steps would outweigh the motion
FIELD_OF_VIEW = 20  # degrees: narrow, so that a bar's height in the stack hardly shifts it on the screen

# Okabe and Ito's colours, told apart by the colour-blind: a hue for each leg, its bars dark and light by turns.
LEGS = ((0x0072B2, 0x56B4E9), (0xD55E00, 0xE69F00), (0x009E73, 0x7FCEB9))
TRACE, REFERENCE = 0xCC79A7, 0xB8B8B8
PLATE, MOTOR, PIN = 0xCCD2D8, 0x4A5058, 0x2A2E33


def write_animation(path, t, points, bars, *, title, grounded=(), actuated=(), traced=None, reference=None):
    """Write a web page, complete in one file, that plays the motion of a planar mechanism.

    path       file to write (HTML in UTF-8)
    t          (n,) s, increasing; more than 60 samples a second are thinned to 60 by linear interpolation
    points     (n, k, 2) m, the joints' positions
    bars       pairs (i, j) of joints; a bar starts at i, points at j and has its mean length
    title      text over the picture
    grounded   joints fixed to the base
    actuated   joints with a motor
    traced     joint whose path is drawn, or None
    reference  (m, 2) m, the path it should follow, or None

    Raises ValueError for fewer than 2 samples, unequal lengths, numbers that are not finite, times that do not
    increase and joints that do not exist; ImportError without meshcat; OSError if the file cannot be written.
    """
    viewer = _viewer()
    t, points = _motion(t, points)
    reference = np.empty((0, 2)) if reference is None else _finite("reference", reference, "m", 2)
    _check_joints(points.shape[1], bars, grounded, actuated, () if traced is None else (traced,))
    t, points = _thinned(t, points)
    if len(reference) > REFERENCE_POINTS:
        reference = reference[np.linspace(0, len(reference) - 1, REFERENCE_POINTS).astype(int)]
    trace = points[:, traced] if traced is not None else np.empty((0, 2))

    shown = np.vstack([points.reshape(-1, 2), reference])
    low, high = shown.min(axis=0), shown.max(axis=0)
    size = max(high - low) or 1.0
    width, layer = 0.03 * size, 0.013 * size
    legs = _legs(bars, grounded, actuated)
    order = sorted(range(len(bars)), key=legs.__getitem__)
    heights = [order.index(b) * layer for b in range(len(bars))]  # each bar has its own, so that none cuts another

    commands = [
        *_stage(),
        # At unit size about the origin the viewer's lights and the centre of its orbit are right for any mechanism.
        {"type": "set_transform", "path": "/mechanism", "matrix": _at(*-(low + high) / (2 * size), scale=1 / size)},
        _base(points[0, list(grounded)], width, layer),
        _paths(reference, trace, width, len(bars) * layer),
        *_joints(points.shape[1], bars, heights, grounded, actuated, traced, width, layer),
        *_bars(points, bars, legs, heights, width, layer),
        _animation(t, points, bars),
    ]
    key = [("path", TRACE)] * (len(trace) > 0) + [("reference", REFERENCE)] * (len(reference) > 0)
    half = (high - low) / (2 * size) + 2.4 * width / size  # of what is to be seen, feet and motors included
    Path(path).write_bytes(_page(viewer, title, key, commands, half).encode())


def _viewer():
    # The package is found and not imported: importing it loads its server, with zmq and tornado.
    meshcat = find_spec("meshcat")
    if meshcat is None:
        raise ImportError("an animation needs the viewer in meshcat: pip install meshcat")
    return Path(meshcat.submodule_search_locations[0], "viewer")


def _finite(name, values, *shape):
    """The values as floats; a letter in the shape stands for any number."""
    values = np.asarray(values, dtype=float)
    if values.ndim != len(shape) or any(want == 2 != got for want, got in zip(shape, values.shape)):
        raise ValueError(f"{name} has shape {values.shape}, not ({', '.join(map(str, shape))})")
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        raise ValueError(f"{name}[{', '.join(map(str, bad[0]))}] is {values[tuple(bad[0])]}, not finite")
    return values


def _motion(t, points):
    t, points = _finite("t", t, "n"), _finite("points", points, "n", "k", 2)
    if len(t) != len(points):
        raise ValueError(f"t has {len(t)} samples and points {len(points)}")
    if len(t) < 2:
        raise ValueError(f"a motion needs at least 2 samples, not {len(t)}")
    late = np.flatnonzero(np.diff(t) <= 0) + 1
    if len(late):
        raise ValueError(f"t[{late[0]}] = {t[late[0]]} is not after t[{late[0] - 1}] = {t[late[0] - 1]}")
    return t - t[0], points


def _check_joints(count, bars, grounded, actuated, traced):
    pairs = [(f"bars[{b}]", bar) for b, bar in enumerate(bars)]
    for name, joints in [*pairs, ("grounded", grounded), ("actuated", actuated), ("traced", traced)]:
        for joint in joints:
            if joint not in range(count):
                raise ValueError(f"{name} names joint {joint}, but points has joints 0 to {count - 1}")


def _thinned(t, points):
    frames = max(2, round(t[-1] * FRAMES_PER_SECOND) + 1)
    if len(t) <= frames:
        return t, points
    times = np.linspace(0.0, t[-1], frames)
    columns = [np.interp(times, t, column) for column in points.reshape(len(t), -1).T]
    return times, np.stack(columns, axis=1).reshape(frames, -1, 2)


def _legs(bars, grounded, actuated):
    """(depth, leg) of each bar: how many bars are between it and the nearest grounded joint, and which one that is."""
    roots = [joint for joint in dict.fromkeys([*grounded, *actuated]) if any(joint in bar for bar in bars)]
    reached, legs = {joint: (0, leg) for leg, joint in enumerate(roots)}, {}
    while wave := {
        b: min(reached[joint] for joint in bar if joint in reached)
        for b, bar in enumerate(bars)
        if b not in legs and not reached.keys().isdisjoint(bar)
    }:
        legs |= wave
        for b, (depth, leg) in wave.items():
            for joint in bars[b]:
                reached.setdefault(joint, (depth + 1, leg))
    return [legs.get(b, (0, 0)) for b in range(len(bars))]


# Solids in the words of three.js. Matrices are listed column by column; z is the height over the drawing plane.


def _at(x=0.0, y=0.0, z=0.0, angle=0.0, scale=1.0):
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    return [float(entry) for entry in (c, s, 0, 0, -s, c, 0, 0, 0, 0, scale, 0, x, y, z, 1)]


def _mesh(geometry, matrix, colour, **material):
    # Only outer faces are drawn, or hidden walls show as hairlines; all cast shadows, or light leaks in below a solid.
    return {
        "geometry": geometry,
        "matrix": matrix,
        "material": {"type": "MeshPhongMaterial", "color": colour, "shininess": 20, "shadowSide": 2, **material},
    }


def _box(centre, length, width, low, high, colour, angle=0.0):
    geometry = {"type": "BoxGeometry", "width": float(length), "height": width, "depth": high - low}
    return _mesh(geometry, _at(*centre, (low + high) / 2, angle), colour)


def _cylinder(radius, low, high, colour):
    geometry = {
        "type": "CylinderGeometry",
        "radiusTop": radius,
        "radiusBottom": radius,
        "height": high - low,
        "radialSegments": 40,
    }
    upright = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, (low + high) / 2, 1]  # three.js lays its axis along y
    return _mesh(geometry, upright, colour)


def _triangles(vertices, faces, colour, **material):
    return _mesh(
        {
            "type": "BufferGeometry",
            "data": {
                "attributes": {"position": {"itemSize": 3, "type": "Float32Array", "array": _packed(vertices)}},
                "index": {"itemSize": 1, "type": "Uint32Array", "array": _packed(faces, "<u4")},
            },
        },
        _at(),
        colour,
        **material,
    )


def _link(length, width, low, high, colour):
    """A bar with round ends, from the origin to (length, 0)."""
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 25)
    end = width / 2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    outline = np.concatenate([end, (length, 0) - end])
    n = len(outline)
    vertices = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (low, high)])
    here, after, first = np.arange(n), np.roll(np.arange(n), -1), np.zeros(n, int)
    faces = [
        (first, after, here),
        (first + n, here + n, after + n),  # bottom, top, and two for each piece of wall
        (here, after, after + n),
        (here, after + n, here + n),
    ]
    return _triangles(vertices, np.concatenate([np.stack(face, axis=1) for face in faces]), colour, flatShading=True)


def _ribbon(path, width, height, colour):
    """A flat band along a path: WebGL draws lines one pixel wide, whatever width they are given."""
    step = np.diff(path, axis=0)
    length = np.hypot(*step.T)
    start, end, along = path[:-1][length > 0], path[1:][length > 0], step[length > 0] / length[length > 0, None]
    along = along * (width / 2)  # a piece is longer by this at both ends, which fills the corners
    across = along[:, ::-1] * (-1, 1)
    corners = np.stack([start - along - across, start - along + across, end + along - across, end + along + across], 1)
    vertices = np.concatenate([corners, np.full((len(start), 4, 1), height)], axis=2)
    faces = 4 * np.arange(len(start))[:, None] + (0, 2, 1, 1, 2, 3)
    return _triangles(vertices, faces, colour, type="MeshBasicMaterial", side=2)


# Commands to the viewer.


def _packed(numbers, dtype="<f4"):
    """Numbers in the msgpack extension that the viewer reads as a typed array."""
    import umsgpack  # a dependency of meshcat

    return umsgpack.Ext({"<f4": 0x17, "<u4": 0x16}[dtype], np.asarray(numbers, dtype).tobytes())


def _object(path, meshes):
    return {
        "type": "set_object",
        "path": path,
        "object": {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": [{"uuid": f"g{i}", **mesh["geometry"]} for i, mesh in enumerate(meshes)],
            "materials": [{"uuid": f"m{i}", **mesh["material"]} for i, mesh in enumerate(meshes)],
            "object": {
                "type": "Group",
                "children": [
                    {
                        "type": "Mesh",
                        "geometry": f"g{i}",
                        "material": f"m{i}",
                        "matrix": mesh["matrix"],
                        "receiveShadow": True,
                        "castShadow": mesh["material"]["type"] == "MeshPhongMaterial",
                    }
                    for i, mesh in enumerate(meshes)
                ],
            },
        },
    }


def _stage():
    """A light ground under the machine's shadow, in place of the viewer's grid, axes and dark sky."""
    ground = _mesh(
        {"type": "PlaneGeometry", "width": 40, "height": 40},
        _at(z=-0.06),
        0x000000,
        type="ShadowMaterial",
        transparent=True,
        opacity=0.16,
    )
    clutter = ("/Grid", "/Axes", "/Lights/PointLightNegativeX", "/Lights/PointLightPositiveX")
    settings = [
        ("/Background", "top_color", [1, 1, 1]),
        ("/Background", "bottom_color", [0.93, 0.94, 0.95]),
        ("/Lights/SpotLight", "visible", True),
        ("/Lights/SpotLight/<object>", "castShadow", True),
        ("/Lights/SpotLight/<object>", "position", [0.5, 0.9, 3]),
        ("/Lights/SpotLight/<object>", "angle", 0.4),
        ("/Lights/SpotLight/<object>", "intensity", 0.42),
    ]
    return [
        *({"type": "delete", "path": path} for path in clutter),
        *({"type": "set_property", "path": path, "property": name, "value": to} for path, name, to in settings),
        _object("/ground", [ground]),
    ]


def _base(feet, width, layer):
    plates = [_box(foot, 4.4 * width, 4.4 * width, -4 * layer, -3 * layer, PLATE) for foot in feet]
    for a, b in zip(feet, feet[1:]):
        angle = np.arctan2(*(b - a)[::-1])
        plates.append(_box((a + b) / 2, np.hypot(*(b - a)), 3.4 * width, -4 * layer, -3.2 * layer, PLATE, angle))
    return _object("/mechanism/base", plates)


def _paths(reference, trace, width, height):
    ribbons = [(reference, 0.35 * width, height, REFERENCE), (trace, 0.15 * width, height + 0.05 * width, TRACE)]
    # a path that stays in one point has no band, and the viewer complains of an empty one
    return _object("/mechanism/paths", [_ribbon(*ribbon) for ribbon in ribbons if np.diff(ribbon[0], axis=0).any()])


def _joints(count, bars, heights, grounded, actuated, traced, width, layer):
    for joint in range(count):
        here = [height for bar, height in zip(bars, heights) if joint in bar] or [0.0]
        solids = [_cylinder(0.3 * width, min(here), max(here) + 1.3 * layer, TRACE if joint == traced else PIN)]
        if joint in actuated:
            solids.append(_cylinder(1.5 * width, -3 * layer, -0.1 * layer, MOTOR))
        elif joint in grounded:
            solids.append(_cylinder(0.9 * width, -3 * layer, -0.1 * layer, PLATE))
        yield _object(f"/mechanism/joints/{joint}", solids)


def _bars(points, bars, legs, heights, width, layer):
    for b, ((i, j), (depth, leg), height) in enumerate(zip(bars, legs, heights)):
        length = np.hypot(*(points[:, j] - points[:, i]).T).mean()
        colour = LEGS[leg % len(LEGS)][depth % 2]
        yield _object(f"/mechanism/bars/{b}", [_link(length, width, height, height + 0.9 * layer, colour)])


def _animation(t, points, bars):
    times, place = _packed(t), np.pad(points, [(0, 0), (0, 0), (0, 1)])
    moves = {f"/mechanism/joints/{joint}": [("position", "vector3", place[:, joint])] for joint in range(len(place[0]))}
    for b, (i, j) in enumerate(bars):
        # The angle itself and not a quaternion: made continuous it interpolates rightly, in a quarter of the numbers.
        angle = np.unwrap(np.arctan2(*(points[:, j] - points[:, i]).T[::-1]))
        moves[f"/mechanism/bars/{b}"] = [("position", "vector3", place[:, i]), ("rotation[z]", "number", angle)]
    return {
        "type": "set_animation",
        "options": {"play": True, "repetitions": float("inf")},
        "animations": [
            # at 1 frame a second the viewer's frame numbers are seconds, and need not be whole
            {
                "path": path,
                "clip": {
                    "name": "default",
                    "fps": 1,
                    "tracks": [
                        {"name": "." + name, "type": kind, "times": times, "values": _packed(values)}
                        for name, kind, values in tracks
                    ],
                },
            }
            for path, tracks in moves.items()
        ],
    }


def _page(viewer, title, key, commands, half):
    import umsgpack

    licences = [viewer / "LICENSE", viewer / "dist" / "main.min.js.THIRD_PARTY_LICENSES.json"]
    return PAGE.substitute(
        title=html.escape(title),
        key="".join(f'<span style="color:#{colour:06x}">&#9644;</span> {name} ' for name, colour in key),
        half=json.dumps(half.tolist()),
        field=FIELD_OF_VIEW,
        commands=json.dumps([b64encode(umsgpack.packb(command)).decode() for command in commands]),
        script=(viewer / "dist" / "main.min.js").read_text("utf-8"),
        licences="\n".join(licence.read_text("utf-8") for licence in licences),
    )


# The policy forbids the page every request, whatever the viewer or a title may try; the empty icon keeps the browser
# from asking for one. `fit` keeps the camera's direction and backs off until all is seen between title and controls.
PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<meta name="viewport" content="width=device-width">
<link rel="icon" href="data:,">
<title>$title</title>
<style>
body { margin: 0; overflow: hidden; font: 15px/1.5 system-ui, sans-serif; color: #2a2e33; }
#pane { width: 100vw; height: 100vh; }
header { position: absolute; top: 12px; left: 16px; right: 260px; pointer-events: none; }
h1 { margin: 0; font-size: 18px; font-weight: 600; overflow-wrap: anywhere; }
footer { position: absolute; bottom: 0; left: 0; right: 0; padding: 10px 16px; display: flex; gap: 12px; }
footer input { flex: 1; min-width: 0; }
footer button, footer output { width: 70px; }
.dg.main { filter: invert(0.9) hue-rotate(180deg); }
</style>
</head>
<body>
<div id="pane"></div>
<header><h1>$title</h1>$key</header>
<footer>
<button></button>
<input type="range" min="0" step="any" aria-label="time">
<output></output>
<select aria-label="speed"></select>
</footer>
<script>$script</script>
<script>
var viewer = new MeshCat.Viewer(document.getElementById("pane"));
for (const command of $commands)
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));

const player = viewer.animator, [play, time, clock, speed] = document.querySelectorAll("footer > *");
time.max = player.duration;
for (const factor of [0.1, 0.25, 0.5, 1, 2, 4]) speed.add(new Option("speed " + factor, factor, false, factor == 1));
play.onclick = () => player.playing ? player.pause() : player.play();
time.oninput = () => { player.seek(+time.value); player.display_progress(+time.value); };
speed.onchange = () => { player.mixer.timeScale = +speed.value; };
(function show() {
  play.textContent = player.playing ? "pause" : "play";
  time.value = player.time;
  clock.value = player.time.toFixed(2) + " s";
  requestAnimationFrame(show);
})();

function fit() {
  const [x, y] = $half, free = Math.max(0.3, 1 - 110 / innerHeight), camera = viewer.camera;
  camera.position.setLength(Math.max(y / free, x / camera.aspect) / Math.tan($field * Math.PI / 360));
  viewer.set_dirty();
}
viewer.camera.fov = $field;
viewer.camera.position.set(0, 1, 0);
viewer.set_3d_pane_size();
fit();
window.addEventListener("resize", fit);
</script>
<script type="text/plain">$licences</script>
</body>
</html>
""")
