"""Set-points in the units of drives: counts, turns, binary, and numbers that do not fit."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar.paths.setpoints import setpoints

ROBOT = fb.FiveBar()
MOTION = fb.line((0.05, 0.09), (-0.03, 0.1), 1.0)


@pytest.fixture(scope="module")
def table():
    return setpoints(ROBOT, MOTION, 200.0)


def test_counts_lead_back_to_the_angles(table, tmp_path):
    machine = fb.Machine(ROBOT, offset=(0.2, -0.3), ratio=(-1.0, 0.1))
    counts = table.for_drives(8192, machine, zero=(100, -5000))
    assert counts.dtype == np.int32
    back = machine.angles((counts - np.array([100, -5000])) / 8192 * 2 * np.pi)
    np.testing.assert_allclose(back, table.q, atol=np.pi / 8192 * 1.0001)
    table.to_drives(tmp_path / "a.bin", 8192, machine, (100, -5000))
    read = np.fromfile(tmp_path / "a.bin", "<i4").reshape(-1, 2)
    np.testing.assert_array_equal(read, counts)
    table.to_drives(tmp_path / "a.csv", 8192, machine, (100, -5000))
    rows = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=2)
    np.testing.assert_array_equal(rows[:, 1:], counts)
    np.testing.assert_allclose(rows[:, 0], table.t)


@pytest.mark.parametrize("drive", ["odrive", "moteus"])
def test_turns(table, drive, tmp_path):
    turns = table.for_drives(drive)
    np.testing.assert_allclose(turns * 2 * np.pi, table.q, atol=1e-6)
    table.to_drives(tmp_path / "a.bin", drive)
    np.testing.assert_array_equal(np.fromfile(tmp_path / "a.bin", "<f4").reshape(-1, 2), turns)


def test_dynamixels(table):
    goal = table.for_drives("dynamixel")
    np.testing.assert_allclose((goal - 2048) / 4096 * 2 * np.pi, table.q, atol=1e-3)
    with pytest.raises(ValueError, match=r"motor 1 is to go to \d+ at t = .* beyond 0 to 4095"):
        table.for_drives("dynamixel", zero=(4000, 2048))
    wrapped = table.for_drives("dynamixel", zero=(4096 + 2048, 2048), wrap=True)
    np.testing.assert_array_equal(wrapped, goal)
    middle = 4096 - (goal[0, 0] + goal[-1, 0]) // 2 + 2048
    with pytest.raises(ValueError, match="turn back by a whole turn"):
        table.for_drives("dynamixel", zero=(middle, 2048), wrap=True)
    with pytest.raises(ValueError, match="-2147483648 to 2147483647: .* or wrap=True .--wrap"):
        table.for_drives(2**32, zero=(0, 2**31 - 1))
    with pytest.raises(ValueError, match="must be one of"):
        table.for_drives("servo")
    degrees = fb.Machine(ROBOT, ratio=(np.pi / 180, np.pi / 180))
    with pytest.raises(ValueError, match="could be theirs or the motor"):
        table.for_drives("odrive", degrees)


@pytest.mark.parametrize("drive", ["dynamixel-extended", 8192])
def test_a_drive_of_many_turns_is_not_wrapped(table, drive):
    for zero in ((0, 0), (3000, -9000)):
        plain = table.for_drives(drive, zero=zero)
        np.testing.assert_array_equal(table.for_drives(drive, zero=zero, wrap=True), plain)
    with pytest.raises(
        ValueError, match="beyond -[0-9]+ to [0-9]+: give another zero .--zero-counts.$"
    ):
        table.for_drives(drive, zero=(2**31, 0), wrap=True)


def test_a_turn_that_has_all_of_32_bits_is_wrapped_into_them(table):
    zero = 2**31 + 2**30
    wrapped = table.for_drives(2**32, zero=(zero, zero), wrap=True)
    assert wrapped.min() >= -(2**31)
    turns = (wrapped.astype(float) - zero) / 2**32 - table.q / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


def test_a_file_for_drives_names_its_columns(table, tmp_path):
    """And has whole numbers and the pen, where there is one."""
    with_pen = replace(table, pen=np.arange(len(table.t)) % 3 > 0)
    for motion, names in ((table, "t,q1,q2"), (with_pen, "t,q1,q2,pen")):
        motion.to_drives(tmp_path / "a.csv", "dynamixel")
        head, columns, *lines = (tmp_path / "a.csv").read_text("utf-8").splitlines()
        assert columns == names and '"drive": "dynamixel"' in head and '"robot"' in head
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
        np.testing.assert_array_equal(rows[:, 1:3], motion.for_drives("dynamixel"))
        np.testing.assert_array_equal(rows[:, 0], motion.t)
        if motion.pen is not None:
            np.testing.assert_array_equal(rows[:, 3], motion.pen)


def test_a_motion_that_is_free_of_modes_keeps_its_own():
    """A plan may change them on the way: then its own poses count."""

    class Free:
        duration, start, working = MOTION.duration, MOTION.start, None

        def __call__(self, t):
            return MOTION(t)

        def joints(self, t):
            raise AssertionError("`accelerations` has all")

        def accelerations(self, t):
            xi, xi_dot, xi_ddot = MOTION(t)
            return fb.ikm2(fb.ikm(fb.igm(ROBOT, xi, (1, -1)), xi_dot), xi_ddot)

    free, given = setpoints(ROBOT, Free(), 20.0), setpoints(ROBOT, MOTION, 20.0, (1, -1))
    assert free.working is None and given.working == (1, -1)
    np.testing.assert_allclose(free.q, given.q, rtol=1e-14)
    np.testing.assert_array_equal(free.q_dot, given.q_dot)
    asked = setpoints(ROBOT, Free(), 20.0, (-1, -1))
    np.testing.assert_allclose(asked.q, setpoints(ROBOT, MOTION, 20.0).q, rtol=1e-14)


def test_a_motion_that_names_no_start_begins_at_0():
    def motion(t):
        return MOTION(t)

    motion.duration = MOTION.duration
    one, other = setpoints(ROBOT, motion, 20.0), setpoints(ROBOT, MOTION, 20.0)
    np.testing.assert_allclose(one.xi, other.xi, rtol=1e-14)
    assert one.working == (-1, -1) and one.pen is None
