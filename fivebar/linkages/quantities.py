"""Quantities of a motion by name: "coupler.angle", "M.x", "slide.position", "torque", ..."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .dynamics import driving_torque, equivalent_inertia, potential

if TYPE_CHECKING:
    from .motion import Motion
    from .study import Study

# {quantity: unit} of links, points, coordinates and the whole linkage.
LINK = {"angle": "rad", "rate": "rad/s", "angular_acceleration": "rad/s^2"}
POINT = {
    "x": "m",
    "y": "m",
    "vx": "m/s",
    "vy": "m/s",
    "ax": "m/s^2",
    "ay": "m/s^2",
    "distance": "m",
    "speed": "m/s",
    "total": "m/s^2",
    "tangential": "m/s^2",
    "normal": "m/s^2",
    "curvature_radius": "m",
}
COORDINATE = {"position": "m", "velocity": "m/s", "acceleration": "m/s^2"}
WHOLE = {
    "transmission_angle": "rad",
    "inertia": "kg m^2",
    "inertia_slope": "kg m^2/rad",
    "potential": "J",
    "torque": "N m",
}
UNITS = LINK | POINT | COORDINATE | WHOLE
VECTORS = {"": "position", "v": "velocity", "a": "acceleration"}
ALONG_PATH = ("speed", "tangential", "normal", "curvature_radius")


def unit(name: str) -> str:
    """Return the unit of a quantity."""
    return UNITS[name.rpartition(".")[2]]


def known(motion: Motion) -> list[str]:
    """Return the names of all quantities of a motion."""
    names = []
    for parts, quantities in _groups(motion):
        for part in parts:
            names += [f"{part}.{quantity}" for quantity in quantities]
    return names + (["transmission_angle"] if isinstance(motion.q, tuple) else list(WHOLE))


def _groups(motion):
    return (motion.links, LINK), (motion.coordinates, COORDINATE), (motion.points, POINT)


def usual(motion: Motion, loaded: bool) -> list[str]:
    """Return the quantities of a table by default, without points that only pictures need."""
    chain = motion.chain
    left_out = {"slider", *chain.marks, *chain.grounded}
    names = []
    for parts, quantities in _groups(motion):
        for part in parts:
            if part not in left_out:
                names += [f"{part}.{quantity}" for quantity in list(quantities)[:6]]
    if not chain.coordinates:  # A slider's path, and what is traced with one, is simple.
        names += [f"{chain.traced}.{quantity}" for quantity in ALONG_PATH]
    names.append("transmission_angle")
    if any(link.body.mass or link.body.inertia for link in chain.links.values()):
        return [*names, "inertia", "torque"]
    return [*names, "torque"] if loaded else names


def usual_panels(study: Study) -> list[list[str]]:
    """Return groups of quantities to be plotted together.

    Coordinates or else angles of the links, their rates, their accelerations, the torque. Of a
    four-bar whose coupler point is named, the speed and accelerations of that point.
    """
    motion = study.motion
    if motion.coordinates:
        panels = [[f"{motion.coordinates[0]}.{quantity}"] for quantity in COORDINATE]
    elif getattr(study.linkage, "point", None) is not None:
        point = motion.chain.traced
        panels = [[f"{link}.angle" for link in motion.links], [f"{point}.speed"]]
        panels.append([f"{point}.tangential", f"{point}.normal"])
    else:
        panels = []
        for quantity in LINK:
            panels.append([f"{link}.{quantity}" for link in motion.links])
    return panels + ([["torque"]] if "torque" in study.columns else [])


def evaluate(
    motion: Motion, name: str, load: dict | None = None, gravity: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Return one quantity of a motion by its name, (*batch,)."""
    part, _, quantity = name.rpartition(".")
    if part in motion.links and quantity in LINK:
        return getattr(motion, quantity)(part)
    if part in motion.coordinates and quantity in COORDINATE:
        return motion.coordinate(part)[list(COORDINATE).index(quantity)]
    if part in motion.points and quantity in POINT:
        return _of_point(motion, part, quantity)
    match name:
        case "transmission_angle":
            return motion.transmission_angle()
        case "inertia":
            return equivalent_inertia(motion)[0]
        case "inertia_slope":
            return equivalent_inertia(motion)[1]
        case "potential":
            return potential(motion, gravity)[0]
        case "torque":
            return driving_torque(motion, load, gravity)
    raise ValueError(f"no quantity {name!r}; the known ones are {', '.join(known(motion))}")


def _of_point(motion, point, quantity):
    if quantity in ALONG_PATH:
        return getattr(motion, quantity)(point)
    if quantity == "distance":
        return np.hypot(*np.moveaxis(motion.position(point), -1, 0))
    if quantity == "total":
        return np.hypot(*np.moveaxis(motion.acceleration(point), -1, 0))
    vector = getattr(motion, VECTORS[quantity[:-1]])(point)
    return vector[..., "xy".index(quantity[-1])]
