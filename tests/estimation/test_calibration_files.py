"""A calibration as a value: its file, its pictures, and the calls that are refused."""

import json
from itertools import product

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import LENGTHS
from tests.helpers.twins import HOME, LAB, measured, poses, robot_of, seen, twin

from .test_calibrate import GEOMETRY


def test_a_file_of_a_calibration_comes_back(tmp_path):
    rng = np.random.default_rng(19)
    data = measured(twin(rng, LAB, GEOMETRY), 12, rng, 1e-4)
    data["y"][3] = np.nan
    data |= dict(distance=np.full(12, np.nan), to=np.full(12, np.nan))
    found = fb.calibrate(LAB, data, (*GEOMETRY, "scale"), sigma=1e-4)
    found.to_json(tmp_path / "c.json")
    again = fb.Calibration.from_json(tmp_path / "c.json")
    assert (
        str(again) == str(found)
        and again.sd == found.sd
        and np.array_equal(again.covariance, found.covariance)
    )
    text = (tmp_path / "c.json").read_text("utf-8")
    bad = [json.loads(text) for _ in range(4)]
    for (name, place), each in zip(product(("p", "start"), (3, 12)), bad):  # fuzzing found it
        each[name][place] = 1e-320
    for content in ({"fivebar": "x"}, *bad):
        (tmp_path / "bad.json").write_text(json.dumps(content), encoding="utf-8")
        with pytest.raises(ValueError, match="bad.json: not a file of kind 'calibration"):
            fb.Calibration.from_json(tmp_path / "bad.json")
    found.machine.save(tmp_path / "robot.toml")
    assert fb.load_machine(tmp_path / "robot.toml") == found.machine


@pytest.mark.deep
def test_pictures_of_points_of_halves_and_of_distances(tmp_path):
    rng = np.random.default_rng(20)
    true = twin(rng, LAB, GEOMETRY)
    data = measured(true, 12, rng, 1e-4)
    data["x"][5] += 5e-3
    found = fb.calibrate(LAB, data, (*GEOMETRY, "scale"))
    figure = found.plot(tmp_path / "c.png")
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert (tmp_path / "c.png").stat().st_size > 20_000 and texts == ["row 6"]
    del data["y"]
    assert len(fb.calibrate(LAB, data, LENGTHS).plot().axes) == 3
    q, points, assembly, _ = seen(true, poses(true, 12, rng, HOME))
    far = dict(
        distance=np.hypot(*(points - np.roll(points, -1, axis=0)).T),
        to=(np.arange(12) + 1) % 12 + 1,
    )
    assert (
        len(
            fb.calibrate(LAB, dict(q1=q[:, 0], q2=q[:, 1], assembly=assembly) | far, LENGTHS)
            .plot()
            .axes
        )
        == 3
    )
    assert robot_of(true).d == true["d"]


BAD = dict(q1=[0.1, 0.2], q2=[0.1, 0.2], x=[0.09, 0.09], y=[0.07, 0.07])


@pytest.mark.parametrize(
    "data, options, words",
    [
        (BAD | dict(z=[1, 2]), {}, "data has no column 'z'"),
        (dict(q1=[1.0], x=[1.0], y=[1.0]), {}, "data has no column q2"),
        (BAD | dict(x=[1.0]), {}, "differ in length"),
        (BAD | dict(working1=[2, 1]), {}, "row 1: working1 must be \\+1 or -1"),
        (
            BAD | dict(distance=[0.1, np.nan], to=[3, np.nan]),
            {},
            "row 1: .* to = 3 must be a length",
        ),
        (BAD | dict(distance=[0.1, np.nan]), {}, "row 1: distance = 0.1 and to = nan must be"),
        (dict(q1=[0.1], q2=[0.2]), {}, "nothing is measured in data"),
        (BAD, dict(unknown=("l13",)), "unknown: no 'l13'; the known ones are l11"),
        (BAD, dict(unknown=("l11", "l11")), "unknown names l11 twice"),
        (BAD, dict(unknown=()), "unknown is empty"),
        (BAD, dict(start={"l1": 1}), "start: no 'l1'"),
        (BAD, dict(loss="l2"), "loss must be one of linear"),
        (BAD, dict(sigma=-1.0), "sigma must be finite and > 0"),
    ],
)
def test_wrong_calls_are_refused_by_name(data, options, words):
    with pytest.raises(ValueError, match=words):
        fb.calibrate(LAB, data, **options)
    with pytest.raises(ValueError, match="calibrate refuses a robot with kind = .biglide."):
        fb.calibrate(fb.Biglide(), data)
