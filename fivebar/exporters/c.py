"""C99 of compiled models: one header, no allocation, float or double; and any casadi.Function as a
C function.
"""

from __future__ import annotations

import textwrap

import casadi as ca

from ..models.instructions import WIDTH, Language, indexed, statements, variables, wrapped

INTEGERS = "assembly", "working"  # inputs that are modes

PRELUDE = """\
#include <math.h>

#ifdef __FAST_MATH__
#error "results that are no numbers tell of a pose out of reach: compile without -ffast-math"
#endif

/* For single precision, which a small chip has in hardware, define it: -DFIVEBAR_FLOAT. */
#ifndef FIVEBAR_
#ifdef FIVEBAR_FLOAT
typedef float fivebar_real;
#define FIVEBAR_(x) x##f
#else
typedef double fivebar_real;
#define FIVEBAR_(x) x
#endif
#endif
"""


def _number(value):
    # A macro gives it the suffix of a float: a double in an expression would take all of it to
    # double.
    text = {ca.inf: "INFINITY", -ca.inf: "-INFINITY"}.get(value, f"FIVEBAR_({float(value)!r})")
    return "NAN" if value != value else text


def _read(name, shape, row, column):
    cast = "(fivebar_real)" if name in INTEGERS else ""
    return cast + indexed(name, shape, row, column)


def _write(name, shape, row, column):
    return f"*{name}" if shape == (1, 1) else indexed(name, shape, row, column)


LANGUAGE = Language(
    _number, lambda name, operands: f"FIVEBAR_({name})({', '.join(operands)})", _read, _write
)


def to_c(function: ca.Function, name: str, about: str = "", safe: bool = False) -> str:
    """Return a static C function of this name: its inputs, then its outputs, vectors as x[n],
    matrices as x[rows][columns].

    It returns 0, or 1 where a result is not finite, which with safe is then 0. about: for the
    comment above it.
    """
    arguments = [_argument(function, k, False) for k in range(function.n_in())]
    arguments += [_argument(function, k, True) for k in range(function.n_out())]
    body = wrapped("fivebar_real ", variables(function), ";", hang=True)
    body += [f"{line};" for line in statements(function, LANGUAGE)]
    results = list(_results(function))
    finite = [
        f"{each} - {each} == 0" for each in results
    ]  # neither for infinities nor for what is no number
    good = " && ".join(finite)
    if safe:
        body += [f"if ({good}) return 0;", f"{' = '.join(results)} = 0;", "return 1;"]
    else:
        body.append(f"return !({good});")
    head = "".join(f" * {line}\n" for line in textwrap.wrap(about, WIDTH - 3))
    comment = f"/*\n{head} * {function.n_instructions()} instructions.\n */\n"
    lines = "\n".join(f"    {line}" for line in body)
    declaration = "\n".join(wrapped(f"static inline int {name}(", arguments, ")", hang=True))
    return f"{comment}{declaration}\n{{\n{lines}\n}}\n"


def _argument(function, k, out):
    name = (function.name_out if out else function.name_in)(k)
    rows, columns = (function.size_out if out else function.size_in)(k)
    kind = "int" if name in INTEGERS else "fivebar_real"
    if (rows, columns) == (1, 1):
        return f"{kind} *{name}" if out else f"{kind} {name}"
    places = f"[{rows}]" if columns == 1 else f"[{rows}][{columns}]"
    return f"{'' if out or columns > 1 else 'const '}{kind} {name}{places}"


def _results(function):
    for k in range(function.n_out()):
        rows, columns = function.size_out(k)
        for row in range(rows):
            for column in range(columns):
                yield _write(function.name_out(k), (rows, columns), row, column)
