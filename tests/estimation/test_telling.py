"""What data cannot tell apart: ranks against an SVD in 50 digits, and the sentences."""

import re

import mpmath as mp
import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.calibration.indistinguishable import plainest
from fivebar.estimation.calibration.measured_robot import LENGTHS, UNKNOWNS, sizes
from tests.estimation.test_machine import exact_jacobian
from tests.helpers.twins import HOME, LAB, NOMINAL, poses, seen, twin

ALL = UNKNOWNS[:13]
GEOMETRY = (*LENGTHS, "offset1", "offset2")
COAXIAL = fb.FiveBar(0.1, 0.2, 0.1, 0.2, 0.0)


def rank_in_50_digits(found):
    """Singular values of the Jacobian at the values found, in units of the sizes, above 1e-13 of the largest.

    Exact of these very doubles, of which pi - t is none: what a symmetry makes 0 is some 1e-16 of them. The gap has to
    be there: nothing between 1e-13 and 1e-10.
    """
    rows = found.rows
    with mp.workdps(80):
        p = [mp.mpf(float(v)) for v in found.p]
        full = exact_jacobian(p, rows.q.tolist(), found.assembly.tolist())
        places = [UNKNOWNS.index(name) for name in found.unknown]
        kept = [2 * n + axis for n, axis in zip(*rows.measured[:2])]
        size = sizes(found.nominal, rows.q, found.unknown)
        matrix = mp.matrix(
            [[full[r, k] * mp.mpf(float(s)) for k, s in zip(places, size)] for r in kept]
        )
        s = [float(v) for v in mp.svd_r(matrix, compute_uv=False)]
    assert not [v for v in s if 1e-13 < v / s[0] < 1e-10]
    return sum(v > 1e-13 * s[0] for v in s)


def data_of(true, rng, n=10, modes=HOME, axes="xy", q=None):
    if q is None:
        q, points, *_ = seen(true, poses(true, n, rng, modes))
    else:
        robot = fb.FiveBar(*(true[name] for name in LENGTHS))
        points = fb.dgm(robot, q, -1).xi
    return dict(q1=q[:, 0], q2=q[:, 1]) | {axis: points[:, "xy".index(axis)] for axis in axes}


SYMMETRIC = np.stack([(t := np.linspace(0.1, 0.7, 9)), np.pi - t], axis=-1)
CROSSED = (-1, 1), (1, -1)  # the modes of motors on one axis: in the others both legs are one


@pytest.mark.every(3)
@pytest.mark.parametrize(
    "robot, unknown, axes, q, lost",
    [
        (LAB, GEOMETRY, "xy", None, 0),
        (LAB, (*GEOMETRY, "x0", "y0", "turn"), "xy", None, 0),
        (LAB, (*GEOMETRY, "x0", "y0", "scale"), "xy", None, 1),
        (LAB, ALL, "xy", None, 1),
        (NOMINAL, ALL, "xy", None, 1),
        (LAB, (*GEOMETRY, "x0", "y0"), "x", None, 1),  # nothing sees y0
        (
            COAXIAL,
            (*LENGTHS[:4], "offset1", "offset2", "turn"),
            "xy",
            None,
            1,
        ),  # turned motors, or a turned frame
        (LAB, LENGTHS[:4], "y", SYMMETRIC, 2),  # both legs alike
        (LAB, GEOMETRY, "y", SYMMETRIC, 3),
    ],
)
def test_ranks_are_those_of_an_svd_in_50_digits(robot, unknown, axes, q, lost):
    rng = np.random.default_rng(len(unknown))
    true = twin(rng, robot, ())
    modes = CROSSED if robot is COAXIAL else HOME
    found = fb.calibrate(robot, data_of(true, rng, modes=modes, axes=axes, q=q), unknown)
    assert found.rank == rank_in_50_digits(found) == len(unknown) - lost
    assert len(found.indistinguishable) == lost
    for (
        name
    ) in unknown:  # what is told is told to rounding, what is not stays where it was, and has no sd
        assert found.values[name] == pytest.approx(true[name], abs=1e-11)


def sentences(unknown, axes, q, robot=LAB, spread=1.0):
    rng = np.random.default_rng(1)
    true = twin(rng, robot, ()) if q is not None else twin(rng, robot, unknown, spread)
    modes = CROSSED if robot is COAXIAL else HOME
    return fb.calibrate(
        robot, data_of(true, rng, modes=modes, axes=axes, q=q), unknown
    ).indistinguishable


def test_legs_alike_are_not_told_from_each_other():
    found = sentences(LENGTHS[:4], "y", SYMMETRIC)
    for words, one, other in zip(found, ("l11", "l12"), ("l21", "l22")):
        together = f"{one} and {other} only together: nothing measured changes if "
        assert words.startswith(together)
        changes = words.removeprefix(together).split(":")[0]
        assert changes in (
            f"{one} grows by 1 mm and {other} falls by 1 mm",
            f"{one} falls by 1 mm and {other} grows by 1 mm",
        )
    assert all("would tell" in each for each in found)


def test_a_remedy_is_one():
    """Following the advice makes the rank full: other places, then a second coordinate."""
    found = sentences(GEOMETRY, "y", SYMMETRIC)
    assert len(found) == 3 and all("poses in other places" in each for each in found), found
    assert sentences(GEOMETRY, "y", None) == ()
    (sentence,) = sentences((*GEOMETRY, "y0"), "x", None)
    assert sentence == "y0 not at all: no measurement depends on it: measuring y, too, would tell"


def test_offsets_and_turn_of_motors_on_one_axis():
    """Moving both zeros back as the frame turns changes nothing measured: found by turning, in numbers."""
    unknown = ("offset1", "offset2", "turn")
    (sentence,) = sentences((*LENGTHS[:4], *unknown), "xy", None, COAXIAL, 0.0)
    assert sentence.startswith(
        "offset1, offset2 and turn only together: nothing measured changes if "
    )
    assert "offset1 falls by 1 deg, offset2 falls by 1 deg and turn grows by 1 deg" in sentence or (
        "offset1 grows by 1 deg, offset2 grows by 1 deg and turn falls by 1 deg" in sentence
    )
    assert "no measurement of this kind can" in sentence or "would tell" in sentence


def test_the_easiest_measurement_is_advised():
    """A turned frame with both zeros turned back: no ruler sees it. Of a scaled robot, one does."""
    turned = sentences((*LENGTHS[:4], "offset1", "offset2", "turn"), "xy", None, COAXIAL, 0.0)
    assert turned[0].endswith(
        "no measurement of this kind can; measure offset1 or offset2 or turn by itself, and leave"
        " it out of unknown"
    )
    (scaled,) = sentences((*GEOMETRY, "x0", "y0", "scale"), "xy", None)
    words, changes, remedy = scaled.split(": ")
    assert words == "l11, l12, l21, l22, d and scale only together"
    lengths = [float(number) for number in re.findall(r"(?:grows|falls) by (\S+) mm", changes)]
    share = float(re.search(r"scale (?:grows|falls) by (\S+)$", changes)[1])
    assert lengths == pytest.approx(
        [1e3 * share * getattr(LAB, each) for each in LENGTHS], rel=0.02
    )
    assert remedy == (
        "a distance between two of its points by a ruler (columns distance, to) would tell"
    )
    alike = sentences(LENGTHS[:4], "y", SYMMETRIC)
    assert all(
        each.endswith(": poses in other places of the same modes would tell") for each in alike
    )
    rng = np.random.default_rng(4)
    q, points, assembly, _ = seen(twin(rng, LAB, ()), poses(twin(rng, LAB, ()), 9, rng, HOME))
    ruler = {"q1": q[:, 0], "q2": q[:, 1], "assembly": assembly, "to": (np.arange(9) + 1) % 9 + 1}
    ruler["distance"] = np.hypot(*(points - np.roll(points, -1, axis=0)).T)
    found = fb.calibrate(LAB, ruler, (*LENGTHS, "turn", "scale"))
    assert found.indistinguishable == tuple(
        f"{name} not at all: no measurement depends on it: points x, y in a measuring frame would tell"
        for name in ("turn", "scale")
    )
    assert found.values["turn"] == 0.0 and found.values["scale"] == 1.0


def test_least_norm_stays_near_the_start():
    rng = np.random.default_rng(3)
    true = twin(rng, LAB, (*GEOMETRY, "x0", "y0", "scale"))
    found = fb.calibrate(LAB, data_of(true, rng, 30), (*GEOMETRY, "x0", "y0", "scale"))
    products = [
        found.values[name] * found.values["scale"] / true[name] / true["scale"] for name in LENGTHS
    ]
    assert np.abs(np.array(products) - 1).max() < 1e-11
    # No nearer point does as well: the step from the start has nothing along the null space.
    step = (found.p - found.start)[[UNKNOWNS.index(n) for n in found.unknown]] / found.sizes
    null = np.array([(*(found.values[n] for n in LENGTHS), -found.values["scale"])])
    along = step[[found.unknown.index(n) for n in (*LENGTHS, "scale")]]
    scaled = null / found.sizes[[found.unknown.index(n) for n in (*LENGTHS, "scale")]]
    assert abs(scaled @ along) < 1e-6 * np.linalg.norm(scaled)


@pytest.mark.deep
def test_hardly_told_is_said():
    """A patch of 2 mm: of full rank, and of no use."""
    rng = np.random.default_rng(2)
    q = np.array([0.2, -0.1]) + 0.01 * rng.uniform(-1, 1, (12, 2))
    data = data_of(twin(rng, LAB, ()), rng, q=q)
    data["x"] = data["x"] + 1e-4 * rng.standard_normal(12)
    found = fb.calibrate(LAB, data, GEOMETRY, sigma=1e-4)
    assert found.rank == 7 and found.indistinguishable == ()
    weak = [name for name in GEOMETRY if found.sd[name] > (0.1 if name[0] == "o" else 0.009)]
    assert found.weakly_identified == (f"hardly known, as their sd says: {', '.join(weak)}",)
    assert weak and found.weakly_identified[0] in str(found)


@pytest.mark.parametrize("unknown", [("offset1", "offset2"), ("l11", "l12", "l21", "l22")])
@pytest.mark.parametrize("loss", ["linear", "huber"])
def test_as_many_numbers_as_unknowns_show_no_scatter(unknown, loss):
    """Then no deviation is known, however well the unknowns themselves are: that is what is said."""
    rng = np.random.default_rng(4)
    pose = fb.dgm(LAB, rng.uniform(-0.3, 0.3, (len(unknown) // 2, 2)))
    columns = np.column_stack([pose.q, pose.xi, pose.working, pose.assembly]).T
    data = dict(zip(("q1", "q2", "x", "y", "working1", "working2", "assembly"), columns))
    found = fb.calibrate(LAB, data, unknown, loss=loss)
    assert found.rank == len(unknown) and found.indistinguishable == ()
    (words,) = found.weakly_identified
    assert f"{len(unknown)} measured numbers for {len(unknown)} combinations" in words
    assert "scatter" in words and "--sigma" in words
    text = str(found)
    assert "inf" not in text.replace("infl", "") and "not told" not in text
    assert text.count("no scatter") == len(unknown)
    told = fb.calibrate(LAB, data, unknown, sigma=1e-5)
    assert "scatter" not in str(told) and all(np.isfinite([*told.sd.values()]))


def test_plainest_vectors_have_the_fewest_entries():
    plain = np.array([[1.0, 1, 0, 0, 0, 0], [0, 0, 0, 1, -0.5, 0]])
    mixed = np.array([[0.6, 0.8], [-0.8, 0.6]]) @ plain
    assert np.abs(plainest(np.linalg.svd(mixed)[2][:2])) == pytest.approx(np.abs(plain))
