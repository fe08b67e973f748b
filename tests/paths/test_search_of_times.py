"""The search of least times in its steps: both bounds meet after little work, and motions keep their limits."""

import math
import time

import pytest

from fivebar.paths.timing.mesh import mesh_of
from fivebar.paths.timing.solve import refined
from fivebar.paths.timing.time_path import _timed
from tests.helpers.paths_to_time import used
from tests.paths.test_polygons import CASES


@pytest.mark.parametrize(
    "name, gap, looks",
    [
        ("torques", 1e-3, 850),
        ("accelerations", 1e-3, 1250),
        ("across Type 2", 1e-2, 1700),
        ("elbows", 0.03, 2900),
    ],
)
def test_both_bounds_meet_after_few_looks_at_stretches(name, gap, looks):
    """Where the last motion helps to bound the next one; else it would be many times as many."""
    robot, path, limits = CASES[name]
    mesh = mesh_of(robot, path, (-1, -1))
    mesh, found = refined(mesh, limits, gap, time.thread_time() + 3.0)
    motion = _timed(limits, mesh, found)
    assert 0 < motion.gap <= gap and found.looks <= looks
    asked = {key: getattr(limits, key) for key in ("torque", "joint_acceleration", "acceleration")}
    assert used(motion, {key: value for key, value in asked.items() if value}, 10) <= 1
    assert math.isfinite(motion.duration)
