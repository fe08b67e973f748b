"""Figures and words of results, from their definitions: evidence, degrees of freedom, tables, files."""

import io
from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy import stats

import fivebar as fb
from fivebar.estimation.calibration.measured_robot import LENGTHS, PLACE
from fivebar.estimation.calibration.measured_robot import seen as seen_by
from fivebar.estimation.calibration.photo import _sides
from fivebar.estimation.calibration.report import report
from fivebar.estimation.calibration.sheet import sheet
from fivebar.estimation.saving import read_json, write_json
from tests.helpers.twins import HOME, LAB, measured, poses, seen, twin

NAMES = (*LENGTHS, "offset1", "offset2")
SIGMA = 3e-4


def few_rough_points(spread=1.0):
    rng = np.random.default_rng(4)
    return measured(twin(rng, LAB, NAMES, spread), 8, rng, SIGMA, HOME)


@pytest.fixture(scope="module")
def rough():
    return fb.calibrate(LAB, few_rough_points(), NAMES, sigma=SIGMA, mistakes="keep")


@pytest.mark.parametrize("level", [0.0, 1.0, -0.1, 1.1, np.nan])
def test_a_level_is_between_0_and_1(rough, level):
    with pytest.raises(ValueError, match="level must be"):
        rough.intervals(level)


def slopes_of(found):
    """Derivatives of the weighted points by the unknowns, SI, rows of x and y in turn."""
    _, slopes = seen_by(found.p, found.rows.q, found.assembly)
    columns = [PLACE[name] for name in found.unknown]
    return slopes[:, :, columns].reshape(-1, len(columns))


def test_a_workshop_s_tolerance_is_advised_where_data_are_rougher():
    """For bars of 0.09 m it is 0.27 mm: then all lengths have it as prior, or none."""
    rough, fine = (
        fb.calibrate(LAB, few_rough_points(spread), NAMES, sigma=sigma, mistakes="keep")
        for spread, sigma in ((1.0, SIGMA), (0.1, SIGMA / 10))
    )
    assert max(rough.sd[name] for name in LENGTHS) > 2.7e-4 > max(fine.sd[name] for name in LENGTHS)
    assert rough.advised_priors == pytest.approx(dict.fromkeys(LENGTHS, 2.7e-4))
    assert fine.advised_priors == {}


def test_priors_are_advised_by_the_scatter_where_sigma_is_not_given(rough):
    """As with the scatter for sigma; the report then says both."""
    data = few_rough_points()
    relative = fb.calibrate(LAB, data, NAMES, mistakes="keep")
    scatter = np.sqrt(relative.variance)
    told = fb.calibrate(LAB, data, NAMES, sigma=scatter, mistakes="keep")
    assert relative.advised_priors == pytest.approx(told.advised_priors)
    words = " ".join(f"{name}={1e3 * sd:.2g}mm" for name, sd in rough.advised_priors.items())
    assert f"goes where it should more exactly with --prior {words}, or" in (report(rough))
    assert f"more exactly with --sigma {scatter:.2g} --prior l11=" in report(relative)


def rows_with(numbers):
    """4 exact rows, of which this many numbers are measured."""
    rng = np.random.default_rng(5)
    data = measured(twin(rng, LAB, NAMES), 4, rng, 1e-5, HOME)
    if numbers < 8:
        data["y"][3] = np.nan
    return data


def test_one_number_to_spare_gives_deviations_and_none_gives_none():
    one = fb.calibrate(LAB, rows_with(8), NAMES)
    assert one.dof == 1 and one.p_value is None
    off = one.residuals.ravel()
    assert one.variance == pytest.approx(off @ off)
    slopes = slopes_of(one)
    sd = np.sqrt(one.variance * np.diag(np.linalg.inv(slopes.T @ slopes)))
    assert list(one.sd.values()) == pytest.approx(sd, rel=1e-3)
    far = stats.t.ppf(0.975, 1)
    for name, (low, high) in one.intervals().items():
        assert (high - low) / 2 == pytest.approx(far * one.sd[name])
        assert (high + low) / 2 == pytest.approx(one.values[name])
    none = fb.calibrate(LAB, rows_with(7), NAMES)
    assert none.dof == 0 and none.variance == np.inf and set(none.sd.values()) == {np.inf}
    assert none.advised_priors == {}
    known = fb.calibrate(LAB, rows_with(7), NAMES, sigma=1e-5)
    assert known.p_value is None and known.fits is None and known.variance == 1.0
    assert np.isfinite(list(known.sd.values())).all()
    p_value = stats.chi2.sf(fb.calibrate(LAB, rows_with(8), NAMES, sigma=1e-5).chi2, 1)
    assert fb.calibrate(LAB, rows_with(8), NAMES, sigma=1e-5).p_value == pytest.approx(p_value)


def test_a_table_of_unknowns_is_in_columns(rough):
    """Names and units begin at one place, numbers end at one."""
    lines = report(rough).splitlines()
    first = next(k for k, line in enumerate(lines) if line.split()[:2] == ["unit", "before"])
    head, *rows = lines[first : first + 1 + len(NAMES)]
    assert [row.split()[0] for row in rows] == list(NAMES)
    for row in rows:
        name, unit, *numbers = row.split()
        assert row.index(unit, len(name)) == head.index("unit")
        assert unit == ("mm" if name in LENGTHS else "deg")
        low, value, high = float(numbers[3]), float(numbers[1]), float(numbers[4])
        assert low < value < high
    for title in ("before", "found", "sd", "95 % from", "to"):
        end = head.index(f" {title}") + len(f" {title}")
        assert all(row[: end + 1].rstrip() == row[:end] for row in rows)
        assert all(row[end - 1].isdigit() for row in rows)


def test_repeatability_of_several_poses_is_that_of_each():
    rng = np.random.default_rng(8)
    points = rng.normal(size=(3, 30, 2)) * 1e-4 + rng.normal(size=(3, 1, 2))
    both = fb.repeatability(points)
    assert both.AP is None and both.commanded is None and both.points.shape == (3, 30, 2)
    for k in range(3):
        alone = fb.repeatability(points[k], points[k].mean(axis=0))
        assert alone.AP == pytest.approx([0.0], abs=1e-12)
        assert both.RP[k] == pytest.approx(alone.RP[0])
        assert both.distances[k] == pytest.approx(np.hypot(*(points[k] - both.barycentre[k]).T))
    head, *rows, worst = str(both).splitlines()
    assert "AP" not in head and [row.split()[0] for row in rows] == ["1", "2", "3"]
    assert f"worst RP {1e3 * both.RP.max():.4f} mm" in worst
    assert "29 cycles at a pose" in str(fb.repeatability(points[:, 1:]))
    assert repr(both) == f"<Repeatability: 3 poses, 30 cycles, RP = {1e3 * both.RP.max():.4g} mm>"
    # Two points: each is half of their distance from the barycentre.
    assert fb.repeatability([(0.0, 0.0), (2e-4, 0.0)]).RP == pytest.approx([1e-4])
    for wrong in ([(0.0, 0.0)], [(0.0, 0.0, 0.0)] * 3, np.zeros((0, 5, 2)), np.zeros((1, 1, 3, 2))):
        with pytest.raises(ValueError, match=r"points must have shape \(n, 2\)"):
            fb.repeatability(wrong)


@dataclass
class Part:
    count: int
    exact: bool
    size: float


@dataclass
class Whole:
    name: str
    parts: tuple[Part, ...]
    by_name: dict[str, float]
    rows: np.ndarray
    modes: np.ndarray
    limit: float | None
    note: str | None
    more: tuple[int, ...] = (7,)
    bad: np.ndarray = field(default_factory=lambda: np.zeros(2))


WHOLE = Whole(
    "a",
    (Part(3, True, 2.0), Part(0, False, np.inf)),
    {"x": 1.0},
    np.array([[0.5, np.nan]]),
    np.array([1, -1]),
    None,
    "b",
)


def saved(content, kind="thing"):
    out = io.StringIO()
    write_json(out, kind, content)
    return out.getvalue()


def test_values_of_a_file_have_the_types_they_had():
    again = read_json(io.StringIO(saved(WHOLE)), "thing", Whole, str)
    for found, given in zip(again.parts, WHOLE.parts, strict=True):
        assert found == given
        assert [type(each) for each in vars(found).values()] == [int, bool, float]
    assert (again.name, again.limit, again.note, again.more) == ("a", None, "b", (7,))
    assert again.by_name == {"x": 1.0} and type(again.by_name["x"]) is float
    assert np.array_equal(again.rows, WHOLE.rows, equal_nan=True)
    assert np.array_equal(again.modes, WHOLE.modes) and again.modes.dtype.kind == "i"
    assert np.array_equal(again.bad, np.zeros(2))
    whole = saved(WHOLE).replace('"size": 2.0', '"size": 2')
    assert type(read_json(io.StringIO(whole), "thing", Whole, str).parts[0].size) is float


@pytest.mark.parametrize(
    "was, now",
    [
        ('"count": 3', '"count": "3"'),
        ('"name": "a"', '"name": 1'),
        ('"name": "a"', '"title": "a"'),
        ('"note": "b"', '"note": 2.5'),
        ('"size": 2.0', '"size": "long"'),
        ('"fivebar": "thing"', '"fivebar": "other"'),
        ('"fivebar": "thing"', '"what": "thing"'),
        ("0.5", '"wide"'),
    ],
)
def test_a_file_with_other_values_is_refused(was, now):
    text = saved(WHOLE)
    assert was in text
    with pytest.raises(ValueError, match="not a file of kind 'thing': "):
        read_json(io.StringIO(text.replace(was, now, 1)), "thing", Whole, str)


def test_a_mistake_in_a_file_is_told_with_its_line(tmp_path):
    rng = np.random.default_rng(9)
    data = measured(twin(rng, LAB, NAMES), 12, rng, 1e-5, HOME)
    pose = fb.dgm(LAB, np.column_stack([data["q1"], data["q2"]]), -1)
    near = np.hypot(*(pose.xi - (np.stack([data["x"], data["y"]], axis=1))).T) < 0.01
    data["assembly"] = np.where(near, -1, 1)
    data["assembly"][4] *= -1
    file = tmp_path / "points.csv"
    lines = [",".join(data), *(",".join(map(repr, map(float, row))) for row in zip(*data.values()))]
    file.write_text("\n".join(lines), "utf-8")
    with pytest.raises(ValueError, match="^line 6: the fitted robot is in other modes there"):
        fb.calibrate(LAB, file, NAMES)
    with pytest.raises(ValueError, match="^row 5: the fitted robot is in other modes there"):
        fb.calibrate(LAB, data, NAMES)


def test_a_known_frame_stays_where_it_is_and_only_its_turn_is_found():
    rng = np.random.default_rng(10)
    true = twin(rng, LAB, LENGTHS) | {"x0": 0.3, "y0": -0.2, "turn": 2.0}
    q, points, assembly, _ = seen(true, poses(true, 12, rng, HOME))
    data = {"q1": q[:, 0], "q2": q[:, 1], "x": points[:, 0], "y": points[:, 1]}
    data["assembly"] = assembly
    found = fb.calibrate(LAB, data, (*LENGTHS, "turn"), start={"x0": 0.3, "y0": -0.2})
    assert found.values["turn"] == pytest.approx(2.0, abs=1e-9)
    assert found.values["d"] == pytest.approx(true["d"], abs=1e-9)
    assert found.machine.frame.shift == (0.3, -0.2)
    assert found.assembly.dtype == np.int8 and np.array_equal(found.assembly, assembly)
    for mode in found.machine.measured:
        assert [type(sign) for sign in mode] == [int] * 3


def test_a_report_has_the_misses_before_and_after(rough):
    """Before: with the drawing's lengths."""
    before = rough.rows.points - fb.dgm(LAB, rough.rows.q, rough.assembly).xi
    rms = [1e3 * np.sqrt(np.mean(off**2)) for off in (before, rough.residuals)]
    assert rough.rms_before == pytest.approx(1e-3 * rms[0])
    modes = len({(*w, a) for w, a in zip(rough.working.tolist(), rough.assembly.tolist())})
    lines = report(rough).splitlines()
    assert lines[:2] == [
        f"8 rows with 16 coordinates, in {modes} of 8 modes; 7 unknowns, of which 7 combinations can be told",
        f"misses, RMS: {rms[0]:.4g} mm before, {rms[1]:.4g} mm after",
    ]
    assert rough.chi2 == pytest.approx((rough.residuals**2).sum() / SIGMA**2) and rough.dof == 9
    p_value = stats.chi2.sf(rough.chi2, 9)
    words = f"chi2 = {rough.chi2:.4g} for 9 degrees of freedom, p = {p_value:.2g}: the model fits"
    assert lines[2] == f"{words} to the sigma given" and rough.fits
    assert "all unknowns are told apart" in lines or rough.weakly_identified
    assert "off all other rows" not in report(rough)


def test_a_report_warns_of_misses_that_are_large_for_a_bar():
    data = few_rough_points()
    data["x"] = data["x"] + 0.02 * np.sin(1e4 * data["x"])
    found = fb.calibrate(LAB, data, ("x0", "y0"), mistakes="keep")
    assert f"THE MISSES ARE LARGE, {found.rms / 0.09:.1%} of a bar" in str(found)
    assert "THE MISSES" not in str(fb.calibrate(LAB, few_rough_points(), NAMES, mistakes="keep"))


def test_some_rows_with_a_sigma_and_some_without_are_refused():
    data = few_rough_points()
    data["sigma"] = np.where(np.arange(8) == 5, np.nan, 2e-4)
    with pytest.raises(ValueError, match="row 6: no sigma, where other rows have one"):
        fb.calibrate(LAB, data, NAMES)
    found = fb.calibrate(LAB, data, NAMES, sigma=3e-4, mistakes="keep")
    assert found.weight == pytest.approx(np.where(np.arange(16) // 2 == 5, 1 / 3e-4, 1 / 2e-4))


def test_poses_are_written_with_what_is_to_be_measured_left_empty():
    found = fb.measurement_poses(LAB, 4, start={"offset1": 0.1, "ratio2": 2.0})
    out = io.StringIO()
    found.to_csv(out)
    head, *rows = out.getvalue().splitlines()
    assert head == "q1,q2,x,y,working1,working2,assembly,x_nominal,y_nominal" and len(rows) == 4
    for k, row in enumerate(rows):
        q1, q2, x, y, *modes, x_nominal, y_nominal = row.split(",")
        angles = float(q1) + 0.1, 2.0 * float(q2)
        pose = fb.dgm(LAB, angles, found.assembly[k])
        assert pose.xi == pytest.approx((float(x_nominal), float(y_nominal)), abs=1e-12)
        assert (x, y) == ("", "")
        assert [int(mode) for mode in modes] == [*pose.working.tolist(), int(pose.assembly)]
        assert pose.xi == pytest.approx(found.xi[k]) and found.q[k] == pytest.approx(
            (float(q1), float(q2))
        )
    assert found.sd(2e-5)["l11"] == pytest.approx(2e-5 * found.unit_sd[0])


def test_errors_of_a_tip_are_told_in_a_line():
    tolerances = {"l11": 1e-4, "backlash2": 2e-3}
    found = fb.tip_error(LAB, tolerances, [(0.0, 0.1), (0.02, 0.12)], samples=500, seed=3)
    by_chance = f"by Monte Carlo {1e3 * found.monte_carlo_sd.max():.3g} mm"
    words = f"2 poses, 500 samples, sd up to {1e3 * found.sd.max():.3g} mm, {by_chance}"
    assert repr(found) == f"<TipError: {words}>"
    assert found.tolerances == pytest.approx([1e-4, 1e-3]) and found.names == tuple(tolerances)
    # A motor with play stands at one side of it or at the other.
    along = np.hypot(*found.jacobian[0, :, 1])
    alone = fb.tip_error(LAB, {"backlash2": 2e-3}, (0.0, 0.1), samples=500)
    assert np.hypot(*alone.drawn[0].T) == pytest.approx(1e-3 * along, rel=0.02)
    with pytest.raises(ValueError, match="21 poses times 1000000 samples: at most 2e7 together"):
        fb.tip_error(LAB, tolerances, np.tile((0.0, 0.1), (21, 1)), samples=1_000_000)
    other = fb.igm(fb.FiveBar(l11=0.095), (0.0, 0.1))
    with pytest.raises(ValueError, match="poses must be of the same robot"):
        fb.tip_error(LAB, tolerances, other)


def test_what_no_drawing_is_made_for_is_refused():
    for machine, options, words in (
        (LAB, {"paper": "A3"}, "sheet: paper must be"),
        (LAB, {"working": (1, 0)}, "sheet: working must be"),
        (5, {}, "sheet: machine must be"),
    ):
        with pytest.raises((ValueError, TypeError), match=words):
            sheet(machine, **options)
    with pytest.raises(
        ValueError, match="200 x 148 mm is no sheet of A5, .* about 210 x 148 mm, its longer"
    ):
        _sides("A5", (0.2, 0.148))
    assert _sides("A5", (0.209, 0.149)) == (0.209, 0.149) and _sides("A4", None) == (0.297, 0.21)


def test_a_mistake_is_told_with_how_far_points_move():
    """y in mm: RMS distances from the mean."""
    rng = np.random.default_rng(11)
    data = measured(twin(rng, LAB, ("l11",)), 8, rng, 1e-5, HOME)
    data["y"] = 1e3 * data["y"]
    with pytest.raises(ValueError, match="bars of 90 mm cannot") as refused:
        fb.calibrate(LAB, data, ("l11",))
    x, y, q1, q2 = (data[name] - data[name].mean() for name in ("x", "y", "q1", "q2"))
    moved = 1e3 * np.sqrt((x @ x + y @ y) / (q1 @ q1 + q2 @ q2))
    assert str(refused.value).startswith(f"x, y move by {moved:.3g} mm for each rad of q1, q2")


@pytest.mark.every(5)
@pytest.mark.parametrize("names", [("x0", "y0", "turn"), ("x0", "y0", "turn", "scale")])
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_frame_is_found_by_points_of_both_assembly_modes(seed, names):
    """In one working mode, no mode noted: a camera may lie anywhere, and count pixels."""
    rng = np.random.default_rng(seed)
    true = twin(rng, LAB, LENGTHS) | {"x0": 0.3, "y0": -0.2, "turn": rng.uniform(-3.0, 3.0)}
    if "scale" in names:
        true |= {"x0": 300.0, "y0": 200.0, "scale": 4000.0}
    q, points, assembly, _ = seen(true, poses(true, 14, rng, HOME))
    assert set(assembly) == {-1, 1}
    data = {"q1": q[:, 0], "q2": q[:, 1], "x": points[:, 0], "y": points[:, 1]}
    unknown = (*LENGTHS[1:], *names)
    found = fb.calibrate(LAB, data, unknown, start={"l11": true["l11"]})
    assert found.values == pytest.approx({name: true[name] for name in unknown}, abs=1e-7)
    assert np.array_equal(found.assembly, assembly)
