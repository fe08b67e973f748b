"""JavaScript of any casadi.Function of SX expressions: what a page in a browser computes with."""

from __future__ import annotations

import re
from functools import partial

import casadi as ca

from .instructions import Language, indexed, statements, variables, wrapped

RESERVED = """
    arguments await break case catch class const continue debugger default delete do else enum
    eval export extends false finally for function if implements import in instanceof interface
    let new null out package private protected public return static super switch this throw true
    try typeof var void while with yield Infinity Math NaN undefined
""".split()

# As C has them: what is no number is true there and false here, Math.min gives it on, Math.pow has
# other limits.
OWN = {
    ca.OP_NOT: "+({0} === 0)",
    ca.OP_AND: "+({0} !== 0 && {1} !== 0)",
    ca.OP_OR: "+({0} !== 0 || {1} !== 0)",
    ca.OP_IF_ELSE_ZERO: "{0} !== 0 ? {1} : 0",
    ca.OP_FMOD: "{0} % {1}",
    ca.OP_FMIN: "{0} < {1} || {1} !== {1} ? {0} : {1}",
    ca.OP_FMAX: "{0} > {1} || {1} !== {1} ? {0} : {1}",
    ca.OP_COPYSIGN: "{1} < 0 || 1 / {1} < 0 ? -Math.abs({0}) : Math.abs({0})",
    **dict.fromkeys(
        (ca.OP_POW, ca.OP_CONSTPOW),
        "{0} === 1 || ({0} === -1 && Math.abs({1}) === Infinity) ? 1 : {0} ** {1}",
    ),
}


def to_javascript(function: ca.Function, flat: bool = False) -> str:
    """Return the function in JavaScript: its inputs in, an object of its outputs by name out.

    Vectors are arrays x[n], matrices x[rows][columns], what is 1 x 1 a number. Equal to CasADi's
    own evaluation to the bit but for sin, cos and their like, which every browser rounds in its own
    way.
    flat: results by columns, one output after the other, into the array `out`, its last argument,
    which it gives back: nothing is allocated.
    ValueError for what is no function of SX expressions, for operations without words here and for
    names that JavaScript does not take.
    """
    name = function.name()
    inputs = [function.name_in(k) for k in range(function.n_in())]
    outputs = [function.name_out(k) for k in range(function.n_out())]
    for word in (name, *inputs, *outputs):
        if word in RESERVED or re.fullmatch(r"w\d+|[^A-Za-z_$].*", word):
            raise ValueError(
                f"{name}: {word!r} is no name in JavaScript, or taken; choose another one"
            )
    language = Language(
        _number, _call, indexed, partial(_flat, function, outputs) if flat else indexed, OWN
    )
    body = wrapped("let ", variables(function), ";")
    if not flat:
        own = [f"{each} = {_empty(function.size_out(k))}" for k, each in enumerate(outputs)]
        body += wrapped("let ", own, ";")
    body += [f"{line};" for line in statements(function, language)]
    body.append("return out;" if flat else f"return {{{', '.join(outputs)}}};")
    head = f"function {name}({', '.join([*inputs, 'out'] if flat else inputs)})"
    return f"{head} {{\n" + "\n".join(body) + "\n}\n"


def _number(value):
    if value != value:
        return "NaN"
    text = {ca.inf: "Infinity", -ca.inf: "-Infinity"}.get(value, repr(float(value)))
    return text.removesuffix(".0")


def _call(name, operands):
    return f"Math.{'abs' if name == 'fabs' else name}({', '.join(operands)})"


def _flat(function, outputs, name, shape, row, column):
    start = sum(function.numel_out(k) for k in range(outputs.index(name)))
    return f"out[{start + row + shape[0] * column}]"


def _empty(shape):
    rows, columns = shape
    if shape == (1, 1):
        return "0"
    if columns == 1:
        row = "0"
    else:
        row = f"[{', '.join('0' * columns)}]"
    return f"[{', '.join([row] * rows)}]"
