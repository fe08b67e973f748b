"""Exported C: against CasADi's virtual machine, the models themselves, on ARM, and in single precision."""

import ctypes

import numpy as np
import pytest

import fivebar as fb
from fivebar.exporters.header import CONTROLLER, MODELS, controller
from fivebar.models.machine_code import library

from ..helpers.needs import need
from ..helpers.physics_cases import CASES, robot_of_case
from . import chip

ROBOTS = {
    "fivebar": fb.FiveBar(),
    "uneven": fb.FiveBar(
        l11=0.1, l12=0.13, l21=0.08, l22=0.15, d=0.05, zz1=0.001, zz2=0.003, m=0.2
    ),
    "biglide": fb.Biglide(),
    "vertical": robot_of_case(CASES[0]),
    "rubbing": robot_of_case(CASES[1], elbows=(0.004, 0.007)),
}
COUNT = 200
ULP = np.finfo(float).eps


def functions_of(robot, name):
    found = {f"{name}_{key}": fb.compile(robot, *model[:2]) for key, model in MODELS.items()}
    return found | {f"{name}_{CONTROLLER}": controller(robot)}


def samples_of(robot, function, rng, count=COUNT):
    """Inputs of which some are out of reach, rounded to single precision, which both precisions know."""
    size, columns = sum(robot.distal), []
    turning = 3.0 if robot.turns else size / 2
    for k in range(function.n_in()):
        name, elements = function.name_in(k), function.numel_in(k)
        if name in ("assembly", "working"):
            values = rng.choice([-1.0, 1.0], (count, elements))
        elif name == "xi":
            values = rng.uniform(-size, size, (count, elements))
        elif name.startswith("q") and "dot" not in name:
            values = rng.uniform(-turning, turning, (count, elements))
        else:
            values = rng.normal(size=(count, elements))
        columns.append(values)
    return np.hstack(columns).astype(np.float32).astype(float)


@pytest.fixture(scope="module", params=ROBOTS)
def made(request, tmp_path_factory):
    need("a C compiler")
    robot, name = ROBOTS[request.param], request.param
    functions = functions_of(robot, name)
    text = fb.export(robot, "c", name=name)
    folder = tmp_path_factory.mktemp(name)

    def program(**options):
        return chip.Program(folder, text, functions, **options)

    return robot, functions, program


def pairs(functions, robot, seed=0):
    rng = np.random.default_rng(seed)
    return [
        (name, function, samples_of(robot, function, rng)) for name, function in functions.items()
    ]


@pytest.mark.every(5)
@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero")
def test_equal_to_the_bit_to_casadis_own_machine(made):
    robot, functions, program = made
    own = program()
    for name, function, samples in pairs(functions, robot):
        found, status = own(name, samples)
        expected = chip.in_casadi(function, samples)
        open_ = ~np.isfinite(expected).all(axis=1)
        np.testing.assert_array_equal(status, open_, name)
        assert open_.any() and not open_.all()
        if name.endswith(CONTROLLER):
            expected[open_] = 0.0  # what a motor gets
        np.testing.assert_array_equal(found, expected, name)


@pytest.mark.every(5)
def test_the_models_themselves_say_the_same(made):
    robot, functions, program = made
    own, rng = program(), np.random.default_rng(1)
    prefix = next(iter(functions)).rpartition("_dgm")[0]

    def call(name, *inputs):
        (found,), (status,) = own(
            f"{prefix}_{name}", [np.concatenate([np.ravel(each) for each in inputs])]
        )
        return found, status

    for _ in range(20):
        q = rng.uniform(-0.3, 0.3, 2) * (1 if robot.turns else 0.5)
        q_dot, q_ddot, tau = rng.normal(size=(3, 2))
        pose = fb.dgm(robot, q, -1)
        rates = fb.dkm(pose, q_dot)
        acc = fb.dkm2(rates, q_ddot)
        M, c = fb.dynamic_model(rates)
        expected = [
            (("dgm", q, -1), pose.xi),
            (("passive", q, -1), pose.q_passive),
            (("igm", pose.xi, pose.working), q),
            (("dkm", q, q_dot, -1), (pose.xi, rates.xi_dot)),
            (("ikm", pose.xi, rates.xi_dot, pose.working), (q, q_dot)),
            (("ikm2", pose.xi, rates.xi_dot, acc.xi_ddot, pose.working), (q, q_dot, q_ddot)),
            (("dynamic_model", q, q_dot, -1), (*M, c)),
            (("inverse_dynamics", q, q_dot, q_ddot, -1), fb.inverse_dynamics(acc)),
            (("forward_dynamics", q, q_dot, tau, -1), fb.forward_dynamics(rates, tau).q_ddot),
            (
                ("computed_torque", q, q_dot, q + 0.1, q_dot, q_ddot, (90, 80), (19, 18), -1),
                fb.ComputedTorque(robot, (90, 80), (19, 18)).law(q, q_dot, q + 0.1, q_dot, q_ddot),
            ),
        ]
        for (name, *inputs), value in expected:
            found, status = call(name, *inputs)
            assert status == 0
            np.testing.assert_allclose(found, np.ravel(value), rtol=1e-11, atol=1e-12, err_msg=name)


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero", "ignore:overflow")
@pytest.mark.parametrize("single", [False, True], ids=["double", "float"])
@pytest.mark.deep
def test_arm_is_equal_to_the_bit_where_no_trigonometric_function_is(made, single):
    need("ARM compilers")
    robot, functions, program = made
    here, there = (
        program(single=single),
        program(single=single, arm=True, flags=["-mfpu=neon-vfpv4"]),
    )
    ulp, exact = (np.finfo(chip.REAL[single]).eps), 0
    for name, function, samples in pairs(functions, robot, seed=2):
        (own, own_status), (arms, arms_status) = here(name, samples), there(name, samples)
        np.testing.assert_array_equal(own_status, arms_status, name)
        good = own_status == 0
        share = chip.bound(
            function, samples[good], ulp, chip.TRIGONOMETRIC
        )  # sin, cos, atan2 may differ by an ulp
        late = chip.bound(function, samples[good], ulp)  # what follows is then rounded anew
        untouched = share == 0
        exact += untouched.sum()
        np.testing.assert_array_equal(own[good][untouched], arms[good][untouched], name)
        apart = np.abs(own[good] - arms[good])
        assert (apart <= 2 * share + late).all(), name
    assert exact > COUNT / 10


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:divide by zero", "ignore:overflow")
@pytest.mark.deep
def test_single_precision_errs_by_no_more_than_its_instructions_round(made):
    robot, functions, program = made
    own = program(single=True)
    for name, function, samples in pairs(functions, robot, seed=3):
        found, status = own(name, samples)
        exact = chip.evaluate(function, samples)[0]
        allowed = chip.bound(
            function, samples, np.finfo(np.float32).eps
        )  # twice what a rounding is
        tame = (status == 0) & (allowed < 1e-3 * np.abs(exact)).all(
            axis=1
        )  # first order says it all
        assert tame.mean() > 0.1, name
        assert (np.abs(found - exact)[tame] <= allowed[tame]).all(), name


STEP = """
{header}
int step(const double *in, double *out)
{{
    fivebar_real q[2], q_dot[2], x[2], v[2], a[2], r[2], rv[2], ra[2], tau[2], kp[2] = {{100, 100}}, kd[2] = {{20, 20}};
    int k, status, working[2] = {{-1, -1}};
    for (k = 0; k < 2; k++) {{
        q[k] = (fivebar_real)in[k], q_dot[k] = (fivebar_real)in[2 + k], x[k] = (fivebar_real)in[4 + k];
        v[k] = (fivebar_real)in[6 + k], a[k] = (fivebar_real)in[8 + k];
    }}
    status = fivebar_ikm2(x, v, a, working, r, rv, ra);
    status |= fivebar_computed_torque(q, q_dot, r, rv, ra, kp, kd, -1, tau);
    out[0] = tau[0], out[1] = tau[1];
    return status;
}}
"""


@pytest.mark.parametrize(
    "flags, most", [((), 1e-12), (("-DFIVEBAR_FLOAT",), 2e-7)], ids=["double", "float"]
)
def test_the_loop_closed_by_the_exported_controller(flags, most):
    """The lab's control task 1 by C that gets what a chip gets: the run is that of ComputedTorque to its precision."""
    need("a C compiler")
    robot, reference = fb.FiveBar(), fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
    text = STEP.format(header=fb.export(robot, "c", functions=["ikm2", "computed_torque"]))
    step = ctypes.CDLL(str(library(text, "test", ("-std=c99", *flags)))).step

    def chip_controller(t, q, q_dot, reference):
        given, tau = np.concatenate([q, q_dot, *reference(t)]), np.empty(2)
        assert step(*(ctypes.c_void_p(array.ctypes.data) for array in (given, tau))) == 0
        return tau

    ours = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), reference, duration=2.2)
    chips = fb.simulate(robot, chip_controller, reference, duration=2.2)
    apart = np.abs(chips.xi - ours.xi).max()
    assert apart < most and (not flags or apart > 1e-9)


@pytest.mark.deep
def test_a_motor_gets_nothing_where_there_is_no_pose(tmp_path):
    need("a C compiler")
    function = controller(fb.FiveBar())
    own = chip.Program(
        tmp_path, fb.export(fb.FiveBar(), "c"), {"fivebar_computed_torque": function}
    )
    sample = np.zeros((1, 15))
    sample[0, :2], sample[0, 14] = (np.pi, 0.0), -1
    found, status = own("fivebar_computed_torque", sample)
    assert status == [1] and (found == 0).all()
