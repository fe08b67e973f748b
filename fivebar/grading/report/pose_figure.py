"""The robot in the expected and in the returned pose, as a small drawing."""

from __future__ import annotations

from math import cos, hypot, isfinite, sin

from ...models.robots import Robot
from ..exercise import Exercise
from ..variants import lengths

WIDTH, HEIGHT, ROOM = 300, 190, 14  # of the drawing and its margin, px
EXPECTED, CAME = "#1a7f37", "#c4320a"


def pose_figure(robot: Robot, exercise: Exercise, sample: dict) -> str:
    """SVG text; "" where the exercise's names are no pose or velocity, or nothing can be drawn of
    what came.

    The pose is read from the names of the arguments and the returned values: q11, q21 turn the
    proximal bars (slide the feet), x, y or q12, q22 place the distal ones, xD, yD draw the
    end-effector's velocity.
    """
    names = exercise.returns
    if len(sample["expected"]) != len(names):
        return ""
    drawn = []
    for numbers in (sample["expected"], sample["came"]):
        drawn.append(_lines(robot, sample["inputs"] | dict(zip(names, numbers))))
    if not drawn[1] or names == ("xD", "yD") and not _arrows(sample):
        return ""
    if names == ("xD", "yD"):
        drawn = [lines + arrow for lines, arrow in zip(drawn, _arrows(sample, drawn[0]))]
    elif not set(names) & {"x", "q11", "q12"}:
        return ""
    return _svg(drawn)


def _lines(robot, at):
    """Polylines (m) of base or foot, bars and end-effector; () where a number is missing or not
    finite.
    """
    known = ("q11", "q21", *(("x", "y") if "x" in at else ("q12", "q22")))
    if not all(name in at and isfinite(at[name]) for name in known):
        return ()
    legs = []
    for leg, drive, bar in zip("12", robot.drives, robot.distal):
        q = at[f"q{leg}1"]
        elbow = drive.pivot(drive.direction(q))
        phi = None if "x" in at else drive.absolute(at[f"q{leg}2"], q)
        end = (
            (at["x"], at["y"])
            if phi is None
            else (elbow[0] + bar * cos(phi), elbow[1] + bar * sin(phi))
        )
        legs.append(((drive.x, drive.y), elbow, end) if robot.turns else (elbow, end))
    reach = sum(lengths(robot).values())
    return tuple(legs) if all(hypot(*point) < 3 * reach for leg in legs for point in leg) else ()


def _arrows(sample, drawn=None):
    """Both velocities to one scale, from the end-effector; () where one is not finite or both
    vanish.
    """
    pairs = sample["expected"], sample["came"]
    longest = max(hypot(*pair) for pair in pairs)
    if not (isfinite(longest) and longest > 0):
        return ()
    if drawn is None:
        return pairs
    x, y = drawn[0][-1]
    return [(((x, y), (x + 0.06 * vx / longest, y + 0.06 * vy / longest)),) for vx, vy in pairs]


def _svg(drawn):
    points = [point for lines in drawn for line in lines for point in line]
    columns = list(zip(*points))
    low = [min(column) for column in columns]
    high = [max(column) for column in columns]
    scale = min(
        (WIDTH - 2 * ROOM) / (high[0] - low[0]), (HEIGHT - 2 * ROOM) / max(high[1] - low[1], 1e-3)
    )
    middle = [(a + b) / 2 for a, b in zip(low, high)]

    def place(point):
        x = WIDTH / 2 + scale * (point[0] - middle[0])
        y = HEIGHT / 2 - scale * (point[1] - middle[1])
        return f"{x:.0f},{y:.0f}"

    parts = []
    for lines, colour, style in zip(drawn, (EXPECTED, CAME), ('5"', '2" stroke-dasharray="7 5"')):
        for line in lines:
            joined = " ".join(place(point) for point in line)
            parts.append(
                f'<polyline points="{joined}" fill="none" stroke="{colour}" stroke-width="{style}/>'
            )
            for x, y in (place(point).split(",") for point in line[-2:]):
                parts.append(
                    f'<circle cx="{x}" cy="{y}" r="4" fill="#fff" stroke="{colour}"'
                    ' stroke-width="2"/>'
                )
    for start, *_ in drawn[0][:2]:  # base joints, or where the feet should be
        x, y = place(start).split(",")
        parts.append(
            f'<rect x="{int(x) - 5}" y="{int(y) - 5}" width="10" height="10" fill="#444"/>'
        )
    label = "the robot as it should be (solid, green) and as your answer has it (dashed, red)"
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img"'
        f' aria-label="{label}">' + "".join(parts) + "</svg>"
    )
