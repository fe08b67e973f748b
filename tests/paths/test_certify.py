"""Certificates: never a proof of what is false, mostly one of what is true, and a checker that is not fooled."""

import ast
import copy
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path as File

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import iv, mp

import fivebar as fb
from fivebar.cli import main
from fivebar.paths.certificates import checker
from fivebar.paths.certificates.certify import certify
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Arc, Line, Polynomial
from tests.helpers.paths_to_time import bezier

NIGHTLY = os.environ.get("FIVEBAR_NIGHTLY") == "1"
ROBOTS = [
    fb.FiveBar(),
    fb.FiveBar(0.07, 0.2, 0.07, 0.2, 0.25),
    fb.FiveBar(0.11, 0.13, 0.09, 0.15, 0.1),
]
HOME = Path([Line((0.09, 0.068), (0.0, 0.1)), Arc((0.0, 0.12), 0.02, -math.pi / 2, 4.0)])


def sampled(robot, path, working, count=2001):
    """The least |sin q12|, |sin q22|, and det A with its sign, on samples; nan where not reached."""
    pose = fb.igm(robot, path(np.linspace(0.0, path.length, count))[0], working, unreachable="nan")
    return np.abs(np.stack([*pose.sines, pose.det_A])), np.sign(pose.det_A)


@pytest.mark.every(2)
@pytest.mark.parametrize("working", [(-1, -1), (-1, 1), (1, -1), (1, 1)])
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_checkers_equations_are_those_of_the_robot(robot, working):
    xi = np.random.default_rng(1).uniform(-0.2, 0.2, (50, 2))
    pose = fb.igm(robot, xi, working, unreachable="nan")
    iv.prec = 80
    lengths = [checker.Number(iv.mpf(getattr(robot, name))) for name in checker.LENGTHS]
    for k, (x, y) in enumerate(xi):
        x, y = (checker.Number(iv.mpf(each)) for each in (x, y))
        found = checker.margins(list(checker.legs(x, y, lengths)), working)
        if found is None:
            assert np.isnan(pose.q[k]).any()
            continue
        exact = [*(math.sin(angle) ** 2 for angle in pose.q_passive[k]), pose.det_A[k]]
        np.testing.assert_allclose([float(each.value.mid) for each in found], exact, atol=1e-11)


def test_a_proof_and_the_checker_alone(tmp_path):
    found = certify(
        fb.FiveBar(), HOME, tolerances=2e-4, constraints=fb.Constraints(det_A=0.05, sin=0.05)
    )
    assert found.proved and found.assembly == -1 and len(repr(found)) < 120
    file = tmp_path / "proof.json"
    found.to_json(file)
    alone = subprocess.run([sys.executable, checker.__file__, file], capture_output=True, text=True)
    assert (alone.returncode, alone.stdout) == (0, "proved\n")
    file.write_text(
        file.read_text("utf-8").replace('"margin": 0.05', '"margin": 0.06'), encoding="utf-8"
    )
    alone = subprocess.run([sys.executable, checker.__file__, file], capture_output=True, text=True)
    assert (alone.returncode, alone.stderr) == (1, "it is not as it was written (sha256)\n")
    for text in ("", "[]", "{}", "1", "[" * 100000):
        file.write_text(text, encoding="utf-8")
        assert re.match(r"it is no certificate: .*\w", checker.check(file))


WHOLE, HALF_OF_THE_BAR = 0.09, 0.045


@pytest.mark.parametrize(
    "change, message",
    [
        ({"margin": 0.9}, "piece 1, from 0.0 to .* of it: not proved"),
        ({"tolerances": {"l12": HALF_OF_THE_BAR}}, "piece 1, from 0.0 to .* of it: not proved"),
        ({"tolerances": {"l12": WHOLE}}, "piece 1, from 0.0 to .* of it: not proved"),
        ({"tool": {"leg": 1, "along": -0.09, "across": 0.0}}, "piece 1, from .*: not proved"),
        ({"tool": {"leg": 1}}, "tool must have leg, 1 or 2, along and across"),
        ({"tool": {"leg": 3, "along": 0.0, "across": 0.0}}, "tool must have leg, 1 or 2"),
        ({"tool": None}, "tool must be an object of finite numbers"),
        ({"pieces": [{"spline": []}]}, "piece 1 is no line, arc or polynomial of finite numbers"),
        ({"pieces": [{"arc": [[0, 0], 1]}]}, "piece 1 is no line, arc or polynomial"),
        ({"pieces": [{"line": [[0, 0], [None, 1]]}]}, "piece 1 is no line, arc or polynomial"),
        ({"pieces": []}, "it has no pieces"),
        ({"parts": [[0.0, 0.0, 1.0]]}, "piece 1, from 0.0 to 0.0 of it: not proved"),
        ({"parts": [[]]}, "piece 1 does not begin where the one before ends, or its parts are"),
        ({"parts": [[0, 1], [0, 1]]}, "parts must be a list of numbers for each piece"),
        ({"robot": {}}, "robot must have l11, l12, l21, l22, d, and tolerances none but these"),
        ({"tolerances": {"l13": 0.1}}, "robot must have .*, and tolerances none but these"),
        ({"tolerances": {"d": math.nan}}, "tolerances must be an object of finite numbers"),
        ({"tolerances": {"d": 10**400}}, "tolerances must be an object of finite numbers"),
        ({"tolerances": {"d": -0.1}}, "a length, a tolerance or the margin is below 0"),
        ({"margin": math.inf}, "margin must be a finite number"),
        ({"margin": "0.1"}, "margin must be a finite number"),
        ({"working": [1, 0]}, "working must be two modes of -1 or 1"),
        ({"assembly": 0}, "assembly must be -1 or 1"),
        ({"motor": 1}, "unknown: motor"),
    ],
)
def test_a_claim_left_open_is_not_proved_and_another_file_says_what_is_wrong(
    change, message, tmp_path
):
    """With each version of mpmath, whatever it says of intervals that overlap."""
    path = Path([Line((0.0, 0.12), (0.01, 0.12))])
    found = certify(fb.FiveBar(), path, constraints=fb.Constraints(det_A=0.1, sin=0.1))
    assert found.proved
    claim = json.loads(json.dumps(found.claim)) | change
    file = tmp_path / "proof.json"
    file.write_text(json.dumps(claim | {"sha256": checker.digest(claim)}), encoding="utf-8")
    assert re.match(f"(it is no certificate: )?{message}", checker.check(file))


ODD = [None, True, 0, -1, 3, 0.5, math.nan, -math.inf, 1e308, 10**400, "x", "", [], {}, [[1]]]


def places_in(node, way=()):
    """The ways to all values in nested lists and objects."""
    for key, value in node.items() if isinstance(node, dict) else enumerate(node):
        yield (*way, key)
        if isinstance(value, dict | list):
            yield from places_in(value, (*way, key))


@pytest.mark.every(4)
@pytest.mark.parametrize("odd", ODD, ids=repr)
def test_an_odd_value_anywhere_is_refused_in_words(odd):
    """No error of Python's, nor of mpmath's, whatever a file is; but for what is still a proof."""
    path = Path([Line((0.0, 0.12), (0.01, 0.12)), Arc((0.01, 0.13), 0.01, -math.pi / 2, 0.0)])
    claim = json.loads(json.dumps(certify(fb.FiveBar(), path, tolerances=1e-4).claim))
    claim["tool"] = {"leg": 2, "along": 0.01, "across": 0.01}
    for *way, key in places_in(claim):
        other = copy.deepcopy(claim)
        node = other
        for step in way:
            node = node[step]
        node[key] = odd
        other["sha256"] = checker.digest(other)
        reason = checker.refusal(other)
        assert reason is None or re.search(r"not proved|(\w\w+ ){2}", reason), (way, key)
        if key == "sha256" or isinstance(odd, str | list) or odd is None:
            assert reason is not None, (way, key)


def test_a_file_that_cannot_be_read(tmp_path):
    file = tmp_path / "proof.json"
    file.write_bytes(b"\xff")
    assert "it is no JSON in UTF-8" in checker.check(file)
    assert "it cannot be read: " in checker.check(tmp_path)
    assert "it cannot be read: " in checker.check(tmp_path / "none.json")


def test_the_checker_needs_mpmath_alone():
    text = File(checker.__file__).read_text(encoding="utf-8")
    imports = [
        node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    names = {getattr(node, "module", None) or node.names[0].name for node in imports}
    assert names == {"hashlib", "json", "sys", "types", "typing", "mpmath"}


def test_what_is_false_comes_with_a_robot_that_breaks_it():
    robot = fb.FiveBar()
    cases = [
        (
            Path([Line((0.09, 0.068), (0.05, 0.0))]),
            {"tolerances": 1e-3},
        ),  # the lab's task 2: Type 2
        (Path([Line((0.09, 0.068), (0.3, 0.0))]), {"working": (1, -1)}),  # out of reach
        (
            HOME,
            {
                "constraints": fb.Constraints(det_A=0.7, sin=0.7),
                "tolerances": {"l11": 5e-3, "d": 1e-3},
            },
        ),
    ]
    for path, asked in cases:
        found = certify(robot, path, **asked)
        assert not found.proved and any(stretch.false for stretch in found.unproved)
        with pytest.raises(ValueError, match="not proved from s = "):
            found.to_json("nowhere.json")
        for stretch in found.unproved:
            assert 0 <= stretch.start < stretch.at < stretch.stop <= path.length
            if stretch.false:
                other = fb.FiveBar(**stretch.lengths)
                pose = fb.igm(
                    other, path(stretch.at)[0], asked.get("working", (-1, -1)), unreachable="nan"
                )
                least = asked["constraints"].sin if "constraints" in asked else 0.0
                kept = np.min(np.abs([*pose.sines, pose.det_A])) >= least
                assert not (kept and pose.assembly == found.assembly)


def test_a_path_out_of_reach_is_in_no_assembly_mode():
    (stretch,) = (found := certify(fb.FiveBar(), Path([Line((0.3, 0.0), (0.3, 0.1))]))).unproved
    assert found.assembly == 0 and stretch.false and "r1^2 = -" in stretch.why


def test_the_stretch_that_is_not_proved_begins_where_check_path_finds_type_2():
    path = Path([Line((0.09, 0.06796322), (0.05, 0.0))])
    (stretch,) = certify(fb.FiveBar(), path).unproved
    meets = math.dist(
        (0.09, 0.06796322), (0.0525327138758270042, 0.00430328475849708415)
    )  # reference: five_bar.json
    assert stretch.false and stretch.start <= meets <= stretch.start + path.length / 1000


def side(robot, xi, working):
    """The sign of det A at 40 digits; 0 where a leg does not reach."""
    u2 = []
    with mp.workdps(40):
        for sign, l1, l2, mode in (
            (-1, robot.l11, robot.l12, working[0]),
            (1, robot.l21, robot.l22, working[1]),
        ):
            reach = mp.mpc(xi[0] - sign * mp.mpf(robot.d) / 2, xi[1])
            l1, l2, r = mp.mpf(l1), mp.mpf(l2), abs(reach)
            if not abs(l1 - l2) < r < l1 + l2:
                return 0
            angle = mp.acos((r**2 + l2**2 - l1**2) / (2 * r * l2))
            u2.append(reach / r * mp.expj(-mode * angle))
        return int(mp.sign((mp.conj(u2[0]) * u2[1]).imag))


def grazing(robot, by, rng):
    """A short arc that passes the exact locus at a distance, m, and one that crosses it by as much: (working, arcs)."""
    loci = [locus for locus in robot.loci if len(locus.points) > 20]
    locus = loci[rng.integers(len(loci))]
    k = int(rng.integers(5, len(locus.points) - 5))
    at, tangent = locus.points[k], locus.points[k + 1] - locus.points[k - 1]
    normal = np.array([-tangent[1], tangent[0]]) / np.linalg.norm(tangent) * rng.choice([-1, 1])
    radius = 0.02 * robot.d * rng.uniform(0.2, 1.0)
    start = math.atan2(*-normal[::-1]) - rng.uniform(0.2, 1.5)
    arcs = [
        Path([Arc(at + normal * (radius + d), radius, start, start + rng.uniform(1.6, 3.0))])
        for d in (by, -by)
    ]
    return locus.working[rng.integers(len(locus.working))], normal, at, arcs


def graze(count, rng):
    """How many grazing arcs were proved of those that clear the locus, and of those that cross it."""
    robots = [copy.copy(robot) for robot in ROBOTS]
    proved = {"clear": 0, "crossing": 0}
    for robot in robots:
        object.__setattr__(robot, "loci", fb.singularity_loci(robot).task)
    for _ in range(count):
        robot, by = robots[rng.integers(len(robots))], 10 ** rng.uniform(-12, -3) * 0.1
        working, normal, at, (clear, crossing) = grazing(robot, by, rng)
        proved["clear"] += certify(robot, clear, working=working).proved
        centre, radius = np.array(crossing.pieces[0].centre), crossing.pieces[0].radius
        sides = [
            side(robot, xi, working)
            for xi in (centre - normal * radius, *crossing([0.0, crossing.length])[0])
        ]
        if not all(sides) or len(set(sides)) > 1:  # else another locus than this one is near
            found = certify(robot, crossing, working=working)
            proved["crossing"] += 1
            assert not found.proved, (robot, working, crossing)
    return proved


@pytest.mark.deep
def test_no_arc_that_grazes_a_locus_is_proved_free_falsely():
    count = 33_000 if NIGHTLY else 40
    proved = graze(count, np.random.default_rng(7))
    print(proved)
    assert proved["clear"] > 0.5 * count
    assert proved["crossing"] > 0.5 * count


def mutated(certificate, rng):
    """A certificate with one of its numbers, words or parts changed."""
    other = copy.deepcopy(certificate)
    places = []

    def walk(node, where):
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            if isinstance(value, dict | list):
                walk(value, (*where, key))
            places.append((*where, key))

    walk(other, ())
    *way, key = places[rng.integers(len(places))]
    node = other
    for step in way:
        node = node[step]
    value = node[key]
    if isinstance(value, bool | str | dict | list):
        node[key] = "0" * 64 if key == "sha256" else None if rng.random() < 0.5 else 0.5
    else:
        node[key] = rng.choice(
            [-value, value * (1 + 10 ** rng.uniform(-9, 0)), value + rng.normal() * 0.1, 0.0]
        )
    if node[key] == value:
        del node[key]
    return other


@pytest.mark.deep
def test_every_mutated_certificate_is_refused_and_with_a_new_digest_each_that_became_false():
    rng = np.random.default_rng(3)
    curve = Polynomial([[0.0, 0.12], [0.05, 0.01], [-0.02, 0.03], [0.0, -0.02]], 0.06)
    found = certify(
        fb.FiveBar(),
        Path([curve]),
        tolerances={"l11": 1e-4, "d": 1e-4},
        constraints=fb.Constraints(det_A=0.2, sin=0.2),
    )
    assert found.proved
    whole = json.loads(json.dumps(found.claim))
    whole["sha256"] = checker.digest(whole)
    assert checker.refusal(whole) is None
    kept = 0
    for k in range(1000):
        other = mutated(whole, rng)
        assert checker.refusal(other) is not None
        if k % 5 or "sha256" not in other:
            continue
        other["sha256"] = checker.digest(other)
        if checker.refusal(other) is None:  # then what it says now must be so
            kept += 1
            robot = fb.FiveBar(**other["robot"])
            path = Path([Polynomial(other["pieces"][0]["polynomial"], 0.06)])
            least, signs = sampled(robot, path, other["working"], 501)
            assert (least >= other["margin"] - 1e-12).all() and (signs == -other["assembly"]).all()
    assert 0 < kept < 200


@pytest.mark.deep
@settings(deadline=None, max_examples=500 if NIGHTLY else 25)
@given(
    st.sampled_from(ROBOTS),
    st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), min_size=2, max_size=4),
    st.tuples(st.sampled_from((-1, 1)), st.sampled_from((-1, 1))),
    st.floats(0.0, 0.5),
)
def test_check_path_and_samples_do_not_contradict(robot, control, working, margin):
    try:
        path = Path([bezier(np.array(control), 0.1)])
        motion = lambda s: path(s)[:3]  # noqa: E731
        motion.duration = path.length
        checked = fb.check_path(robot, motion, working)
    except ValueError:
        return
    found = certify(
        robot, path, working=working, constraints=fb.Constraints(det_A=margin, sin=margin)
    )
    least, signs = sampled(robot, path, working)
    if found.proved:
        # check_path counts a sine of 1e-9 as 0.
        assert checked.singularity_free or checked.min_margin <= 1e-9
        assert checked.min_margin >= margin - 1e-9
        assert (least >= margin - 1e-12).all() and (signs == -found.assembly).all()
    elif any(stretch.false for stretch in found.unproved):
        assert not checked.singularity_free or checked.min_margin <= margin + 1e-9
    elif checked.singularity_free:
        assert checked.min_margin < margin + 1e-6  # what is neither is at its very limit


@pytest.mark.parametrize(
    "change, message",
    [
        (
            {"robot": fb.Biglide()},
            "certify refuses a robot with kind = .biglide.: it is about the five lengths",
        ),
        ({"path": fb.line((0, 0.1), (0.01, 0.1), 1.0)}, "path must be a Path"),
        ({"constraints": fb.Constraints(joints=((0, 1), None))}, "constraint joints is not kept"),
        ({"tolerances": -1e-3}, "tolerances of l11 must be finite and >= 0"),
        ({"tolerances": {"l13": 1e-3}}, "tolerances of l13: known are l11, l12, l21, l22, d"),
        ({"tolerances": 0.09}, "tolerances of 0.09 m leave nothing of l11 = 0.09 m"),
        ({"working": (1, 0)}, "working"),
    ],
)
def test_what_cannot_be_certified_is_refused(change, message):
    with pytest.raises((TypeError, ValueError), match=message):
        certify(**{"robot": fb.FiveBar(), "path": HOME} | change)


def test_the_command_proves_refuses_and_checks(tmp_path, capsys):
    square, proof = tmp_path / "square.csv", tmp_path / "proof.json"
    square.write_text("x (mm);y (mm)\n30;100\n30;130\n-30;130\n-30;100\n30;100\n", encoding="utf-8")
    asked = [
        "certify",
        str(square),
        "--tolerance",
        "1e-4",
        "--tolerance",
        "d=2e-4",
        "--margin",
        "0.1",
    ]
    assert main([*asked, "--out", str(proof)]) == 0
    notes = capsys.readouterr()
    assert "proved on 4 pieces: l11 = 0.09 +- 0.0001" in notes.out and "read in mm" in notes.err
    assert main(["certify", "--check", str(proof)]) == 0
    assert (
        "d = 0.118 +- 0.0002 m, working [-1, -1], assembly -1, margin 0.1"
        in capsys.readouterr().out
    )
    assert main(["certify", "--check", str(square)]) == 1
    assert "it is no certificate" in capsys.readouterr().err
    assert main([*asked, "--margin", "0.8", "--json", "--out", str(tmp_path / "none.json")]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["proved"] and any(each["false"] for each in found["unproved"])
    assert not (tmp_path / "none.json").exists()
    for wrong in (
        ["certify"],
        [*asked, "--check", str(proof)],
        [*asked, "--tolerance", "l11"],
        ["certify", "no.csv"],
    ):
        assert main(wrong) == 2
