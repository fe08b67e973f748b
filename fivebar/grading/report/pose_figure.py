"""The robot in the expected and in the returned pose, as a small drawing."""

from __future__ import annotations

from math import cos, hypot, isfinite, sin

import numpy as np

from ...models.robots import Robot
from ..exercise import Exercise
from ..intake.students_robots import lengths
from ..robots import has_models

SIZE = np.array([300, 190])  # px, of the drawing
MARGIN = 14  # px
STYLES = (
    'fill="none" stroke="#1a7f37" stroke-width="5"',  # as it should be
    'fill="none" stroke="#c4320a" stroke-width="2" stroke-dasharray="7 5"',
)


def pose_figure(robot: Robot, exercise: Exercise, sample: dict) -> str:
    """Return SVG text, or "" where the returned values are no pose or cannot be drawn.

    The pose is read from the names of the arguments and the returned values: q11, q21 turn the
    proximal bars (slide the feet), x, y or q12, q22 place the distal ones.
    """
    names = exercise.returns
    is_pose = has_models(robot) and not {"x", "q11", "q12"}.isdisjoint(names)
    if not is_pose or len(sample["expected"]) != len(names):
        return ""
    poses = []
    for numbers in (sample["expected"], sample["came"]):
        values = sample["inputs"] | dict(zip(names, numbers))
        poses.append(_legs(robot, values))
    if not poses[1]:
        return ""
    return _svg(poses)


def _legs(robot, values):
    """Return a polyline (m) for each leg, [] where a number is missing, not finite or too large."""
    needed = ["q11", "q21"]
    needed += ["x", "y"] if "x" in values else ["q12", "q22"]
    for name in needed:
        if name not in values or not isfinite(values[name]):
            return []
    largest = 3 * sum(lengths(robot).values())
    legs = []
    for leg, drive, bar in zip("12", robot.drives, robot.distal):
        q = values[f"q{leg}1"]
        elbow = drive.pivot(drive.direction(q))
        if "x" in values:
            end = values["x"], values["y"]
        else:
            phi = drive.absolute(values[f"q{leg}2"], q)
            along_x = bar * cos(phi)
            along_y = bar * sin(phi)
            end = elbow[0] + along_x, elbow[1] + along_y
        points = [elbow, end]
        if robot.turns:
            base = (drive.x, drive.y)
            points = [base, *points]
        if not all(hypot(*point) < largest for point in points):
            return []
        legs.append(points)
    return legs


def _svg(poses):
    points = np.concatenate([leg for legs in poses for leg in legs])
    low = points.min(axis=0)
    high = points.max(axis=0)
    middle = (low + high) / 2
    extent = np.maximum(high - low, 1e-3)
    scale = min((SIZE - 2 * MARGIN) / extent)
    upwards = (1, -1)  # y of a drawing grows downwards
    parts = []
    for legs, style in zip(poses, STYLES):
        for leg in legs:
            pixels = SIZE / 2 + scale * (leg - middle) * upwards
            joined = " ".join(f"{x:.0f},{y:.0f}" for x, y in pixels)
            parts.append(f'<polyline points="{joined}" {style}/>')
            for x, y in pixels:
                parts.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="4" {style}/>')
    width, height = SIZE
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img"'
        ' aria-label="the robot as it should be (solid, green) and as your answer has it (dashed,'
        f' red)">{"".join(parts)}</svg>'
    )
