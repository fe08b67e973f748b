"""Generated JavaScript: against CasADi's virtual machine, instruction by instruction, and against the models."""

import casadi as ca
import numpy as np
import pytest

import fivebar as fb
from fivebar.base.backend import as_numbers
from fivebar.models.instructions import FUNCTIONS, OPERATIONS
from fivebar.models.javascript import OWN, to_javascript
from fivebar.models.parameters import parameters_of, with_parameters
from fivebar.visualization.functions import pose_functions

from ..conftest import UNEQUAL
from . import chip
from .javascript import run

COUNT = 100_000
ULP = np.finfo(float).eps
ROBOTS = {
    "amoro": fb.FiveBar(),
    "unequal": UNEQUAL,
    "coaxial": fb.ROBOTS["haply"].robot,
    "biglide": fb.Biglide(l2=0.3),
}
# Where C and JavaScript ask the same of the processor; of the others each browser has its own.
EXACT = (
    set(OPERATIONS)
    | set(OWN) - {ca.OP_POW, ca.OP_CONSTPOW}
    | {
        code
        for code, (name, _) in FUNCTIONS.items()
        if name in ("sqrt", "fabs", "ceil", "floor", "fmin", "fmax", "fmod", "copysign")
    }
)


def batch(function, samples):
    """CasADi's own results (n, all elements by columns)."""
    ends = np.cumsum([function.numel_in(k) for k in range(function.n_in())])[:-1]
    whole = ca.Function(
        "whole", function.sx_in(), [ca.vertcat(*map(ca.vec, function.call(function.sx_in())))]
    )
    return whole.map(len(samples))(*(part.T for part in np.split(samples, ends, axis=1))).full().T


def test_every_operation_at_every_kind_of_number():
    odd = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        -2.5,
        3.0,
        1e-310,
        1e300,
        -1e300,
        np.inf,
        -np.inf,
        np.nan,
        0.3,
        1e16,
    ]
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    samples = np.array([(a, b) for a in odd for b in odd])
    codes = sorted({*OPERATIONS, *FUNCTIONS} - {ca.OP_ASSIGN, ca.OP_CONSTPOW})
    two = {
        ca.OP_ADD,
        ca.OP_SUB,
        ca.OP_MUL,
        ca.OP_DIV,
        ca.OP_LT,
        ca.OP_LE,
        ca.OP_EQ,
        ca.OP_NE,
        ca.OP_AND,
        ca.OP_OR,
        ca.OP_IF_ELSE_ZERO,
        *(code for code, (_, count) in FUNCTIONS.items() if count == 2),
    }
    results = [ca.SX.binary(code, x, y) if code in two else ca.SX.unary(code, x) for code in codes]
    function = ca.Function("every", [x, y], results, ["x", "y"], [f"r{code}" for code in codes])
    assert {function.instruction_id(k) for k in range(function.n_instructions())} >= set(codes)
    found, expected = run(to_javascript(function), function, samples), batch(function, samples)
    for code, mine, theirs in zip(codes, found.T, expected.T):
        if code in EXACT:
            np.testing.assert_array_equal(mine, theirs, str(code))
        else:
            good = np.isfinite(theirs) & (np.abs(theirs) < 1e300)
            np.testing.assert_array_equal(np.isnan(mine), np.isnan(theirs), str(code))
            np.testing.assert_allclose(mine[good], theirs[good], rtol=4 * ULP, err_msg=str(code))


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero", "ignore:overflow")
@pytest.mark.parametrize("name", ["unequal", "biglide"])
@pytest.mark.deep
def test_models_are_casadis_to_the_bit_where_nothing_is_trigonometric(name):
    kind, values = type(ROBOTS[name]), parameters_of(ROBOTS[name])
    p, rng = ca.SX.sym("p", len(values)), np.random.default_rng(7)
    for function in pose_functions(with_parameters(kind, p), p):
        modes = function.numel_in(1)
        # lengths of other robots too, points in and out of reach
        lengths = np.array(values) * rng.uniform(0.7, 1.3, (COUNT, len(values)))
        size = 3.0 if kind is fb.FiveBar and modes == 1 else 0.4
        samples = np.hstack(
            [rng.uniform(-size, size, (COUNT, 2)), rng.choice([-1.0, 1.0], (COUNT, modes)), lengths]
        )
        found, expected = run(to_javascript(function), function, samples), batch(function, samples)
        closes = np.isfinite(expected).all(axis=1)
        assert 0.1 < closes.mean() < 0.95
        some = rng.choice(np.flatnonzero(closes), 1000, replace=False)
        share = chip.bound(function, samples[some], ULP, chip.TRIGONOMETRIC)
        late = chip.bound(function, samples[some], ULP)
        by_columns = np.argsort(chip.rowwise(function))
        share, late = share[:, by_columns], late[:, by_columns]
        untouched = (share == 0).all(axis=0)
        np.testing.assert_array_equal(found[:, untouched], expected[:, untouched])
        assert (np.abs(found - expected)[some] <= 2 * share + late).all()
        assert untouched.sum() >= (12 if modes == 2 else 1)
        assert (np.isnan(found) == np.isnan(expected)).all(
            axis=1
        ).mean() > 1 - 1e-4  # the limit itself, by an ulp


@pytest.mark.every(4)
@pytest.mark.parametrize("name", ROBOTS)
def test_models_are_pythons_at_random_and_at_the_limits(name):
    robot, rng = ROBOTS[name], np.random.default_rng(11)
    igm, dgm = pose_functions(robot)
    size = sum(robot.distal) + robot.d
    turn = np.exp(1j * rng.uniform(-np.pi, np.pi, 2000))
    left, right = robot.drives
    reach = (
        [left.length + robot.distal[0], abs(left.length - robot.distal[0])]
        if robot.turns
        else [robot.distal[0]]
    )
    limits = [complex(left.x, 0) + radius * part for radius, part in zip(reach, np.split(turn, 2))]
    at = np.concatenate([*limits, [complex(left.x), complex(right.x), 0.0]])
    xi = np.concatenate(
        [rng.uniform(-size, size, (4000, 2)), np.stack([at.real, at.imag], axis=-1)]
    )
    working = rng.choice([-1, 1], xi.shape)
    q = rng.uniform(-np.pi, np.pi, (4000, 2)) * (1 if robot.turns else size)
    q = np.concatenate([q, [[0.0, 0.0], [np.pi, 0.0], [-np.pi / 2, -np.pi / 2]], q[:500] * [1, 0]])
    assembly = rng.choice([-1, 1], (len(q), 1))
    for function, points, modes, pose in [
        (igm, xi, working, fb.igm(robot, xi, working, unreachable="nan")),
        (dgm, q, assembly, fb.dgm(robot, q, assembly[:, 0], unreachable="nan")),
    ]:
        found = run(to_javascript(function), function, np.hstack([points, modes]))
        parts, start = {}, 0
        for k in range(function.n_out()):
            parts[function.name_out(k)] = found[:, start : start + function.numel_out(k)]
            start += function.numel_out(k)
        closes = (
            np.isfinite(pose.det_A)
            & np.isfinite(pose.xi).all(axis=-1)
            & np.isfinite(np.stack(pose.sines)).all(axis=0)
        )
        np.testing.assert_array_equal(parts["closes"][:, 0], closes)
        assert closes.any() and not closes.all()
        expected = {
            "xi": pose.xi,
            "q": pose.q,
            "elbows": pose.elbows.swapaxes(1, 2).reshape(-1, 4),
            "serial": np.stack(pose.sines, axis=-1),
            "parallel": pose.det_A[:, None],
            "gap": -pose.reach_margin[:, None],
        }
        for key, value in expected.items():
            apart = np.abs(parts[key] - value)[closes]
            if key == "q":
                apart = (
                    np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi) if robot.turns else apart
                )
            # at a limit the rounding of a square counts by its root
            assert np.nanmax(apart) < 1e-7 and np.nanmean(apart > 1e-11) < 0.35, key
        tame = (
            closes & (np.abs(np.stack(pose.sines)).min(axis=0) > 1e-6) & (np.abs(pose.det_A) > 1e-6)
        )
        np.testing.assert_array_equal(parts["working"][tame], pose.working[tame])
        np.testing.assert_array_equal(parts["assembly"][tame, 0], pose.assembly[tame])


def test_what_cannot_be_written_is_refused():
    x, m = ca.SX.sym("x"), ca.MX.sym("m")
    for function, words in [
        (ca.Function("f", [m], [ca.sin(m)]), "function of SX expressions"),
        (ca.Function("f", [x], [ca.erf(x)]), "no words for CasADi's operation OP_ERF"),
        (ca.Function("f", [x], [x], ["in"], ["y"]), "'in' is no name"),
        (ca.Function("f", [x], [x], ["x"], ["w1"]), "'w1' is no name"),
        (ca.Function("let", [x], [x], ["x"], ["y"]), "'let' is no name"),
    ]:
        with pytest.raises(ValueError, match=words):
            to_javascript(function)


def test_flat_results_lie_by_columns():
    x = ca.SX.sym("x", 2)
    function = ca.Function("flat", [x], [x[0] + x[1], ca.horzcat(x, 2 * x)], ["x"], ["a", "b"])
    whole = ca.Function("both", [x], [ca.vertcat(*map(ca.vec, function.call([x])))], ["x"], ["all"])
    code = to_javascript(function, flat=True) + "const both = x => ({all: flat(x, [])});"
    np.testing.assert_array_equal(run(code, whole, np.array([[3.0, 4.0]])), [[7, 3, 4, 6, 8]])


def test_symbols_alone_are_left_as_they_were():
    robot = fb.FiveBar()
    plain = fb.compile(robot, ["xi"], ["q"])
    with as_numbers():
        exact = fb.compile(robot, ["xi"], ["q"])
    assert plain.n_instructions() < exact.n_instructions()
    assert fb.compile(robot, ["xi"], ["q"]).n_instructions() == plain.n_instructions()
