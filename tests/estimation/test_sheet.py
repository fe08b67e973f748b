"""Calibration by a test drawing and a ruler: robots of known truth draw it."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.estimation.calibration.sheet import sheet

NOMINAL = fb.FiveBar(l11=0.1, l12=0.14, l21=0.1, l22=0.14, d=0.1)
MACHINE = fb.Machine(NOMINAL, offset=(0.1, 0.0), frame=fb.Placement((0.2, 0.05), 0.3))
NAMES = "l11", "l12", "l21", "l22", "d"


def drawn_by(built, offsets, drawn):
    """Where a built robot puts the crosses, m, in its own frame."""
    xi = drawn.machine.frame.inverse(drawn.crosses)
    pose = fb.igm(drawn.machine.robot, xi, drawn.working)
    return fb.dgm(built, pose.q + offsets, pose.assembly).xi


def ruled(drawn, points, table, noise, rng):
    """The table with its distances filled in to 0.1 mm."""
    drawn.distances_to_csv(table)
    head, *rows = table.read_text("utf-8").splitlines()
    for k, (one, other) in enumerate(drawn.pairs):
        distance = np.linalg.norm(points[one] - points[other]) + noise * rng.standard_normal()
        rows[k] += f"{1e3 * distance:.1f}"
    table.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(2))
def test_a_ruler_finds_the_robot(seed, tmp_path):
    rng = np.random.default_rng(seed)
    built = fb.FiveBar(*(np.array([0.1, 0.14, 0.1, 0.14, 0.1]) + rng.normal(0, 8e-4, 5)))
    offsets = rng.normal(0, 0.02, 2)
    drawn = sheet(MACHINE, "A5")
    before = drawn_by(built, offsets, drawn)
    ruled(drawn, before, tmp_path / "a.csv", 2e-4, rng)
    machine_offset = dict(offset1=0.1, offset2=0.0)
    found = fb.calibrate(NOMINAL, tmp_path / "a.csv", sigma=2e-4, start=machine_offset)
    assert found.fits and not found.indistinguishable
    for name in NAMES:
        assert abs(found.values[name] - getattr(built, name)) < 4.5 * found.sd[name]
    # Draw again, by the calibrated robot.
    xi = MACHINE.frame.inverse(drawn.crosses)
    told = fb.igm(found.robot, xi, drawn.working).q
    told = told - [found.values["offset1"] - 0.1, found.values["offset2"]]
    after = fb.dgm(built, told + offsets, -1).xi

    def off(points):
        gaps = np.linalg.norm(points[:, None] - points, axis=-1)
        return np.abs(gaps - np.linalg.norm(xi[:, None] - xi, axis=-1)).max()

    assert off(after) < 4e-4 < off(before)


@pytest.mark.deep
def test_the_sheet_keeps_to_its_paper_and_workspace():
    for paper, size in (("A5", (0.21, 0.148)), ("A4", (0.297, 0.21))):
        drawn = sheet(NOMINAL, paper)
        points = drawn.path(np.linspace(0, drawn.path.length, 2000))[0]
        assert (np.ptp(points, axis=0) <= np.array(size) - 0.02).all()
        path = fb.check_path(NOMINAL, drawn.path.at_unit_speed, drawn.working)
        assert path.singularity_free
        assert set(drawn.pairs[:, 0].tolist()) == set(range(12))


@pytest.mark.deep
def test_the_commands_go_once_around(tmp_path, capsys):
    MACHINE.save(tmp_path / "robot.toml")
    robot = ["--robot", str(tmp_path / "robot.toml")]
    assert main(["calibrate", "--from-drawing", "A5", *robot, "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    line = next(line for line in printed.splitlines() if line.startswith("draw it:"))
    words = line.split("fivebar ")[1].split()
    fast = ["--format", "gcode", "--speed-error", "0.3", "--line-deviation", "1e-4"]
    assert main([*words, *fast, "--out", str(tmp_path / "drawn"), "--json"]) == 0
    capsys.readouterr()
    drawn = sheet(MACHINE, "A5")
    rng = np.random.default_rng(0)
    built = fb.FiveBar(0.101, 0.1393, 0.0995, 0.1408, 0.1006)
    points = drawn_by(built, (0.01, -0.01), drawn)
    ruled(drawn, points, tmp_path / "out/distances.csv", 1e-4, rng)
    table = str(tmp_path / "out/distances.csv")
    assert main(["calibrate", table, *robot, "--sigma", "1e-4", "--out", str(tmp_path / "c")]) == 0
    found = fb.load_machine(tmp_path / "c/robot.toml")
    assert abs(found.robot.l11 - 0.101) < 4e-4


def test_bad_sheets_are_refused(tmp_path, capsys):
    with pytest.raises(ValueError, match="paper must be one of"):
        sheet(NOMINAL, "A3")
    with pytest.raises(ValueError, match="the machine is a biglide"):
        sheet(fb.Machine(fb.Biglide()))
    with pytest.raises(TypeError, match="must be a Machine"):
        sheet("A5")
    assert main(["calibrate"]) == 2
    assert "needs a file of measured data" in capsys.readouterr().err
