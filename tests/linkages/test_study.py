"""Motion studies: tables, files, pictures, animations, and `fivebar linkage` as a user meets it."""

import argparse
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb
from fivebar import cli
from fivebar.cli import linkage as linkage_cli
from fivebar.linkages import (
    GRAVITY,
    PRINTED,
    REPAIRED,
    Body,
    FiveBarLinkage,
    FourBar,
    SliderCrank,
    Study,
    coupler_curves,
    move,
    straight_line,
    study,
    type_2_curves,
)
from fivebar.linkages.quantities import known, unit
from fivebar.linkages.six_bar_press import SPEED
from fivebar.visualization.plot.linkages import coupler_curve_figure

TABLE_2 = FourBar(
    0.2, 0.06, 0.16, 0.14, point=(0.1, 0.03), coupler_body=Body(0.4, 0.001, (0.08, 0.0))
)
STUDIES = {
    "four-bar": (TABLE_2, {}),
    "crank held": (TABLE_2.inversion("crank"), {}),
    "coupler held": (TABLE_2.inversion("coupler"), {"drive": "swing"}),
    "rocker held": (TABLE_2.inversion("rocker"), {"drive": "swing"}),
    **{
        f"slider-crank, {held} held": (SliderCrank(0.05, 0.15, 0.02, held), {"drive": drive})
        for held, drive in {
            "guide": "turn",
            "crank": "turn",
            "rod": "turn",
            "slider": "swing",
        }.items()
    },
    "press": (REPAIRED, {"speed": SPEED, "gravity": GRAVITY, "load": {"E": (0.0, 1e3)}}),
    "press up to its lock": (PRINTED, {"speed": SPEED, "drive": "until-lock"}),
    "five-bar": (FiveBarLinkage(), {"drive": "swing"}),
    "five-bar 2 4": (
        FiveBarLinkage(fb.FiveBar(l11=0.1), (2, 4)),
        {"drive": "swing", "speed": [3.0, 3.0]},
    ),
    "parallelogram": (FourBar(2, 1, 2, 1), {}),
    "antiparallelogram": (FourBar(2, 1, 2, 1), {"branch": -1}),
    "kite": (FourBar(1, 2, 2, 1), {}),
    "equal crank and rod": (SliderCrank(0.1, 0.1), {"turns": 0.2}),
    "crank + offset = rod": (SliderCrank(0.1, 0.15, 0.05), {"turns": 2.0}),
}


@pytest.mark.every(4)
@pytest.mark.parametrize("name", STUDIES)
def test_csv_and_back(name, tmp_path):
    linkage, options = STUDIES[name]
    run = study(linkage, **{"speed": 5.0, "turns": 1.5} | options)
    run.to_csv(tmp_path / "run.csv")
    again = Study.from_csv(tmp_path / "run.csv")
    assert again.linkage == linkage and list(again.columns) == list(run.columns)
    assert not {"G", "H", "K", "L"} & {column.partition(".")[0] for column in run.columns}
    for column in run.columns:
        assert np.array_equal(again[column], run[column], equal_nan=True), column
    assert np.array_equal(again.t, run.t) and np.array_equal(again.points(), run.points())
    header = (tmp_path / "run.csv").read_text("utf-8").splitlines()[1].split(",")
    assert (
        header[0] == "t (s)"
        and header[1].startswith("q")
        and all(cell.endswith(")") for cell in header)
    )
    assert header[-1] == f"{list(run.columns)[-1]} ({unit(list(run.columns)[-1])})"


@pytest.mark.deep
@pytest.mark.parametrize("name", STUDIES)
def test_rates_are_the_slopes_of_the_table(name):
    """The table by itself: every rate is the slope of its own position column, whatever the drive does."""
    linkage, options = STUDIES[name]
    run = study(linkage, **{"speed": 5.0, "samples": 4001} | options)
    part = slice(len(run.t) // 4, 2 * len(run.t) // 3)  # away from locks and from ends
    t = run.t[part]
    for first, second in (
        ("angle", "rate"),
        ("rate", "angular_acceleration"),
        ("x", "vx"),
        ("vy", "ay"),
    ):
        for column in [c for c in run.columns if c.endswith(f".{first}")]:
            slope = np.gradient(run[column][part], t)[1:-1]
            given = run[f"{column.rpartition('.')[0]}.{second}"][part][1:-1]
            assert slope == pytest.approx(given, abs=2e-4 * (5e-3 + np.abs(given).max())), column


def test_any_quantity_can_be_asked_for():
    run = study(
        TABLE_2,
        3.0,
        turns=2,
        samples=37,
        quantities=["M.speed", "inertia", "torque"],
        gravity=(0.0, -9.81),
    )
    assert list(run.columns) == ["M.speed", "inertia", "torque"] and len(run.t) == 73
    assert repr(run) == "<Study: FourBar, 4.18879 s in 73 rows, 3 quantities>"
    for name in known(run.motion):
        assert run[name].shape == (73,) and unit(name)
    assert run["M.speed"] == pytest.approx(np.hypot(run["M.vx"], run["M.vy"]), rel=1e-12)
    assert run["crank.angle"][-1] == pytest.approx(4 * np.pi)  # continuous over the turns
    with pytest.raises(
        ValueError, match=r"no quantity 'M.z'; the known ones are crank.angle, crank.rate"
    ):
        run["M.z"]


def test_a_crank_that_locks_says_where_and_when():
    with pytest.raises(
        fb.UnreachableError,
        match=r"the crank cannot turn: from 160.24 deg at 120 deg/s it locks at 336.825007 deg after 1.47154173 s",
    ):
        study(PRINTED, SPEED)
    with pytest.raises(
        fb.UnreachableError, match=r"at -120 deg/s it locks at 45.1749929 deg after 0.958875059 s"
    ):
        study(PRINTED, -SPEED)
    run = study(PRINTED, SPEED, turns=0.25)  # not as far as the lock
    assert run.lock is None and run.t[-1] == pytest.approx(0.75)
    with pytest.raises(
        fb.UnreachableError, match=r"cannot start at 0 deg.*nearest allowed angle is -23.1749929"
    ):
        study(PRINTED, SPEED, start=0.0)
    with pytest.raises(fb.UnreachableError, match="motors lock at .* after 0.4"):
        study(FiveBarLinkage(), start=(0.0, 1.0471975511965976))
    run = study(FiveBarLinkage(), start=(0.0, 1.0471975511965976), drive="until-lock")
    assert run.lock[1] == pytest.approx(0.497896784) and np.isfinite(run["link 2.angle"]).all()


def test_a_press_whose_bar_is_too_short_closes_nowhere():
    press = replace(REPAIRED, l5=0.01)
    for asked in (lambda: study(press), lambda: move(press, 1.0)):
        with pytest.raises(fb.UnreachableError, match="on this branch no angle of the crank clos"):
            asked()


def test_swings_stay_inside_and_strokes_are_whole():
    run = study(TABLE_2.inversion("rocker"), drive="swing")
    low, high = np.radians([27.6604499, 78.463041])
    assert low < run.q.min() < low + 0.05 and high - 0.05 < run.q.max() < high
    watt = straight_line("watt")
    run = study(watt.linkage, drive="swing", between=tuple(sorted(watt.stroke)), branch=watt.branch)
    assert [run["M.y"].min(), run["M.y"].max()] == pytest.approx([-0.25, 0.25], rel=1e-9)
    run = study(PRINTED, drive="swing")
    low, high = np.radians([45.1749929, 336.825007])
    assert low < run.q.min() < low + 0.15 and high - 0.15 < run.q.max() < high
    with pytest.raises(ValueError, match="turns fully: it has no range"):
        study(TABLE_2, drive="swing")


@pytest.mark.parametrize(
    "robot, motors, turns",
    [
        (fb.FiveBar(), (1, 5), 1.0),
        (fb.FiveBar(l11=0.1), (2, 4), 0.2),
        (fb.FiveBar(0.09, 0.03, 0.03, 0.09, 0.118), (1, 5), 1.0),
        (fb.FiveBar(0.09, 0.03, 0.03, 0.09, 0.118), (1, 5), 0.2),
        (fb.FiveBar(0.09, 0.03, 0.02, 0.08, 0.12), (1, 5), 0.2),
    ],
)
def test_two_motors_swing_a_quarter_period_apart_as_far_as_closes(robot, motors, turns):
    linkage = FiveBarLinkage(robot, motors)
    run = study(linkage, [1.5, -3.0], drive="swing", turns=turns)
    start = np.array([linkage.home[k] for k in motors])
    arm = run.q - start
    amplitude = np.hypot(*arm[0])
    assert arm[0] == pytest.approx([0.0, amplitude], abs=1e-12)
    assert np.hypot(*arm.T) == pytest.approx(amplitude, rel=1e-12)
    assert np.stack(run.motion.q_dot, axis=-1) == pytest.approx(
        3.0 * arm[:, ::-1] * (1, -1), rel=1e-12, abs=1e-12
    )
    assert np.stack(run.motion.q_ddot, axis=-1) == pytest.approx(-9.0 * arm, rel=1e-12, abs=1e-12)
    halved = round(math.log2(0.4 / amplitude))
    assert amplitude == pytest.approx(0.4 / 2**halved, rel=1e-12) and 0 <= halved < 5
    wider = move(linkage, start + 2 * arm, unreachable="nan").position("joint 3")
    assert halved == 0 or np.isnan(wider).any()


@pytest.mark.parametrize(
    "options, message",
    [
        (dict(speed=0.0), "speed must be finite and not 0"),
        (dict(speed=math.nan), "speed must be finite"),
        (dict(turns=-1), "turns must be finite and > 0"),
        (dict(samples=1), "at least 3 samples"),
        (dict(drive="jump"), "no drive 'jump'; the known ones are turn, until-lock, swing"),
        (dict(branch=3), r"branch must be \+1 or -1"),
        (dict(linkage=FiveBarLinkage(), between=(0.1, 0.2)), "between is for linkages with one"),
    ],
)
def test_studies_that_cannot_be(options, message):
    with pytest.raises(ValueError, match=message):
        study(**{"linkage": TABLE_2} | options)


def test_a_parallelogram_stays_one():
    run = study(FourBar(2, 1, 2, 1), turns=2)
    assert run["rocker.angle"] == pytest.approx(run["crank.angle"], abs=1e-12)
    assert run["coupler.angle"] == pytest.approx(0, abs=1e-12)
    crossed = study(FourBar(2, 1, 2, 1), turns=2, branch=-1)
    assert (
        np.ptp(crossed["rocker.angle"]) > 2 * np.pi
        and (crossed["rocker.rate"] * crossed["crank.rate"]).max() < 0
    )


def test_singular_samples_name_their_angle():
    with pytest.raises(fb.SingularityError, match="in line .*; the first at 0.375 s, 180 deg"):
        study(
            FourBar(2, 1, 2, 1), start=0.25 * np.pi, turns=1, samples=9, quantities=["rocker.rate"]
        )


@pytest.mark.parametrize("damage", ["", "# fivebar linkage study, SI units: {}\n", "t,x\n1,2\n"])
def test_files_that_are_no_study(damage, tmp_path):
    (tmp_path / "x.csv").write_text(damage, encoding="utf-8")
    with pytest.raises(ValueError, match="x.csv, line 1: not a file written by Study.to_csv"):
        Study.from_csv(tmp_path / "x.csv")


def test_damaged_studies_name_the_line(tmp_path):
    study(TABLE_2, samples=5).to_csv(tmp_path / "x.csv")
    lines = (tmp_path / "x.csv").read_text("utf-8").splitlines()
    for changed, message in (
        (
            [*lines[:3], lines[3].replace(",", ",x", 1), *lines[4:]],
            r"line 4: q \(rad\) must be a number, not 'x1.57",
        ),
        ([*lines[:3], lines[3] + ",1", *lines[4:]], "line 4: 37 cells, where the header has 36"),
        (
            [lines[0], lines[1].replace("(s)", "(ms)"), *lines[2:]],
            r"line 2: no column t \(s\); found t \(ms\), q ",
        ),
        (lines[:-1], "4 rows, where its first line makes 5"),
    ):
        (tmp_path / "x.csv").write_text("\n".join(changed), encoding="utf-8")
        with pytest.raises(ValueError, match=message):
            Study.from_csv(tmp_path / "x.csv")


@pytest.mark.every(4)
@pytest.mark.parametrize("name", STUDIES)
def test_pictures_and_animations(name, tmp_path):
    linkage, options = STUDIES[name]
    run = study(linkage, **{"speed": 5.0} | options)
    figure = run.plot()
    assert len(figure.axes) == 5 if "torque" in run.columns else 4
    assert figure.axes[1].lines[0].get_xdata() == pytest.approx(run.t)
    run.animate(tmp_path / "motion.html")
    assert f"<title>{linkage.title}</title>" in (tmp_path / "motion.html").read_text("utf-8")


def test_inversions_differ():
    """Held at another link the same bars move otherwise: no two inversions trace the same path."""
    for group in (
        ("four-bar", "crank held", "coupler held", "rocker held"),
        [n for n in STUDIES if "slider" in n],
    ):
        sizes = set()
        for name in group:
            linkage, options = STUDIES[name]
            run = study(linkage, speed=5.0, **options)
            points = run.points()
            sizes.add(tuple(np.round(np.ptp(points, axis=(0, 1)), 4)))
            moving = np.ptp(points, axis=0).max(axis=1) > 1e-9
            still = {name for name, moves in zip(run.motion.points, moving) if not moves}
            assert set(run.motion.chain.grounded) <= still
        assert len(sizes) == 4


def test_coupler_curves_in_one_figure_by_colour():
    curves = [
        c
        for b in (0.15, 0.16, 0.17)
        for c in coupler_curves(FourBar(0.2, 0.06, b, 0.14), f"coupler {b} m")
    ]
    figure = coupler_curve_figure(curves, [TABLE_2])
    shown = [line for line in figure.axes[0].lines if line.get_marker() == "None"]
    assert len(shown) == 6 and len({line.get_color() for line in shown}) == 3
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert labels == ["coupler 0.15 m", "coupler 0.16 m", "coupler 0.17 m"]
    locus = coupler_curve_figure(
        type_2_curves(fb.FiveBar())
    )  # the robot's Type 2, by the same function
    labels = [text.get_text() for text in locus.axes[0].get_legend().get_texts()]
    assert labels == ["Type 2, stretched", "Type 2, elbows coincide"]
    with pytest.raises(ValueError, match="no curves"):
        coupler_curve_figure(())


@pytest.mark.parametrize(
    "sides",
    [
        (0.1265315, 0.12577337, 0.15572584, 0.15812294),
        (0.27815589, 0.28707014, 0.16104816, 0.13944719),
        (0.2, 0.12, 0.16, 0.14),
    ],
)
def test_curves_of_locking_linkages_are_closed_and_say_where_they_lock(sides):
    """Rounding left some of these open by eight of their steps."""
    curves = coupler_curves(FourBar(*sides, point=(0.05, 0.03)))
    for curve in curves:
        assert len(curve.points) == 1441 and len(curve.locks) == 2
        assert np.hypot(*(curve.points[0] - curve.points[-1])) < 1e-5 * sides[0]
    (axes,) = coupler_curve_figure(curves).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["coupler curve", "the mechanism locks"]
    assert not any(len(curve.locks) for curve in type_2_curves(fb.FiveBar()))


def run_cli(argv, monkeypatch):
    parser = argparse.ArgumentParser(prog="fivebar")
    linkage_cli.add_parsers(parser.add_subparsers(dest="command", required=True))
    monkeypatch.setattr(cli, "_parser", lambda asked: parser)
    return cli.main(["linkage", *argv])


@pytest.mark.parametrize(
    "argv", [["slider-crank", "0.05", "0.15"], ["slider-crank", "7e-6", "2e-5"], ["six-bar-press"]]
)
def test_cli_shows_no_rounding_error(argv, monkeypatch, capsys, tmp_path):
    """Nothing below 1e-9 of the largest quantity of its unit: along its guide a slider has y = 0."""
    assert run_cli([*argv, "--csv", str(tmp_path / "a.csv")], monkeypatch) == 0
    lines = re.findall(r"(?m)^  (\S+) +(\S+) +(\S+) (.*)$", capsys.readouterr().out)
    assert len(lines) > 15
    for _, low, high, own in lines:
        size = max(abs(float(x)) for _, *ends, other in lines for x in ends if other == own)
        assert all(x == 0 or abs(x) > 1e-9 * size for x in map(float, (low, high)))


def test_cli_verdict_alone(monkeypatch, capsys):
    assert run_cli(["four-bar", "0.2", "0.06", "0.16", "0.14"], monkeypatch) == 0
    printed = capsys.readouterr()
    assert (
        printed.err == ""
        and printed.out.startswith("four-bar, ground 0.2 m")
        and "crank-rocker" in printed.out
    )
    assert run_cli(["six-bar-press", "printed"], monkeypatch) == 0
    assert "locks at 336.825007 deg after 1.471542 s" in capsys.readouterr().out
    assert run_cli(["six-bar-press", "--l2", "0.3"], monkeypatch) == 0
    assert "source of the set: as repaired, but for l2\n" in capsys.readouterr().out
    assert run_cli(["slider-crank", "0.05", "0.15", "--held", "rod", "--json"], monkeypatch) == 0
    assert "oscillating cylinder" in json.loads(capsys.readouterr().out)["verdict"][0]


@pytest.mark.deep
def test_cli_study_with_files(monkeypatch, capsys, tmp_path):
    files = [str(tmp_path / name) for name in ("a.png", "a.csv", "a.html")]
    options = [
        "--plot",
        files[0],
        "--csv",
        files[1],
        "--html",
        files[2],
        "--speed",
        "3",
        "--turns",
        "2",
        "--branch",
        "-1",
    ]
    assert (
        run_cli(
            ["four-bar", "0.2", "0.06", "0.16", "0.14", "--point", "0.1", "0.05", *options],
            monkeypatch,
        )
        == 0
    )
    printed = capsys.readouterr()
    assert (
        printed.err == ""
        and printed.out.splitlines()[-3:] == files
        and "rocker.rate" in printed.out
    )
    run = Study.from_csv(files[1])
    assert run.linkage.point == (0.1, 0.05) and run.t[-1] == pytest.approx(4 * np.pi / 3)
    assert run["rocker.angle"].max() < 0  # the other branch
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG" and "MeshCat" in (
        tmp_path / "a.html"
    ).read_text("utf-8")


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "argv",
    [
        ["slider-crank", "0.05", "0.15", "--offset", "0.02", "--held", "crank"],
        ["six-bar-press", "--load", "1e5", "--no-gravity"],
        ["six-bar-press", "printed", "--drive", "until-lock"],
        ["six-bar-press", "--l2", "0.06", "--branch", "1", "-1"],
        ["five-bar", "--motors", "2", "4", "--l11", "0.1"],
        *(["straight-line", name] for name in ("evans", "chebyshev", "watt", "hoeken", "roberts")),
    ],
)
def test_cli_studies(argv, monkeypatch, capsys, tmp_path):
    assert run_cli([*argv, "--csv", str(tmp_path / "a.csv"), "--json"], monkeypatch) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["files"] == [str(tmp_path / "a.csv")] and data["verdict"] and data["ranges"]
    run = Study.from_csv(tmp_path / "a.csv")
    if "straight-line" in argv:  # the whole usual stroke, but where its end is a lock
        mechanism = straight_line(argv[1])
        along = (
            move(mechanism.linkage, run.q, branch=mechanism.branch).position("M")
            - mechanism.through
        ) @ mechanism.direction
        whole = np.ptp(
            move(mechanism.linkage, np.array(mechanism.stroke), branch=mechanism.branch).position(
                "M"
            ),
            axis=0,
        ).max()
        assert np.ptp(along) > 0.95 * whole
    if "--load" in argv:
        assert run["torque"].max() == pytest.approx(5364, abs=2)


@pytest.mark.parametrize(
    "argv, code, message",
    [
        (
            ["four-bar", "0.1", "0.1", "0.1", "0.5"],
            2,
            "this four-bar can never close: rocker = 0.5 m",
        ),
        (["four-bar", "1", "0", "1", "1"], 2, "crank must be finite and > 0"),
        (["four-bar", "0.2", "0.06", "0.16", "0.14", "--held", "bar"], 2, "held must be one of"),
        (
            ["four-bar", "0.2", "0.06", "0.16", "0.14", "--speed", "0", "--csv", "x.csv"],
            2,
            "--speed must be finite and not 0",
        ),
        (
            ["four-bar", "0.2", "0.06", "0.16", "0.14", "--turns", "-1", "--csv", "x.csv"],
            2,
            "--turns must be finite and > 0",
        ),
        (
            ["four-bar", "0.2", "0.06", "0.16", "0.14", "--plot", "a.gif"],
            2,
            "--plot must end in .png, .svg or .pdf",
        ),
        (
            ["straight-line", "peaucellier"],
            2,
            "the known ones are evans, chebyshev, watt, hoeken, roberts",
        ),
        (["six-bar-press", "mended"], 2, "no press 'mended'; the known ones are repaired, printed"),
        (["five-bar", "--motors", "1", "6"], 2, "motors must be two of the joints 1 to 5"),
        (
            ["six-bar-press", "printed", "--csv", "x.csv"],
            1,
            "it locks at 336.825007 deg after 1.47154173 s",
        ),
        (
            ["four-bar", "0.2", "0.06", "0.16", "0.14", "--csv", "/dev/null/x"],
            2,
            "/dev/null: File exists",
        ),
    ],
)
def test_cli_failures_are_one_line(argv, code, message, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert run_cli(argv, monkeypatch) == code
    printed = capsys.readouterr()
    assert (
        printed.err.startswith("fivebar: ")
        and message in printed.err
        and printed.err.count("\n") == 1
    )
    if code == 1:  # the verdict comes first, whatever happens then
        assert "Grashof" in printed.out or "crank-rocker" in printed.out
