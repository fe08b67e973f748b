"""The linkages of the live page: each as one function of its crank angle and lengths, and what its
parts are called.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import lru_cache

import casadi as ca
import numpy as np

from ...base.backend import as_numbers
from ...linkages import PRESSES, FourBar, SixBarPress, SliderCrank, crank_range, straight_line
from ...linkages.checks import check_branch
from ...linkages.slider_crank import HELD
from ...linkages.straight_line import BUILDERS
from ..functions import named

_PRESS = PRESSES["repaired"][0]
STRAIGHT = tuple(BUILDERS)
OUTPUTS = {"slide": "slider", "S6_down": "slider"}  # what is moved along these coordinates


@dataclass(frozen=True)
class Kind:
    """A linkage of the page: its function's name, title, parameters, how it is built from them, and
    what it drives.

    parameters: {name: (default m, whether it may be negative)}; out: the link whose angle, or the
    coordinate whose value, is what the crank drives; branches: how many signs its branch has.
    """

    name: str
    title: str
    parameters: dict
    build: Callable
    out: str
    angle: bool
    branches: int = 1


def _of_symbols(kind, **parameters):
    """A linkage of symbols: what its class checks of numbers is not asked."""
    made = object.__new__(kind)
    for field in fields(kind):
        object.__setattr__(made, field.name, parameters.get(field.name, field.default))
    return made


def _four_bar(values):
    return _of_symbols(FourBar, **dict(zip(_SIDES, values)), point=tuple(values[4:]))


def _press(values):
    return _of_symbols(
        SixBarPress, **dict(zip(_BARS, values)), l12=_PRESS.l12, theta11=_PRESS.theta11
    )


def _slider(held):
    return lambda values: _of_symbols(SliderCrank, **dict(zip(_SLIDER, values)), held=held)


# MechAnalyzer's crank-rocker
_SIDES = {
    name: (x, False)
    for name, x in (("ground", 0.2), ("crank", 0.06), ("coupler", 0.16), ("rocker", 0.14))
}
_POINT = {"along": (0.08, True), "across": (0.06, True)}
_SLIDER = {"crank": (0.05, False), "rod": (0.15, False), "offset": (0.0, True)}
_BARS = {name: (getattr(_PRESS, name), False) for name in ("l2", "l3", "l4", "l5", "l11")}
KINDS = [
    Kind("four", "four-bar", _SIDES | _POINT, _four_bar, "rocker", True),
    *(
        Kind(
            f"slider_{held}",
            f"slider-crank, {held} held",
            _SLIDER,
            _slider(held),
            "slide" if held in ("guide", "slider") else "guide",
            held in ("crank", "rod"),
        )
        for held in HELD
    ),
    Kind("press", "six-bar press", _BARS, _press, "S6_down", False, 2),
]


@lru_cache(maxsize=1)
def mechanisms() -> tuple[list[ca.Function], dict]:
    """The functions, and for each {what the page says and draws of it}."""
    found = [_mechanism(kind) for kind in KINDS]
    return [function for function, _ in found], {
        kind.name: words for kind, (_, words) in zip(KINDS, found)
    }


def _mechanism(kind):
    q, speed, branch = ca.SX.sym("q"), ca.SX.sym("speed"), ca.SX.sym("branch", kind.branches)
    values = ca.SX.sym("values", len(kind.parameters))
    signs = branch if kind.branches == 1 else (branch[0], branch[1])
    with as_numbers():
        motion = kind.build([values[k] for k in range(values.numel())]).start(q, speed, 0.0, signs)
        chain = motion.chain
        at = motion.position(chain.traced)
        if kind.angle:
            out = (
                motion.angle(kind.out),
                motion.rate(kind.out),
                motion.angular_acceleration(kind.out),
            )
        else:
            out = motion.coordinate(kind.out)
        whole = (
            ca.fabs(ca.sum1(at) + out[0]) < ca.inf
        )  # the output, too: a press has a dyad beyond what is traced
        outputs = {
            "points": ca.vertcat(*(ca.SX(motion.position(name)).T for name in chain.points)),
            "velocity": motion.velocity(chain.traced),
            "acceleration": motion.acceleration(chain.traced),
            "tangential": motion.tangential(chain.traced),
            "normal": motion.normal(chain.traced),
            "radius": motion.curvature_radius(chain.traced),
            "output": ca.vertcat(*out),
            "transmission": motion.transmission_angle(),
            "closes": whole,
        }
    names = list(chain.points)

    def places(groups):
        return [[names.index(name) for name in group] for group in groups]

    marks = chain.marks
    words = {
        "title": kind.title,
        "names": [name if name not in marks else "" for name in names],
        "parameters": [
            {"name": name, "value": x, "signed": signed}
            for name, (x, signed) in kind.parameters.items()
        ],
        "bars": places(chain.bars),
        "grounded": places([chain.grounded])[0],
        "actuated": places([chain.actuated])[0],
        "traced": names.index(chain.traced),
        "rails": places(chain.rails),
        "blocks": places(chain.blocks),
        "pins": [k for k, name in enumerate(names) if name not in marks],
        "branches": kind.branches,
        "branch": [-1, -1] if kind.branches == 2 else [1],
        "output": OUTPUTS.get(kind.out, kind.out),
        "angle": kind.angle,
    }
    return named(kind.name, outputs, q, speed, branch, values), words


def straight_lines() -> dict:
    """Of each straight-line mechanism, its ground laid on the x axis: lengths, branch, stroke and
    nominal line.
    """
    found = {}
    for name in STRAIGHT:
        mechanism = straight_line(name)
        linkage = mechanism.linkage
        c, s = math.cos(linkage.tilt), math.sin(linkage.tilt)
        level = np.array([[c, s], [-s, c]])
        through = level @ (np.array(mechanism.through) - linkage.base)
        scale = 0.2 / linkage.ground  # in the source's unit: here a ground of 200 mm
        point = linkage.point or (linkage.coupler / 2, 0.0)
        found[name] = {
            "values": [scale * x for x in (*linkage.sides, *point)],
            "branch": [mechanism.branch],
            "through": (scale * through).tolist(),
            "direction": (level @ mechanism.direction).tolist(),
            "stroke": sorted(angle - linkage.tilt for angle in mechanism.stroke),
            "source": mechanism.source,
        }
    return found


def address_of(
    linkage: FourBar | SliderCrank | SixBarPress, branch: object = None, crank: float | None = None
) -> str:
    """What follows the live page's address, for this linkage with its ground laid on the x axis.

    branch: None is its usual one; crank: rad, None an angle at which it closes. ValueError for a
    press whose guide is not the paper's.
    """
    branch = check_branch(linkage, branch)
    if isinstance(linkage, FourBar):
        name, values = "four", (*linkage.sides, *(linkage.point or (linkage.coupler / 2, 0.0)))
    elif isinstance(linkage, SliderCrank):
        name, values = f"slider_{linkage.held}", (linkage.crank, linkage.rod, linkage.offset)
    else:
        if (linkage.l12, linkage.theta11) != (_PRESS.l12, _PRESS.theta11):
            raise ValueError(
                "the live page has the paper's l12 and theta11 only, and this press has others"
            )
        name, values = "press", [getattr(linkage, each) for each in _BARS]
    if crank is None:
        allowed = crank_range(linkage, branch)
        if not allowed.intervals:
            raise ValueError(
                "on this branch the linkage closes at no crank angle: there is nothing to show"
            )
        low, high = max(allowed.intervals, key=lambda interval: interval[1] - interval[0])
        crank = 0.6 if allowed.full else (low + high) / 2
        crank -= getattr(linkage, "tilt", 0.0)
    signs = "".join(
        "+" if each > 0 else "-" for each in (branch if isinstance(branch, tuple) else (branch,))
    )
    crank = math.remainder(crank, 2 * math.pi)
    numbers = ",".join(map(digits, values))
    return f"#linkage={name}&values={numbers}&branch={signs}&crank={digits(crank)}"


def digits(x: float) -> str:
    """A number for an address: all its digits, without the + that would be read as a space."""
    return repr(float(x)).replace("e+", "e").removesuffix(".0")
