"""from_csv: what it says of its curves, polylines, smoothing, and files whose units are not clear."""

import io
import re

import numpy as np
import pytest

import fivebar as fb

SQUARE = "t,x,y\n0,0,0\n0.4,0.1,0\n0.8,0.1,0.1\n1.2,0,0.1\n1.6,0,0.05\n2,0,0\n"
CORNERS = np.array([(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1), (0, 0)])


def read(text, *arguments, **options):
    return fb.from_csv(io.StringIO(text), *arguments, **options)


def noisy(seed=0, noise=1e-5, rate=100.0):
    t = np.arange(200) / rate
    points = 0.05 * np.stack([np.cos(t), np.sin(t)], axis=1)
    points += np.random.default_rng(seed).normal(scale=noise, size=(200, 2))
    return (
        t,
        points,
        "t,x,y\n"
        + "\n".join(f"{a!r},{x!r},{y!r}" for a, (x, y) in zip(t.tolist(), points.tolist())),
    )


def figure(path, words):
    return float(re.search(rf"{words} ([-+.e\d]+)", " ".join(path.notes))[1])


def off_chords(path, corners):
    z = path(np.linspace(path.start, path.start + path.duration, 20001))[0] @ (1, 1j)
    c = corners @ (1, 1j)
    d = np.diff(c)
    w = np.clip(((z[:, None] - c[:-1]) * d.conj()).real / np.abs(d) ** 2, 0, 1)
    return np.abs(z[:, None] - c[:-1] - w * d).min(axis=1).max()


def test_a_spline_says_how_far_it_leaves_the_chords():
    path = read(SQUARE)
    # Of each row's own chord, so that what it says is no less than the distance from all of them.
    assert figure(path, "by up to") / 1e3 >= 0.99 * off_chords(path, CORNERS) > 0.01
    assert "(lines 2 to 3)" in path.notes[0] and "it leaves the chords" in repr(path)
    # A straight even motion has nothing but rounding to say of itself.
    straight = read("t,x,y\n" + "".join(f"{0.1 * k},{0.0205 + 0.005 * k},0.09\n" for k in range(8)))
    assert figure(straight, "by up to") == 0 == figure(straight, "its acceleration reaches")


def test_a_spline_says_what_noise_does_to_accelerations():
    t, points, text = noisy()
    path = read(text)
    own = np.linalg.norm(np.diff(points, 2, axis=0), axis=1).max() * 100**2
    seen = np.linalg.norm(path(np.linspace(0, t[-1], 40001))[2], axis=1).max()
    assert figure(path, "second differences of the samples") == pytest.approx(own, rel=0.01)
    assert (
        figure(path, "its acceleration reaches") == pytest.approx(seen, rel=0.1) and seen > 2 * own
    )


@pytest.mark.parametrize("deviation", [2e-5, 5e-5, 1e-3])
def test_smoothing_within_a_deviation(deviation):
    t, points, text = noisy()
    path = read(text, deviation=deviation)
    off = np.linalg.norm(path(t)[0] - points, axis=1).max()
    assert (
        min(0.5 * deviation, 3e-5) < off <= deviation
    )  # of 1e-5 m of noise, 4e-5 m is the largest
    rough = figure(read(text), "its acceleration reaches")
    assert figure(path, "its acceleration reaches") < rough * (0.7 if deviation == 2e-5 else 0.1)


def test_a_polyline_stays_on_its_chords():
    path = read(SQUARE, kind="polyline", deviation=1e-3)
    assert off_chords(path, CORNERS) <= 1e-3
    times = np.array([0.4, 0.8, 1.2])
    np.testing.assert_allclose(
        np.linalg.norm(path(times)[0] - CORNERS[1:4], axis=1), 1e-3, rtol=1e-12
    )
    t, h = np.linspace(0.001, 1.999, 3001), 1e-6
    for order in range(2):
        slope = (path(t + h)[order] - path(t - h)[order]) / (2 * h)
        size = np.abs(path(t)[order + 1]).max()
        np.testing.assert_allclose(slope, path(t)[order + 1], atol=1e-3 * size)
    assert figure(path, "by up to") <= 1.0
    seen = np.linalg.norm(path(np.linspace(0, 2, 200001))[2], axis=1).max()
    assert figure(path, "its acceleration reaches") == pytest.approx(seen, rel=0.01)
    two = read("t,x,y\n0,0,0\n0.5,0.1,0\n", kind="polyline", deviation=1e-3)
    np.testing.assert_allclose(two(0.25), [(0.05, 0), (0.2, 0), (0, 0)])


def test_a_polyline_too_dense_for_its_deviation_is_cut_less():
    path = read(
        "t,x,y\n" + "\n".join(f"{k / 10},{0.01 * k},{0.01 * (k % 2)}" for k in range(9)),
        kind="polyline",
        deviation=1,
    )
    t = np.linspace(0, 0.8, 4001)
    assert np.abs(np.diff(path(t)[1], axis=0)).max() < 0.01 and np.isfinite(path(t)[2]).all()


@pytest.mark.parametrize(
    "text, message",
    [
        (
            "t,x,y\n" + "\n".join(f"{10 * k},0.0{k},0" for k in range(12)),
            "its steps are 10: is t in ms",
        ),
        (
            "t,x,y\n" + "\n".join(f"{k},0.0{k % 10},0" for k in range(12)),
            "its steps are 1: is t in ms",
        ),
        (
            "t,x,y\n" + "\n".join(f"{k / 10},{k},0" for k in range(12)),
            "could be in metres or in millimetres",
        ),
        (
            "t,x_mm,y\n" + "\n".join(f"{k / 10},{k},0" for k in range(12)),
            "x has a unit in its heading, but y has none",
        ),
        ("t,x (mm),y [mm]\n0,1,2\n1,3\n", "line 3: 2 cells"),
        ("t,x (furlong),y\n0,1,2\n", "line 1: column 'x .furlong.': 'furlong' is none of"),
    ],
)
def test_units_that_are_not_clear_are_refused(text, message):
    with pytest.raises(ValueError, match=message):
        read(text)


def test_files_as_people_have_them():
    rows = "\n".join(f"{10 * k};{k},5;{k}" for k in range(12))
    for path in (
        read("Time (ms);X [mm];Y [mm]\n" + rows),
        read("t;x;y\n" + rows, units={"t": "ms", "x": "mm", "y": "mm"}),
    ):
        assert path.duration == pytest.approx(0.11)
        np.testing.assert_allclose(path(0.11)[0], (0.0115, 0.011), atol=1e-12)
    assert "Time (ms): read in ms" in read("Time (ms);X [mm];Y [mm]\n" + rows).notes
    stated = read("t_s,x,y\n" + "\n".join(f"{2 * k},0.0{k},0" for k in range(8)))
    assert stated.duration == 14.0


def test_one_unit_is_a_word():
    text = "t,x,y\n" + "\n".join(f"{k / 10},{k},0" for k in range(8))
    np.testing.assert_allclose(read(text, units="mm")(0.7)[0], (0.007, 0), atol=1e-12)
    for units in (5, [5], {"x": 5}, b"mm"):
        with pytest.raises(TypeError, match="units must be words"):
            read(text, units=units)


@pytest.mark.parametrize("kind", ["spline", "polyline"])
@pytest.mark.parametrize("rows, step", [(2, 1e-320), (8, 1e-100)])
def test_times_too_close_for_any_motion_are_refused(rows, step, kind):
    """A speed beyond all numbers, or an acceleration whose square is."""
    text = "t,x,y\n" + "".join(f"{k * step},{0.01 * k * k},{0.02 * k}\n" for k in range(rows))
    options = {"kind": kind, "deviation": 1e-3} if kind == "polyline" else {}
    words = "at least 6 rows" if kind == "spline" and rows == 2 else "beyond all bounds"
    with pytest.raises(ValueError, match=words):
        read(text, **options)


def test_choices_that_exclude_one_another():
    for options, message in (
        (dict(kind="polyline"), "kind=polyline needs a deviation"),
        (dict(smoothing=1e-4, deviation=1e-4), "leave one of them"),
        (dict(kind="cubic"), "kind must be one of spline, polyline"),
        (dict(deviation=-1.0), "deviation must be finite and > 0"),
    ):
        with pytest.raises(ValueError, match=message):
            read(SQUARE, **options)
