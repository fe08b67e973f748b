"""A robot with two drives in the words of Machine."""

import numpy as np

from ...models.dyads import Crank


def drawn(robot, elbows, xi, frame=None):
    """Points (m, k, 2) of a robot and the words of Machine for them: a crank is a bar on a motor, a slider a driven
    block on a rail; frame: points (m, k, 2) of the robot whose rails are taken, for a ghost."""
    points = [xi]
    words = dict(bars=[], grounded=[], actuated=[], rails=[], blocks=[])
    for k, drive in enumerate(robot.drives):
        first = len(points)
        if isinstance(drive, Crank):
            points += [np.broadcast_to((drive.x, drive.y), xi.shape), elbows[:, k]]
            words["bars"] += [(first, first + 1), (first + 1, 0)]
            words["grounded"].append(first)
            words["actuated"].append(first)
        else:
            axis, length = np.array(drive.tangent(0.0)), robot.distal[k]
            along = elbows[:, k] @ axis
            foot = elbows[0, k] - along[0] * axis
            ends = [
                foot + (value + side * 0.25 * length) * axis for value, side in ((along.min(), -1), (along.max(), 1))
            ]
            rail = [np.broadcast_to(end, xi.shape) for end in ends] if frame is None else [
                frame[:, first + 1], frame[:, first + 2]]  # fmt: skip
            half = 0.07 * length * axis
            points += [elbows[:, k], *rail, elbows[:, k] - half, elbows[:, k] + half]
            words["bars"].append((first, 0))
            words["grounded"] += [first + 1, first + 2]
            words["rails"].append((first + 1, first + 2))
            words["blocks"].append((first + 3, first + 4, True))
    return np.stack(points, axis=1), {name: tuple(value) for name, value in words.items()} | {"traced": 0}
