"""Exported C compiled and run, here or as ARM's under qemu, and CasADi's instructions evaluated one by one."""

import shutil
import subprocess

import casadi as ca
import numpy as np

from fivebar.models.machine_code import c_compiler

STRICT = (
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-pedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Werror",
)
ARM = "arm-linux-gnueabihf-gcc"
EMULATED = "qemu-arm"
TRIGONOMETRIC = {ca.OP_SIN, ca.OP_COS, ca.OP_ATAN2}
REAL = {False: np.float64, True: np.float32}

MAIN = """\
#include <stdio.h>
#include <string.h>
#include "{header}"
int main(int count, char **names)
{{
    fivebar_real in[16], out[16];
    int status, modes[2];
    (void)count;
{calls}    return 2;
}}
"""
CALL = """\
    if (!strcmp(names[1], "{name}")) {{
        while (fread(in, sizeof in[0], {inputs}, stdin) == {inputs}) {{
            modes[0] = (int)in[{first}];
            modes[1] = (int)in[{second}];
            (void)modes;
            status = {name}({arguments});
            fwrite(out, sizeof out[0], {outputs}, stdout);
            out[0] = (fivebar_real)status;
            fwrite(out, sizeof out[0], 1, stdout);
        }}
        return 0;
    }}
"""


class Program:
    """A header and its functions {name: casadi.Function} as a program. single: in floats; arm: for ARM."""

    def __init__(self, folder, text, functions, single=False, arm=False, flags=()):
        header = folder / "model.h"
        header.write_text(text, encoding="utf-8")
        self.functions, self.single, self.arm = functions, single, arm
        source, self.path = folder / "main.c", folder / f"main-{single}-{arm}"
        source.write_text(
            MAIN.format(header=header, calls="".join(_call(*each) for each in functions.items())),
            encoding="utf-8",
        )
        compiler = shutil.which(ARM) if arm else c_compiler()
        options = [
            *STRICT,
            "-O2",
            "-ffp-contract=off",
            *flags,
            *(["-DFIVEBAR_FLOAT"] * single),
            *(["-static"] * arm),
        ]
        done = subprocess.run(
            [compiler, *options, str(source), "-o", str(self.path), "-lm"],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr

    def __call__(self, name, samples):
        """Results (n, all elements, matrices by rows) and statuses (n,) of inputs (n, all elements)."""
        command = [shutil.which(EMULATED)] * self.arm + [str(self.path), name]
        kind = REAL[self.single]
        done = subprocess.run(
            command, input=np.asarray(samples, dtype=kind).tobytes(), capture_output=True
        )
        assert done.returncode == 0, done.stderr
        found = np.frombuffer(done.stdout, dtype=kind).reshape(len(samples), -1).astype(float)
        return found[:, :-1], found[:, -1].astype(int)


def _call(name, function):
    arguments, place = [], 0
    for k in range(function.n_in()):
        if function.name_in(k) in ("assembly", "working"):
            arguments.append("modes" if function.numel_in(k) > 1 else "modes[0]")
            mode = place
        else:
            arguments.append(f"in + {place}")
        place += function.numel_in(k)
    inputs, place = place, 0
    for k in range(function.n_out()):
        rows, columns = function.size_out(k)
        cast = f"(fivebar_real (*)[{columns}])" if columns > 1 else ""
        arguments.append(f"{cast}(out + {place})")
        place += rows * columns
    return CALL.format(
        name=name,
        inputs=inputs,
        outputs=place,
        arguments=", ".join(arguments),
        first=mode,
        second=min(mode + 1, 15),
    )


def rowwise(function):
    """For each result by rows its place among CasADi's, by columns."""
    places, start = [], 0
    for k in range(function.n_out()):
        rows, columns = function.size_out(k)
        places += [start + row + rows * column for row in range(rows) for column in range(columns)]
        start += rows * columns
    return places


def in_casadi(function, samples):
    """Results by rows of CasADi's own virtual machine."""
    ends = np.cumsum([function.numel_in(k) for k in range(function.n_in())])[:-1]
    found = []
    for sample in samples:
        values = function.call([ca.DM(part) for part in np.split(sample, ends)])
        found.append(np.concatenate([value.full().ravel() for value in values]))
    return np.array(found)


def evaluate(function, samples, moved=(), by=0.0):
    """Results by rows (1 + moved, n, all elements), instruction by instruction in NumPy.

    moved: instructions each of whose results in turn grows by this share of it; the first is without.
    """
    starts = np.cumsum([0, *(function.numel_in(k) for k in range(function.n_in()))])
    ends = np.cumsum([0, *(function.numel_out(k) for k in range(function.n_out()))])
    shape = 1 + len(moved), len(samples)
    rows = {k: row for row, k in enumerate(moved, 1)}
    work, results = {}, np.empty((*shape, ends[-1]))
    for k in range(function.n_instructions()):
        code, inputs, outputs = (
            function.instruction_id(k),
            function.instruction_input(k),
            function.instruction_output(k),
        )
        if code == ca.OP_OUTPUT:
            results[..., ends[outputs[0]] + outputs[1]] = work[inputs[0]]
            continue
        if code == ca.OP_INPUT:
            value = samples[:, starts[inputs[0]] + inputs[1]]
        elif code == ca.OP_CONST:
            value = np.full(len(samples), function.instruction_constant(k))
        else:
            value = OPERATIONS[code](*(work[slot] for slot in inputs))
        if k in rows:
            value = np.array(np.broadcast_to(value, shape))
            value[rows[k]] *= 1 + by
        work[outputs[0]] = value
    return results[..., rowwise(function)]


OPERATIONS = {
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_DIV: np.divide,
    ca.OP_NEG: np.negative,
    ca.OP_SQ: np.square,
    ca.OP_TWICE: lambda x: 2 * x,
    ca.OP_INV: lambda x: 1 / x,
    ca.OP_SQRT: np.sqrt,
    ca.OP_SIN: np.sin,
    ca.OP_COS: np.cos,
    ca.OP_ATAN2: np.arctan2,
    ca.OP_CEIL: np.ceil,
    ca.OP_FABS: np.abs,
    ca.OP_SIGN: np.sign,
    ca.OP_ASSIGN: np.positive,
    ca.OP_FMIN: np.fmin,
    ca.OP_COPYSIGN: np.copysign,
    ca.OP_LT: lambda x, y: 1.0 * (x < y),
    ca.OP_LE: lambda x, y: 1.0 * (x <= y),
    ca.OP_EQ: lambda x, y: 1.0 * (x == y),
    ca.OP_NOT: lambda x: 1.0 * (x == 0),
    ca.OP_IF_ELSE_ZERO: lambda condition, x: np.where(condition, x, 0.0),
}


def bound(function, samples, share, only=None):
    """Of each result, what a change of every instruction's by this share of it can make, to first order.

    only: the operations that change.
    """
    codes = [function.instruction_id(k) for k in range(function.n_instructions())]
    moved = [
        k for k, code in enumerate(codes) if code != ca.OP_OUTPUT and (only is None or code in only)
    ]
    exact, *others = evaluate(function, samples, moved, share)
    return np.sum(np.abs(others - exact), axis=0) if moved else np.zeros_like(exact)
