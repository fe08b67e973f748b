"""The biglide's loci against what det A and det B do, and the maps, distances and path checks that go with them."""

import json

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import fivebar as fb
from fivebar import cli
from fivebar.singularities.maps import Map
from fivebar.singularities.margins import Singularity
from fivebar.visualization.plot.maps import singularity_map as picture
from tests.models.test_biglide import LAB, MODES, UNEQUAL

LONG = fb.Biglide(l1=0.9, l2=0.3)  # folded bars are parallel too
SHORT = fb.Biglide(l1=0.2, l2=0.7, d=0.3)
ROBOTS = {"lab": LAB, "unequal": UNEQUAL, "long": LONG, "short": SHORT}


@pytest.fixture(params=ROBOTS)
def slides(request):
    return ROBOTS[request.param]


def lines(robot, mode, kind):
    """x of the lines of a type that are active in a working mode."""
    return sorted(
        p.points[0, 0]
        for p in fb.singularity_loci(robot).task
        if p.type == kind and mode in p.working
    )


def test_the_labs_lines():
    loci = fb.singularity_loci(LAB)
    edge = LAB.l1 - 0.2
    found = {(p.kind, int(p.type)): float(p.points[0, 0]) for p in loci.task}
    wanted = {("left inward", 1): edge, ("right inward", 1): -edge, ("stretched", 2): 0.0}
    assert found == pytest.approx(wanted, abs=1e-16)
    (stretched,) = (p for p in loci.task if p.kind == "stretched")
    assert set(stretched.working) == {(1, -1), (-1, 1)}
    rise = np.sqrt((2 * LAB.l1) ** 2 - 0.4**2)
    shifts = sorted(
        float(np.diff(p.at(3.0))[0]) for p in loci.joint if p.type == Singularity.PARALLEL
    )
    assert shifts == pytest.approx([-rise, rise], abs=1e-15)
    assert all(
        p.unbounded and not p.closed and p.interval == (-np.inf, np.inf)
        for p in loci.task + loci.joint
    )
    assert loci.everywhere == () and len(loci.type3.xi) == 0


@pytest.mark.parametrize("mode", MODES)
def test_det_a_and_b_vanish_on_the_lines_and_nowhere_else(slides, mode):
    low, high = slides.d / 2 - slides.l2, -slides.d / 2 + slides.l1
    low, high = max(low, -slides.d / 2 - slides.l1), min(high, slides.d / 2 + slides.l2)
    x = np.linspace(low, high, 20001)
    pose = fb.igm(slides, np.stack([x, np.full(len(x), 0.7)], axis=1), mode)
    det = np.linalg.det(pose.A)[1:-1]
    changes = np.flatnonzero(det[1:] * det[:-1] < 0) + 1
    step = x[1] - x[0]
    zeros = sorted([*x[changes], *x[1:-1][det == 0]])
    wanted = [
        line
        for line in lines(slides, mode, Singularity.PARALLEL)
        if low + 2 * step < line < high - 2 * step
    ]
    assert len(zeros) == len(wanted) and np.abs(np.array(zeros) - wanted).max(initial=0) <= step
    # Type 1: both ends of what is reached, and b keeps its sign between them.
    serial = np.array(lines(slides, mode, Singularity.SERIAL))
    assert max(np.abs(serial - end).min() for end in (low, high)) < 1e-15
    assert (pose.working[1:-1] == mode).all()
    for line in wanted:
        assert fb.singularity(fb.igm(slides, (line, 5.0), mode), tol=1e-12) == Singularity.PARALLEL
    for line in (low, high):
        assert fb.singularity(fb.igm(slides, (line, 5.0), mode), tol=1e-7) == Singularity.SERIAL


@pytest.mark.parametrize("assembly", [1, -1])
def test_joint_space(slides, assembly):
    loci = fb.singularity_loci(slides)
    reach = slides.l1 + slides.l2
    shift = np.linspace(-reach, reach, 40001)
    pose = fb.dgm(
        slides,
        np.stack([np.full(len(shift), 0.3), 0.3 + shift], axis=1),
        assembly,
        unreachable="nan",
    )
    step, closes = shift[1] - shift[0], np.isfinite(pose.xi[:, 0])
    for leg, side in enumerate(("left", "right")):
        b = pose.B[:, leg, leg]
        with np.errstate(invalid="ignore"):
            zeros = shift[1:][b[1:] * b[:-1] < 0]
        wanted = sorted(
            float(np.diff(p.points[0])[0])
            for p in loci.joint
            if p.kind.startswith(side) and assembly in p.assembly
        )
        assert len(zeros) == len(wanted) and np.abs(zeros - wanted).max(initial=0) <= step
    ends = shift[1:][closes[1:] != closes[:-1]]
    parallel = sorted(
        {
            round(float(np.diff(p.points[0])[0]), 12)
            for p in loci.joint
            if p.type == Singularity.PARALLEL
        }
    )
    assert len(ends) == len(parallel) and np.abs(ends - parallel).max() <= step
    for piece in loci.joint:
        for mode in (m for m in piece.assembly if m == assembly):
            q = piece.at(np.array([-2.0, 0.4]))
            inward = {"stretched": -1e-13, "folded": 1e-13}.get(piece.kind, 0.0) * np.sign(
                np.diff(q)
            )
            pose = fb.dgm(slides, q + [0, 1] * inward, mode)
            assert (fb.singularity(pose, tol=2e-6) == piece.type).all()
            if piece.type == Singularity.SERIAL:  # the other leg tells the working mode
                other = 1 - ("left", "right").index(piece.kind.split()[0])
                assert {w[other] for w in piece.working} == set(pose.working[:, other].tolist())


@given(
    *(st.floats(0.1, 1), st.floats(0.1, 1), st.just(0.0) | st.floats(1e-12, 1.5)),
    *(st.floats(-0.5, 0.5), st.floats(-9, 9), st.sampled_from(MODES)),
)
def test_distance(l1, l2, d, x, y, mode):
    assume(d < 0.99 * (l1 + l2))
    robot = fb.Biglide(l1=l1, l2=l2, d=d)
    assume(not fb.singularity_loci(robot).everywhere)
    pieces = fb.singularity_loci(robot).task
    distance, kind = fb.locus_distance(robot, (x, y))
    away = {p.kind: abs(p.at(y)[0] - x) for p in pieces}
    assert distance == pytest.approx(min(away.values()), abs=1e-15)
    assert any(p.type == kind and abs(away[p.kind] - distance) < 1e-15 for p in pieces)
    own, _ = fb.locus_distance(robot, [(x, y)], working=mode)
    assert own[0] == pytest.approx(
        min(away[p.kind] for p in pieces if mode in p.working), abs=1e-15
    )


def test_degenerate_robots():
    coaxial = fb.Biglide(d=0.0)
    loci = fb.singularity_loci(coaxial)
    assert loci.everywhere == ((1, 1), (-1, -1))
    assert fb.locus_distance(coaxial, [(0.1, 3.0), (1.0, 0.0)])[0].tolist() == [
        0.0,
        pytest.approx(1 - LAB.l1),
    ]
    assert fb.igm(coaxial, (0.1, 0.0)).assembly == 0
    assert [p.kind for p in loci.joint if p.working == loci.everywhere] == ["self-motion"]
    stiff = fb.Biglide(l1=0.25, l2=0.35, d=0.6)  # reaches one line only, always of Type 3
    task = fb.singularity_loci(stiff).task
    assert {int(p.type) for p in task} == {3} and all(
        p.points[0, 0] == pytest.approx(-0.05) for p in task
    )


def test_aspects_are_refused_with_the_reason():
    for call in (fb.aspects, lambda robot: fb.aspect(robot, 1)):
        with pytest.raises(
            ValueError, match="guides of a biglide have no ends.*need strokes of the feet"
        ):
            call(LAB)


@pytest.mark.every(5)
@pytest.mark.parametrize("space", ["task", "joint"])
def test_map(slides, space, tmp_path):
    data = fb.singularity_map(slides, space=space, shape=(301, 61))
    assert space == "task" or (-data.y[0], data.x[-1]) == (max(slides.l1, slides.l2),) * 2
    loci = fb.singularity_loci(slides)
    for mode, layer in zip(data.modes, data.values):
        row = layer[30]
        if space == "task":
            with np.errstate(invalid="ignore"):
                zeros = data.x[1:][row[1:] * row[:-1] < 0]
            wanted = lines(slides, mode, Singularity.PARALLEL)
            near = [np.abs(np.array(wanted) - zero).min() for zero in zeros]
            assert max(near, default=0) <= data.x[1] - data.x[0]
            assert np.array_equal(
                layer, np.broadcast_to(row, layer.shape), equal_nan=True
            )  # the same for every y
        else:
            assert (
                np.nanmax(-mode * -np.sign(row)) <= 1
                and (np.sign(row[np.isfinite(row)]) == -mode).all()
            )
    data.to_npz(tmp_path / "map.npz")
    again = Map.from_npz(tmp_path / "map.npz")
    assert again.robot == slides and np.array_equal(again.values, data.values, equal_nan=True)
    data.to_csv(tmp_path / "map.csv")
    header = (tmp_path / "map.csv").read_text("utf-8").splitlines()[1]
    assert header.startswith("x,y" if space == "task" else "q1,q2")
    figure = picture(data)
    figure.savefig(tmp_path / "map.png", dpi=40)
    panels = [axes for axes in figure.axes if axes.get_title()]
    for axes, mode in zip(panels, data.modes):
        drawn = [line.get_xydata() / 1e3 for line in axes.lines if line.get_color() != "#b0b0b0"]
        if space == "task":
            wanted = [piece.points[0, 0] for piece in loci.task if mode in piece.working]
            found = [points[0, 0] for points in drawn]
            assert all(
                points[0, 1] <= data.y[0] + 1e-9 and points[-1, 1] >= data.y[-1] - 1e-9
                for points in drawn
            )
        else:
            wanted = [np.diff(piece.points[0])[0] for piece in loci.joint if mode in piece.assembly]
            found = [np.diff(points[0])[0] for points in drawn]
        assert sorted(found) == pytest.approx(sorted(wanted), abs=1e-12)
    labels = {axes.get_xlabel() for axes in panels}
    assert labels <= {"", "x (mm)", "$q_{1}$ (mm)"}


def test_lines_have_their_direction_as_tangent():
    for locus in (*fb.singularity_loci(LAB).task, *fb.singularity_loci(LAB).joint):
        s = np.array([-3, 0, 2])
        np.testing.assert_allclose(
            locus.tangent(s), locus.at(s + 0.5) - locus.at(s - 0.5), rtol=0, atol=1e-15
        )


def test_fields_are_named_in_the_robots_words():
    assert fb.singularity_map(LAB, "serial_left", shape=(9, 9)).description.startswith(
        "sin phi1, signed"
    )
    assert fb.singularity_map(fb.FiveBar(), "serial_left", shape=(9, 9)).description.startswith(
        "sin q12, signed"
    )
    with pytest.raises(ValueError, match="no pose closes at the 9 x 9 nodes .* task space"):
        fb.singularity_map(LAB, window=(1, 2, 0, 1), shape=(9, 9))
    with pytest.raises(ValueError, match="no pose closes at the 9 x 9 nodes .* joint space"):
        fb.singularity_map(LAB, space="joint", window=(1, 2, -2, -1), shape=(9, 9))


def test_margins_have_no_unit():
    pose = fb.igm(LAB, (0.03, 0.4))
    margins = fb.singularity_margins(pose)
    assert margins.length == 1.0
    for name, matrix in (("A", pose.A), ("B", pose.B), ("J", np.linalg.solve(pose.A, pose.B))):
        values = np.linalg.svd(matrix, compute_uv=False)
        assert getattr(margins.sigma_min, name) == pytest.approx(values[-1], rel=1e-12)
        assert getattr(margins.condition, name) == pytest.approx(values[0] / values[-1], rel=1e-12)


def test_check_path():
    across = fb.line((0.05, 0.1), (-0.05, 0.5), 2.0)
    free = fb.check_path(LAB, across)
    assert free.singularity_free and free.min_margin == pytest.approx(
        min(
            np.abs(
                np.stack([*fb.igm(LAB, across(np.array([t]))[0]).B.diagonal(axis1=1, axis2=2)])
            ).min()
            for t in (0, 2)
        )
    )
    check = fb.check_path(LAB, across, (-1, 1))
    assert (check.type, check.touching, check.criterion_holds) == (
        Singularity.PARALLEL,
        False,
        True,
    )
    assert check.time == pytest.approx(1.0, abs=1e-12)  # the quintic's acceleration is 0 half-way
    skew = fb.check_path(LAB, fb.line((0.06, 0.1), (-0.02, 0.5), 2.0), (-1, 1))
    pose, (_, _, xi_ddot) = (
        skew.pose,
        fb.line((0.06, 0.1), (-0.02, 0.5), 2.0)(np.array([skew.time])),
    )
    free = np.array([-pose.A[0, 1], pose.A[0, 0]])
    assert pose.xi[0] == pytest.approx(0, abs=1e-14) and not skew.criterion_holds
    assert skew.criterion == pytest.approx(LAB.m * free @ xi_ddot[0], rel=1e-9)
    out = fb.check_path(LAB, fb.line((0.0, 0.0), (0.2, 0.1), 1.0))
    assert not out.reachable and out.type == Singularity.SERIAL
    assert fb.line((0.0, 0.0), (0.2, 0.1), 1.0)(out.leaves)[0][0] == pytest.approx(
        LAB.l1 - 0.2, abs=1e-12
    )


@pytest.mark.deep
def test_on_the_command_line(tmp_path, capsys):
    robot = ["--robot", "biglide", "--nodes", "41", "--out", str(tmp_path / "map.png")]
    path = tmp_path / "path.csv"
    path.write_text(
        "t,x,y\n"
        + "".join(f"{t},{0.05 - 0.05 * t},{0.2 + 0.1 * t}\n" for t in np.linspace(0, 2, 9)),
        encoding="utf-8",
    )
    assert cli.main(["map", *robot, "--path", str(path), "--data", str(tmp_path / "map.csv")]) == 0
    out, err = capsys.readouterr()
    assert "path in working mode -+: crosses Type 2 at t = 1" in out and "aspect" not in out
    assert "aspects are not listed: those of a biglide are strips without ends" in err
    assert cli.main(["map", *robot, "--json", "--space", "joint", "--l1", "0.5"]) == 0
    assert json.loads(capsys.readouterr().out)["aspects"] is None
    for wrong, words in (
        (["--l11", "0.1"], "no parameter l11 of a biglide robot; the known ones are l1, l2"),
        (["--d", "2.9"], "this robot can never close: d = 2.9 m"),
    ):
        assert cli.main(["map", *robot, *wrong]) == 2
        assert words in capsys.readouterr().err
    file = tmp_path / "own.toml"
    file.write_text("l1 = 0.5\nmf1 = 2.0\n", encoding="utf-8")
    assert cli.main(["map", "--robot", str(file), *robot[2:]]) == 0
    file.write_text('kind = "biglide"\nl1 = 0.5\nzz12 = 2.0\n', encoding="utf-8")
    assert cli.main(["map", "--robot", str(file), *robot[2:]]) == 2
    assert "no parameter" in capsys.readouterr().err


def test_singular_poses_close(slides):
    """Both feet are on their guides, the bars unit vectors, and each line is where these poses are."""
    loci = fb.singularity_loci(slides)
    for kind, own, u1, u2 in loci._families:
        assert (abs(u1), abs(u2)) == pytest.approx((1, 1), abs=1e-15)
        x = -slides.d / 2 + slides.l1 * u1.real
        assert slides.d / 2 + slides.l2 * u2.real == pytest.approx(x, abs=1e-15)
        assert [p.points[0, 0] for p in loci.task if p.kind == kind] == pytest.approx(
            [x], abs=1e-15
        )
        shift = slides.l1 * u1.imag - slides.l2 * u2.imag
        assert any(
            np.diff(p.points[0])[0] == pytest.approx(shift, abs=1e-15)
            for p in loci.joint
            if p.kind == kind
        )
        across = own == Singularity.PARALLEL
        assert (
            (u1.conjugate() * u2).imag if across else min(abs(u1.imag), abs(u2.imag))
        ) == pytest.approx(0, abs=1e-15)
    for piece in (*loci.task, *loci.joint):
        assert (
            piece.closed is False and piece.points.tolist() == piece.at(piece.parameters).tolist()
        )
        assert piece.parameters.tolist() == [-(slides.l1 + slides.l2), slides.l1 + slides.l2]
