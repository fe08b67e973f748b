"""The robot in the expected and in the returned pose, as a small drawing."""

from __future__ import annotations

from math import cos, hypot, isfinite, sin

import numpy as np

from ...models.robots import Robot
from ..exercise import Exercise
from ..variants import lengths

SIZE, MARGIN = np.array([300, 190]), 14  # px, of the drawing
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
    if len(sample["expected"]) != len(names) or not set(names) & {"x", "q11", "q12"}:
        return ""
    poses = []
    for numbers in (sample["expected"], sample["came"]):
        poses.append(_legs(robot, sample["inputs"] | dict(zip(names, numbers))))
    return _svg(poses) if poses[1] else ""


def _legs(robot, values):
    """Return a polyline (m) for each leg, [] where a number is missing, not finite or too large."""
    known = ("q11", "q21", *(("x", "y") if "x" in values else ("q12", "q22")))
    if not all(name in values and isfinite(values[name]) for name in known):
        return []
    legs = []
    for leg, drive, bar in zip("12", robot.drives, robot.distal):
        q = values[f"q{leg}1"]
        elbow = drive.pivot(drive.direction(q))
        if "x" in values:
            end = values["x"], values["y"]
        else:
            phi = drive.absolute(values[f"q{leg}2"], q)
            end = elbow[0] + bar * cos(phi), elbow[1] + bar * sin(phi)
        legs.append(((drive.x, drive.y), elbow, end) if robot.turns else (elbow, end))
    reach = 3 * sum(lengths(robot).values())
    return legs if all(hypot(*point) < reach for leg in legs for point in leg) else []


def _svg(poses):
    points = np.concatenate([leg for legs in poses for leg in legs])
    low, high = points.min(axis=0), points.max(axis=0)
    scale = min((SIZE - 2 * MARGIN) / np.maximum(high - low, 1e-3))
    parts = []
    for legs, style in zip(poses, STYLES):
        for leg in legs:
            pixels = SIZE / 2 + scale * (leg - (low + high) / 2) * (1, -1)
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
