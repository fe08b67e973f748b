"""Robots of tests/data/physics.json, as they are built, and the full bodies that they are."""

import json
from pathlib import Path

import fivebar as fb

from .full_bodies import FullBodies

CASES = json.loads((Path(__file__).parents[1] / "data" / "physics.json").read_text("utf-8"))[
    "robots"
]
LENGTHS = "l11", "l12", "l21", "l22", "d"
ELBOWS = 0.004, 0.007  # N m s/rad, of a robot with friction in them


def numbers(values):
    return tuple(float(value) for value in values)


def robot_of_case(case, **more):
    given = case["robot"]
    links = {name: fb.Link.about_centre(*numbers(link)) for name, link in given["links"].items()}
    return fb.FiveBar.from_links(
        *(float(given[name]) for name in LENGTHS),
        links,
        float(given["payload"]),
        numbers(given["gravity"]),
        numbers(given["rotor"]),
        numbers(given["fv"]),
        numbers(given["fs"]),
        **more,
    )


def bodies_of_case(case, elbows=(0, 0)):
    given = case["robot"]
    return FullBodies(
        numbers((given["l11"], given["l21"])),
        numbers((given["l12"], given["l22"])),
        float(given["d"]),
        [numbers(given["links"][name]) for name in ("11", "12", "21", "22")],
        float(given["payload"]),
        numbers(given["gravity"]),
        *(numbers(given[name]) for name in ("rotor", "fv", "fs")),
        elbows,
    )


FEET = [(1.1, 0, 0, 0), (0.4, 0.11, 0.02, 0.002), (0.9, 0, 0, 0), (0.5, 0.17, -0.03, 0.003)]


def heavy_biglide():
    """The lab's with bars of mass, grouped by hand: a foot carries what is not at the end-effector."""
    lengths, ends = (0.2828427, 0.30), []
    grouped = {"gravity": (0.6, -9.81), "fv1": 0.3, "fs2": 0.2}
    for leg, bar in zip("12", lengths):
        (foot, *_), (mass, x, y, inertia) = FEET[2 * int(leg) - 2 : 2 * int(leg)]
        ends.append(mass * x / bar)
        grouped |= {
            f"mf{leg}": foot + mass - ends[-1],
            f"my{leg}": mass * y,
            f"zz{leg}": inertia + mass * (x * x + y * y) - mass * x * bar,
        }
    robot = fb.Biglide(*lengths, 0.4, m=0.7 + sum(ends), **grouped)
    return robot, FullBodies(
        None, lengths, 0.4, FEET, 0.7, (0.6, -9.81), (0, 0), (0.3, 0), (0, 0.2)
    )
