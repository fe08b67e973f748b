"""The robot in the expected and in the returned pose, as a small drawing."""

from math import cos, hypot, isfinite, sin

WIDTH, HEIGHT, ROOM = 300, 190, 14
EXPECTED, CAME = "#1a7f37", "#c4320a"


def pose_figure(robot, exercise, sample):
    """SVG text; "" where the exercise's names are no pose or velocity, or nothing can be drawn of what came.

    The pose is read from the names of the arguments and the returned values: q11, q21 turn the proximal bars, x, y or
    q12, q22 place the distal ones, xD, yD draw the end-effector's velocity.
    """
    names = exercise.returns
    if len(sample["expected"]) != len(names) or not hasattr(robot, "l12"):
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
    return _svg(robot, drawn)


def _lines(robot, at):
    """Polylines (m) of base, bars and end-effector; () where a number is missing or not finite."""
    known = ("q11", "q21", *(("x", "y") if "x" in at else ("q12", "q22")))
    if not all(name in at and isfinite(at[name]) for name in known):
        return ()
    legs = []
    for leg, side in (("1", -1), ("2", 1)):
        base = side * robot.d / 2, 0.0
        q, l1, l2 = at[f"q{leg}1"], getattr(robot, f"l{leg}1"), getattr(robot, f"l{leg}2")
        elbow = base[0] + l1 * cos(q), l1 * sin(q)
        phi = None if "x" in at else q + at[f"q{leg}2"]
        end = (at["x"], at["y"]) if phi is None else (elbow[0] + l2 * cos(phi), elbow[1] + l2 * sin(phi))
        legs.append((base, elbow, end))
    reach = sum(getattr(robot, name) for name in ("l11", "l12", "l21", "l22", "d"))
    return tuple(legs) if all(hypot(*point) < 3 * reach for leg in legs for point in leg) else ()


def _arrows(sample, drawn=None):
    """Both velocities to one scale, from the end-effector; () where one is not finite or both vanish."""
    pairs = sample["expected"], sample["came"]
    longest = max(hypot(*pair) for pair in pairs)
    if not (isfinite(longest) and longest > 0):
        return ()
    if drawn is None:
        return pairs
    x, y = drawn[0][-1]
    return [(((x, y), (x + 0.06 * vx / longest, y + 0.06 * vy / longest)),) for vx, vy in pairs]


def _svg(robot, drawn):
    points = [point for lines in drawn for line in lines for point in line]
    low = [min(point[i] for point in points) for i in (0, 1)]
    high = [max(point[i] for point in points) for i in (0, 1)]
    scale = min((WIDTH - 2 * ROOM) / (high[0] - low[0]), (HEIGHT - 2 * ROOM) / max(high[1] - low[1], 1e-3))
    middle = [(a + b) / 2 for a, b in zip(low, high)]

    def place(point):
        return f"{WIDTH / 2 + scale * (point[0] - middle[0]):.0f},{HEIGHT / 2 - scale * (point[1] - middle[1]):.0f}"

    parts = []
    for lines, colour, style in zip(drawn, (EXPECTED, CAME), ('5"', '2" stroke-dasharray="7 5"')):
        for line in lines:
            joined = " ".join(place(point) for point in line)
            parts.append(f'<polyline points="{joined}" fill="none" stroke="{colour}" stroke-width="{style}/>')
            for x, y in (place(point).split(",") for point in line[-2:]):
                parts.append(f'<circle cx="{x}" cy="{y}" r="4" fill="#fff" stroke="{colour}" stroke-width="2"/>')
    for side in (-0.5, 0.5):
        x, y = place((side * robot.d, 0.0)).split(",")
        parts.append(f'<rect x="{int(x) - 5}" y="{int(y) - 5}" width="10" height="10" fill="#444"/>')
    label = "the robot as it should be (solid, green) and as your answer has it (dashed, red)"
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img" aria-label="{label}">'
        + "".join(parts)
        + "</svg>"
    )
