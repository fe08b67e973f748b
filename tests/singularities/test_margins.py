"""Types, margins against NumPy's own SVD, and distances against dense sampling."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.distance import locus_distance
from fivebar.singularities.loci import singularity_loci
from fivebar.singularities.margins import Singularity, singularity, singularity_margins

ROBOTS = (
    fb.FiveBar(),
    fb.FiveBar(0.2, 0.5, 0.45, 0.3, 0.25),
    fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1),
    fb.FiveBar(0.3, 0.2, 0.25, 0.28, 0.06),
    fb.ROBOTS["hoang-2015"].robot,
)


def poses(robot, count=300, working=(-1, 1)):
    reach = max(robot.l11 + robot.l12, robot.l21 + robot.l22)
    xi = np.random.default_rng(1).uniform(-reach, reach, (count, 2))
    pose = fb.igm(robot, xi, working, unreachable="nan")
    return fb.igm(robot, xi[np.isfinite(pose.q).all(axis=1)], working)


@pytest.mark.parametrize("robot", ROBOTS)
def test_margins_against_svd(robot):
    pose = poses(robot)
    margins = singularity_margins(pose)
    length = (robot.l11 + robot.l21) / 2
    matrices = {"A": pose.A, "B": pose.B / length, "J": np.linalg.solve(pose.A, pose.B) / length}
    for name, matrix in matrices.items():
        sigma = np.linalg.svd(matrix, compute_uv=False)
        # The SVD's own error in the small singular value is eps times the large one, J's times the condition of A.
        error = 1e-14 * sigma[:, 0] * (margins.condition.A if name == "J" else 1)
        assert (np.abs(getattr(margins.sigma_min, name) - sigma[:, 1]) <= error).all()
        kappa = sigma[:, 0] / sigma[:, 1]
        assert (
            np.abs(getattr(margins.condition, name) / kappa - 1) <= error / sigma[:, 1] + 1e-13
        ).all()
    np.testing.assert_allclose(
        margins.manipulability, np.abs(np.linalg.det(matrices["J"])), rtol=1e-10
    )
    np.testing.assert_allclose(margins.serial, np.sin(pose.q_passive), rtol=0, atol=1e-14)
    np.testing.assert_allclose(margins.parallel, np.linalg.det(pose.A), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        np.sin(margins.transmission_angle), np.abs(margins.parallel), rtol=0, atol=1e-15
    )
    assert (-np.sign(margins.serial) == pose.working).all() and (
        -np.sign(margins.parallel) == pose.assembly
    ).all()


def test_margins_next_to_type_2_do_not_cancel():
    """sigma_min of A is |det A| / sqrt(2) there; 1 - |cos(phi2 - phi1)| would have lost all digits of it."""
    robot = fb.FiveBar()
    left, spread = 0.3, 1e-6
    # From the two distal directions: elbows, then q.
    direction = np.array([np.exp(1.1j), -np.exp(1j * (1.1 + spread))])
    e1 = -robot.d / 2 + robot.l11 * np.exp(1j * left)
    xi = e1 + robot.l12 * direction[0]
    e2 = xi - robot.l22 * direction[1]
    robot = fb.FiveBar(l21=abs(e2 - robot.d / 2))
    pose = fb.dgm(robot, (left, np.angle(e2 - robot.d / 2)), assembly=1)
    margins = singularity_margins(pose)
    assert margins.sigma_min.A == pytest.approx(abs(pose.det_A) / np.sqrt(2), rel=1e-12)
    assert margins.condition.A == pytest.approx(2 / abs(pose.det_A), rel=1e-12)
    assert abs(margins.parallel) == pytest.approx(spread, rel=1e-3)


def test_margins_of_one_pose_and_of_singular_ones():
    margins = singularity_margins(fb.dgm(fb.FiveBar(), (0.0, 0.0)))
    assert margins.parallel == pytest.approx(0.9900815544841736, abs=1e-15)
    assert margins.serial.shape == (2,) and np.ndim(margins.condition.J) == 0
    both_straight = singularity_margins(fb.igm(fb.FiveBar(), (0.0, np.sqrt(0.18**2 - 0.059**2))))
    assert both_straight.sigma_min.B <= 1e-8 and both_straight.sigma_min.J <= 1e-8
    flat = fb.igm(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.2), (0.0, 0.0), (1, 1))
    margins = singularity_margins(flat)
    assert margins.parallel == pytest.approx(0, abs=1e-15)
    on_type_2 = fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4)
    margins = singularity_margins(fb.igm(on_type_2, (0.0, 0.0)))
    assert (
        margins.condition.A == np.inf
        and margins.condition.B == np.inf
        and margins.manipulability == np.inf
    )
    assert margins.sigma_min.J == 0 and margins.condition.J == np.inf


def test_types():
    robot = fb.FiveBar()
    assert singularity(fb.dgm(robot, (0.0, 0.0))) is Singularity.NONE
    loci = singularity_loci(robot)
    for piece in loci.task:
        if len(piece.points) == 1:
            continue
        xi = piece.at(np.linspace(*piece.interval, 12)[1:-1])
        for mode in piece.working:
            kind = singularity(fb.igm(robot, xi, mode), tol=1e-7)
            assert kind.shape == (10,) and (kind & piece.type == piece.type).all()
            one = singularity(fb.igm(robot, xi[3], mode), tol=1e-7)
            assert isinstance(one, Singularity) and one == kind[3]
    flat = fb.igm(fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.4), (0.0, 0.0))
    assert singularity(flat) == Singularity.SERIAL | Singularity.PARALLEL == 3
    unreachable = fb.igm(robot, [[1.0, 1.0], [0.09, 0.06]], unreachable="nan")
    assert singularity(unreachable).tolist() == [0, 0]


@pytest.mark.every(3)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("working", (None, (-1, -1), (1, -1)))
def test_locus_distance_against_dense_sampling(robot, working):
    from scipy import spatial

    reach = max(robot.l11 + robot.l12, robot.l21 + robot.l22)
    xi = np.random.default_rng(2).uniform(-1.2 * reach, 1.2 * reach, (40, 5, 2))
    distance, kind = locus_distance(robot, xi, working)
    assert distance.shape == kind.shape == (40, 5)
    nearest, types = np.full((40, 5), np.inf), np.zeros((40, 5), dtype=int)
    for piece in singularity_loci(robot).task:
        if working is None or working in piece.working:
            dense = piece.at(np.linspace(*piece.interval, 20001))
            to_piece = spatial.cKDTree(dense).query(xi)[0]
            types = np.where(to_piece < nearest, piece.type, types)
            nearest = np.minimum(nearest, to_piece)
    # Sampling overestimates, by h^2 / 8 d at a distance d from samples h apart, by h / 2 on the curve.
    h = 4e-3 * reach
    assert (distance <= nearest + 1e-15).all()
    assert (nearest - distance <= np.minimum(h, h * h / np.maximum(distance, 1e-300))).all()
    assert np.mean(kind == types) > 0.98


@pytest.mark.every(3)
@pytest.mark.parametrize("robot", ROBOTS)
def test_locus_distance_to_rounding(robot):
    """A step e along the normal of a piece is e away from it, wherever no other piece is nearer."""
    for piece in singularity_loci(robot).task:
        if len(piece.points) == 1:
            continue
        s = np.linspace(*piece.interval, 30)[1:-1]
        tangent = piece.tangent(s)
        normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1) / np.linalg.norm(
            tangent, axis=1, keepdims=True
        )
        for e in (0.0, 1e-9, 1e-4, -1e-4):
            distance, kind = locus_distance(robot, piece.at(s) + e * normal, piece.working[0])
            assert (distance <= abs(e) + 1e-15).all()
            nearest = np.abs(distance - abs(e)) <= 1e-15
            assert nearest.mean() > 0.35 and (e == 0 or (kind[nearest] == piece.type).mean() > 0.8)


def test_locus_distance_of_one_point():
    distance, kind = locus_distance(fb.FiveBar(), (0.0, 0.1), working=(1, -1))
    assert isinstance(distance, float) and kind is Singularity.PARALLEL
    # The centre of a circle is as far from all of it.
    robot = fb.FiveBar(0.3, 0.2, 0.25, 0.28, 0.06)
    assert locus_distance(robot, (-0.03, 0.0), working=(1, 1)) == (
        pytest.approx(0.1, abs=1e-16),
        Singularity.SERIAL,
    )
    assert locus_distance(fb.FiveBar(), np.empty((0, 2)))[0].shape == (0,)


@pytest.mark.parametrize(
    "lengths", [(0.09, 0.09, 0.09, 0.09, 0.118), (0.1, 0.05, 0.1, 0.05, 0.3), (1, 1, 2, 1, 5)]
)
def test_locus_distance_from_far_and_to_a_point(lengths):
    """Workspaces of one point, in the origin and beside it: its distance. From far away that of the outline."""
    robot = fb.FiveBar(*lengths)
    outline = np.concatenate([piece.points for piece in singularity_loci(robot).task])
    xi = np.random.default_rng(5).normal(size=(300, 2)) * 10.0 ** np.linspace(-17, 17, 300)[:, None]
    xi = xi if np.ptp(outline) < 1e-12 else xi[np.abs(xi).max(axis=1) > 100]
    nearest = np.hypot(*(xi[:, None] - outline).T).min(axis=0)
    np.testing.assert_allclose(locus_distance(robot, xi)[0], nearest, rtol=1e-7, atol=1e-16)


def test_locus_distance_where_a_mode_is_singular_everywhere():
    robot = fb.ROBOTS["liu-2006-e"].robot
    xi = [[1.0, 0.5], [3.0, 4.0]]
    distance, kind = locus_distance(robot, xi, working=(1, 1))
    assert (
        distance[0] == 0 and distance[1] == pytest.approx(2, abs=1e-15) and kind.tolist() == [2, 1]
    )
    assert locus_distance(robot, xi[0], working=(1, -1))[0] == pytest.approx(
        np.hypot(1, 0.5), abs=1e-15
    )


def test_bad_input():
    pose = fb.dgm(fb.FiveBar(), (0.0, 0.0))
    for tol in (-1.0, np.nan, "x"):
        with pytest.raises(ValueError, match="tol must be"):
            singularity(pose, tol)
    with pytest.raises(TypeError, match="pose must be a Pose, as dgm and igm give, not "):
        singularity((0.0, 0.0))
    with pytest.raises(TypeError, match="pose must be a Pose, as dgm and igm give, not FiveBar"):
        singularity_margins(fb.FiveBar())
    with pytest.raises(ValueError, match=r"working must be \+1 or -1"):
        locus_distance(fb.FiveBar(), (0.0, 0.0), working=(1, 2))
    with pytest.raises(ValueError, match="two modes"):
        locus_distance(fb.FiveBar(), (0.0, 0.0), working=(1, 1, 1))
    with pytest.raises(ValueError, match="xi must be finite"):
        locus_distance(fb.FiveBar(), (np.nan, 0.0))
    import casadi

    symbolic = fb.dgm(fb.FiveBar(), casadi.SX.sym("q", 2))
    with pytest.raises(TypeError, match="singularity needs a pose of numbers, not CasADi symbols"):
        fb.singularity(symbolic)
    with pytest.raises(TypeError, match="not CasADi symbols"):
        locus_distance(fb.FiveBar(), casadi.SX.sym("xi", 2))


@pytest.mark.parametrize("robot", [fb.FiveBar(0.1, 0.12, 0.08, 0.11, 0.07), fb.Biglide()])
def test_margins_of_symbols_are_those_of_numbers(robot):
    """And their slopes are those of finite differences."""
    import casadi

    def numbers(margins):
        return [
            margins.parallel,
            margins.transmission_angle,
            margins.manipulability,
            *(getattr(margins.sigma_min, name) for name in "ABJ"),
            *(getattr(margins.condition, name) for name in "ABJ"),
        ]

    xi = casadi.SX.sym("xi", 2)
    margins = singularity_margins(fb.igm(robot, xi, (-1, 1)))
    outputs = casadi.vertcat(margins.serial, *numbers(margins))
    function = casadi.Function("margins", [xi], [outputs, casadi.jacobian(outputs, xi)])
    rng = np.random.default_rng(5)
    for _ in range(20):
        at = np.array([0.02, 0.15]) + rng.uniform(-0.02, 0.02, 2)

        def values(at):
            margins = singularity_margins(fb.igm(robot, at, (-1, 1)))
            return np.array([*margins.serial, *map(float, numbers(margins))])

        value, slope = (result.full() for result in function(at))
        assert np.allclose(value[:, 0], values(at), rtol=1e-12)
        steps = 1e-6 * np.eye(2)
        central = [(values(at + step) - values(at - step)) / 2e-6 for step in steps]
        assert np.allclose(slope, np.transpose(central), rtol=1e-5, atol=1e-5)
