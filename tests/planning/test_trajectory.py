"""Reference motions against the lab's numbers, against their own slopes, and bad files against their messages."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fivebar as fb

REST = {1: (0, 0), 2: (0, 0)}


def check_slopes(path, times):
    h = 1e-5
    xi, xi_dot, xi_ddot = path(times)
    for k, (function, slope) in enumerate(((0, xi_dot), (1, xi_ddot))):
        numeric = (path(times + h)[function] - path(times - h)[function]) / (2 * h)
        assert np.abs(numeric - slope).max() <= 1e-6 * (1 + np.abs(slope).max()), k


@pytest.mark.parametrize(
    "path", [fb.line((0.09, 0.068), (0, 0.1), 2.0), fb.circle((0, 0.1), 0.02, 1.5)]
)
def test_velocity_and_acceleration_are_slopes(path):
    check_slopes(path, np.linspace(0.01, path.duration - 0.01, 200))


def test_line_is_the_quintic():
    s = np.linspace(0, 1, 11)
    xi, _, _ = fb.line((0.09, 0.06796322), (0, 0.1), 2.0)(2 * s)
    blend = 10 * s**3 - 15 * s**4 + 6 * s**5
    np.testing.assert_allclose(
        xi, np.outer(1 - blend, (0.09, 0.06796322)) + np.outer(blend, (0, 0.1)), atol=1e-16
    )


def test_first_and_last_point_are_held():
    path = fb.circle((0, 0.1), 0.02, 1.5)
    for t in (-1.0, 2.0, np.array([-3.0, 9.0])):
        xi, xi_dot, xi_ddot = path(t)
        np.testing.assert_allclose(xi, np.broadcast_to((0.02, 0.1), xi.shape), atol=1e-16)
        assert not xi_dot.any() and not xi_ddot.any()
    xi, xi_dot, xi_ddot = path(0.3)
    assert xi.shape == xi_dot.shape == xi_ddot.shape == (2,)


def test_polynomial_of_the_compliant_crossing(five_bar_numbers):
    case = five_bar_numbers["compliant_crossing"]
    p0, ps, pf, vs, at = (np.array(case[key], float) for key in ("p0", "ps", "pf", "vs", "as_"))
    path = fb.polynomial([(0, {0: p0, **REST}), (2, {0: ps, 1: vs, 2: at}), (4, {0: pf, **REST})])
    t = np.linspace(0, 4, 81)
    expected = [np.polyval(np.array(case[key][::-1], float), t) for key in ("coef_x", "coef_y")]
    np.testing.assert_allclose(path(t)[0].T, expected, atol=2e-14)


@given(
    st.lists(st.sets(st.sampled_from([0, 1, 2]), min_size=1), min_size=2, max_size=4),
    st.floats(-5, 5),
    st.floats(0.1, 9),
)
def test_polynomial_meets_all_its_conditions(orders, first, gap):
    rng = np.random.default_rng(len(orders))
    times = first + gap * np.arange(len(orders))
    orders[0].add(0)
    conditions = [
        (t, {order: rng.normal(size=2) for order in given}) for t, given in zip(times, orders)
    ]
    try:
        path = fb.polynomial(conditions)
    except ValueError as error:
        assert "do not determine" in str(error)  # e.g. positions missing between two accelerations
        return
    size = max(
        np.abs(value).max() * gap**order for _, g in conditions for order, value in g.items()
    )
    for t, given_there in conditions:
        t = min(max(t, path.start), path.start + path.duration)
        for order, value in given_there.items():
            assert path(t)[order] == pytest.approx(
                value, abs=1e-9 * (1 + size) * max(1, 1 / gap) ** order
            )


def test_csv_round_trip(tmp_path):
    path = fb.line((0.09, 0.068), (0, 0.1), 2.0)
    t = np.linspace(0, 2, 81)
    file = tmp_path / "path.csv"
    file.write_text(
        "# a comment\nname,t,x,y\n"
        + "\n".join(f"a,{s!r},{x!r},{y!r}" for s, (x, y) in zip(t.tolist(), path(t)[0].tolist())),
        encoding="utf-8",
    )
    read = fb.from_csv(file)
    times = np.linspace(0, 2, 333)
    for order, bound in enumerate((1e-9, 1e-6, 1e-4)):
        assert np.abs(read(times)[order] - path(times)[order]).max() < bound
    check_slopes(read, np.linspace(0.05, 1.9, 50))
    noisy = tmp_path / "noisy.csv"
    noise = np.random.default_rng(0).normal(scale=1e-4, size=(81, 2))
    rows = np.column_stack([t, path(t)[0] + noise])
    noisy.write_text(
        "t,x,y\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()), encoding="utf-8"
    )
    rough, smooth = fb.from_csv(noisy), fb.from_csv(noisy, smoothing=1.4e-4)
    off = [np.abs(spline(times)[2] - path(times)[2])[20:-20].max() for spline in (smooth, rough)]
    assert off[0] < 0.1 * off[1]


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "empty; needed a header with t, x, y"),
        ("t,x,y\n", "no rows under the header"),
        ("t,x\n0,1\n", "line 1: no column y; found 't', 'x'"),
        ("t,x,y\n0,1,2\n1,1,z\n", "line 3: y must be a number, not 'z'"),
        ("t,x,y\n0,1,2\n1,1\n", "line 3: 2 cells, where the header has 3"),
        ("t,x,y\n0,1,nan\n", "line 2: y is missing"),
        ("t,x,y\n0,1,2\n\n0,1,2\n", "line 4: time must increase, but 0 follows 0"),
        ("t,x,y\n0,1,2\n5,1,2\n3,1,2\n", "line 4: time must increase, but 3 follows 5"),
        ("t,x,y\n-1,1,2\n0,1,2\n", "line 2: time must not be negative, but is -1"),
        ("t,x,y\n0,1,2\n1,1,2\n", "at least 6 rows, not 2"),
    ],
)
def test_bad_csv(tmp_path, text, message):
    file = tmp_path / "bad.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        fb.from_csv(file)


def test_csv_that_is_no_text(tmp_path):
    (tmp_path / "x.csv").write_bytes(b"t,x,y\n\xff\xfe\x00")
    with pytest.raises(ValueError, match="x.csv: not a text file, but a binary one"):
        fb.from_csv(tmp_path / "x.csv")


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: fb.line((0, 0), (1, 1), 0), "duration must be finite and > 0"),
        (lambda: fb.line((0, np.nan), (1, 1), 1), "line: a must be two finite numbers"),
        (lambda: fb.circle((0, 0), -1, 1), "radius must be finite and > 0"),
        (lambda: fb.polynomial([(0, {0: (0, 0)})]), "times must be two or more"),
        (lambda: fb.polynomial([(1, {0: (0, 0)}), (0, {0: (0, 0)})]), "increasing"),
        (
            lambda: fb.polynomial([(0, {3: (0, 0)}), (1, {0: (0, 0)})]),
            "order at t = 0 s must be 0, 1 or 2",
        ),
        (
            lambda: fb.polynomial([(0, {1: (0, 0)}), (1, {1: (0, 0)})]),
            "do not determine a polynomial",
        ),
    ],
)
def test_bad_trajectories(call, message):
    with pytest.raises(ValueError, match=message):
        call()
