"""Compiled models against the NumPy ones, the cache of machine code, compiled closed loops against the Python loop."""

import itertools
import multiprocessing
import shutil
import signal

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.models import machine_code
from fivebar.models.charts import CHARTS
from fivebar.models.compiled import Buffered, minimized
from fivebar.simulation import loops, plant
from fivebar.study.speed_accuracy.charts.fixed_steps import propagate
from tests.helpers import oracle

ROBOT = fb.FiveBar()
TASK_1 = fb.line((0.09, 0.06796322), (0.0, 0.1), 2.0)
EPS = np.finfo(float).eps


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def batch(function, *arrays):
    """Outputs (n, ...) of a function for rows (n, 2) of each input."""
    count = len(arrays[0])
    values = function.map(count).call([array.T for array in arrays])
    outputs = []
    for k, value in enumerate(values):
        rows, columns = function.size_out(k)
        output = value.full().reshape(rows, count, columns).swapaxes(0, 1)
        outputs.append(output.reshape(count, *(n for n in (rows, columns) if n > 1)))
    return outputs


def test_poses_cost_no_velocity_and_no_dynamics():
    alone = fb.compile(ROBOT, ["q"], ["xi"]).n_instructions()
    assert alone < 50
    moving = fb.compile(ROBOT, ["q", "q_dot"], ["xi", "xi_dot"]).n_instructions()
    assert (
        alone
        < moving
        < fb.compile(ROBOT, ["q", "q_dot"], ["xi", "xi_dot", "M", "c"]).n_instructions()
    )
    assert fb.compile(ROBOT, ["q", "q_dot", "tau"], ["xi"]).n_instructions() == alone
    massless = fb.FiveBar(zz1=0, zz2=0)
    assert (
        fb.compile(massless, ["q", "q_dot"], ["M"]).n_instructions()
        < fb.compile(ROBOT, ["q", "q_dot"], ["M"]).n_instructions()
    )


OUTPUTS = [
    "xi",
    "q_passive",
    "A",
    "B",
    "xi_dot",
    "q_passive_dot",
    "d",
    "M",
    "c",
    "energy",
    "q_ddot",
    "xi_ddot",
]


@pytest.mark.deep
def test_compiled_models_equal_numpy(compiler):
    """24 000 poses of 8 robots, a third close to a singularity: within 16 eps kappa |f|, kappa from the oracle."""
    count = 3000
    robots, p = oracle.draw_all(8, count, 3)
    kappa = oracle.condition(p, "q")
    for k, lengths in enumerate(robots):
        for assembly in (-1, 1):
            chosen = (
                np.flatnonzero(p["assembly"][k * count : (k + 1) * count] == assembly) + k * count
            )
            q, q_dot, tau = (p[name][:, chosen].T for name in ("q", "q_dot", "tau"))
            rates = fb.dkm(fb.dgm(fb.FiveBar(**lengths), q, assembly), q_dot)
            acc, (M, c), pose = fb.forward_dynamics(rates, tau), fb.dynamic_model(rates), rates.pose
            numbers = [
                pose.xi,
                pose.q_passive,
                pose.A,
                pose.B,
                rates.xi_dot,
                rates.q_passive_dot,
                rates.d,
                M,
                c,
            ]
            numbers += [fb.energy(rates), acc.q_ddot, acc.xi_ddot]
            for jit in (False, True) if k in (0, 7) else (False,):
                function = fb.compile(
                    fb.FiveBar(**lengths),
                    ["q", "q_dot", "tau"],
                    OUTPUTS,
                    assembly=assembly,
                    jit=jit,
                )
                for name, value, number in zip(OUTPUTS, batch(function, q, q_dot, tau), numbers):
                    assert value.shape == number.shape
                    error = (value - number).reshape(len(q), -1)
                    error = np.angle(np.exp(1j * error)) if name == "q_passive" else error
                    level = "q" if name in ("xi", "q_passive", "A", "B") else "q_dot"
                    key = (f"forward {name}" if name.endswith("ddot") else name, "q", "q_dot")[
                        : 2 if level == "q" else 3
                    ]
                    assert (np.linalg.norm(error, axis=1) <= 16 * EPS * kappa[key][chosen]).all(), (
                        name,
                        jit,
                    )


@pytest.mark.parametrize(
    "inputs, outputs, message",
    [
        (["q"], ["speed"], "no output 'speed'; the known ones are q, xi"),
        (["angle"], ["xi"], "no input 'angle'; the known ones are q, xi, state, q_dot"),
        (["q", "xi"], ["A"], "inputs q and xi are of one level"),
        (["q", "working"], ["xi"], "no input working with q, whose mode is assembly"),
        (["xi", "assembly"], ["q"], "no input assembly with xi, whose mode is working"),
        (["assembly"], ["xi"], "inputs need q, xi or state"),
        (["q", "assembly"], ["assembly"], "output assembly is an input already"),
        (["q_dot"], ["xi_dot"], "inputs need q, xi or state"),
        (["q", "tau"], ["xi"], "input tau needs q_dot or xi_dot"),
        (["q"], ["xi_dot"], "output xi_dot needs an input of q_dot, xi_dot"),
        (["q"], ["q"], "output q is an input already"),
        (["q"], [], "outputs must name at least one"),
    ],
)
def test_names_that_do_not_fit(inputs, outputs, message):
    with pytest.raises(ValueError, match=message):
        fb.compile(ROBOT, inputs, outputs)


@pytest.mark.parametrize("robot", [ROBOT, fb.Biglide()])
def test_modes_told_with_each_call(robot):
    """What the export to C is made of: one function for all modes."""
    q, q_dot = (0.2, -0.1), (0.5, 0.7)
    by_joints = fb.compile(robot, ["q", "q_dot", "assembly"], ["xi", "M", "c"])
    by_task = fb.compile(robot, ["xi", "working"], ["q", "q_passive"])
    for assembly in (-1, 1):
        pose = fb.dgm(robot, q, assembly)
        for found, expected in zip(
            by_joints(q, q_dot, assembly), (pose.xi, *fb.dynamic_model(fb.dkm(pose, q_dot)))
        ):
            np.testing.assert_allclose(np.squeeze(found.full()), expected, rtol=1e-12, atol=1e-15)
        found, passive = by_task(pose.xi, casadi.DM(pose.working.astype(float)))
        np.testing.assert_allclose(found.full().ravel(), q, rtol=1e-12)
        np.testing.assert_allclose(passive.full().ravel(), pose.q_passive, rtol=1e-12)


def test_machine_code_is_kept_and_a_damaged_library_is_built_again(compiler):
    def compiled():
        return fb.compile(ROBOT, ["q"], ["xi"], jit=True)

    first = compiled()
    _, library = sorted(compiler.iterdir())
    before = library.stat().st_mtime_ns
    assert compiled()((0, 0)).full().ravel() == pytest.approx(first((0, 0)).full().ravel())
    assert library.stat().st_mtime_ns == before
    damaged = compiler / "damaged"  # a new file: the old one is still in use by this process
    damaged.write_bytes(library.read_bytes()[:1000])
    damaged.replace(library)
    assert compiled()((0, 0)).full().ravel() == pytest.approx([0.09, 0.0679632253501848])
    names = [library.with_suffix(".sha256").name, library.name]
    assert sorted(path.name for path in compiler.iterdir()) == names


def _build(_):
    return (
        fb.compile(fb.FiveBar(m=0.77), ["q", "q_dot"], ["M"], jit=True)((0, 0), (0, 0))
        .full()
        .tolist()
    )


@pytest.mark.deep
def test_processes_that_build_at_once_do_not_meet(compiler):
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        results = pool.map(_build, range(6), chunksize=1)
    assert all(result == results[0] for result in results)
    assert [path.suffix for path in sorted(compiler.iterdir())] == [".sha256", ".so"]


def test_without_a_compiler_it_says_so(cache, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(RuntimeError, match="no C compiler found"):
        fb.compile(ROBOT, ["q"], ["xi"], jit=True)
    with pytest.warns(RuntimeWarning, match="going on in CasADi's virtual machine"):
        assert fb.compile(ROBOT, ["q"], ["xi"], jit="auto").class_name() == "SXFunction"
    with pytest.raises(ValueError, match="jit must be one of False, True, auto"):
        fb.compile(ROBOT, ["q"], ["xi"], jit="yes")


def test_every_way_to_a_run_asks_for_a_compiler(monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    for module, name in ((machine_code, "_load"), (loops, "_compiled")):
        monkeypatch.setattr(
            module, name, getattr(module, name).__wrapped__
        )  # whatever is kept of other tests
    monkeypatch.setattr(plant, "_uses", lambda function: itertools.count(1))
    idle, still = fb.PD(ROBOT, 0.0, 0.0), fb.line((0.0, 0.1), (0.0, 0.1), 0.02)
    starts = fb.ikm(fb.igm(ROBOT, [(0.0, 0.1)]), (0, 0))
    for run, asked in (
        (
            lambda jit: fb.simulate(
                ROBOT, idle, still, duration=0.02, integrator=fb.Integrator(jit=jit)
            ),
            1,
        ),
        (
            lambda jit: fb.simulate(
                ROBOT,
                idle,
                still,
                duration=0.02,
                integrator=fb.Integrator(method="rk4", jit=jit),
                step=0.01,
            ),
            1,
        ),
        (
            lambda jit: fb.simulate(
                fb.FiveBar(fs1=0.01), idle, still, duration=0.02, integrator=fb.Integrator(jit=jit)
            ),
            2,
        ),  # what sticks, too
        (
            lambda jit: fb.simulate_many(
                ROBOT,
                idle,
                still,
                starts,
                duration=0.02,
                step=0.01,
                integrator=fb.Integrator(jit=jit),
            ),
            1,
        ),
    ):
        with pytest.raises(RuntimeError, match="no C compiler found"):
            run(True)
        with pytest.warns(RuntimeWarning, match="going on in CasADi's virtual machine") as notes:
            run("auto")
        assert len(notes) == asked


@pytest.mark.parametrize("method", [None, "rk4"])
def test_a_motion_is_compiled_once_in_a_process(compiler, monkeypatch, method):
    """With "auto" from the second motion on; the motion is the same, to rounding."""
    made = []
    library = machine_code.library
    monkeypatch.setattr(machine_code, "library", lambda *of: made.append(of) or library(*of))
    machine_code._load.cache_clear()
    plant._uses.cache_clear()
    start = fb.dkm(fb.dgm(ROBOT, (0.3, 0.2)), (1.0, -2.0))
    runs, counts = [], []
    for jit in ("auto", "auto", True, "auto", False):
        integrator = fb.Integrator(method, jit=jit)
        runs.append(fb.simulate(ROBOT, start=start, duration=0.05, integrator=integrator).q)
        counts.append(len(made))
    assert counts == [0, 1, 1, 1, 1]
    np.testing.assert_allclose(runs, np.broadcast_to(runs[0], np.shape(runs)), rtol=0, atol=1e-13)


def test_an_unwritable_cache_and_a_failing_compiler(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", shutil.which("false"))
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(OSError, match="compiled models cannot be kept in .*set FIVEBAR_CACHE"):
        fb.compile(ROBOT, ["q"], ["xi"], jit=True)
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "cache"))
    with pytest.raises(RuntimeError, match="false failed"):
        fb.compile(ROBOT, ["q"], ["xi"], jit=True)
    talks = tmp_path / "talks"
    talks.write_text(
        "#!/bin/sh\necho 'model.c: no such\n register' >&2\nexit 1\n", encoding="utf-8"
    )
    talks.chmod(0o755)
    monkeypatch.setenv("CC", str(talks))
    with pytest.raises(RuntimeError, match="talks failed: model.c: no such register$"):
        fb.compile(ROBOT, ["q"], ["xi"], jit=True)
    assert list((tmp_path / "cache").iterdir()) == []


def test_cache_folder_follows_the_platform(monkeypatch):
    monkeypatch.delenv("FIVEBAR_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    monkeypatch.setattr(machine_code.sys, "platform", "linux")
    assert str(machine_code.cache_folder()) == "/somewhere/fivebar"
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    monkeypatch.setattr(machine_code.sys, "platform", "win32")
    assert str(machine_code.cache_folder()) == "/local/fivebar"


def forced(t):
    return 0.02 * casadi.cos(2 * np.pi * t), -0.016 * casadi.cos(2 * np.pi * t)


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "name, method, order, counts",
    [
        ("joint", "rk4", 4, (800, 1600)),
        ("task", "rk4", 4, (800, 1600)),
        ("joint", "dop8", 8, (48, 72)),
        ("task", "dop8", 8, (96, 128)),
        ("auto", "rk4", 4, (800, 1600)),
        ("auto", "dop8", 8, (32, 42)),
    ],
)
def test_forced_motion_of_the_reference(five_bar_numbers, name, method, order, counts):
    chart = CHARTS[name]
    c, c_dot, modes = chart.coordinates(fb.dkm(fb.dgm(ROBOT, (0.0, 0.0)), (0.0, 0.0)))
    modes = [int(mode) for mode in modes]
    end = five_bar_numbers["forced_motion"]

    def last(count):
        state = Buffered(propagate(ROBOT, chart, modes, method, 2 / count, count, forced))(
            [*c, *c_dot]
        )[0].copy()
        half = chart.size
        return chart.rates(ROBOT, tuple(state[:half].tolist()), tuple(state[half:].tolist()), modes)

    exact = [float(end[key]) for key in ("q11", "q21", "q11_dot", "q21_dot")]
    fine = last(6400 if method == "rk4" else 400)
    assert [*fine.pose.q, *fine.q_dot] == pytest.approx(
        exact, abs=2e-12 if method == "dop8" else 1e-10
    )
    errors = [np.abs(last(count).pose.q - fine.pose.q).max() for count in counts]
    slope = np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0])
    assert slope == pytest.approx(
        order, abs=0.1 if method == "rk4" else 0.4
    )  # order 8 ends in rounding too soon


@pytest.mark.every(9)
@pytest.mark.parametrize("chart", ["auto", "joint", "task"])
@pytest.mark.parametrize(
    "method, options",
    [
        ("rk4", {}),
        ("rk4", {"torque_limit": 0.006}),
        ("rk4", {"measurement": fb.Measurement(delay=2)}),
        ("rk4", {"duration": 1.2345}),
        ("dop8", {}),
    ],
)
@pytest.mark.parametrize(
    "controller", [fb.ComputedTorque(ROBOT, 100, (20, 21)), fb.PD(ROBOT, 0.4, 0.08)]
)
def test_a_compiled_loop_is_the_python_loop(controller, chart, method, options):
    xi = TASK_1(0.0)[0] + [(0.0, 0.0), (1e-3, -2e-3)]
    starts, options = (
        fb.ikm(fb.igm(ROBOT, xi), (0, 0)),
        options | {"integrator": fb.Integrator(method, chart)},
    )
    runs = fb.simulate_many(ROBOT, controller, TASK_1, starts, **options)
    for k, run in enumerate(runs):
        start = fb.ikm(fb.igm(ROBOT, xi[k]), (0, 0))
        one = fb.simulate(ROBOT, controller, TASK_1, start=start, **options)
        for name in ("t", "q", "q_dot", "xi", "tau", "energy", "xi_ref"):
            np.testing.assert_allclose(
                getattr(run, name), getattr(one, name), atol=1e-13, err_msg=name
            )
        for ours, theirs in zip(run.control, one.control):
            np.testing.assert_allclose(ours, theirs, atol=1e-13)


@pytest.mark.deep
def test_many_runs_in_several_calls(compiler):
    rng = np.random.default_rng(2)
    starts = fb.ikm(
        fb.igm(ROBOT, TASK_1(0.0)[0] + rng.normal(scale=1e-3, size=(70, 2))), (0.0, 0.0)
    )
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    runs = fb.simulate_many(ROBOT, controller, TASK_1, starts, integrator=fb.Integrator(jit=True))
    assert len(runs) == 70 and all(np.linalg.norm(run.error[-1]) < 5e-5 for run in runs)
    assert runs[69].xi[0] == pytest.approx(starts.pose.xi[69], abs=1e-16)


def test_bad_loops():
    starts = fb.ikm(fb.igm(ROBOT, [(0.09, 0.06796322)]), (0, 0))
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    for change, message in (
        (
            dict(
                controller=[fb.ComputedTorque(ROBOT, 100, 20)] * 2,
                starts=None,
                reference=None,
                duration=1.0,
            ),
            "needs starts, or a reference",
        ),
        (
            dict(controller=lambda *_: (0, 0)),
            "needs a PD or ComputedTorque controller, not function",
        ),
        (dict(integrator=fb.Integrator(tolerance=1e-9)), "an Integrator without tolerance"),
        (dict(starts=fb.ikm(fb.igm(ROBOT, (0.09, 0.068)), (0, 0))), r"the Rates of a batch \(n,\)"),
        (
            dict(controller=[controller, fb.PD(ROBOT, 1, 1)], starts=None),
            "controllers of one loop differ in their gains alone: number 1 differs",
        ),
        (dict(robot=[ROBOT, fb.Biglide()], starts=None), "of one kind .* number 1 is a Biglide"),
        (dict(robot=[ROBOT] * 3), "one for each run: 3 robots, 1 starts do not go together"),
        (dict(robot=[fb.FiveBar(l11=0.1)]), "starts is a batch of one robot's Rates"),
    ):
        given = dict(robot=ROBOT, controller=controller, reference=TASK_1, starts=starts) | change
        with pytest.raises(ValueError, match=message):
            fb.simulate_many(**given)
    with pytest.raises(
        fb.SingularityError, match="run 0: .*jumps the singularity of the joint chart"
    ):
        fb.simulate_many(
            ROBOT,
            controller,
            fb.line((0.09, 0.06796322), (0.05, 0.0), 4.0),
            starts,
            integrator=fb.Integrator(chart="joint"),
        )


def test_an_interrupt_ends_a_search_that_casadi_makes(capsys):
    """As Ctrl-C does, while IPOPT goes downhill for ever: CasADi ends it, and says nothing to Python."""
    x, before = casadi.MX.sym("x", 5000), signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    try:
        with pytest.raises(KeyboardInterrupt):
            minimized("x", {"x": x, "f": casadi.sum1(casadi.exp(-x))}, {"ipopt.tol": 1e-300}, x0=0)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert capsys.readouterr().err == ""


def test_tolerance_bounds_the_error():
    free = fb.ikm(fb.igm(ROBOT, (0.01, 0.12), working=(1, -1)), (0.02, -0.30))
    exact = fb.simulate(
        ROBOT, duration=0.5, start=free, step=2e-5, integrator=fb.Integrator(method="dop8")
    )
    for tolerance in (1e-6, 1e-9):
        run = fb.simulate(
            ROBOT,
            duration=0.5,
            start=free,
            step=4e-3,
            integrator=fb.Integrator(tolerance=tolerance),
        )
        assert run.step_error <= tolerance
        assert np.abs(run.q[-1] - exact.q[-1]).max() <= run.step_error


def test_symbols_of_the_robot_are_inputs_after_the_others():
    l11, m = casadi.SX.sym("l11"), casadi.SX.sym("m")
    function = fb.compile(fb.FiveBar(l11=l11, m=m), ["q", "q_dot"], ["xi", "M"])
    assert function.name_in() == ["q", "q_dot", "l11", "m"]
    rates = fb.dkm(fb.dgm(fb.FiveBar(l11=0.1, m=0.3), (0.2, 0.1)), (0.3, 0.4))
    xi, M = function((0.2, 0.1), (0.3, 0.4), 0.1, 0.3)
    assert xi.full().ravel() == pytest.approx(rates.pose.xi, rel=1e-14)
    assert M.full() == pytest.approx(fb.dynamic_model(rates)[0], rel=1e-13)
    with pytest.raises(ValueError, match="the symbol q of the robot has the name of an input"):
        fb.compile(fb.FiveBar(l11=casadi.SX.sym("q")), ["q"], ["xi"])


@pytest.mark.parametrize("robot", [ROBOT, fb.Biglide()], ids=["cranks", "sliders"])
def test_the_state_of_four_bars_is_read_and_given(robot):
    """Both ways it is the same motion, of either mode without being told."""
    q, q_dot, tau = (0.03, -0.02), (0.3, 0.4), (0.1, 0.2)
    names = ["q", "xi", "assembly", "q_dot", "xi_dot", "M", "xi_ddot"]
    for assembly in (-1, 1):
        rates = fb.dkm(fb.dgm(robot, q, assembly), q_dot)
        state = fb.compile(robot, ["q", "q_dot"], ["state"], assembly)(q, q_dot)
        angles, turns = state.full().ravel()[:4], state.full().ravel()[4:]
        if robot.turns:
            assert angles[[1, 3]] - angles[[0, 2]] == pytest.approx(rates.pose.q_passive)
            assert turns[[1, 3]] - turns[[0, 2]] == pytest.approx(rates.q_passive_dot)
        else:
            assert angles[[1, 3]] == pytest.approx(rates.pose.q_passive)
            assert turns[[1, 3]] == pytest.approx(rates.q_passive_dot)
        assert angles[[0, 2]].tolist() == list(q) and turns[[0, 2]].tolist() == list(q_dot)
        found = fb.compile(robot, ["state", "tau"], names)(state, tau)
        M, _ = fb.dynamic_model(rates)
        pose, acceleration = rates.pose, fb.forward_dynamics(rates, tau)
        expected = [q, pose.xi, pose.assembly, q_dot, rates.xi_dot, M, acceleration.xi_ddot]
        for got, value in zip(found, expected):
            assert got.full().squeeze() == pytest.approx(np.asarray(value), rel=1e-11, abs=1e-13)


@pytest.mark.parametrize(
    "inputs,words",
    [
        (["state", "q"], "inputs state and q are of one level"),
        (["state", "q_dot"], "inputs state and q_dot are of one level"),
        (["state", "assembly"], "no input assembly with state, which has no mode"),
    ],
)
def test_what_does_not_go_with_a_state(inputs, words):
    with pytest.raises(ValueError, match=words):
        fb.compile(ROBOT, inputs, ["xi"])
