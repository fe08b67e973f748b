"""Calibration by a photograph of the test drawing: synthetic, with the truth known."""

import numpy as np
import pytest
from matplotlib.image import imsave

import fivebar as fb
from fivebar.cli import main
from fivebar.estimation.calibration import photo
from fivebar.estimation.calibration.photo import crosses_in
from fivebar.estimation.calibration.sheet import PAPERS, sheet
from tests.helpers.photographs import photograph

NOMINAL = fb.FiveBar(l11=0.1, l12=0.14, l21=0.1, l22=0.14, d=0.1)
BUILT = fb.FiveBar(0.101, 0.1393, 0.0995, 0.1408, 0.1006)
OFFSETS = np.array([0.01, -0.008])
NAMES = "l11", "l12", "l21", "l22", "d"


@pytest.fixture(scope="module")
def drawn():
    return sheet(NOMINAL, "A5", (-1, -1))


def made(drawn, points, cut=(1.0, 1.0)):
    """Where the built robot's pen is, on a sheet that lies a little turned, m of the sheet."""
    pose = fb.igm(NOMINAL, points, drawn.working)
    reached = fb.dgm(BUILT, pose.q + OFFSETS, pose.assembly).xi
    c, s = np.cos(0.03), np.sin(0.03)
    middle = np.mean(drawn.crosses, axis=0)
    return (reached - middle) @ np.array([[c, s], [-s, c]]) + np.array(PAPERS["A5"]) * cut / 2


def strokes(drawn, cut=(1.0, 1.0)):
    pieces = [piece for piece, down in zip(drawn.path.pieces, drawn.path.pen) if down]
    return [made(drawn, np.array([piece.start, piece.end]), cut) for piece in pieces]


def gaps(points):
    return np.linalg.norm(points[:, None] - points, axis=-1)


@pytest.mark.deep
@pytest.mark.parametrize("turn, tilt, blur", [(0.05, 0.1, 1.0), (3.2, 0.0, 2.0), (-0.15, 0.2, 0.7)])
def test_crosses_are_found_to_a_part_of_a_pixel(turn, tilt, blur, drawn):
    rng = np.random.default_rng(3)
    image = photograph(strokes(drawn), "A5", rng, turn=turn, tilt=tilt, blur=blur)
    found = crosses_in(image, drawn)
    np.testing.assert_allclose(gaps(found), gaps(made(drawn, drawn.crosses)), atol=8e-5)
    np.testing.assert_allclose(found, made(drawn, drawn.crosses), atol=1.5e-4)  # upright


@pytest.mark.deep
@pytest.mark.parametrize("lens", [(-0.06, 0.0), (0.04, 0.0), (-0.05, 0.02), (-0.02, -0.01)])
def test_a_lens_that_bends_lines_is_found_by_the_edges(lens, drawn):
    """Bows of up to 20 pixels, by another model than that which is fitted."""
    rng = np.random.default_rng(6)
    image = photograph(strokes(drawn), "A5", rng, lens=lens, zoom=4500.0)
    found = crosses_in(image, drawn)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(gaps(found), gaps(made(drawn, drawn.crosses)), atol=1.2e-4)


@pytest.mark.every(2)
@pytest.mark.parametrize("turn, channels, tilt", [(0.05, 4, 0.1), (1.6, 0, 0.1), (0.2, 0, 0.8)])
def test_crosses_are_found_in_a_small_photograph(turn, channels, tilt, drawn, monkeypatch):
    """Of a sheet that lies or stands, in colours or in grey, put straight in coarse pixels. By the
    last one's tilt, two edges at a corner have the same length.
    """
    monkeypatch.setattr(photo, "PIXEL", 3e-4)
    cut = 1.004, 0.995
    image = photograph(
        strokes(drawn, cut),
        "A5",
        np.random.default_rng(3),
        turn=turn,
        tilt=tilt,
        blur=0.7,
        shape=(720, 900),
        zoom=2400.0,
        cut=cut,
    )
    if channels:
        colours = np.array([1.2, 0.9, 0.9, 77.0])
        image = image[..., None] * colours
    found = crosses_in(image, drawn, size=np.array(PAPERS["A5"]) * cut)
    np.testing.assert_allclose(gaps(found), gaps(made(drawn, drawn.crosses, cut)), atol=2.5e-4)
    np.testing.assert_allclose(found, made(drawn, drawn.crosses, cut), atol=4e-4)  # upright


@pytest.mark.deep
def test_a_ruler_gives_the_scale(drawn):
    cut = 1.004, 0.995  # as sheets are cut
    image = photograph(strokes(drawn, cut), "A5", np.random.default_rng(7), cut=cut)
    truth = gaps(made(drawn, drawn.crosses))
    assert np.abs(gaps(crosses_in(image, drawn)) - truth).max() > 4e-4
    found = crosses_in(image, drawn, "A5", np.array(PAPERS["A5"]) * cut)
    np.testing.assert_allclose(gaps(found), truth, atol=8e-5)
    with pytest.raises(ValueError, match="148 x 210 mm is no sheet of A5"):
        crosses_in(image, drawn, "A5", (0.148, 0.21))
    with pytest.raises(ValueError, match="paper must be one of"):
        crosses_in(image, drawn, "A6")


@pytest.mark.deep
def test_a_photograph_gives_the_robot(drawn, tmp_path, capsys):
    """Once around: draw, photograph, calibrate, draw again."""
    image = photograph(strokes(drawn), "A5", np.random.default_rng(4))
    imsave(tmp_path / "photo.png", np.clip(image, 0, 1), cmap="gray", vmin=0, vmax=1)
    NOMINAL.save(tmp_path / "robot.toml")
    options = ["--photo", str(tmp_path / "photo.png"), "--from-drawing", "A5"]
    options += ["--working", "-1", "-1", "--sides", "210", "148"]
    out = [
        "--robot",
        str(tmp_path / "robot.toml"),
        "--sigma",
        "3e-5",
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(["calibrate", *options, *out]) == 0
    machine = fb.load_machine(tmp_path / "out/robot.toml")
    for name in NAMES:
        assert abs(getattr(machine.robot, name) - getattr(BUILT, name)) < 3e-4
    wanted = gaps(drawn.crosses)
    before = gaps(made(drawn, drawn.crosses))
    pose = fb.igm(machine.robot, drawn.crosses, drawn.working)
    again = fb.dgm(BUILT, machine.readings(pose.q) + OFFSETS, pose.assembly).xi
    assert np.abs(gaps(again) - wanted).max() < 1.5e-4 < 1e-3 < np.abs(before - wanted).max()


def test_sides_need_a_photograph(capsys):
    assert main(["calibrate", "--from-drawing", "A5", "--sides", "210", "148"]) == 2
    assert "give --photo PICTURE" in capsys.readouterr().err


@pytest.mark.deep
def test_sheets_that_cannot_be_read_are_refused(drawn):
    rng = np.random.default_rng(5)
    with pytest.raises(ValueError, match="no sheet"):
        crosses_in(0.5 + 0.01 * rng.standard_normal((300, 400)), drawn)
    with pytest.raises(ValueError, match="cut off"):
        crosses_in(photograph(strokes(drawn), "A5", rng, zoom=6600.0), drawn)
    with pytest.raises(ValueError, match="0 crosses and 0 marks"):
        crosses_in(photograph([], "A5", rng), drawn)
    with pytest.raises(ValueError, match=r"must be \(rows, columns\)"):
        crosses_in(np.zeros(5), drawn)
