"""Five-bars that people built and published, with the numbers they give."""

import json
import math
import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main

HEATHMANC = fb.FiveBar(0.2, 0.23, 0.2, 0.23, 0.08)  # 200, 230, 80 mm between the motors


def test_heathmanc_at_250_mm_above_its_motors():
    pose = fb.igm(HEATHMANC, (0.0, 0.25), working=(1, -1))
    np.testing.assert_allclose(np.degrees(pose.q), (140.5406, 39.4594), atol=5e-5)


def test_heathmanc_within_its_guards():
    """20 degrees between the distal bars and 15 degrees at the elbows are its guards."""
    limits = math.sin(math.radians(20)), math.sin(math.radians(15))
    areas = {r.working: r.area for r in fb.dexterous(HEATHMANC, *limits) if r.assembly == -1}
    assert areas[1, -1] == pytest.approx(0.47380, abs=5e-6)


def test_motkin_with_angles_from_north():
    """Clockwise from y, as a compass has them: readings of a machine."""
    robot = fb.ROBOTS["motkin"].robot
    machine = fb.Machine(robot, offset=(math.pi / 2, math.pi / 2), ratio=(-1.0, -1.0))
    rng = np.random.default_rng(6)
    for x, y in rng.uniform((-0.03, 0.07), (0.03, 0.12), (20, 2)):
        north = machine.readings(fb.igm(robot, (x, y), (1, -1)).q)
        for heading, base, side in zip(north, (-0.05, 0.05), (-1, 1)):
            way = math.hypot(x - base, y)
            corner = math.acos((0.06**2 + way**2 - 0.1**2) / (2 * 0.06 * way))
            assert heading == pytest.approx(math.atan2(x - base, y) + side * corner)


@pytest.mark.deep
def test_a_chess_board_does_not_fit(tmp_path, capsys):
    """aamna-builds' robot: bars of 220 mm, motors 360 mm apart, a board of 320 x 320 mm."""
    robot = ["--l11", "0.22", "--l12", "0.22", "--l21", "0.22", "--l22", "0.22", "--d", "0.36"]
    options = ["--fits", "0.32", "0.32", "--nodes", "21", "--out", str(tmp_path / "map.png")]
    assert main(["map", *robot, *options]) == 0
    said = capsys.readouterr().out
    words = r"320 x 320 mm does not fit: the largest of its shape is ([\d.]+) x ([\d.]+) mm"
    width, height = map(float, re.search(words, said).groups())
    assert width == height and 230.7 < width < 320
    # Its own shape fits, and where it is said to be.
    options[1:3] = ["0.3449", "0.2307"]
    assert main(["map", *robot, *options, "--json"]) == 0
    board = json.loads(capsys.readouterr().out)["board"]
    assert board["fits"]
    corner, sides = np.array(board["corner_m"]), np.array(board["rectangle_m"])
    u = np.stack(np.meshgrid(np.linspace(0.001, 0.999, 30), np.linspace(0.001, 0.999, 30)), -1)
    built = fb.FiveBar(0.22, 0.22, 0.22, 0.22, 0.36)
    assert board["in"] == "aspect"
    part = fb.aspect(built, board["number"])
    assert part.contains((corner + u * sides).reshape(-1, 2)).all()
