"""Exported C in single and in double precision: error against instructions, and against nearness to
Type 2.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from ....exporters.c import PRELUDE, to_c
from ....exporters.header import CONTROLLER, MODELS, NAMES, controller
from ....models.compiled import compile
from ....models.geometry import dgm
from ....models.instructions import Language, statements
from ....models.kinematics import dkm, dkm2
from ....models.machine_code import library
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel
from ..rivals.arm import OnArm
from .dgm_routes import ROBOT, printed
from .geometry import GAPS, poses

if TYPE_CHECKING:
    from collections.abc import Callable

REGULAR, NEAR, ARM = "regular", "near", "arm"
DYNAMIC, DIRECT = NAMES.index("dynamic_model"), NAMES.index("dgm")
FLAGS = "-std=c99", "-ffp-contract=off"
PRECISIONS = {np.float32: ("-DFIVEBAR_FLOAT",), np.float64: ()}
LOOP = """
{prelude}{function}
void run(long count, const fivebar_real *in, fivebar_real *out)
{{
    for (long k = 0; k < count; k++, in += {inputs}, out += {outputs}) model({arguments});
}}
"""
# Instructions as Python on arrays of the widest numbers that NumPy has.
WIDE = Language(
    lambda value: f"wide({value!r})",
    lambda name, operands: f"{NUMPY.get(name, name)}({', '.join(operands)})",
    lambda name, shape, row, column: f"given[{name!r}][:, {row}]",
    lambda name, shape, row, column: f"found[{name!r}][:, {row + shape[0] * column}]",
)
NUMPY = {"atan2": "arctan2", "fabs": "abs", "fmin": "minimum", "fmax": "maximum"}


@cache
def function_of(index: int) -> ca.Function:
    """The exported function of this place among NAMES."""
    name = NAMES[index]
    return controller(ROBOT) if name == CONTROLLER else compile(ROBOT, *MODELS[name][:2])


@cache
def printed_function(index: int) -> ca.Function:
    """The same as handouts have it: h = sqrt(l^2 - a^2), passive joints as angles, A inverted as it
    stands.
    """
    q, q_dot, assembly = ca.SX.sym("q", 2), ca.SX.sym("q_dot", 2), ca.SX.sym("assembly")
    xi = ca.vertcat(*printed(q[0], q[1]))
    if index == DIRECT:
        return ca.Function("printed", [q, assembly], ca.cse([xi]), ["q", "assembly"], ["xi"])
    bases, rows, slopes, bias = (-ROBOT.d / 2, ROBOT.d / 2), [], [], []
    legs = [(ROBOT.l11, ROBOT.l12), (ROBOT.l21, ROBOT.l22)]
    for k, (base, (l1, _)) in enumerate(zip(bases, legs)):
        passive = ca.atan2(xi[1] - l1 * ca.sin(q[k]), xi[0] - base - l1 * ca.cos(q[k])) - q[k]
        rows.append(ca.horzcat(ca.cos(q[k] + passive), ca.sin(q[k] + passive)))
        slopes.append(l1 * ca.sin(passive))
    A, B = ca.vertcat(*rows), ca.diag(ca.vertcat(*slopes))
    inverse = ca.inv(A)
    J = inverse @ B
    xi_dot = J @ q_dot
    for k, (_, (l1, l2)) in enumerate(zip(bases, legs)):
        u = rows[k]
        cosine = u[0] * ca.cos(q[k]) + u[1] * ca.sin(q[k])
        swing = (u[0] * xi_dot[1] - u[1] * xi_dot[0] - l1 * cosine * q_dot[k]) / l2
        bias.append(-l1 * cosine * q_dot[k] ** 2 - l2 * swing**2)
    M = ca.diag(ca.vertcat(ROBOT.zz1, ROBOT.zz2)) + ROBOT.m * J.T @ J
    c = ROBOT.m * J.T @ inverse @ ca.vertcat(*bias)
    return ca.Function(
        "printed",
        [q, q_dot, assembly],
        ca.cse([ca.densify(M), c]),
        ["q", "q_dot", "assembly"],
        ["M", "c"],
    )


@cache
def inputs_of(problem: str, knob: float) -> dict[str, np.ndarray]:
    """{name of an input: (n, its elements)}, numbers of single precision, of poses of assembly mode
    -1.
    """
    q = poses("singular", knob)[0] if problem == NEAR else poses("batch")[0]
    rng = np.random.default_rng(21)
    q_dot, q_ddot, away = rng.normal(size=(3, *q.shape))
    q = q.astype(np.float32).astype(float)
    pose = dgm(ROBOT, q, unreachable="nan")
    good = np.isfinite(pose.q_passive).all(axis=1) & (
        problem == NEAR or (np.abs(pose.sines) > 0.3).all(axis=0)
    )
    q, q_dot, q_ddot, away = q[good], q_dot[good], q_ddot[good], away[good]
    acc = dkm2(dkm(dgm(ROBOT, q), q_dot), q_ddot)
    pose, ones = acc.rates.pose, np.ones((len(q), 1))
    found = dict(
        q=q,
        q_dot=q_dot,
        q_ddot=q_ddot,
        xi=pose.xi,
        xi_dot=acc.rates.xi_dot,
        xi_ddot=acc.xi_ddot,
        assembly=-ones,
        working=pose.working,
        tau=0.1 * away,
        q_ref=q + 0.1 * away,
        q_ref_dot=q_dot,
        q_ref_ddot=q_ddot,
        kp=100 * ones * (1, 1),
        kd=20 * ones * (1, 1),
        det_A=pose.det_A[:, None],
    )
    return {
        name: np.asarray(value, dtype=float).astype(np.float32).astype(float)
        for name, value in found.items()
    }


@cache
def exact(problem: str, index: int, knob: float) -> list[np.ndarray]:
    """Results (n, elements) of the exported function's instructions in extended precision."""
    function, known = function_of(index), inputs_of(problem, knob)
    wide = np.longdouble
    given = {name: value.astype(wide) for name, value in known.items()}
    count = len(known["q"])
    found = {
        function.name_out(k): np.empty((count, function.numel_out(k)), wide)
        for k in range(function.n_out())
    }
    names = {name: getattr(np, name) for name in ("sqrt", "sin", "cos", "arctan2", "ceil", "abs")}
    exec(
        "\n".join(statements(function, WIDE)),
        {},
        {**names, "wide": wide, "given": given, "found": found},
    )
    return list(found.values())


def judged(
    problem: str, index: int, knob: float, function: ca.Function, precision: type
) -> Callable:
    """Results (n, all elements) -> largest error of an output, in parts of its largest value; what
    it took.
    """
    if precision == np.float64 and np.finfo(np.longdouble).eps > 1e-18:
        raise Failed("no wider numbers here to compare with")
    true = exact(problem, index, knob)
    edges = np.cumsum([values.shape[1] for values in true])[:-1]

    def judge(found):
        if not np.isfinite(found).all():
            raise Failed("nan")
        columns = np.split(found.astype(np.longdouble), edges, axis=1)
        errors = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(columns, true)]
        sine = np.median(np.abs(inputs_of(problem, knob)["det_A"]))
        return {
            "error": float(max(errors)),
            "instructions": function.n_instructions(),
            "det_A": float(sine),
        }

    return judge


def in_c(make: Callable[[int], ca.Function], precision: type) -> Callable[..., Attempt]:
    """prepare of a function made (index), in C of this precision, a loop over the poses."""

    def prepare(problem, knob):
        text, samples, results, judge = _made(make, precision, problem, knob)
        run = ctypes.CDLL(str(library(text, "chip", (*FLAGS, *PRECISIONS[precision])))).run
        count, addresses = (
            ctypes.c_long(len(samples)),
            [ctypes.c_void_p(a.ctypes.data) for a in (samples, results)],
        )

        def call():
            run(count, *addresses)
            return results

        call.keeps = samples  # what the first address is of
        return Attempt(call, judge, per=len(samples))

    return prepare


def on_arm(precision: type, chip: str) -> Callable[..., Attempt]:
    """prepare of an exported function on one of `arm.CHIPS`, with the instructions that it
    executes.
    """

    def prepare(problem, knob):
        text, samples, results, judge = _made(function_of, precision, problem, knob)
        program = OnArm(text, chip, samples.shape[1], results.shape[1], PRECISIONS[precision])

        def judge_all(found):
            return {**judge(found), "executed": program.executed(samples)}

        return Attempt(lambda: program.results(samples), judge_all, per=len(samples))

    return prepare


def _made(make, precision, problem, knob):
    """C text of a problem's function, its inputs and where results go, (n, all elements), and their
    judge.
    """
    index, knob = (DYNAMIC, knob) if problem == NEAR else (int(knob), 0.0)
    function, known = make(index), inputs_of(problem, knob)
    given = [known[function.name_in(k)] for k in range(function.n_in())]
    samples = np.ascontiguousarray(np.hstack(given), dtype=precision)
    results = np.empty(
        (len(samples), sum(function.numel_out(k) for k in range(function.n_out()))), precision
    )
    return _looped(function), samples, results, judged(problem, index, knob, function, precision)


def _looped(function):
    """C of `run`, the function for so many rows of inputs."""
    arguments, start = [], 0
    for k in range(function.n_in()):
        place = f"in + {start}"
        if function.name_in(k) == "assembly":
            place = f"(int)in[{start}]"
        if function.name_in(k) == "working":
            place = f"(int[2]){{(int)in[{start}], (int)in[{start + 1}]}}"
        arguments.append(place)
        start += function.numel_in(k)
    inputs, start = start, 0
    for k in range(function.n_out()):
        columns = function.size2_out(k)
        arguments.append(
            f"(fivebar_real (*)[{columns}])(out + {start})" if columns > 1 else f"out + {start}"
        )
        start += function.numel_out(k)
    return LOOP.format(
        prelude=PRELUDE,
        function=to_c(function, "model"),
        inputs=inputs,
        outputs=start,
        arguments=", ".join(arguments),
    )


def chart() -> Chart:
    places = sorted(range(len(NAMES)), key=lambda index: function_of(index).n_instructions())
    every, gaps = (
        {REGULAR: tuple(places), NEAR: GAPS[:9]},
        {REGULAR: (DIRECT, DYNAMIC), NEAR: GAPS[:9]},
    )
    need = ("C compiler",)
    methods = (
        Method("fivebar export, float", OURS, in_c(function_of, np.float32), every, need),
        Method(
            "fivebar export, double", "double precision", in_c(function_of, np.float64), every, need
        ),
        Method(
            "formulas as printed, float",
            "as printed",
            in_c(printed_function, np.float32),
            gaps,
            need,
        ),
        Method(
            "formulas as printed, double",
            "as printed, double",
            in_c(printed_function, np.float64),
            gaps,
            need,
        ),
        *(
            Method(
                f"{name}, ARM with {chip} precision",
                f"ARM with {chip} precision",
                on_arm(precision, chip),
                {ARM: tuple(places)},
                ("ARM compilers",),
            )
            for chip, name, precision in (
                ("single", "float", np.float32),
                ("single", "double", np.float64),
                ("double", "float", np.float32),
                ("double", "double", np.float64),
            )
        ),
    )
    largest = "largest error, in parts of the largest value"
    return Chart(
        name="chip",
        title="What single precision costs on a chip: error of exported C against its instructions",
        reading=(
            "Each point on the left is one function of `fivebar export --format c`, from left to"
            f" right {', '.join(NAMES[place] for place in places)}: its error over a hundred poses"
            " with |det A| above 0.3, against how many instructions it has, each one operation,"
            " sine, root or copy. Middle: the same as ARM executes it, counted by an emulator,"
            " with the sines of the GNU library (whose single ones are computed in double): a chip"
            " whose hardware has single precision alone, as a Cortex-M4F, and one that has double"
            " too. Right: M and c close to Type 2, where 1 / det A magnifies what the angles'"
            " rounding leaves, in any formula. References are the same instructions in extended"
            " precision. As printed: h = sqrt(l² - a²), passive joints by atan2, A inverted as it"
            " stands."
        ),
        problems={
            REGULAR: "regular poses",
            ARM: "regular poses on ARM",
            NEAR: "dynamic model near Type 2",
        },
        methods=methods,
        panels=(
            (
                Panel(
                    REGULAR,
                    "exported functions",
                    ylabel=largest,
                    x="instructions",
                    xlabel="instructions",
                ),
                Panel(
                    ARM,
                    "as ARM executes them",
                    ylabel=largest,
                    x="executed",
                    xlabel="instructions executed by a call",
                ),
                Panel(
                    NEAR,
                    "near Type 2",
                    ylabel=largest,
                    x="det_A",
                    xlabel="|det A|, median of the poses",
                    ceiling=10.0,
                ),
            ),
        ),
    )
