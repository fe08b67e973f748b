"""Models as functions of arrays: in each library as in NumPy, which is tested against other formulations elsewhere."""

import subprocess
import sys

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar.models.arrays import BLOCK
from tests.helpers.needs import need

BIGLIDE = fb.Biglide(0.12, 0.1, 0.1)
HEAVY = fb.FiveBar.from_links(
    0.09,
    0.1,
    0.08,
    0.09,
    0.12,
    {"11": 0.1, "12": 0.08, "21": 0.1, "22": 0.08},
    payload=0.2,
    gravity=(0, -9.81),
    rotor=(1e-4, 2e-4),
    viscous=(0.01, 0.02),
)
ROBOTS = {"amoro": fb.FiveBar(), "heavy": HEAVY, "biglide": BIGLIDE}
LIBRARIES = "numpy", "array_api_strict", "jax.numpy", "torch"
MOVING = ["q", "q_dot", "tau"], ["xi", "q_passive", "A", "d", "M", "c", "energy", "xi_ddot"]


def library(name):
    """The library of this name; float64 is not rounded in it."""
    if name.startswith("jax"):
        need("JAX")
        import jax

        jax.config.update("jax_enable_x64", True)
        import jax.numpy as jnp

        return jnp
    if name == "torch":
        need("PyTorch")
    __import__(name)
    return sys.modules[name]


@pytest.fixture(params=LIBRARIES)
def xp(request):
    return library(request.param)


def inputs(robot, shape, count=3, seed=0):
    """Positions of the drives, rates and torques."""
    rng = np.random.default_rng(seed)
    wide = 1.5 if isinstance(robot, fb.FiveBar) else 0.12
    return [rng.uniform(-1, 1, (*shape, 2)) * scale for scale in (wide, 2.0, 0.5)[:count]]


def as_one(xp, function):
    """The function, which JAX compiles as a whole, and not one operation after the other."""
    if not xp.__name__.startswith("jax"):
        return function
    import jax

    return jax.jit(function)


def numbers(array):
    return np.asarray(array)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("assembly", [-1, 1])
def test_numpys_are_the_models(name, assembly):
    """Also out of reach, where both give nan."""
    robot = ROBOTS[name]
    q, q_dot, tau = inputs(robot, (4000,))
    found = fb.compile(robot, *MOVING, assembly=assembly, to=np)(q, q_dot, tau)
    rates = fb.dkm(fb.dgm(robot, q, assembly, unreachable="nan"), q_dot)
    M, c = fb.dynamic_model(rates)
    pose, acceleration = rates.pose, fb.forward_dynamics(rates, tau)
    expected = [pose.xi, pose.q_passive, pose.A, rates.d, M, c, fb.energy(rates)]
    expected.append(acceleration.xi_ddot)
    assert 20 < np.isnan(pose.xi[:, 0]).sum() < 3000
    for got, value in zip(found, expected):
        assert got.shape == value.shape
        size = (
            1
            + np.abs(value)
            + np.abs(value) / np.abs(pose.det_A.reshape(-1, *[1] * (value.ndim - 1)))
        )
        assert (np.isnan(got) == np.isnan(value)).all()
        assert np.nanmax(np.abs(got - value) / size) < 1e-12


@pytest.mark.parametrize("name", ROBOTS)
def test_numpys_inverse_models(name):
    robot = ROBOTS[name]
    xi = np.random.default_rng(1).uniform(-0.25, 0.25, (3000, 2))
    function = fb.compile(
        robot, ["xi", "xi_dot", "xi_ddot", "working"], ["q", "assembly", "tau"], to=np
    )
    working = np.random.default_rng(2).choice([-1.0, 1.0], (3000, 2))
    q, assembly, tau = function(xi, 0.3 * xi, -xi, working)
    pose = fb.igm(robot, xi, working, unreachable="nan")
    good = (np.abs(np.stack([*pose.sines, pose.det_A])) > 0.05).all(axis=0)
    both = np.isfinite(pose.q).all(axis=1)
    assert (np.isfinite(q).all(axis=1) == both).all() and both.sum() > 100
    assert np.nanmax(np.abs(q - pose.q)) < 1e-13
    assert (assembly[good] == pose.assembly[good]).all()
    pose = fb.igm(robot, xi[good], working[good])
    expected = fb.inverse_dynamics(fb.ikm2(fb.ikm(pose, 0.3 * xi[good]), -xi[good]))
    assert tau[good] == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.every(50)
@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("shape", [(), (5,), (2, 3), (0,)])
def test_every_library_gives_what_numpy_gives(xp, name, shape):
    robot = ROBOTS[name]
    arrays = inputs(robot, shape, seed=3)
    expected = fb.compile(robot, *MOVING, to=np)(*arrays)
    found = fb.compile(robot, *MOVING, to=xp)(*map(xp.asarray, arrays))
    for got, value in zip(found, expected):
        assert tuple(got.shape) == value.shape
        assert numbers(got) == pytest.approx(value, rel=1e-9, abs=1e-11, nan_ok=True)


def test_float32_stays_float32(xp):
    arrays = [xp.asarray(each.astype(np.float32)) for each in inputs(HEAVY, (50,))]
    exact = fb.compile(HEAVY, *MOVING, to=np)(*inputs(HEAVY, (50,)))
    results = as_one(xp, fb.compile(HEAVY, *MOVING, to=xp))(*arrays)
    assert {each.dtype for each in results} == {xp.zeros(1, dtype=xp.float32).dtype}
    assert numbers(results[0]) == pytest.approx(exact[0], abs=1e-5, nan_ok=True)


def test_one_output_is_an_array_and_inputs_are_broadcast(xp):
    function = fb.compile(fb.FiveBar(), ["q", "q_dot"], ["B"], to=xp)
    found = function(xp.asarray(np.zeros((3, 1, 2))), xp.asarray(np.zeros((4, 2))))
    assert tuple(found.shape) == (3, 4, 2, 2)


@pytest.mark.parametrize("shape", [(BLOCK + 1,), (3, BLOCK // 2), (20, 1, 900)])
def test_a_large_batch_in_blocks_is_the_whole(shape):
    """Also where an input is one for all, or one for each column, and a length one for each row."""
    lengths = np.linspace(0.11, 0.13, shape[0]).reshape(-1, *(1 for _ in shape[1:]))
    robot = fb.FiveBar(l12=casadi.SX.sym("l12"))
    function = fb.compile(robot, ["q", "q_dot"], ["xi", "A"], to=np)
    rng = np.random.default_rng(5)
    q = rng.uniform(-0.3, 0.3, (*shape, 2))
    q_dot = rng.normal(size=(shape[-1] if len(shape) > 1 else 1, 2))
    xi, A = function(q, q_dot, l12=lengths)
    assert xi.shape == (*shape, 2) and A.shape == (*shape, 2, 2)
    for k in [*np.ndindex(*shape)][:: BLOCK // 100]:
        length = float(lengths[k[0]].item())
        rates = fb.dkm(fb.dgm(fb.FiveBar(l12=length), q[k]), q_dot[k[-1] % len(q_dot)])
        np.testing.assert_allclose(xi[k], rates.pose.xi, rtol=0, atol=1e-15)
        np.testing.assert_allclose(A[k], rates.pose.A, rtol=0, atol=1e-15)


def test_lengths_and_masses_as_symbols_are_arguments(xp):
    """They differ along the batch; the robot that is told so is the robot that is built so."""
    lengths = {name: casadi.SX.sym(name) for name in ("l11", "m")}
    function = fb.compile(fb.FiveBar(**lengths), *MOVING, to=xp)
    arrays = inputs(fb.FiveBar(), (3,), seed=5)
    values = {"l11": np.array([0.09, 0.1, 0.11]), "m": np.array([0.5, 0.4, 0.7])}
    given = {name: xp.asarray(value) for name, value in values.items()}
    found = function(*map(xp.asarray, arrays), **given)
    for k in range(3):
        robot = fb.FiveBar(l11=values["l11"][k], m=values["m"][k])
        expected = fb.compile(robot, *MOVING, to=np)(*(array[k] for array in arrays))
        for got, value in zip(found, expected):
            assert numbers(got)[k] == pytest.approx(value, rel=1e-9, abs=1e-12, nan_ok=True)
    same = function(*map(xp.asarray, arrays), l11=0.1, m=0.4)[0]
    assert numbers(same)[1] == pytest.approx(numbers(found[0])[1], rel=1e-14)


# Of poses with derivatives: PyTorch takes them one by one, JAX compiles anew for each other number.
COUNTS = {"jax.numpy": 400, "torch": 40}


def jacobian(xp, function, at, **given):
    """d function / d its array (n, 2), by the library's own differentiation, (n, outputs, 2)."""
    if xp.__name__ == "torch":
        rows = [
            xp.autograd.functional.jacobian(lambda v: function(v, **given), xp.asarray(row))
            for row in at
        ]
        return np.stack([each.numpy() for each in rows])
    import jax

    rows = jax.vmap(jax.jacrev(lambda v: function(v, **given)))
    return numbers(as_one(xp, rows)(xp.asarray(at)))


@pytest.mark.every(4)
@pytest.mark.parametrize("name", ["jax.numpy", "torch"])
@pytest.mark.parametrize("robot", ["amoro", "biglide"])
def test_the_derivative_of_the_direct_model_is_the_kinematic_one(name, robot):
    """A^-1 B, as close to Type 2 as it comes."""
    xp, robot = library(name), ROBOTS[robot]
    (q,) = inputs(robot, (3000,), 1, seed=6)
    q = q[np.isfinite(fb.dgm(robot, q, unreachable="nan").det_A)]
    q = q[: COUNTS[name]]
    pose = fb.dgm(robot, q)
    found = jacobian(xp, fb.compile(robot, ["q"], ["xi"], to=xp), q)
    expected = np.linalg.solve(pose.A, pose.B)
    size = 1 / np.abs(pose.det_A)[:, None, None]
    assert (np.abs(found - expected) < 1e-13 * size * size).all()


def limits(robot, count):
    """Points around the reach of the left leg, to the last digits and exactly at it, (n, 2)."""
    angle = np.linspace(0.05, 6.2, count)
    reach = np.array([1, 1 + 1e-16, 1 - 1e-15, 1 + 1e-15, 1 - 1e-9])[np.arange(count) % 5]
    centre = np.array([-robot.d / 2, 0.0])
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return centre + (robot.l11 + robot.l12) * reach[:, None] * ray


CLOSING = {
    "coaxial": fb.FiveBar(0.1, 0.1, 0.1, 0.1, 0.0),
    "amoro": fb.FiveBar(),
    "unequal": fb.FiveBar(0.1, 0.14, 0.08, 0.12, 0.09),
}


@pytest.mark.every(3)
@pytest.mark.parametrize("robot", CLOSING)
@pytest.mark.parametrize("name", ["jax.numpy", "torch"])
def test_gradients_are_finite_wherever_the_function_is(name, robot):
    """Also where a leg is stretched, both legs coincide, or a branch that is not taken divides by 0."""
    xp, robot = library(name), CLOSING[robot]
    count = COUNTS[name]
    xi = limits(robot, count)
    inverse = as_one(xp, fb.compile(robot, ["xi"], ["q"], to=xp))
    finite = np.isfinite(numbers(inverse(xp.asarray(xi)))).all(axis=1)
    assert finite.sum() > count / 20
    assert np.isfinite(jacobian(xp, inverse, xi)[finite]).all()
    q = np.random.default_rng(4).uniform(-3, 3, (count, 2))
    q[: count // 2] = np.pi / 2 * np.round(q[: count // 2] / (np.pi / 2))
    direct = as_one(xp, fb.compile(robot, ["q"], ["xi"], to=xp))
    finite = np.isfinite(numbers(direct(xp.asarray(q)))).all(axis=1)
    assert finite.sum() > count / 5
    assert np.isfinite(jacobian(xp, direct, q)[finite]).all()


@pytest.mark.every(2)
@pytest.mark.parametrize("name", ["jax.numpy", "torch"])
def test_derivatives_by_a_length_are_those_of_the_closed_loop(name):
    """|C - elbow 1| = l12: u1 . (dC - dE) = 0 for both legs, solved by hand."""
    xp = library(name)
    q = np.array([0.3, 0.1])
    pose = fb.dgm(fb.FiveBar(), q)
    u1, u2 = ((pose.xi - pose.elbows[leg]) for leg in (0, 1))
    along = u1 @ (np.cos(q[0]), np.sin(q[0]))
    expected = np.linalg.solve([u1, u2], [along, 0.0])
    function = fb.compile(fb.FiveBar(l11=casadi.SX.sym("l11")), ["q"], ["xi"], to=xp)
    if name == "torch":
        l11 = xp.tensor(0.09, dtype=xp.float64)
        found = xp.autograd.functional.jacobian(lambda v: function(xp.asarray(q), l11=v), l11)
    else:
        import jax

        found = jax.jit(jax.jacfwd(lambda v: function(xp.asarray(q), l11=v)))(0.09)
    assert numbers(found) == pytest.approx(expected, rel=1e-12)


@pytest.mark.deep
def test_jax_compiles_maps_and_scans_it():
    xp = library("jax.numpy")
    import jax

    function = fb.compile(fb.FiveBar(), ["q"], ["xi", "A"], to=xp)
    (q,) = inputs(fb.FiveBar(), (20,), 1)
    plain = function(xp.asarray(q))
    for other in (jax.jit(function), jax.vmap(function), jax.jit(jax.vmap(function))):
        for got, expected in zip(other(xp.asarray(q)), plain):
            assert numbers(got) == pytest.approx(
                numbers(expected), rel=1e-13, abs=1e-15, nan_ok=True
            )


@pytest.mark.deep
def test_float64_without_jaxs_setting_for_it_is_refused():
    """In a process of its own: JAX would round silently."""
    need("JAX")
    text = (
        "import jax.numpy, numpy, fivebar\n"
        "f = fivebar.compile(fivebar.FiveBar(), ['q'], ['xi'], to=jax.numpy)\n"
        "print(f(jax.numpy.zeros(2)).dtype)\n"
        "try: f(numpy.zeros(2))\n"
        "except TypeError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    dtype, message = done.stdout.splitlines()
    assert dtype == "float32" and "jax_enable_x64" in message


@pytest.mark.deep
def test_workers_begin_without_a_word_where_jax_is_loaded():
    """JAX warns of processes that are forked while its threads run; workers do not use them."""
    need("JAX")
    text = (
        "import jax.numpy, fivebar, os\n"
        "jax.numpy.zeros(3).block_until_ready()\n"
        "done = fivebar.sweep('bars', {'l1': [0.1, 0.2], 'd': [0.1, 0.1]}, workers=2)\n"
        "print(done['bars'].tolist())"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", text], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    assert done.stdout.startswith("[")


def test_nothing_is_imported_for_it():
    text = (
        "import sys, numpy, fivebar\n"
        "fivebar.compile(fivebar.FiveBar(), ['q'], ['xi'], to=numpy)\n"
        "print({'jax', 'torch', 'scipy', 'matplotlib'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_the_text_runs_by_itself():
    text = fb.compile(fb.FiveBar(), ["q"], ["xi"], to=np, source=True)
    names = {"xp": np}
    exec(text, names)
    assert names["fivebar"](np.zeros(2)) == pytest.approx(fb.dgm(fb.FiveBar(), (0, 0)).xi)
    assert "import" not in text and max(map(len, text.splitlines())) < 120


def make(**options):
    return fb.compile(fb.FiveBar(), ["q", "q_dot"], ["xi", "xi_dot"], **options)


ZERO = np.zeros((3, 2))


@pytest.mark.parametrize(
    "call,kind,words",
    [
        (
            lambda: make(to="jax"),
            ValueError,
            "to = 'jax' has no broadcast_to, .*sqrt.*numpy, jax.numpy or torch",
        ),
        (lambda: make(to=casadi), ValueError, "has no .*where"),
        (lambda: make(to=np, jit=True), ValueError, "jit compiles CasADi's function"),
        (lambda: make(source=True), ValueError, "goes with to"),
        (
            lambda: make(to=np)(ZERO.astype(int), ZERO),
            TypeError,
            "q must be an array of numpy, .*not one of numpy, of int64",
        ),
        (lambda: make(to=np)(ZERO, ZERO.astype(complex)), TypeError, "q_dot must be .*complex128"),
        (lambda: make(to=np)(ZERO, ZERO.astype(np.float16)), TypeError, "q_dot must be .*float16"),
        (lambda: make(to=np)([[0.0, 0.0]], ZERO), TypeError, r"q must be .*, not \[\[0.0, 0.0\]\]"),
        (
            lambda: make(to=np)(ZERO, ZERO.astype(np.float32)),
            TypeError,
            "q_dot is float32 and q float64",
        ),
        (
            lambda: make(to=np)(ZERO, np.zeros((3, 4))),
            ValueError,
            r"q_dot must have shape \(\*batch, 2\), not \(3, 4\)",
        ),
        (lambda: make(to=np)(np.float64(0), ZERO), ValueError, r"q must have shape .* not \(\)"),
        (lambda: make(to=np)(ZERO), TypeError, "missing a required argument: 'q_dot'"),
        (lambda: make(to=np)(ZERO, ZERO, l11=0.1), TypeError, "unexpected keyword argument 'l11'"),
        (lambda: with_length("w3"), ValueError, "symbol 'w3' needs another name"),
        (lambda: with_length("lambda"), ValueError, "symbol 'lambda' needs another name"),
        (lambda: with_length("q"), ValueError, "symbol q of the robot has the name of an input"),
        (
            lambda: with_length("l11")(ZERO, l11="0.1"),
            TypeError,
            "l11 must be a number or an array of numpy",
        ),
        (
            lambda: with_length("l11")(ZERO, l11=np.array([1, 2, 3])),
            TypeError,
            "l11 must be .*of int64",
        ),
    ],
)
def test_what_does_not_go_is_refused_at_once(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


def with_length(name):
    return fb.compile(fb.FiveBar(l11=casadi.SX.sym(name)), ["q"], ["xi"], to=np)


def test_arrays_of_another_library_are_refused():
    torch = library("torch")
    with pytest.raises(
        TypeError, match="q must be an array of torch, .*, not one of numpy, of float64"
    ):
        make(to=torch)(ZERO, ZERO)
    with pytest.raises(
        TypeError, match="q must be an array of numpy, .*, not one of torch, of torch.float64"
    ):
        make(to=np)(torch.zeros(3, 2, dtype=torch.float64), ZERO)
