"""Linkages against the source papers' figures, in 40 digits: data/four_bar.json and six_bar_press.json."""

import json
import math
from functools import cache

import numpy as np
import pytest

from fivebar.linkages import (
    GRAVITY,
    PRINTED,
    REPAIRED,
    FourBar,
    crank_range,
    dead_centres,
    driving_torque,
    move,
    straight_line,
    straightness,
    study,
    time_ratio,
    transmission_range,
)
from fivebar.linkages.six_bar_press import SPEED, START
from fivebar.linkages.straight_line import crank_at, roberts
from tests.helpers import DATA

TABLE_2 = FourBar(0.2, 0.06, 0.16, 0.14)  # MechAnalyzer, Table 2
BRANCHES = {"open_B_left_of_A_to_O4": 1, "crossed": -1}
REL = 1e-12


@cache
def numbers(name):
    return json.loads((DATA / f"{name}.json").read_text("utf-8"))


def close(value, expected, scale=0.0):
    """Within 1e-12 of the number, or of its scale where it passes zero."""
    return value == pytest.approx(float(expected), rel=REL, abs=REL * scale)


@pytest.mark.parametrize("name", BRANCHES)
def test_mechanalyzer_table_2_and_its_figure_13_joint_4(name):
    case, branch = numbers("four_bar")["mechanalyzer_table_2"]["branches"][name], BRANCHES[name]
    for row in case["table"]:
        motion = move(TABLE_2, math.radians(row["crank_deg"]), branch=branch)
        assert close(math.degrees(motion.angle("rocker")), row["angle_deg"])
        assert close(motion.rate("rocker"), row["vel"])
        assert close(motion.angular_acceleration("rocker"), row["acc"])
    for key, order in (
        ("angle_rad", 0),
        ("velocity_per_crank_rad", 1),
        ("accel_per_crank_rad2", 2),
    ):
        for end in ("max", "min"):  # the extremes of Fig. 13, which no sample of the curve passes
            at, sign = math.radians(float(case[key][end]["crank_deg"])), 1 if end == "max" else -1
            motion = move(TABLE_2, at + np.array([-1e-3, 0, 1e-3]), branch=branch)
            values = (motion.angle, motion.rate, motion.angular_acceleration)[order]("rocker")
            assert close(values[1], case[key][end]["value"])
            assert sign * values[1] > max(sign * values[0], sign * values[2])


def test_mechanalyzer_table_2_dead_centres_and_transmission():
    case = numbers("four_bar")["mechanalyzer_table_2"]
    extended, folded = dead_centres(TABLE_2)
    expected = case["dead_centres_closed_form_deg"]
    assert close(math.degrees(extended.crank), expected["extended_crank"])
    assert close(math.degrees(folded.crank) + 360, expected["folded_crank"])
    assert close(math.degrees(extended.rocker), expected["rocker_at_extended"])
    assert close(math.degrees(folded.rocker), expected["rocker_at_folded"])
    assert close(time_ratio(TABLE_2), expected["time_ratio"])
    low, high = map(math.degrees, transmission_range(TABLE_2))
    assert close(low, case["transmission_angle_deg"]["min_interior"])
    assert close(high, case["transmission_angle_deg"]["max_interior"])
    turn = move(TABLE_2, np.linspace(0, 2 * np.pi, 721)).transmission_angle()
    assert np.degrees([turn.min(), turn.max()]) == pytest.approx([low, high], rel=1e-12)
    crossed = dead_centres(TABLE_2, -1)
    mirrored = [(-d.crank, -d.rocker) for d in (extended, folded)]
    assert np.array([(d.crank, d.rocker) for d in crossed]) == pytest.approx(np.array(mirrored))


def test_grashof_classes_of_the_reference():
    for sides, kind in numbers("four_bar")["grashof"].items():
        four_bar = FourBar(*json.loads(sides.replace("(", "[").replace(")", "]")))
        assert four_bar.kind == kind
        assert crank_range(four_bar).full == ("crank" in four_bar.turning)


def vector_method():
    links = {
        key: float(value) for key, value in numbers("four_bar")["vector_method"]["links"].items()
    }
    point = links["BM"] * math.cos(links["beta"]), links["BM"] * math.sin(links["beta"])
    return FourBar(links["AD"], links["AB"], links["BC"], links["CD"], point=point)


@pytest.mark.parametrize("row", range(6))
def test_vector_method_equations_8_to_16(row):
    row = numbers("four_bar")["vector_method"]["rows"][row]
    motion = move(vector_method(), math.radians(row["crank_deg"]), branch=row["branch"])
    for value, key in (
        (motion.angle("coupler"), "theta_BC"),
        (motion.angle("rocker"), "theta_CD"),
        (motion.rate("coupler"), "k_BC"),
        (motion.rate("rocker"), "k_CD"),
        (motion.angular_acceleration("coupler"), "l_BC"),
        (motion.angular_acceleration("rocker"), "l_CD"),
        (motion.speed("M"), "speed"),
        (motion.tangential("M"), "a_tangential"),
        (motion.normal("M"), "a_normal"),
        (np.hypot(*motion.acceleration("M")), "a_total"),
        (motion.curvature_radius("M"), "curvature_radius"),
    ):
        assert close(value, row[key]), key
    for value, key in (
        (motion.position, "M"),
        (motion.velocity, "v_analog"),
        (motion.acceleration, "a_analog"),
    ):
        assert value("M") == pytest.approx(np.array(row[key], float), rel=REL)


def test_vector_method_figures_2_to_7():
    from fivebar.visualization.plot.linkages import vector_method_figure

    run = study(vector_method(), speed=1.0)
    figure = vector_method_figure(run)
    lines = [axes.lines[0].get_xydata() for axes in figure.axes]
    assert len(lines) == 6
    row = numbers("four_bar")["vector_method"]["rows"][1]  # 75 degrees
    expected = [np.hypot(*np.array(row["M"], float))]
    expected += [
        float(row[key])
        for key in ("speed", "a_total", "a_tangential", "a_normal", "curvature_radius")
    ]
    assert [line[75, 1] for line in lines] == pytest.approx(expected, rel=1e-12)
    assert [line[75, 0] for line in lines] == pytest.approx([75] * 6)
    a = run["M.tangential"] ** 2 + run["M.normal"] ** 2
    assert a == pytest.approx(run["M.total"] ** 2, rel=1e-12)


def test_hoeken_of_the_reference():
    case, how = (
        numbers("four_bar")["straight_line"]["Hoeken_90_270"],
        straightness(straight_line("hoeken")),
    )
    assert close(how.stroke, case["stroke"]) and close(how.deviation, case["max_abs_deviation"])
    assert close(how.band, case["band_peak_to_peak"]) and close(how.ratio, case["band_over_stroke"])


@pytest.mark.parametrize("half", ["0.1", "0.2", "0.25", "0.3", "0.4"])
def test_watt_of_the_reference(half):
    watt = straight_line("watt")
    ends = [
        crank_at(watt.linkage, -1, (0, 0), (0, 1), sign * float(half), sign * float(half))
        for sign in (-1, 1)
    ]
    points = move(watt.linkage, np.linspace(*ends, 4001), branch=-1).position("M")
    assert points[[0, -1], 1] == pytest.approx([-float(half), float(half)], rel=1e-13)
    expected = float(numbers("four_bar")["straight_line"]["Watt"]["max_abs_x"][f"|y|<={half}"])
    # The reference is a sampled maximum, short of the ends of the stroke by less than a sample of 2e-4.
    assert expected <= np.abs(points[:, 0]).max() <= expected * (1 + 5 * 4e-4 / float(half))


@pytest.mark.parametrize("arm", ["1.2", "1.5", "2"])
def test_roberts_of_the_reference(arm):
    how = straightness(roberts(float(arm)))
    case = numbers("four_bar")["straight_line"]["Roberts"][f"r={arm}"]
    assert how.stroke == pytest.approx(2.0, rel=1e-13)
    assert how.deviation == pytest.approx(
        -float(case["min_y"]), rel=2e-6
    )  # a sampled minimum, here and there
    ends = move(roberts(float(arm)).linkage, roberts(float(arm)).stroke).position("M")
    assert ends == pytest.approx(np.array([[0, 0], [2, 0]]), abs=1e-13)  # exact at A and at D


def test_chebyshev_and_evans_are_exact_at_three_points_of_their_stroke():
    cheb, evans = straight_line("chebyshev"), straight_line("evans")
    q = np.array([math.pi / 2, math.atan2(4, 3), math.atan2(3, 4)])
    points = move(cheb.linkage, q, branch=cheb.branch).position("M")
    assert points == pytest.approx(
        np.array([[0, 4], [2, 4], [4, 4]]), abs=1e-7
    )  # the last one is a crank limit
    middle = dead_centres(evans.linkage)[0].crank  # crank and coupler in line, M in A
    points = move(evans.linkage, np.array([-math.pi / 6, middle, math.pi / 6])).position("M")
    assert points == pytest.approx(np.array([[0, -5], [0, 0], [0, 5]]), abs=1e-13)
    # Chebyshev's and Hoeken's mechanisms are cognates: they draw the same curve.
    assert straightness(cheb).deviation == pytest.approx(
        straightness(straight_line("hoeken")).deviation, rel=1e-6
    )
    assert straightness(evans).ratio == pytest.approx(0.005486, rel=1e-3)


PRESS_CASES = {
    "as_printed": (PRINTED, GRAVITY),
    "crank_52_no_gravity": (REPAIRED, (0.0, 0.0)),
    "crank_52_gravity_along_plus_x": (REPAIRED, GRAVITY),
}


@pytest.mark.parametrize("name", PRESS_CASES)
def test_six_bar_press_of_the_reference(name):
    press, gravity = PRESS_CASES[name]
    case = numbers("six_bar_press")[name]
    checked = 0
    for row in case["values"].values():
        if row is None:
            continue
        motion = move(press, math.radians(float(row["theta2_deg"])), SPEED)
        for link, key in (
            ("coupler", "theta3_deg"),
            ("rocker", "theta4_deg"),
            ("bar", "theta5_deg"),
        ):
            assert close(math.degrees(motion.angle(link)), row[key])
        for way in ("S6", "S6_down"):
            unit = way[2:] + "_m"
            for value, key in zip(
                motion.coordinate(way), ("S6" + unit, "V6" + unit + "_s", "A6" + unit + "_s2")
            ):
                assert close(value, row[key], scale=1e-6), key  # at 160.24 deg V6 is all but zero
        assert close(driving_torque(motion, gravity=gravity), row["M2_noload_Nm"], scale=1e-3)
        assert close(
            driving_torque(motion, {"E": (0, 1e5)}, gravity), row["M2_100kN_Nm"], scale=1.0
        )
        checked += 1
    assert checked == (5 if name == "as_printed" else 8)


def test_six_bar_figures_11_to_13_19_and_20_over_three_turns():
    case = numbers("six_bar_press")["crank_52_gravity_along_plus_x"]
    names = {
        "S6.position": "peak_S6",
        "S6.velocity": "peak_V6",
        "S6.acceleration": "peak_A6",
        "torque": "peak_M2_noload",
    }
    free = study(REPAIRED, SPEED, turns=3, gravity=GRAVITY, samples=1201)
    loaded = study(REPAIRED, SPEED, turns=3, gravity=GRAVITY, samples=1201, load={"E": (0.0, 1e5)})
    assert (
        free.t[-1] == pytest.approx(3 * float(case["period_s"]), rel=1e-14) and free.q[0] == START
    )
    curves = {key: free[name] for name, key in names.items()} | {"peak_M2_100kN": loaded["torque"]}
    for key, values in curves.items():
        for end, best in (("max", np.argmax), ("min", np.argmin)):
            expected, at = float(case[key][end]["value"]), float(case[key][end]["t"])
            width = np.ptp(values)
            assert values[best(values)] == pytest.approx(
                expected, abs=1e-4 * width
            )  # sampled every 2.5 ms
            assert (free.t[best(values)] - at + 1.5) % 3.0 - 1.5 == pytest.approx(0, abs=1.3e-3)
        assert values[1200:2401] == pytest.approx(
            values[:1201], abs=1e-9 * np.abs(values).max()
        )  # three equal turns
    panels = [["S6.position"], ["S6.velocity"], ["S6.acceleration"], ["torque"]]
    axes = loaded.plot(panels=panels).axes
    assert (
        axes[-1].lines[0].get_ydata() == pytest.approx(loaded["torque"])
        and axes[-1].get_ylabel() == "(N m)"
    )


def test_six_bar_as_printed_locks():
    case = numbers("six_bar_press")["as_printed"]
    allowed = crank_range(PRINTED)
    low, high = (float(x) for x in case["crank_forbidden_deg"])
    assert not allowed.full and np.degrees(allowed.intervals[0]) == pytest.approx(
        [high, 360 + low], rel=REL
    )
    run = study(PRINTED, SPEED, drive="until-lock")
    assert close(run.lock[1], case["t_lock_s"]) and run.t[-1] < run.lock[1]
    assert crank_range(REPAIRED).full
