"""Numbers with units in robot files and options, and lengths that nobody can mean."""

import math
import tomllib
import warnings
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fivebar as fb
from fivebar.base import units
from fivebar.base.units import number_in
from fivebar.cli import main
from fivebar.models import values

# Definitions: the international inch and the standard acceleration of gravity are exact.
SAID = [
    ("80 mm", units.METRES, 0.08),
    ("118mm", units.METRES, 0.118),
    ("0.3 in", units.METRES, 0.00762),
    ('0.3"', units.METRES, 0.00762),
    ("-2.5e1 µm", units.METRES, -25e-6),
    ("90 deg", units.RADIANS, math.pi / 2),
    ("90°", units.RADIANS, math.pi / 2),
    ("0.25 turns", units.RADIANS, math.pi / 2),
    ("1.5 min", units.SECONDS, 90.0),
    ("50 mN m", units.NEWTON_METRES, 0.05),
    ("50 mN·m", units.NEWTON_METRES, 0.05),
    ("5 N cm", units.NEWTON_METRES, 0.05),
    ("10 kgf cm", units.NEWTON_METRES, 0.980665),
    ("60 rpm", units.RADIANS_PER_SECOND, 2 * math.pi),
    ("12 g cm^2", units.INERTIAS, 1.2e-6),
    ("12 g·cm²", units.INERTIAS, 1.2e-6),
    ("250 g", units.KILOGRAMS, 0.25),
    ("500 mm/s2", units.ACCELERATIONS, 0.5),
    ("500 mm/s²", units.ACCELERATIONS, 0.5),
    ("1 N m/deg", units.STIFFNESSES, 180 / math.pi),
    ("3 mN m s", units.DAMPINGS, 0.003),
    ("2.5", units.METRES, 2.5),
    (2, units.METRES, 2.0),
    ("7 m", units.METRES, 7.0),
    ("1e3", units.NO_UNIT, 1000.0),
]


@pytest.mark.parametrize("text, known, value", SAID)
def test_a_number_with_a_unit(text, known, value):
    assert number_in(text, known) == pytest.approx(value, rel=1e-15, abs=0)


@given(st.integers(-9999, 9999), st.sampled_from(["mm", "cm", "um"]))
def test_metric_lengths_are_exact_to_the_last_digit(number, unit):
    power = {"mm": -3, "cm": -2, "um": -6}[unit]
    assert number_in(f"{number} {unit}", units.METRES) == float(Decimal(number).scaleb(power))


def test_each_unit_is_known_by_its_name_and_is_in_one_table():
    for table in units.ALL:
        assert next(iter(table.values())) == 1.0
        for unit, size in table.items():
            assert units.unit_named(unit) == unit
            assert number_in(f"3 {unit}", table) == pytest.approx(3 * size, rel=1e-15)
    assert len(set().union(*units.ALL)) == sum(map(len, units.ALL))


@pytest.mark.parametrize(
    "text, known, message",
    [
        ("x", units.METRES, "'x' is not a number"),
        ("1.2.3 mm", units.METRES, "is not a number"),
        ("nan", units.METRES, "'nan' is not a number"),
        ("nan mm", units.METRES, "'nan mm' is not a number"),
        ("0,45 m", units.METRES, "'0,45 m' is not a number, as 1.5"),
        ("1 1/2 in", units.METRES, "'1 1/2 in' is not a number, as 1.5"),
        (math.nan, units.NO_UNIT, "nan is not a number"),
        (None, units.METRES, "None is not a number"),
        ("80 deg", units.METRES, "its unit must be m, mm, cm, um, in"),
        ("80 mm", units.NO_UNIT, "its unit must be none"),
        ("80", units.METRES, '80 m: did you mean 80 mm? Write the unit, as "80 mm" or "80 m"'),
        (-3.5, units.METRES, "-3.5 m: did you mean -3.5 mm?"),
    ],
)
def test_what_is_refused(text, known, message):
    with pytest.raises(ValueError) as error:
        number_in(text, known)
    assert message in str(error.value)


ROBOT = """
l11 = "80 mm"
l12 = "0.1 m"
l21 = "3 in"
l22 = 0.1
d = "118mm"
zz1 = "20000 g cm²"
zz2 = "20 kg cm^2"
m = "500 g"
fv1 = "2 mN m s/rad"
fs1 = "5 mN m"
mx11 = "10 g mm"
gravity = [0, "-9810 mm/s²"]
[readings]
offset = ["90 deg", 0.1]
ratio = ["1 deg", "-1 deg"]
[frame]
shift = ["10 mm", "1 in"]
turn = "45 deg"
[tool]
leg = 1
along = "30 mm"
[constraints]
torque = "50 mN m"
joint_speed = ["60 rpm", 5]
acceleration = "500 mm/s²"
joints = [["0 deg", "180 deg"], []]
half_planes = [[0, 10, "20 mm"]]
region = [["-20 cm", 0], ["20 cm", 0], [0, "30 cm"]]
clearance = "5 mm"
motors = [{stall_torque = "10 kg cm", no_load_speed = "60 rpm", gear = 10}, "ax-12a"]
collisions = {widths = "8 mm", posts = "3 mm"}
"""
IN_SI = """
l11 = 0.08
l12 = 0.1
l21 = 0.0762
l22 = 0.1
d = 0.118
zz1 = 2e-3
zz2 = 2e-3
m = 0.5
fv1 = 2e-3
fs1 = 5e-3
mx11 = 1e-5
gravity = [0, -9.81]
[readings]
offset = [1.5707963267948966, 0.1]
ratio = [0.017453292519943295, -0.017453292519943295]
[frame]
shift = [0.01, 0.0254]
turn = 0.7853981633974483
[tool]
leg = 1
along = 0.03
[constraints]
torque = 0.05
joint_speed = [6.283185307179586, 5]
acceleration = 0.5
joints = [[0, 3.141592653589793], []]
half_planes = [[0, 10, 0.02]]
region = [[-0.2, 0], [0.2, 0], [0, 0.3]]
clearance = 0.005
motors = [{stall_torque = 0.980665, no_load_speed = 6.283185307179586, gear = 10}, "ax-12a"]
collisions = {widths = 0.008, posts = 0.003}
"""


def test_a_robot_file_with_units(tmp_path):
    with_units, in_si = tmp_path / "units.toml", tmp_path / "si.toml"
    with_units.write_text(ROBOT, encoding="utf-8")
    in_si.write_text(IN_SI, encoding="utf-8")
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    fb.load_machine(with_units).save(first)
    fb.load_machine(in_si).save(second)
    numbers = [tomllib.loads(path.read_text("utf-8")) for path in (first, second)]
    assert _close(*numbers)


def _close(one, other):
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_close(one[k], other[k]) for k in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_close, one, other))
    return one == other if isinstance(one, str) else math.isclose(one, other, rel_tol=1e-15)


def test_of_a_biglide_joints_are_lengths_and_efforts_forces(tmp_path):
    path = tmp_path / "biglide.toml"
    path.write_text(
        'kind = "biglide"\nmf1 = "800 g"\nfs1 = "500 mN"\n[readings]\noffset = ["5 mm", 0]\n'
        '[constraints]\njoints = [["-10 cm", "10 cm"], []]\ntorque = "20 N"\n',
        encoding="utf-8",
    )
    machine = fb.load_machine(path)
    assert (machine.robot.mf1, machine.robot.fs1, machine.offset) == (0.8, 0.5, (0.005, 0.0))
    assert machine.constraints.joints == ((-0.1, 0.1), None)
    assert machine.constraints.torque == (20.0, 20.0)
    path.write_text('kind = "biglide"\nfs1 = "5 mN m"\n', encoding="utf-8")
    with pytest.raises(ValueError, match="fs1: '5 mN m': its unit must be N, mN"):
        fb.load_machine(path)


@pytest.mark.parametrize(
    "line, message",
    [
        ("l11 = 80", "l11: 80 m: did you mean 80 mm"),
        ("d = 118", "d: 118 m: did you mean 118 mm"),
        ("l11 = 5e-5", "l11: a bar of 0.05 mm"),
        ('l11 = "80 deg"', "l11: '80 deg': its unit must be m"),
        ("[frame]\nshift = [0, 150]", "shift: 150 m: did you mean 150 mm"),
        ("[tool]\nleg = 1\nalong = 30", "along: 30 m: did you mean 30 mm"),
        ("[tool]\nalong = 0.03", "the table tool needs leg"),
        ("[constraints]\nhalf_planes = [[30, 4, -50]]", "half_planes: -50 m: did you mean -50 mm"),
        ("[constraints]\njoints = [[-45, 225], []]", "joints: -45 rad: did you mean -45 deg"),
        ("[constraints]\nspeed = 100", "speed: 100 m/s: did you mean 100 mm/s"),
        ("[frame]\nturn = 90", "turn: 90 rad: did you mean 90 deg"),
        ("m = 85", "m: 85 kg: did you mean 85 g"),
        ("gravity = [0, -9810]", "gravity: -9810 m/s²: did you mean -9810 mm/s²"),
        ("[constraints]\ntorque = 1200", "torque: 1200 N m: did you mean 1200 mN m"),
        ("[readings]\nratio = [20, -20]", "of a gear of 20 it is 0.05"),
        ("[readings]\noffset = [90, 0]", "offset: 90 rad: did you mean 90 deg"),
        ("[reading]\noffset = [0, 0]", "known ones are links, readings, frame"),
    ],
)
def test_what_nobody_means_without_a_unit_or_by_this_name(tmp_path, line, message):
    path = tmp_path / "robot.toml"
    path.write_text(f"{line}\n", encoding="utf-8")
    with pytest.raises(ValueError) as error:
        fb.load_machine(path)
    assert message in str(error.value) and "robot.toml" in str(error.value)


def test_large_robots_are_written_with_their_unit_and_read_without_a_question(tmp_path):
    path = tmp_path / "large.toml"
    lengths = '"80 m"', '"90 m"', '"80 m"', '"90 m"', '"100 m"'
    names = "l11", "l12", "l21", "l22", "d"
    path.write_text("".join(f"{n} = {v}\n" for n, v in zip(names, lengths)), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        machine = fb.load_machine(path)
        machine = fb.Machine(machine.robot, (20.0, 0.1), frame=fb.Placement((50.0, 0.0), 9.0))
        machine.save(path)
        assert fb.load_machine(path) == machine
    text = path.read_text("utf-8")
    assert machine.robot.l11 == 80.0 and 'l11 = "80.0 m"' in text and '"20.0 rad", 0.1]' in text


def test_a_large_five_bar_warns_once(monkeypatch):
    monkeypatch.setattr(values, "_asked", [])
    with pytest.warns(UserWarning, match="l11: 90 m: did you mean 90 mm. Lengths are in m") as said:
        fb.FiveBar(90, 90, 90, 90, 118)
        fb.FiveBar(91, 90, 90, 90, 118)
    assert len(said) == 1 and said[0].filename == __file__
    monkeypatch.setattr(values, "_asked", [])
    with pytest.warns(UserWarning, match="l1: a bar of 0.05 mm: is it in another unit"):
        fb.Biglide(5e-5, 5e-5, 5e-5)


@pytest.mark.parametrize(
    "ask",
    [
        lambda: fb.sweep("bars", {"l1": [0.09, 90.0], "d": [0.1, 118.0]}),
        lambda: fb.sweep("bars", fb.optimal_design.grid({"l1": (50, 90, 3)})),
        lambda: fb.design("bars", {"l1": (50, 90), "l2": 90}, effort=0.01),
    ],
)
def test_designs_in_millimetres_warn_as_a_robot_does(ask, monkeypatch):
    monkeypatch.setattr(values, "_asked", [])
    with pytest.warns(UserWarning, match="l1: [59]0 m: did you mean [59]0 mm") as said:
        ask()
    assert len(said) == 1 and said[0].filename == __file__
    monkeypatch.setattr(values, "_asked", [])
    fb.sweep("bars", {"r1": [9.0], "r2": [9.0], "r3": [5.0]})  # of no unit


@pytest.mark.parametrize(
    "words, message",
    [
        (["draw", "--example", "--at", "80", "60"], "--at: 80 m: did you mean 80 mm"),
        (["draw", "--example", "--page", "210", "297"], "--page: 210 m: did you mean 210 mm"),
        (["draw", "--example", "--at", "-8deg", "60mm"], "its unit must be m, mm"),
        (["draw", "--example", "--delay", "x"], "--delay: 'x' is not a whole number"),
        (["map", "--l11", "80"], "l11: 80 m: did you mean 80 mm"),
        (["map", "--l11", "x"], "l11: 'x' is not a number"),
        (["map", "--gravity", "0", "9.81mm"], "its unit must be m/s²"),
        (["sweep", "bars", "--grid", "l1=50:200:3"], "--grid: 50 m: did you mean 50 mm"),
        (["sweep", "bars", "--grid", "l1=0.1deg:0.2:3"], "its unit must be m"),
        (["certify", ".", "--tolerance", "l11=5deg"], "--tolerance: '5deg'"),
    ],
)
def test_options_that_are_refused(words, message, capsys):
    try:
        code = main(words)
    except SystemExit as exit_:
        code = exit_.code
    assert code == 2 and message in capsys.readouterr().err


def test_options_with_units(tmp_path, capsys):
    # The same point and lengths in three ways.
    outputs = []
    for words in (
        ["--l11", "0.08", "--from", "0.09", "0.068", "--to", "-0.01", "0.1", "--duration", "1.2"],
        ["--l11", "80mm", "--from", "90mm", "68 mm", "--to", "-10mm", "10cm", "--duration", "1200ms"],
    ):  # fmt: skip
        assert main(["track", *words, "--json", "--out", str(tmp_path)]) == 0
        output = capsys.readouterr().out
        outputs.append([line for line in output.splitlines() if "real_time" not in line])
    assert outputs[0] == outputs[1]
