"""The chart of the direct geometric model with more routes of the sources."""

import math
from dataclasses import replace

import numpy as np

from fivebar.base.backend import cos, sin, sqrt
from fivebar.study.pitfalls.half_angle import half_angle
from fivebar.study.speed_accuracy.chart import Chart, Method
from fivebar.study.speed_accuracy.charts import geometry
from fivebar.study.speed_accuracy.charts.dgm_routes import ROBOT, Angle, elbows


def tangent_half_angle(q1: Angle, q2: Angle) -> tuple:
    """The left distal bar's angle from dx cos + dy sin = c, by its tangent half-angle."""
    x1, y1, dx, dy = elbows(q1, q2)
    c = (dx * dx + dy * dy + ROBOT.l12**2 - ROBOT.l22**2) / (2 * ROBOT.l12)
    phi = half_angle(dy, dx, -c, 1)
    return x1 + ROBOT.l12 * np.cos(phi), y1 + ROBOT.l12 * np.sin(phi)


def arctg(q1: Angle, q2: Angle) -> tuple:
    """The vector method's eq. 9: arctg of the bar's components, which does not know the quadrant."""
    x1, y1, dx, dy = elbows(q1, q2)
    square = dx * dx + dy * dy
    along = 0.5 + (ROBOT.l12**2 - ROBOT.l22**2) / (2 * square)
    across = sqrt(ROBOT.l12**2 / square - along * along)
    tangent = (along * dy + across * dx) / (along * dx - across * dy)
    phi = (math if isinstance(q1, float) else np).atan(tangent)
    return x1 + ROBOT.l12 * cos(phi), y1 + ROBOT.l12 * sin(phi)


def equivalent_four_bar(q1: Angle, q2: Angle) -> tuple:
    """MechAnalyzer eq. 17-21: base and right crank become an imaginary ground link, the rest its
    four-bar; then its coupler point by eq. 1-11: y from a quadratic, x from the circles' difference.
    """
    d, l4 = ROBOT.d, ROBOT.l21
    arcsine = (math if isinstance(q1, float) else np).asin
    ground = sqrt(d * d + l4 * l4 - 2 * d * l4 * cos(math.pi - q2))
    turn = arcsine(l4 * sin(2 * math.pi - q2) / ground)  # the sine rule: right as long as l21 < d
    ax, ay = ROBOT.l11 * cos(q1 + turn), ROBOT.l11 * sin(q1 + turn)
    off = ground - ax
    s = (ROBOT.l12**2 - ROBOT.l22**2 + ground**2 - ax * ax - ay * ay) / (2 * off)
    p, t = 1 + (ay / off) ** 2, s - ground
    quarter = (t * ay / off) ** 2 - p * (t * t - ROBOT.l22**2)
    side = 1 - 2 * (off < 0)  # the root on the left of the line from the elbow to the right pivot
    y = (-t * ay / off + side * sqrt(quarter)) / p
    x = s + ay * y / off
    return x * cos(turn) + y * sin(turn) - d / 2, y * cos(turn) - x * sin(turn)


def chart() -> Chart:
    """Return the chart with these routes."""
    known = geometry.chart()
    single = {"one": (0,), "batch": (0,)}
    everywhere = single | {"singular": geometry.GAPS}
    more = [
        Method(name, geometry.FORMS, geometry.closed(route), knobs)
        for name, route, knobs in (
            ("tangent half-angle", tangent_half_angle, everywhere),
            ("equivalent four-bar (MechAnalyzer eq. 17-21)", equivalent_four_bar, everywhere),
            ("arctg angles (vector method eq. 9)", arctg, single),
        )
    ]
    return replace(known, methods=(*known.methods, *more))
