"""The columns of a log: what they are called by people, drives, and the tools of ROS; and times of
a clock.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...base.columns import (
    COUNTS,
    METRES,
    NEWTON_METRES,
    RADIANS,
    RADIANS_PER_SECOND,
    RADIANS_PER_SECOND2,
    TIME,
    Quantity,
)
from ...models.robots import Robot

SHUFFLED, SEVERAL = (
    0.02,
    10,
)  # share and number of the rows that go back in time: more than a log restarts
NEAR = 5.0  # sampling periods, by which one row overtakes another on a network


def wanted(robot: Robot) -> dict[str, Quantity]:
    """The columns of a log, with the names they go by."""
    turns, stamp = (
        robot.turns,
        r"(?:.*[./])?stamp[._]?",
    )  # of ROS: whole seconds, and beside them nanoseconds
    found = {"t": replace(TIME, pattern=stamp + "secs?")}
    q = {**RADIANS, **COUNTS} if turns else {**METRES, **COUNTS}
    rate = RADIANS_PER_SECOND if turns else {"m/s": 1.0, "mm/s": 1e-3}
    second = RADIANS_PER_SECOND2 if turns else {"m/s2": 1.0, "mm/s2": 1e-3}
    effort = {**(NEWTON_METRES if turns else {"n": 1.0, "mn": 1e-3}), "a": 1.0, "ma": 1e-3}
    for k, side in (("1", "left"), ("2", "right")):

        def joint_state(
            kind, k=k, side=side
        ):  # as ROS's tools export them: from 0, or by the joints' names
            at = int(k) - 1
            own = f"{side}|{side}_joint|joint_?{k}|motor_?{k}|{robot.words.joints[at]}"
            return (
                rf"(?:.*[./])?{kind}(?:\[{at}\]|\.{at})|field\.{kind}{at}|.*[./](?:{own})[./]{kind}"
            )

        j = robot.words.joints[int(k) - 1]
        base = (
            j,
            f"theta{k}",
            f"theta{k}1",
            f"angle{k}",
            f"pos{k}",
            f"position{k}",
            f"joint{k}",
            f"enc{k}",
            f"encoder{k}",
            f"motor{k}",
            f"q_{side}",
            f"{side}",
        )
        found[f"q{k}"] = Quantity(base, q, pattern=joint_state("position"))
        found[f"tau{k}"] = Quantity(
            (
                f"torque{k}",
                f"tau{k}1",
                f"effort{k}",
                f"force{k}",
                f"current{k}",
                f"i{k}",
                f"tau_{side}",
                f"torque_{side}",
                f"couple{k}",
            ),
            effort,
            False,
            joint_state("effort"),
        )
        dots = (
            f"{j}_dot",
            f"dq{k}",
            f"qd{k}",
            f"vel{k}",
            f"velocity{k}",
            f"speed{k}",
            f"omega{k}",
            f"qdot{k}",
            f"vitesse{k}",
        )
        found[f"q{k}_dot"] = Quantity(dots, rate, False, joint_state("velocity"))
        twice = (f"{j}_ddot", f"ddq{k}", f"qdd{k}", f"acc{k}", f"acceleration{k}", f"qddot{k}")
        found[f"q{k}_ddot"] = Quantity(twice, second, False)
    for axis in "xy":
        found[axis] = Quantity((), METRES, False)
        found[f"{axis}_ref"] = Quantity(
            (f"{axis}_desired", f"{axis}d", f"ref_{axis}"), METRES, False
        )
    found["t_ns"] = Quantity((), {"ns": 1e-9}, False, stamp + "(?:nanosec|nsecs?)")
    return found


def since_1970(t, stated, notes):
    """Times of a clock in ms, us or ns, whose unit nobody names, in s: of these years only one can
    be meant.
    """
    first, last = np.nanmin(t, initial=np.inf), np.nanmax(t, initial=0.0)
    for unit, factor in () if stated else (("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if 5e8 < first * factor <= last * factor < 5e9:
            notes.append(f"t is read in {unit} since 1970")
            return t * factor
    return t


def order(t: np.ndarray) -> np.ndarray | None:
    """The rows (n,) in the order of their times, where they were shuffled or overtook each other;
    None where time only goes on, or begins again.

    Put in order, such times are as even as any. Those of a restart fall between or on the earlier
    ones, or go back seldom and far.
    """
    dt, rows = np.diff(t), np.argsort(t, kind="stable")
    back, ordered = dt < 0, np.diff(t[rows])
    if not back.any() or not (dt > 0).any():
        return None
    step = np.median(ordered[ordered > 0])
    if np.mean((ordered > 0) & (ordered < 0.5 * step)) > SHUFFLED:
        return None
    again = np.sum(ordered == 0) - np.sum(dt == 0)
    often = back.sum() >= SEVERAL and back.mean() > SHUFFLED and again < 0.3 * len(t)
    return rows if often or (-dt.min() < NEAR * step and not again) else None
