"""What can be asked of a motion by name, with its unit: "coupler.angle", "M.x", "slide.position",
"torque", ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .dynamics import driving_torque, equivalent_inertia, potential

if TYPE_CHECKING:
    from .motion import Motion
    from .study import Study

LINK = {
    "angle": ("rad", lambda m, name: m.angle(name)),
    "rate": ("rad/s", lambda m, name: m.rate(name)),
    "angular_acceleration": ("rad/s^2", lambda m, name: m.angular_acceleration(name)),
}
POINT = {
    "x": ("m", lambda m, name: m.position(name)[..., 0]),
    "y": ("m", lambda m, name: m.position(name)[..., 1]),
    "vx": ("m/s", lambda m, name: m.velocity(name)[..., 0]),
    "vy": ("m/s", lambda m, name: m.velocity(name)[..., 1]),
    "ax": ("m/s^2", lambda m, name: m.acceleration(name)[..., 0]),
    "ay": ("m/s^2", lambda m, name: m.acceleration(name)[..., 1]),
    "distance": ("m", lambda m, name: np.hypot(*np.moveaxis(m.position(name), -1, 0))),
    "speed": ("m/s", lambda m, name: m.speed(name)),
    "total": ("m/s^2", lambda m, name: np.hypot(*np.moveaxis(m.acceleration(name), -1, 0))),
    "tangential": ("m/s^2", lambda m, name: m.tangential(name)),
    "normal": ("m/s^2", lambda m, name: m.normal(name)),
    "curvature_radius": ("m", lambda m, name: m.curvature_radius(name)),
}
COORDINATE = {
    "position": ("m", lambda m, name: m.coordinate(name)[0]),
    "velocity": ("m/s", lambda m, name: m.coordinate(name)[1]),
    "acceleration": ("m/s^2", lambda m, name: m.coordinate(name)[2]),
}
WHOLE = {
    "transmission_angle": ("rad", lambda m, load, gravity: m.transmission_angle()),
    "inertia": ("kg m^2", lambda m, load, gravity: equivalent_inertia(m)[0]),
    "inertia_slope": ("kg m^2/rad", lambda m, load, gravity: equivalent_inertia(m)[1]),
    "potential": ("J", lambda m, load, gravity: potential(m, gravity)[0]),
    "torque": ("N m", lambda m, load, gravity: driving_torque(m, load, gravity)),
}


def unit(name: str) -> str:
    """The unit of a quantity, by its name."""
    own = name.rpartition(".")[2]
    if name in WHOLE:
        return WHOLE[name][0]
    return next(table[own][0] for table in (LINK, POINT, COORDINATE) if own in table)


def known(motion: Motion) -> list[str]:
    """The names of all quantities of a motion."""
    parts = ((motion.links, LINK), (motion.coordinates, COORDINATE), (motion.points, POINT))
    names = [f"{part}.{own}" for group, table in parts for part in group for own in table]
    one_drive = not isinstance(motion.q, tuple)
    return names + [name for name in WHOLE if one_drive or name == "transmission_angle"]


def usual(motion: Motion, loaded: bool) -> list[str]:
    """The names that a table has where none are asked for: without the points that only pictures
    need.
    """
    points = [
        p for p in motion.points if p not in motion.chain.marks and p not in motion.chain.grounded
    ]
    names = [f"{link}.{own}" for link in motion.links for own in LINK if link != "slider"]
    names += [f"{way}.{own}" for way in motion.coordinates for own in COORDINATE]
    names += [f"{point}.{own}" for point in points for own in ("x", "y", "vx", "vy", "ax", "ay")]
    if (
        not motion.coordinates
    ):  # a slider's path, or what is traced beside one, is straight or a circle
        names += [
            f"{motion.chain.traced}.{own}"
            for own in ("speed", "tangential", "normal", "curvature_radius")
        ]
    names.append("transmission_angle")
    massive = any(link.body.mass or link.body.inertia for link in motion.chain.links.values())
    return names + (["inertia", "torque"] if massive else ["torque"] if loaded else [])


def usual_panels(study: Study) -> list[list[str]]:
    """Quantities plotted together: ways, or else the links' angles; their rates; their
    accelerations; the torque.

    Of a four-bar whose coupler point is named, that point's speed and accelerations in place of the
    links' rates.
    """
    motion = study.motion
    if motion.coordinates:
        panels = [
            [f"{motion.coordinates[0]}.{own}"] for own in ("position", "velocity", "acceleration")
        ]
    elif getattr(study.linkage, "point", None) is not None:
        point = motion.chain.traced
        panels = [[f"{link}.angle" for link in motion.links], [f"{point}.speed"]]
        panels.append([f"{point}.tangential", f"{point}.normal"])
    else:
        panels = [
            [f"{link}.{own}" for link in motion.links]
            for own in ("angle", "rate", "angular_acceleration")
        ]
    return panels + ([["torque"]] if "torque" in study.columns else [])


def evaluate(
    motion: Motion, name: str, load: dict | None = None, gravity: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """One quantity of a motion by its name."""
    part, _, own = name.rpartition(".")
    if name in WHOLE:
        return WHOLE[name][1](motion, load, gravity)
    for group, table in (
        (motion.links, LINK),
        (motion.coordinates, COORDINATE),
        (motion.points, POINT),
    ):
        if part in group and own in table:
            return table[own][1](motion, part)
    raise ValueError(f"no quantity {name!r}; the known ones are {', '.join(known(motion))}")
