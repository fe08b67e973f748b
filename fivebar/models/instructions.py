"""A casadi.Function as lines of another language: one walk over its instructions, whatever the
language.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import casadi as ca

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# What all languages of C's family write alike; {0}, {1}: the operands. Truth is a number, 0 or 1.
OPERATIONS = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "1 / {0}",
    ca.OP_LT: "+({0} < {1})",
    ca.OP_LE: "+({0} <= {1})",
    ca.OP_EQ: "+({0} == {1})",
    ca.OP_NE: "+({0} != {1})",
    ca.OP_NOT: "+!{0}",
    ca.OP_AND: "+({0} && {1})",
    ca.OP_OR: "+({0} || {1})",
    ca.OP_IF_ELSE_ZERO: "{0} ? {1} : 0",
    ca.OP_SIGN: "{0} < 0 ? -1 : {0} > 0 ? 1 : {0}",
}
# Operation -> (its function's name in C and in most languages, operands).
FUNCTIONS = {
    ca.OP_SQRT: ("sqrt", 1),
    ca.OP_SIN: ("sin", 1),
    ca.OP_COS: ("cos", 1),
    ca.OP_TAN: ("tan", 1),
    ca.OP_ASIN: ("asin", 1),
    ca.OP_ACOS: ("acos", 1),
    ca.OP_ATAN: ("atan", 1),
    ca.OP_ATAN2: ("atan2", 2),
    ca.OP_EXP: ("exp", 1),
    ca.OP_LOG: ("log", 1),
    ca.OP_TANH: ("tanh", 1),
    ca.OP_POW: ("pow", 2),
    ca.OP_CONSTPOW: ("pow", 2),
    ca.OP_FABS: ("fabs", 1),
    ca.OP_CEIL: ("ceil", 1),
    ca.OP_FLOOR: ("floor", 1),
    ca.OP_FMIN: ("fmin", 2),
    ca.OP_FMAX: ("fmax", 2),
    ca.OP_FMOD: ("fmod", 2),
    ca.OP_HYPOT: ("hypot", 2),
    ca.OP_COPYSIGN: ("copysign", 2),
}
WIDTH = 118  # of a line
OTHERS = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


@dataclass(frozen=True)
class Language:
    """How a language writes instructions.

    number (value) -> literal; call (name, operands) -> call of a function of FUNCTIONS; read
    (input's name, its rows and columns, row, column) -> an element; write likewise of an output;
    operations: what differs from OPERATIONS.
    """

    number: Callable[[float], str]
    call: Callable[[str, list[str]], str]
    read: Callable[[str, tuple, int, int], str]
    write: Callable[[str, tuple, int, int], str]
    operations: dict[int, str] = field(default_factory=dict)


def indexed(name: str, shape: tuple, row: int, column: int) -> str:
    """Return an element of a vector or a matrix of this shape; of what is one number its name."""
    if shape == (1, 1):
        return name
    if shape[1] == 1:
        return f"{name}[{row}]"
    return f"{name}[{row}][{column}]"


def statements(function: ca.Function, language: Language) -> Iterator[str]:
    """Yield the assignments, without their semicolons, that compute a function of dense SX
    expressions.

    They use the variables of `variables`. ValueError for a function that is none, or an operation
    unknown here.
    """
    if not function.is_a("SXFunction"):
        raise ValueError(
            f"{function.name()} must be a function of SX expressions, not a {function.class_name()}"
        )
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        inputs = function.instruction_input(k)
        outputs = function.instruction_output(k)
        if code == ca.OP_OUTPUT:
            target = _element(language.write, function.name_out, function.sparsity_out, *outputs)
            yield f"{target} = {_variable(inputs[0])}"
            continue
        if code == ca.OP_INPUT:
            value = _element(language.read, function.name_in, function.sparsity_in, *inputs)
        elif code == ca.OP_CONST:
            value = language.number(function.instruction_constant(k))
        else:
            value = _operation(function, code, [_variable(slot) for slot in inputs], language)
        yield f"{_variable(outputs[0])} = {value}"


def _operation(function, code, operands, language):
    if known := language.operations.get(code) or OPERATIONS.get(code):
        return known.format(*operands)
    if code in FUNCTIONS:
        name, count = FUNCTIONS[code]
        return language.call(name, operands[:count])
    raise ValueError(f"{function.name()}: no words for CasADi's operation {OTHERS.get(code, code)}")


def wrapped(start: str, words: list[str], end: str, hang: bool = False) -> list[str]:
    """start, the words with commas between them, end, in lines of WIDTH, none for no words; hang:
    under the first.
    """
    lines = [start]
    for k, word in enumerate(words):
        piece = word + (end if k == len(words) - 1 else ", ")
        if len(lines[-1]) + len(piece) > WIDTH:
            lines.append(" " * len(start) * hang)
        lines[-1] += piece
    return [line.rstrip() for line in lines] if words else []


def variables(function: ca.Function) -> list[str]:
    """Return names of the variables that the statements assign to."""
    return [_variable(slot) for slot in range(function.sz_w())]


def _variable(slot):
    return f"w{slot}"


def _element(write, name, sparsity, which, place):
    pattern = sparsity(which)
    if not pattern.is_dense():
        raise ValueError(f"{name(which)} must be dense")
    rows, columns = pattern.shape
    return write(name(which), (rows, columns), place % rows, place // rows)
