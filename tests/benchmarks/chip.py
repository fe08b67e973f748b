"""The chart of precisions with the formulas as printed, and exported C as two ARM chips execute it."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np

from fivebar.exporters.c import PRELUDE, to_c
from fivebar.exporters.header import NAMES
from fivebar.study.speed_accuracy.chart import Attempt, Chart, Method, Panel
from fivebar.study.speed_accuracy.charts import chip
from fivebar.study.speed_accuracy.charts.dgm_routes import ROBOT, printed

from .arm import OnArm, lacks_arm

ARM, DIRECT = "arm", NAMES.index("dgm")


@cache
def as_printed(index: int) -> ca.Function:
    """Return the function as handouts have it: h = sqrt(l^2 - a^2), passive joints by atan2, A
    inverted as it stands.
    """
    q, q_dot, assembly = ca.SX.sym("q", 2), ca.SX.sym("q_dot", 2), ca.SX.sym("assembly")
    x, y = printed(q[0], q[1])
    if index == DIRECT:
        xi = ca.cse([ca.vertcat(x, y)])
        return ca.Function("printed", [q, assembly], xi, ["q", "assembly"], ["xi"])
    base = ca.DM([-ROBOT.d / 2, ROBOT.d / 2])
    l1, l2 = ca.DM([ROBOT.l11, ROBOT.l21]), ca.DM([ROBOT.l12, ROBOT.l22])
    passive = ca.atan2(y - l1 * ca.sin(q), x - base - l1 * ca.cos(q)) - q
    ux, uy = ca.cos(q + passive), ca.sin(q + passive)
    inverse = ca.inv(ca.horzcat(ux, uy))
    J = inverse @ ca.diag(l1 * ca.sin(passive))
    xi_dot = J @ q_dot
    cosine = ux * ca.cos(q) + uy * ca.sin(q)
    phi_dot = (ux * xi_dot[1] - uy * xi_dot[0] - l1 * cosine * q_dot) / l2
    d = -l1 * cosine * q_dot**2 - l2 * phi_dot**2
    M = ca.diag(ca.DM([ROBOT.zz1, ROBOT.zz2])) + ROBOT.m * J.T @ J
    c = ROBOT.m * J.T @ inverse @ d
    names = ["q", "q_dot", "assembly"]
    outputs = ca.cse([ca.densify(M), c])
    return ca.Function("printed", [q, q_dot, assembly], outputs, names, ["M", "c"])


PRECISIONS = {np.float32: ("-DFIVEBAR_FLOAT",), np.float64: ()}
LOOP = """
{prelude}{function}
void run(long count, const fivebar_real *in, fivebar_real *out)
{{
    for (long k = 0; k < count; k++, in += {inputs}, out += {outputs}) model({arguments});
}}
"""


def loop_of(function: ca.Function) -> str:
    """Return C of `run`: the function for so many rows of inputs."""
    arguments, inputs, outputs = [], 0, 0
    for k in range(function.n_in()):
        place = f"in + {inputs}"
        if function.name_in(k) == "assembly":
            place = f"(int)in[{inputs}]"
        if function.name_in(k) == "working":
            place = f"(int[2]){{(int)in[{inputs}], (int)in[{inputs + 1}]}}"
        arguments.append(place)
        inputs += function.numel_in(k)
    for k in range(function.n_out()):
        columns = function.size2_out(k)
        cast = f"(fivebar_real (*)[{columns}])" if columns > 1 else ""
        arguments.append(f"{cast}(out + {outputs})")
        outputs += function.numel_out(k)
    return LOOP.format(
        prelude=PRELUDE,
        function=to_c(function, "model"),
        inputs=inputs,
        outputs=outputs,
        arguments=", ".join(arguments),
    )


def on_arm(precision, hardware):
    """Return prepare of an exported function on one of `arm.CHIPS`, with the instructions that it executes."""

    def prepare(_, knob):
        function, known = chip.exported(int(knob)), chip.inputs_of(chip.REGULAR, 0.0)
        columns = [known[function.name_in(k)] for k in range(function.n_in())]
        samples = np.ascontiguousarray(np.hstack(columns), dtype=precision)
        outputs = sum(function.numel_out(k) for k in range(function.n_out()))
        program = OnArm(
            loop_of(function), hardware, samples.shape[1], outputs, PRECISIONS[precision]
        )
        judge = chip.judged(chip.REGULAR, int(knob), 0.0, function)

        def judge_all(results):
            return judge(results) | {"executed": program.executed(samples)}

        return Attempt(lambda: program.results(samples), judge_all, per=len(samples))

    return prepare


def chart() -> Chart:
    """Return the chart of precisions with a panel for ARM."""
    known = chip.chart()
    methods = list(known.methods)
    knobs = {chip.REGULAR: (DIRECT, chip.DYNAMIC), chip.NEAR: chip.GAPS[:9]}
    for name, precision in (("float", np.float32), ("double", np.float64)):
        prepare = chip.in_precision(precision, as_printed)
        methods.append(
            Method(f"formulas as printed, {name}", f"as printed, {name}", prepare, knobs)
        )
    for hardware in ("single", "double"):
        for name, precision in (("float", np.float32), ("double", np.float64)):
            family = f"ARM with {hardware} precision"
            knobs = {ARM: tuple(chip.by_size())}
            prepare = on_arm(precision, hardware)
            methods.append(Method(f"{name}, {family}", family, prepare, knobs, (lacks_arm,)))
    panel = Panel(
        ARM,
        "as ARM executes them",
        ylabel=chip.LARGEST,
        x="executed",
        xlabel="instructions executed by a call",
    )
    return replace(
        known,
        reading=f"{known.reading} As printed: h = sqrt(l² - a²), passive joints by atan2, A inverted as it stands. On ARM: as executed by a call, counted by an emulator, with the sines of the GNU"
        " library (whose single ones are computed in double): a chip whose hardware has single precision alone, as a"
        " Cortex-M4F, and one that has double too.",
        problems=known.problems | {ARM: "regular poses on ARM"},
        methods=tuple(methods),
        panels=((known.panels[0][0], panel, known.panels[0][1]),),
    )
