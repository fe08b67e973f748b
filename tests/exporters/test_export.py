"""`fb.export` and `fivebar export`: texts and files, options, refusals."""

import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.exporters.c import to_c
from fivebar.exporters.header import NAMES
from fivebar.models.machine_code import c_compiler

from ..helpers.needs import need

SIMULATORS = "mjcf", "urdf", "sdf"


@pytest.mark.parametrize("format", SIMULATORS)
@pytest.mark.parametrize(
    "robot", [fb.FiveBar(gravity=(0.0, -9.81), fs1=0.01, fv12=0.1), fb.Biglide()]
)
def test_files_are_xml_and_say_how_they_are_closed(robot, format, tmp_path):
    text = fb.export(robot, format, tmp_path / "robot", name="mine")
    assert (tmp_path / "robot").read_text("utf-8") == text
    root = ET.fromstring(text)
    named = root if format != "sdf" else root.find("world/model")
    assert "mine" in (named.get("name"), named.get("model"))
    assert "close" in text.split("-->")[0]
    assert max(map(len, text.split("-->")[0].splitlines())) <= 124


def test_an_sdf_with_the_loops_joint_is_closed():
    """Where the poses of the links put both tips, from the text alone."""
    robot = fb.FiveBar(l11=0.1, l12=0.13, l21=0.08, l22=0.15, d=0.05)
    start = fb.dgm(robot, (0.4, 0.9))
    root = ET.fromstring(fb.export(robot, "sdf", start=start, closure="joint"))
    tips, places = [], {}
    for link in root.iter("link"):
        x, y, _, _, _, turn = map(float, link.find("pose").text.split())
        places[link.get("name")] = x + 1j * y, np.exp(1j * turn)
    for bar, length in (("distal1", 0.13), ("distal2", 0.15)):
        place, turn = places[bar]
        tips.append(place + length * turn)
    for tip in tips:
        np.testing.assert_allclose((tip.real, tip.imag), start.xi, atol=1e-16)
    for k, elbow in enumerate(start.elbows):
        place, _ = places[f"distal{k + 1}"]
        np.testing.assert_allclose((place.real, place.imag), elbow, atol=1e-16)
    loop = root.find("world/model/joint[@name='tip']")
    assert [loop.find(tag).text for tag in ("parent", "child")] == ["distal1", "distal2"]
    assert loop.find("pose").text.startswith("0.15 ")


def test_a_robot_that_does_not_close_at_0_is_shown_where_it_does():
    robot = fb.FiveBar(l11=0.05, l12=0.06, l21=0.05, l22=0.06, d=0.15)
    text = fb.export(robot, "urdf")
    words = text.split("for instance at ")[1].split(".\n")[0].replace(",", "").split()
    known = {name: float(value) for name, value in zip(words[::3], words[2::3])}
    pose = fb.dgm(robot, (known["q11"], known["q21"]))
    np.testing.assert_array_equal(pose.q_passive, [known["q12"], known["q22"]])


@pytest.mark.parametrize(
    "options, message",
    [
        (
            dict(format="stl"),
            "format must be one of mjcf, urdf, sdf, c, reprapfirmware, ros2_control, gcode, not 'stl'",
        ),
        (dict(format="urdf", step=0.1), "step is no option of urdf, which has start"),
        (dict(format="mjcf", functions=["dgm"]), "functions is no option of mjcf"),
        (dict(format="c", closure="joint"), "closure is no option of c"),
        (dict(format="sdf", closure="weld"), "closure must be one of constraint, joint"),
        (
            dict(format="c", functions=["dgm", "foo"]),
            "no function 'foo'; the known ones are dgm, passive",
        ),
        (dict(format="c", functions=[]), "functions must name at least one of dgm"),
        (
            dict(format="c", name="1st"),
            "name must be a letter, then letters, digits and _, not '1st'",
        ),
        (dict(format="mjcf", name='a"b'), "name must be a letter"),
        (dict(format="mjcf", step=0.0), "step must be finite and > 0"),
        (dict(format="mjcf", step=float("nan")), "step must be finite"),
        (
            dict(format="urdf", start=fb.dgm(fb.FiveBar(d=0.1), (0, 0))),
            "start is a pose of another robot",
        ),
        (
            dict(format="urdf", start=fb.dgm(fb.FiveBar(), np.zeros((3, 2)))),
            "start must be one pose that closes",
        ),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(ValueError) as caught:
        fb.export(fb.FiveBar(), **options)
    assert str(caught.value).startswith(message)


def test_robots_that_no_format_has():
    for robot in (
        replace(fb.FiveBar(), m=casadi.SX.sym("m")),
        replace(fb.FiveBar(), l11=casadi.SX.sym("l")),
    ):
        for format in (*SIMULATORS, "c"):
            with pytest.raises(ValueError, match="symbols as parameters"):
                fb.export(robot, format)
    with pytest.raises(TypeError, match="robot must be a robot, as FiveBar"):
        fb.export(5, "c")
    with pytest.raises(
        ValueError, match="MuJoCo takes no body below 1e-15 kg or kg m.2, and proximal2 would be"
    ):
        fb.export(fb.FiveBar(zz2=1e-15), "mjcf")
    text = fb.export(fb.ROBOTS["hoang-2015"].robot, "c")
    assert "fivebar_ikm2(" in text and "dynamic" not in text and "torque(" not in text
    with pytest.raises(ValueError, match="forward_dynamics needs zz1 > 0"):
        fb.export(fb.ROBOTS["hoang-2015"].robot, "c", functions=["forward_dynamics"])


def test_a_file_is_written_whole_or_not_at_all(tmp_path):
    out = tmp_path / "robot.xml"
    fb.export(fb.FiveBar(), "mjcf", out)
    before = out.read_bytes()
    with pytest.raises(ValueError):
        fb.export(fb.FiveBar(m=0), "mjcf", out)
    assert out.read_bytes() == before and [each.name for each in tmp_path.iterdir()] == [
        "robot.xml"
    ]
    with pytest.raises(OSError):
        fb.export(fb.FiveBar(), "mjcf", tmp_path / "nowhere" / "robot.xml")


def test_the_command(tmp_path, capsys):
    for format in (*SIMULATORS, "c"):
        out = tmp_path / f"robot.{format}"
        assert (
            main(
                ["export", "--format", format, "--out", str(out), "--robot", "biglide", "--m", "2"]
            )
            == 0
        )
        assert capsys.readouterr().out == f"{out}\n"
        assert out.read_text("utf-8") == fb.export(fb.Biglide(m=2), format)
    assert main(["export", "--format", "c", "--functions", "igm", "dkm", "--name", "left"]) == 0
    text = capsys.readouterr().out
    assert "left_igm(" in text and "left_dkm(" in text and "left_dgm(" not in text
    assert (
        main(
            [
                "export",
                "--format",
                "mjcf",
                "--start",
                "0.2",
                "0.1",
                "--assembly",
                "-1",
                "--step",
                "0.002",
            ]
        )
        == 0
    )
    assert capsys.readouterr().out == fb.export(
        fb.FiveBar(), "mjcf", start=fb.dgm(fb.FiveBar(), (0.2, 0.1)), step=0.002
    )


@pytest.mark.parametrize(
    "arguments, message",
    [
        (
            ["--format", "mjcf", "--m", "0"],
            "no bodies of positive mass move as this robot: m = 0 kg must be above 0 kg",
        ),
        (["--format", "mjcf", "--functions", "dgm"], "functions is no option of mjcf"),
        (
            ["--format", "mjcf", "--homing-deg", "1", "2"],
            "--homing-deg is no option of mjcf, which has start, step",
        ),
        (["--format", "c", "--functions", "foo"], "no function 'foo'"),
        (["--format", "urdf", "--start", "3.1", "0", "--d", "0.2"], "unreachable"),
    ],
)
def test_the_command_refuses(arguments, message, capsys):
    assert main(["export", *arguments]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and message in shown.err


def test_headers_get_along_with_each_other_with_cplusplus_and_not_with_fast_math(tmp_path):
    need("a C compiler")
    for name, robot in (
        ("left", fb.FiveBar()),
        ("right", fb.FiveBar(d=0.1)),
        ("feet", fb.Biglide()),
    ):
        fb.export(robot, "c", tmp_path / f"{name}.h", name=name)
    source = tmp_path / "main.c"
    includes = "".join(f'#include "{name}.h"\n' for name in ("left", "right", "feet", "left"))
    source.write_text(includes + "int main(void) { return 0; }\n", encoding="utf-8")

    def build(*flags):
        command = [c_compiler(), *flags, "-c", str(source), "-o", str(tmp_path / "main.o")]
        return subprocess.run(command, capture_output=True, text=True)

    for flags in (["-std=c99"], ["-std=c99", "-DFIVEBAR_FLOAT"], ["-x", "c++"]):
        done = build(*flags, "-Wall", "-Wextra", "-Werror")
        assert done.returncode == 0, done.stderr
    done = build("-ffast-math")
    assert done.returncode and "compile without -ffast-math" in done.stderr


def test_any_function_of_sx_is_written():
    x = casadi.SX.sym("x", 2)
    every = [
        casadi.tan(x[0]),
        casadi.fmin(x[0], x[1]),
        casadi.if_else(x[0] < x[1], x[0], 3),
        casadi.floor(x[1]),
        casadi.exp(x[0]),
        casadi.logic_and(x[0] <= 1, casadi.logic_not(x[1] == 2)),
        casadi.fabs(x[0]) ** 2.5,
        -casadi.inf,
    ]
    text = to_c(
        casadi.Function("f", [x], [casadi.densify(casadi.vertcat(*every))], ["x"], ["y"]), "f"
    )
    for piece in (
        "FIVEBAR_(tan)(",
        "FIVEBAR_(fmin)(",
        " ? ",
        "+!",
        "<=",
        "FIVEBAR_(pow)(",
        "-INFINITY",
    ):
        assert piece in text, piece
    with pytest.raises(ValueError, match="no words for CasADi's operation OP_ERF"):
        to_c(casadi.Function("g", [x], [casadi.erf(x)]), "g")
    y = casadi.MX.sym("y", 2)
    with pytest.raises(ValueError, match="must be a function of SX expressions, not a MXFunction"):
        to_c(casadi.Function("g", [y], [2 * y]), "g")
    with pytest.raises(ValueError, match="must be dense"):
        to_c(casadi.Function("g", [x], [casadi.SX(casadi.diag(x))]), "g")


def test_all_functions_are_documented():
    text = fb.export(fb.FiveBar(), "c")
    for name in NAMES:
        assert f"static inline int fivebar_{name}(" in text
    for word in ("rad/s^2", "N m", "Units: m, kg, s, rad"):
        assert word in text
