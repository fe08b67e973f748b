"""Mistakes in measured data are refused, with a figure and questions, and good data never are."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.estimation.calibration.measured_robot import FRAME, LENGTHS
from fivebar.estimation.calibration.rows import rows_of
from tests.helpers.twins import LAB, measured, poses, seen, twin

GEOMETRY = (*LENGTHS, "offset1", "offset2")
FREE = (*GEOMETRY, *FRAME[:3])
COUNTS = 4096 / (2 * np.pi)


def data_of(seed, n=20, sigma=1e-4, modes_noted=False):
    rng = np.random.default_rng(seed)
    true = twin(rng, LAB, FREE) | dict(x0=0.3, y0=-0.2, turn=0.4)
    q, points, _, working = seen(true, poses(true, n, rng))
    points = points + sigma * rng.standard_normal(points.shape)
    data = dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])
    return true, data | dict(
        working1=working[:, 0].copy(), working2=working[:, 1].copy()
    ) if modes_noted else data


def degrees(data, *names):
    return data | {name: np.degrees(data[name]) for name in names}


COLUMNS = {
    "q1 in degrees": lambda data: degrees(data, "q1"),
    "q2 in degrees": lambda data: degrees(data, "q2"),
    "q1 and q2 in degrees": lambda data: degrees(data, "q1", "q2"),
    "q1 and q2 swapped": lambda data: data | dict(q1=data["q2"], q2=data["q1"]),
    "q1 with the wrong sign": lambda data: data | dict(q1=-data["q1"]),
    "x in mm": lambda data: data | dict(x=1e3 * data["x"]),
    "y in mm": lambda data: data | dict(y=1e3 * data["y"]),
    "x and y in mm": lambda data: data | dict(x=1e3 * data["x"], y=1e3 * data["y"]),
    "x and y in m, not in mm": lambda data: data | dict(x=data["x"] / 1e3, y=data["y"] / 1e3),
    "x and y swapped": lambda data: data | dict(x=data["y"], y=data["x"]),
    "q1 and q2 in counts, 4096 a turn": lambda data: (
        data | dict(q1=COUNTS * data["q1"], q2=COUNTS * data["q2"])
    ),
}


UNITS = {name for name in COLUMNS if " in " in name}
REFUSED = "x, y move by .* mm for each rad of q1, q2, and bars of 90 mm cannot. Are q1, q2 in"


@pytest.mark.parametrize("what", sorted(UNITS))
@pytest.mark.parametrize("sigma", [None, 1e-4])
def test_a_wrong_unit_is_asked_about_by_what_bars_cannot_do(what, sigma):
    """Also where a robot of 0.09 mm would fit to sigma."""
    _, data = data_of(1)
    with pytest.raises(ValueError, match=REFUSED):
        fb.calibrate(LAB, COLUMNS[what](data), FREE, sigma=sigma)


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "what", [name for name in COLUMNS if name not in UNITS and name != "q1 and q2 swapped"]
)
def test_a_wrong_column_is_asked_about(what):
    _, data = data_of(1)
    with pytest.raises(ValueError, match="no robot with these unknowns fits|does not close"):
        fb.calibrate(LAB, COLUMNS[what](data), FREE)


def test_exchanged_joints_are_those_of_a_robot_that_is_turned():
    """A frame that is unknown may lie so that the left leg is on the right."""
    true, data = data_of(1)
    found = fb.calibrate(LAB, COLUMNS["q1 and q2 swapped"](data), FREE)
    assert found.values["l11"] == pytest.approx(true["l21"], abs=5 * found.sd["l11"])
    assert abs(found.values["turn"] - true["turn"]) == pytest.approx(np.pi, abs=0.05)
    with pytest.raises(ValueError, match="no robot with these unknowns fits|does not close"):
        fb.calibrate(LAB, COLUMNS["q1 and q2 swapped"](data), GEOMETRY)


@pytest.mark.parametrize("sigma", [1e-2, 0.1])
def test_a_sigma_near_the_size_of_a_bar_is_refused(sigma):
    """To such a sigma fits any robot."""
    _, data = data_of(1)
    with pytest.raises(ValueError, match="% of a bar, and to that any robot fits. .* not in mm"):
        fb.calibrate(LAB, data, FREE, sigma=sigma)
    assert fb.calibrate(LAB, data, FREE, sigma=sigma, mistakes="keep").rms < 1.2e-4


def test_angles_in_radians_that_are_said_to_be_degrees_are_refused():
    _, data = data_of(1)
    units = {"q1": "deg", "q2": "deg"}
    with pytest.raises(ValueError, match=REFUSED):
        fb.calibrate(LAB, data, FREE, units=units)


def test_modes_that_are_noted_wrong():
    _, data = data_of(4, modes_noted=True)
    assert fb.calibrate(LAB, data, FREE).notes == ()
    data["working1"][3] *= -1
    with pytest.raises(ValueError, match="^row 4: the fitted robot is in other modes there than"):
        fb.calibrate(LAB, data, FREE)


@pytest.mark.deep
def test_garbage_is_called_so():
    rng = np.random.default_rng(11)
    garbage = {name: rng.standard_normal(10) for name in ("q1", "q2", "x", "y")}
    with pytest.raises(ValueError, match="no robot with these unknowns fits"):
        fb.calibrate(LAB, garbage, GEOMETRY)
    near = measured(twin(rng, LAB, LENGTHS, spread=6.0), 12, rng, 3e-3)
    assert "THE MISSES ARE LARGE" in str(fb.calibrate(LAB, near, LENGTHS))


@pytest.mark.deep
def test_good_data_are_never_accused():
    """Noise from 1 um to 1 mm, few rows and many, off by much: no mistake is seen where none is."""
    rng = np.random.default_rng(6)
    for k in range(24):
        unknown = (LENGTHS, GEOMETRY, FREE)[k % 3]
        true = twin(rng, LAB, unknown, spread=4.0)
        sigma = 10 ** rng.uniform(-6, -3)
        found = fb.calibrate(LAB, measured(true, int(rng.integers(8, 40)), rng, sigma), unknown)
        assert found.notes == () and found.rms < 1.5 * sigma


BUILT = fb.FiveBar(0.0908, 0.0893, 0.0895, 0.0911, 0.1172)


def read_between(seed, n, low, high, sigma=2e-4):
    """Rows of a robot as built, with offsets, at readings drawn between two pairs of angles."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(low, high, (4 * n, 2))
    points = fb.dgm(BUILT, q + (0.012, -0.02), unreachable="nan").xi
    closes = np.flatnonzero(np.isfinite(points[:, 0]))[:n]
    q, points = q[closes], points[closes] + sigma * rng.standard_normal((n, 2))
    return dict(q1=q[:, 0], q2=q[:, 1], x=points[:, 0], y=points[:, 1])


@pytest.mark.parametrize(
    ("n", "low", "high", "seeds"),
    [
        (5, (0.9, 0.9), (2.0, 2.2), range(4)),
        (30, (1.4, 1.5), (1.5, 1.6), range(2)),
        (20, (1.2, 1.9), (1.2, 1.9), [0]),
        pytest.param(5, (0.9, 0.9), (2.0, 2.2), range(4, 60), marks=pytest.mark.deep),
        pytest.param(30, (1.4, 1.5), (1.5, 1.6), range(2, 20), marks=pytest.mark.deep),
        pytest.param(20, (1.2, 1.9), (1.2, 1.9), range(2, 7), marks=pytest.mark.deep),
    ],
)
def test_few_rows_and_patches_are_never_accused(n, low, high, seeds):
    """Where so little is measured, a robot with other columns often fits a little better."""
    for seed in seeds:
        data = read_between(seed, n, low, high)
        assert fb.calibrate(LAB, data).rms < 4e-4


def test_rows_of_one_pose_ask_for_more_where_what_fits_is_no_robot():
    with pytest.raises(ValueError, match="no robot has the lengths .* Measure more rows, or say"):
        fb.calibrate(LAB, read_between(1, 20, (1.2, 1.9), (1.2, 1.9)))


def test_rows_that_spoil_the_fit_are_named():
    """A point typed wrong, one typed twice, one with the wrong sign."""
    data = read_between(2, 30, (0.9, 0.9), (2.0, 2.2))
    data["x"][7] += 0.02
    data["x"][15], data["y"][15] = data["x"][16], data["y"][16]
    data["y"][22] *= -1
    with pytest.raises(ValueError, match="row 8, row 16, row 23: off all other rows") as refused:
        fb.calibrate(LAB, data)
    assert "--loss cauchy" in str(refused.value)
    right = {name: np.delete(column, [7, 15, 22]) for name, column in data.items()}
    assert fb.calibrate(LAB, right).rms < 3e-4


@pytest.mark.deep
def test_a_measuring_frame_that_nobody_asked_for_is_asked_about():
    data = read_between(2, 30, (0.9, 0.9), (2.0, 2.2))
    xi = np.exp(0.3j) * (data["x"] + 1j * data["y"]) + 0.2 - 0.05j
    data |= dict(x=xi.real, y=xi.imag)
    with pytest.raises(ValueError, match="x0, y0, turn"):
        fb.calibrate(LAB, data)
    found = fb.calibrate(LAB, data, FREE)
    assert found.values["turn"] == pytest.approx(0.3, abs=0.05) and found.rms < 3e-4


def test_of_many_rows_a_message_names_the_first():
    empty = {name: np.zeros(50) for name in ("q1", "q2")}
    with pytest.raises(ValueError, match="without x, y or distance: all 50 rows. Say"):
        fb.calibrate(LAB, empty | dict(x=np.full(50, np.nan)))
    rows = rows_of(empty | dict(x=np.where(np.arange(50) < 30, np.nan, 0.1)))
    assert rows.notes[0].endswith("row 12 and 18 more") and len(rows) == 20


def test_an_outlier_that_is_no_known_mistake_is_an_outlier():
    _, data = data_of(7)
    data["x"][3] += 0.004
    found = fb.calibrate(LAB, data, FREE)
    assert list(found.outliers) == ["row 4"] and found.outliers["row 4"] < 1e-6
    assert "off all other rows: row 4 (p = " in str(found) and "leave them out" in str(found)
    assert found.advised_priors == {}  # it is rough by this row, not by noise


def a_file(path, mistakes=True):
    """A CSV as people have it, with a row in another mode and a column in degrees; or without these mistakes."""
    _, data = data_of(8, 24, modes_noted=True)
    if mistakes:
        data["q2"] = np.degrees(data["q2"])
        data["working1"][6], data["working2"][6] = -data["working1"][6], -data["working2"][6]
    rows = zip(*(data[name] for name in ("q1", "q2", "x", "y", "working1", "working2")))
    lines = [
        f"{a:.6f};{b:.6f};{1e3 * x:.4f};{1e3 * y:.4f};{v:+d};{w:+d}" for a, b, x, y, v, w in rows
    ]
    head = "# camera, Tuesday\nq1;q2;x (mm);y (mm);working1;working2\n"
    path.write_text(head + "\n".join(lines).replace(".", ","), encoding="utf-8")
    return str(path)


@pytest.mark.deep
def test_the_command_refuses_one_mistake_and_then_the_other_and_gives_lengths(tmp_path, capsys):
    wrong, right = a_file(tmp_path / "wrong.csv"), a_file(tmp_path / "right.csv", mistakes=False)
    options = ["--unknown", *FREE, "--sigma", "1e-4"]
    assert main(["calibrate", wrong, *options]) == 1
    printed = capsys.readouterr()
    assert printed.out == "" and "x, y move by" in printed.err and "--mistakes keep" in printed.err
    assert main(["calibrate", wrong, *options, "--units", "q2=deg"]) == 1
    assert "line 9: the fitted robot is in other modes" in capsys.readouterr().err
    out = tmp_path / "out"
    command = ["calibrate", right, "--unknown", *FREE, "scale", "--sigma", "1e-4"]
    assert main([*command, "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "l11      mm" in text and "the model fits to the sigma given" in text
    assert "l11, l12, l21, l22, d and scale only together: nothing measured changes if" in text
    assert {path.name for path in out.iterdir()} == {
        "calibration.png",
        "calibration.json",
        "calibration.txt",
        "robot.toml",
    }


@pytest.mark.parametrize(
    "words, code, message",
    [
        (["--unknown", "l13"], 2, "--unknown: no 'l13'; the known ones are l11"),
        (["--start", "l13=1"], 2, "--start: no 'l13'"),
        (["--start", "x0"], 2, "--start must be NAME=VALUE"),
        (["--start", "x0=a"], 2, "--start: 'a' is not a number"),
        (["--robot", "biglide"], 2, "calibrate refuses a robot with kind ="),
        (["--units", "furlong"], 2, "--units: furlong: known are"),
        (["--working", "1", "1"], 2, "--working is of a test drawing: give --from-drawing"),
    ],
)
def test_wrong_commands(tmp_path, capsys, words, code, message):
    assert main(["calibrate", a_file(tmp_path / "a.csv", mistakes=False), *words]) == code
    assert message in capsys.readouterr().err


OWN = fb.FiveBar(0.2, 0.23, 0.2, 0.23, 0.08)
TURNED = "offset1", "offset2"


def far_data(seed, rows, offsets):
    """Exact points of OWN whose motors' zeros lie anywhere, in one mode that is noted."""
    rng = np.random.default_rng(seed)
    working = tuple(rng.choice((-1, 1), 2).tolist())
    xi = []
    while len(xi) < rows:
        point = rng.uniform((-0.15, 0.18), (0.15, 0.34))
        pose = fb.igm(OWN, point, working, unreachable="nan")
        if np.isfinite(pose.q).all() and min(abs(pose.det_A), *np.abs(pose.sines)) > 0.2:
            xi.append(point)
    x, y = np.transpose(xi)
    q1, q2 = (fb.igm(OWN, xi, working).q - offsets).T
    noted = {f"working{leg + 1}": np.full(rows, working[leg]) for leg in (0, 1)}
    return dict(q1=q1, q2=q2, x=x, y=y), noted


@pytest.mark.every(6)
@pytest.mark.parametrize("noted", [False, True])
@pytest.mark.parametrize(
    "change",
    [
        lambda data: data | dict(x=1e3 * data["x"], y=1e3 * data["y"]),
        lambda data: degrees(data, "q1", "q2"),
        lambda data: data | dict(q1=-data["q1"]),
    ],
)
def test_a_mistake_is_refused_wherever_the_motors_zeros_are(change, noted):
    offsets = (2.46, 0.68) if noted else (-2.0, 1.3)
    data, modes = far_data(1, 6, np.array(offsets))
    with pytest.raises(ValueError, match="Are q1, q2 in degrees"):
        fb.calibrate(OWN, change(data) | (modes if noted else {}), TURNED)
    data |= modes if noted else {}
    assert fb.calibrate(OWN, data, TURNED).rms < 1e-9


@pytest.mark.deep
def test_misses_of_another_size_than_a_measurement_are_no_calibration(tmp_path, capsys):
    data, _ = far_data(4, 8, np.array([0.1, -0.2]))
    data["x"] = data["x"][::-1]  # no change of a column explains it
    assert fb.calibrate(OWN, data, TURNED, mistakes="keep").rms > 0.01
    table, robot = tmp_path / "data.csv", tmp_path / "robot.toml"
    np.savetxt(table, np.transpose([*data.values()]), "%.6f", ",", header="q1,q2,x,y", comments="")
    OWN.save(robot)
    arguments = [str(table), "--robot", str(robot), "--unknown", *TURNED, "--out", str(tmp_path)]
    assert main(["calibrate", *arguments]) != 0
    message = capsys.readouterr().err
    assert "of a bar. Are q1, q2 in degrees or rad" in message and "--mistakes keep" in message
    assert not (tmp_path / "calibration.json").exists()


def test_few_rows_say_that_they_check_nothing_and_exact_ones_have_no_outlier():
    data, modes = far_data(5, 6, np.array([0.1, -0.2]))
    found = fb.calibrate(OWN, data | modes, TURNED)
    assert not found.outliers and not found.notes
    two = {name: column[:2] for name, column in (data | modes).items()}
    (note,) = fb.calibrate(OWN, two, TURNED).notes
    assert note == "so few rows do not show a wrong unit, sign or mode: 4 rows or more do"
    one = str(fb.calibrate(OWN, {name: column[:1] for name, column in two.items()}, TURNED))
    assert one.startswith("1 row with 2 coordinates") and "left out" not in one
    lines = str(fb.calibrate(OWN, two)).splitlines()
    told = next(k for k, line in enumerate(lines) if line.startswith("not told apart"))
    assert lines[told - 1].startswith("- no deviation is known")
