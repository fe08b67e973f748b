"""Exported C in single and in double precision: error against instructions and near Type 2.

The instructions of the C are carried out on arrays, so that no compiler is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import casadi as ca
import numpy as np

from ....exporters.header import CONTROLLER, MODELS, NAMES, controller
from ....models.compiled import compile
from ....models.geometry import dgm
from ....models.instructions import Language, statements
from ....models.kinematics import dkm, dkm2
from ..chart import OURS, Attempt, Chart, Failed, Method, Panel
from .dgm_routes import ROBOT
from .geometry import GAPS, poses

REGULAR = "regular"
NEAR = "near"
DYNAMIC = NAMES.index("dynamic_model")
# Instructions as Python on arrays of a precision.
NAMES_IN_NUMPY = {"atan2": "arctan2", "fabs": "abs", "fmin": "minimum", "fmax": "maximum"}
IN_NUMPY = Language(
    lambda value: f"number({value!r})",
    lambda name, operands: f"{NAMES_IN_NUMPY.get(name, name)}({', '.join(operands)})",
    lambda name, shape, row, column: f"given[{name!r}][:, {row}]",
    lambda name, shape, row, column: f"result[{name!r}][:, {row + shape[0] * column}]",
)
LARGEST = "largest error, in parts of the largest value"


@cache
def exported(index: int) -> ca.Function:
    """Return the exported function of this place among NAMES."""
    name = NAMES[index]
    return controller(ROBOT) if name == CONTROLLER else compile(ROBOT, *MODELS[name][:2])


@cache
def inputs_of(problem: str, gap: float) -> dict[str, np.ndarray]:
    """Return {input: (n, its elements)}, in single precision, of poses of assembly mode -1."""
    q = poses("singular", gap).q if problem == NEAR else poses("batch").q
    q_dot, q_ddot, offset = np.random.default_rng(21).normal(size=(3, *q.shape))
    q = q.astype(np.float32).astype(float)
    pose = dgm(ROBOT, q, unreachable="nan")
    good = np.isfinite(pose.q_passive).all(axis=1)
    if problem != NEAR:
        good &= (np.abs(pose.sines) > 0.3).all(axis=0)
    q = q[good]
    q_dot = q_dot[good]
    q_ddot = q_ddot[good]
    offset = offset[good]
    acc = dkm2(dkm(dgm(ROBOT, q), q_dot), q_ddot)
    pose = acc.rates.pose
    ones = np.ones((len(q), 1))
    inputs = {
        "q": q,
        "q_dot": q_dot,
        "q_ddot": q_ddot,
        "xi": pose.xi,
        "xi_dot": acc.rates.xi_dot,
        "xi_ddot": acc.xi_ddot,
        "assembly": -ones,
        "working": pose.working,
        "tau": 0.1 * offset,
        "q_ref": q + 0.1 * offset,
        "q_ref_dot": q_dot,
        "q_ref_ddot": q_ddot,
        "kp": 100 * ones * (1, 1),
        "kd": 20 * ones * (1, 1),
        "det_A": pose.det_A[:, None],
    }
    return {name: np.asarray(value, np.float32).astype(float) for name, value in inputs.items()}


def evaluated(function: ca.Function, problem: str, gap: float, precision: type) -> np.ndarray:
    """Return results (n, all elements) of the instructions of a function in this precision."""
    known = inputs_of(problem, gap)
    inputs = {function.name_in(k): known[function.name_in(k)] for k in range(function.n_in())}
    given: dict = {name: value.astype(precision) for name, value in inputs.items()}
    count = len(known["q"])
    outputs = range(function.n_out())
    result: dict = {
        function.name_out(k): np.empty((count, function.numel_out(k)), precision) for k in outputs
    }
    names = {name: getattr(np, name) for name in ("sqrt", "sin", "cos", "arctan2", "ceil", "abs")}
    names |= {"number": precision, "given": given, "result": result}
    exec("\n".join(statements(function, IN_NUMPY)), {}, names)
    return np.hstack(list(result.values()))


@cache
def exact(problem: str, index: int, gap: float) -> np.ndarray:
    """Return the results (n, all elements) of the exported function in extended precision."""
    if np.finfo(np.longdouble).eps > 1e-18:
        raise Failed("no wider numbers here to compare with")
    return evaluated(exported(index), problem, gap, np.longdouble)


def judged(problem: str, index: int, gap: float, function: ca.Function) -> Callable:
    """Return judge: results -> largest error of an output, in parts of its largest value."""
    wide = exact(problem, index, gap)
    det_A = inputs_of(problem, gap)["det_A"]
    edges = np.cumsum([function.numel_out(k) for k in range(function.n_out())])[:-1]

    def judge(results):
        errors = []
        for a, b in zip(np.split(results, edges, axis=1), np.split(wide, edges, axis=1)):
            errors.append(np.abs(a - b).max() / np.abs(b).max())
        return {
            "error": np.max(errors),
            "instructions": function.n_instructions(),
            "det_A": np.median(np.abs(det_A)),
        }

    return judge


def in_precision(
    precision: type, make: Callable[[int], ca.Function] = exported
) -> Callable[..., Attempt]:
    """Return prepare of a function make(place among NAMES)."""

    def prepare(problem, knob):
        index, gap = (DYNAMIC, knob) if problem == NEAR else (int(knob), 0.0)
        function = make(index)
        per = len(inputs_of(problem, gap)["q"])
        judge = judged(problem, index, gap, function)
        return Attempt(lambda: evaluated(function, problem, gap, precision), judge, per)

    return prepare


def by_size() -> list[int]:
    """Return the places of the exported functions among NAMES, the smallest first."""
    return sorted(range(len(NAMES)), key=lambda index: exported(index).n_instructions())


def chart() -> Chart:
    """Return the chart of precisions."""
    places = by_size()
    knobs = {REGULAR: tuple(places), NEAR: GAPS[:9]}
    single = in_precision(np.float32)
    double = in_precision(np.float64)
    methods = (
        Method("fivebar export, float", OURS, single, knobs),
        Method("fivebar export, double", "double precision", double, knobs),
    )
    regular = Panel(
        REGULAR, "exported functions", ylabel=LARGEST, x="instructions", xlabel="instructions"
    )
    near = Panel(
        NEAR,
        "near Type 2",
        ylabel=LARGEST,
        x="det_A",
        xlabel="|det A|, median of the poses",
        ceiling=10.0,
    )
    return Chart(
        name="chip",
        title="What single precision costs on a chip: error of exported C against its instructions",
        reading=(
            "Left: each point is one function of `fivebar export --format c`, from left to right"
            f" {', '.join(NAMES[place] for place in places)}: its error over a hundred poses with"
            " |det A| above 0.3, against its number of instructions, each one operation, sine, root"
            " or copy. Right: M and c close to Type 2, where 1 / det A magnifies the rounding of"
            " the angles, in any formula. The reference is the same instructions in extended"
            " precision."
        ),
        problems={REGULAR: "regular poses", NEAR: "dynamic model near Type 2"},
        methods=methods,
        panels=((regular, near),),
    )
