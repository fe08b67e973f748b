"""Where a path is cut to be timed, what a certificate says of its parts, and images of a tool."""

import cmath
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import fivebar as fb
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Line, Polynomial
from fivebar.paths.placing.tool_regions import _bends, _between, _Image
from fivebar.paths.timing.bounds import Stretches
from fivebar.paths.timing.constraint_rows import Limits
from fivebar.paths.timing.jerk import refuse_kinks
from fivebar.paths.timing.mesh import cut_at_signs, mesh_of
from fivebar.paths.timing.refusals import where
from fivebar.paths.timing.solve import refined
from fivebar.paths.timing.time_path import _timed
from fivebar.paths.tool import MountedTool
from fivebar.singularities.dexterous import bent_parts
from fivebar.singularities.leg_circles import LegCircles

ROBOT = fb.FiveBar(fs1=0.01, fs2=0.02)
ACROSS = Path(
    (Line((0.09, 0.068), (0.07, 0.03)), Line((0.07, 0.03), (0.05, 0.0))), feed=(0.3, np.inf)
)


@pytest.fixture(scope="module")
def mesh():
    return mesh_of(ROBOT, ACROSS, (-1, -1))


def det_A(s):
    return fb.igm(ROBOT, ACROSS(s)[0], (-1, -1)).det_A


def test_a_path_is_cut_where_it_crosses_type_2(mesh):
    s = np.linspace(0, ACROSS.length, 20_001)
    value = det_A(s)
    assert (value[1:] * value[:-1] < 0).sum() == mesh.crossing.sum() == 1
    assert np.abs(det_A(mesh.s[mesh.crossing])).max() < 1e-12
    middle = (mesh.s[1:] + mesh.s[:-1]) / 2
    assert (np.sign(det_A(middle)) == mesh.side).all()
    assert mesh.s[0] == 0 and mesh.s[-1] == ACROSS.length and (np.diff(mesh.s) > 0).all()
    assert ACROSS.knots[1] in mesh.s and len(mesh) == len(mesh.s) - 1
    assert mesh.s[mesh.rest].tolist() == [stop.s for stop in ACROSS.stops]
    assert (mesh.speed == np.where(middle < ACROSS.knots[1], 0.3, np.inf)).all()


def test_a_stretch_whose_ends_show_two_signs_is_cut_between_them():
    piece, none = np.array([0, 1]), np.zeros(2)
    lengths = np.diff(ACROSS.knots)
    found = cut_at_signs(ROBOT, ACROSS, Stretches(piece, none, lengths), (-1, -1))
    crossing = brentq(lambda s: det_A(ACROSS.knots[1] + s), 0.0, lengths[1], xtol=1e-15)
    assert found.piece.tolist() == [0, 1, 1]
    assert found.first == pytest.approx([0, 0, crossing], abs=1e-13)
    assert found.last == pytest.approx([lengths[0], crossing, lengths[1]], abs=1e-13)
    halves = cut_at_signs(ROBOT, ACROSS, found, (-1, -1))
    assert len(halves) == 3  # a node on Type 2 has no sign


def turned_twice():
    """A path that almost follows the circle about an elbow: its joint turns round, and soon back again."""
    place, half = np.array([0.0, 0.1]), 0.02
    normal = (fb.igm(ROBOT, place, (-1, -1)).elbows[0] - place) / ROBOT.l12
    tangent = np.array([normal[1], -normal[0]])
    s = np.polynomial.Polynomial([-half, 2.0026 * half])
    across = s**2 / (2 * ROBOT.l12) + 8 * (s**3 - 3e-6 * half**2 * s)
    place = [p + t * s + n * across for p, t, n in zip(place, tangent, normal)]
    return Path((Polynomial(np.stack([p.coef for p in place], axis=-1), 2.0026 * half),))


@pytest.mark.parametrize("path", [ACROSS, turned_twice()])
def test_a_path_is_cut_where_a_joint_turns_round(path):
    """Also where it does so twice on a stretch of the first mesh."""
    mesh = mesh_of(ROBOT, path, (-1, -1))
    middle = (mesh.s[1:] + mesh.s[:-1]) / 2
    pose = fb.igm(ROBOT, path(middle)[0], (-1, -1))
    slopes = fb.ikm(pose, path(middle)[1]).q_dot.T
    known = mesh.turns != 0
    assert (np.sign(slopes)[known] == mesh.turns[known]).all()
    assert known.all()
    s = np.linspace(0, path.length, 400_001)
    sampled = fb.ikm(fb.igm(ROBOT, path(s)[0], (-1, -1)), path(s)[1]).q_dot
    signs = np.sign(sampled[(np.abs(sampled) > 1e-12).all(axis=1)])
    assert (np.diff(mesh.turns) != 0).sum() == (np.diff(signs, axis=0) != 0).sum()


def test_all_that_is_asked_for_is_enclosed_on_a_mesh(mesh):
    share = np.array([0.0, 0.3, 0.7, 1.0])
    places = mesh.s[:-1, None] + np.diff(mesh.s)[:, None] * share
    value = det_A(places)
    D = mesh.found["D"]
    middle = D.first[:, None] * (1 - share) ** 2 + D.last[:, None] * share**2
    middle += 2 * D.middle[:, None] * share * (1 - share)
    off = np.abs(middle - value) - D.slack[:, None] - D.bend[:, None] * share * (1 - share)
    assert off.max() < 1e-12
    halves = mesh.split(np.full(len(mesh), 2))
    assert len(halves) == 2 * len(mesh) and set(mesh.s) <= set(halves.s)
    assert halves.found["D"].bend.max() < 0.3 * D.bend.max()


def test_a_factor_of_the_torques_beside_type_2(mesh):
    k = int(np.flatnonzero(mesh.crossing)[0])
    a1, a2 = mesh.found["a1"], mesh.found["a2"]
    assert mesh.criterion[k] and not mesh.tied.any()
    largest = max(np.abs([*a.first, a.last[-1]]).max() for a in (a1, a2))
    assert mesh.share("a", k) == max(abs(a1.first[k]), abs(a2.first[k])) / largest
    assert mesh.share("v", k) == 0.0


@pytest.mark.every(2)
@pytest.mark.parametrize("elbow", [0.0, 0.003])
def test_torques_are_kept_on_both_sides_of_type_2(elbow):
    """On a coarse mesh, by the models at places between its nodes."""
    limits = Limits(torque=(0.1, 0.12))
    robot = replace(ROBOT, fv12=elbow)
    mesh = mesh_of(robot, ACROSS, (-1, -1))
    motion = _timed(limits, *refined(mesh, limits, 0.2, math.inf))
    assert motion.crossing.sum() == 1 and 0 < motion.gap < 0.2
    share = np.array([0.03, 0.3, 0.7, 0.97])
    t = (motion.times[:-1, None] + np.diff(motion.times)[:, None] * share).ravel()
    used = np.abs(motion.torques(t)) / limits.torque
    near = np.abs(t - motion.times[motion.crossing][0]) < 0.05
    assert used.max() <= 1 + 1e-6 and used[near].max() > 0.3
    assert fb.check_path(robot, motion).criterion_holds


def test_places_in_words():
    place = "joint C at (0.09, 0.068) m in the robot's own frame"
    assert where(ACROSS, 0.0) == f"s = 0 m of {ACROSS.length:.6g}, {place}"
    lines = replace(ACROSS, lines=(7,) * len(ACROSS.pieces))
    assert where(lines, 0.0) == f"s = 0 m of {ACROSS.length:.6g}, line 7, {place}"


def test_a_path_that_leaves_the_workspace_is_refused_at_the_place():
    """On the third of three lines: within an eighth of a stretch after it leaves, and by how much."""
    path = fb.path([(0.09, 0.068), (0.05, 0.09), (0.0, 0.12), (-0.1, 0.3)])
    far = path.knots[2] + brentq(
        lambda s: np.hypot(*(path.on(2, s)[0] - (ROBOT.d / 2, 0))) - 0.18, 0, 0.1
    )
    with pytest.raises(
        fb.UnreachableError, match="before s = .*: unreachable: right leg"
    ) as refused:
        fb.time_path(fb.FiveBar(), path, constraints=fb.Constraints(torque=0.1))
    s = float(str(refused.value).split("s = ")[1].split(" m")[0])
    assert 0 < s - far < path.length / 96 / 8 * 1.01
    gap = np.hypot(*(path(s)[0] - (ROBOT.d / 2, 0.0))) - 0.18
    assert refused.value.gap == pytest.approx(gap, rel=1e-4)


def test_curvatures_that_jump_are_named():
    arc = fb.paths.pieces.Arc((0.0, 0.02), 0.02, -math.pi / 2, 0.0)
    path = Path((Line((-0.05, 0.0), (0.0, 0.0)), arc))
    words = (
        "as it does at s = 0.05 m of 0.0814159, joint C at .*, 0. m in the robot's own frame: with"
    )
    with pytest.raises(ValueError, match=words):
        refuse_kinks(path)
    refuse_kinks(Path((arc,)))
    refuse_kinks(Path((arc, fb.paths.pieces.Arc((0.0, 0.02), 0.02, 0.0, 1.0))))
    refuse_kinks(Path((Line((-0.05, 0.0), (0.0, 0.0)), arc), dwells={0.05: 1.0}))


# Images of a tool


def images():
    for leg, along, across, mode in ((1, 0.02, 0.01, (1, -1)), (2, -0.03, 0.015, (-1, -1))):
        tool = fb.Tool(leg, along, across)
        mounted = MountedTool(tool, fb.FiveBar(), mode)
        yield tool, mode, _Image(mounted, LegCircles(mounted.robot, 0.0, _bends(mounted, 0.0)))


def test_places_of_a_tool_and_their_derivatives():
    rng = np.random.default_rng(5)
    for tool, mode, image in images():
        xi = rng.uniform((-0.03, 0.07), (0.03, 0.11), (40, 2))
        pose = fb.igm(fb.FiveBar(), xi, mode)
        z = xi @ (1, 1j)
        np.testing.assert_allclose(image.points(z)[0], tool.point(pose) @ (1, 1j), atol=1e-15)
        np.testing.assert_allclose(image._sines(z), pose.sines[tool.leg - 1], atol=1e-13)
        dz = rng.normal(size=40) + 1j * rng.normal(size=40)
        h = 1e-7
        change = (image.points(z + h * dz)[0] - image.points(z - h * dz)[0]) / (2 * h)
        np.testing.assert_allclose(image.points(z, dz)[1], change, atol=1e-5)


def test_a_tool_folds_where_it_is_in_line_with_the_proximal_bar():
    for _, _, image in images():
        mounted = image.mounted
        (((leg, side), (cosine, sine)),) = _bends(mounted, 0.0).items()
        assert leg == mounted.tool.leg - 1 and sine > 0
        bent = complex(cosine, -side * mounted.working[leg] * sine)
        across = (bent * mounted.from_elbow).imag
        other = (bent.conjugate() * mounted.from_elbow).imag
        assert min(abs(across), abs(other)) < 1e-15 < 1e-3 < max(abs(across), abs(other))
        assert _bends(mounted, sine + 1e-9) == {} != _bends(mounted, sine - 1e-9)
    straight = MountedTool(fb.Tool(1, 0.02), fb.FiveBar(), (1, 1))
    assert _bends(straight, 0.0) == {}


def test_a_tool_goes_about_the_base_joint():
    for tool, _, image in images():
        arc = image.around(0.3, -2 * math.pi)
        radius = math.hypot(tool.along, tool.across)
        np.testing.assert_allclose(np.abs(arc.z - image.base), radius, rtol=1e-6)
        assert cmath.phase(arc.z[0] - image.base) == pytest.approx(0.3)
        assert arc.moment == pytest.approx(-2 * math.pi * radius**2 / 2, rel=1e-9)


def test_images_of_loops_are_closed():
    """Each arc begins in the very point in which the one before ends."""
    for _, mode, image in images():
        parts = bent_parts(image.mounted.robot, mode, image.circles, 0.0)
        for part in parts:
            for loop in part.boundary:
                arcs = image.loop(loop)
                for arc, after in zip(arcs, arcs[1:] + arcs[:1]):
                    assert abs(arc.z[-1] - after.z[0]) < 1e-8


def test_a_curve_is_given_its_ends():
    def curve(x):
        return 2.0 * np.asarray(x) + 0j, np.full(np.shape(x), 2.0)

    ended = _between(curve, -1j, 5.0)
    z, dz = ended(np.array([0.0, 0.25, 1.0]))
    assert z.tolist() == [-1j, 0.5, 5.0] and dz.tolist() == [2, 2, 2]


# Certificates


def test_what_a_certificate_says_of_stretches():
    from fivebar.paths.certificates.certify import Certificate, Unproved, _stretches

    def part(start, stop, false, why):
        return Unproved(start, (start + stop) / 2, stop, false, why, {})

    parts = [
        part(0.0, 0.1, True, "first"),
        part(0.1, 0.2, True, "second"),
        part(0.2, 0.3, False, "third"),
        part(0.4, 0.5, False, "fourth"),
    ]
    joined = _stretches(parts)
    assert [(u.start, u.stop, u.why) for u in joined] == [
        (0.0, 0.2, "first"),
        (0.2, 0.3, "third"),
        (0.4, 0.5, "fourth"),
    ]
    claim = {"parts": [[0, 0.5, 1], [0, 1]], "margin": 0.1, "pieces": [1, 2], "assembly": -1}
    found = Certificate(claim, tuple(joined))
    assert repr(found) == (
        "<Certificate: not proved, margin 0.1, 2 pieces in 3 parts, 0 to 0.2 m: first, and 2 more>"
    )
    assert repr(Certificate(claim, tuple(joined[1:]))).endswith("0.3 m: third, and 1 more>")
    assert repr(Certificate(claim, tuple(joined[2:]))).endswith("0.4 to 0.5 m: fourth>")
    assert not found.proved and found.assembly == -1
    with pytest.raises(ValueError, match="certify: not proved from s = 0 to 0.2 m: first"):
        found.to_json(io.StringIO())
    assert repr(Certificate(claim, ())) == (
        "<Certificate: proved, margin 0.1, 2 pieces in 3 parts>"
    )
