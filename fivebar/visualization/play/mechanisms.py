"""The linkages of the live page: each as one function of its crank angle and lengths, and what its
parts are called.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...base.backend import as_numbers
from ...linkages import PRESSES, FourBar, SixBarPress, SliderCrank, crank_range, straight_line
from ...linkages.checks import check_branch
from ...linkages.slider_crank import HELD
from ...linkages.straight_line import BUILDERS
from ..functions import named_function
from ..skeleton import chain_parts

_PRESS = PRESSES["repaired"][0]
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
    """Return a linkage of symbols: what its class checks of numbers is not asked."""
    linkage = object.__new__(kind)
    for field in fields(kind):
        object.__setattr__(linkage, field.name, parameters.get(field.name, field.default))
    return linkage


def _four_bar(values):
    return _of_symbols(FourBar, **dict(zip(_SIDES, values)), point=tuple(values[4:]))


def _press(values):
    return _of_symbols(
        SixBarPress, **dict(zip(_BARS, values)), l12=_PRESS.l12, theta11=_PRESS.theta11
    )


def _slider(held):
    return lambda values: _of_symbols(SliderCrank, **dict(zip(_SLIDER, values)), held=held)


# The crank-rocker in Table 2 of the MechAnalyzer paper
_SIDES = dict(ground=(0.2, False), crank=(0.06, False), coupler=(0.16, False), rocker=(0.14, False))
_POINT = dict(along=(0.08, True), across=(0.06, True))
_SLIDER = dict(crank=(0.05, False), rod=(0.15, False), offset=(0.0, True))
_BARS = {name: (getattr(_PRESS, name), False) for name in ("l2", "l3", "l4", "l5", "l11")}
KINDS = [Kind("four", "four-bar", _SIDES | _POINT, _four_bar, "rocker", True)]
for _held in HELD:
    _out = "slide" if _held in ("guide", "slider") else "guide"
    _title = f"slider-crank, {_held} fixed"
    KINDS.append(
        Kind(f"slider_{_held}", _title, _SLIDER, _slider(_held), _out, _held in ("crank", "rod"))
    )
KINDS.append(Kind("press", "six-bar press", _BARS, _press, "S6_down", False, 2))


@lru_cache(maxsize=1)
def mechanisms() -> tuple[list[ca.Function], dict]:
    """Return the functions, and for each {what the page says and draws of it}."""
    functions, words = zip(*map(_mechanism, KINDS))
    return list(functions), dict(zip((kind.name for kind in KINDS), words))


def _mechanism(kind):
    q = ca.SX.sym("q")
    speed = ca.SX.sym("speed")
    branch = ca.SX.sym("branch", kind.branches)
    values = ca.SX.sym("values", len(kind.parameters))
    signs = branch if kind.branches == 1 else (branch[0], branch[1])
    with as_numbers():
        motion = kind.build([values[k] for k in range(values.numel())]).start(q, speed, 0.0, signs)
        chain = motion.chain
        at = motion.position(chain.traced)
        angle = motion.angle, motion.rate, motion.angular_acceleration
        out = [f(kind.out) for f in angle] if kind.angle else motion.coordinate(kind.out)
        # The output, too: a press has a dyad beyond what is traced.
        whole = ca.fabs(ca.sum1(at) + out[0]) < ca.inf
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
    names = ["" if name in chain.marks else name for name in chain.points]
    words = {
        "title": kind.title,
        "names": names,
        "parameters": [
            {"name": name, "value": x, "signed": signed}
            for name, (x, signed) in kind.parameters.items()
        ],
        **chain_parts(chain),
        "pins": [k for k, name in enumerate(names) if name],
        "branches": kind.branches,
        "branch": [-1, -1] if kind.branches == 2 else [1],
        "output": OUTPUTS.get(kind.out, kind.out),
        "angle": kind.angle,
    }
    return named_function(kind.name, outputs, q, speed, branch, values), words


def straight_lines() -> dict:
    """Return of each straight-line mechanism, its ground laid on the x axis: lengths, branch,
    stroke and nominal line.
    """
    lines = {}
    for name in BUILDERS:
        mechanism = straight_line(name)
        linkage = mechanism.linkage
        c = math.cos(linkage.tilt)
        s = math.sin(linkage.tilt)
        level = np.array([[c, s], [-s, c]])
        scale = 0.2 / linkage.ground  # in the source's unit: here a ground of 200 mm
        through = scale * level @ (np.array(mechanism.through) - linkage.base)
        lines[name] = {
            "values": [scale * x for x in _four_bar_values(linkage)],
            "branch": [mechanism.branch],
            "through": through.tolist(),
            "direction": (level @ mechanism.direction).tolist(),
            "stroke": sorted(angle - linkage.tilt for angle in mechanism.stroke),
            "source": mechanism.source,
        }
    return lines


def _four_bar_values(linkage):
    return *linkage.sides, *(linkage.point or (linkage.coupler / 2, 0.0))


def address_of(linkage: Any, branch: Any) -> str:
    """Return what follows the live page's address, for this linkage with its ground laid on the x
    axis.

    branch: None is its usual one. The crank stands at an angle at which the linkage closes. Raises
    ValueError for a press whose guide is not the paper's.
    """
    signs: Any = check_branch(linkage, branch)
    if isinstance(linkage, FourBar):
        name, values = "four", _four_bar_values(linkage)
    elif isinstance(linkage, SliderCrank):
        name = f"slider_{linkage.held}"
        values = (linkage.crank, linkage.rod, linkage.offset)
    else:
        if (linkage.l12, linkage.theta11) != (_PRESS.l12, _PRESS.theta11):
            raise ValueError("the live page has presses with the paper's l12 and theta11 only")
        name = "press"
        values = [getattr(linkage, bar) for bar in _BARS]
    allowed = crank_range(linkage, signs)
    if not allowed.intervals:
        raise ValueError("the linkage closes at no crank angle: there is nothing to show")
    low, high = max(allowed.intervals, key=np.ptp)
    crank = 0.6 if allowed.full else (low + high) / 2
    crank -= getattr(linkage, "tilt", 0.0)
    letters = "".join("+" if sign > 0 else "-" for sign in np.ravel(signs))
    numbers = ",".join(map(digits, values))
    crank = digits(math.remainder(crank, 2 * math.pi))
    return f"#linkage={name}&values={numbers}&branch={letters}&crank={crank}"


def digits(x: float) -> str:
    """Return a number for an address: all digits, without the + that would be a space."""
    return repr(float(x)).replace("e+", "e").removesuffix(".0")
