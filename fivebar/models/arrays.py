"""Compiled models as plain Python functions of arrays, for every library of the array API standard:
NumPy, JAX, PyTorch.
"""

from __future__ import annotations

import inspect
import keyword
import math
import re
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import casadi as ca
import numpy as np

from ..base.checks import shown
from .instructions import Language, statements

# The square root's derivative at 0 would make nan of the derivative of a choice that does not take
# it: it is 0 here.
OPERATIONS = {
    ca.OP_SQRT: "xp.where({0} == 0, {0}, xp.sqrt(xp.where({0} == 0, one, {0})))",
    ca.OP_LT: "xp.where({0} < {1}, one, zero)",
    ca.OP_LE: "xp.where({0} <= {1}, one, zero)",
    ca.OP_EQ: "xp.where({0} == {1}, one, zero)",
    ca.OP_NE: "xp.where({0} != {1}, one, zero)",
    ca.OP_NOT: "xp.where({0} == 0, one, zero)",
    ca.OP_AND: "xp.where(({0} != 0) & ({1} != 0), one, zero)",
    ca.OP_OR: "xp.where(({0} != 0) | ({1} != 0), one, zero)",
    ca.OP_IF_ELSE_ZERO: "xp.where({0} != 0, {1}, zero)",
    ca.OP_SIGN: "xp.where({0} < 0, -one, xp.where({0} > 0, one, {0}))",
    ca.OP_FABS: "xp.abs({0})",
    ca.OP_FMIN: "xp.where(({0} < {1}) | ({1} != {1}), {0}, {1})",
    ca.OP_FMAX: "xp.where(({0} > {1}) | ({1} != {1}), {0}, {1})",
}
BLOCK = 16_384  # rows: what is computed on the way to their results stays in a processor's cache
OWN_NAMES = re.compile(r"xp|zeros?|one|w\d+|.*_\d\d")  # in the text


def array_function(function: ca.Function, arguments: Sequence[str], xp: Any) -> Callable:
    """Return a function of dense SX expressions as a function of arrays of the library xp.

    arguments: the inputs given by position; the others, numbers or one for each of the batch, are
    given by name. ValueError where the library lacks what is needed.
    """
    text = source(function, arguments)
    needed = sorted(set(re.findall(r"\bxp\.(\w+)", text)) | {"float32", "float64"})
    if missing := [name for name in needed if not hasattr(xp, name)]:
        raise ValueError(
            f"to = {shown(xp)} has no {', '.join(missing)}: give a library of the array API"
            " standard, such as numpy, jax.numpy or torch"
        )
    names = {"xp": xp}
    exec(text, names)
    plain = names[function.name()]
    lengths = {name: function.numel_in(name) for name in function.name_in()}
    signature = inspect.signature(plain)

    @wraps(plain)
    def checked(*arrays, **numbers):
        given = signature.bind(*arrays, **numbers).arguments
        _check(given, lengths, xp)
        if xp is not np:
            return plain(**given)
        with np.errstate(all="ignore"):  # out of reach the result is nan
            return _in_blocks(plain, given, lengths)

    return checked


def _in_blocks(plain, given, lengths):
    """Call a function of NumPy's arrays, block by block along its first axis."""
    batches = {
        name: np.shape(value)[: np.ndim(value) - (lengths[name] > 1)]
        for name, value in given.items()
    }
    whole = np.broadcast_shapes(*batches.values())
    if math.prod(whole) <= BLOCK:
        return plain(**given)
    rows = max(BLOCK * whole[0] // math.prod(whole), 1)
    of_rows = [
        name
        for name, batch in batches.items()
        if batch[:1] == whole[:1] and len(batch) == len(whole)
    ]
    blocks = []
    for k in range(0, whole[0], rows):
        part = {name: given[name][k : k + rows] for name in of_rows}
        blocks.append(plain(**given | part))
    if isinstance(blocks[0], tuple):
        return tuple(map(np.concatenate, zip(*blocks)))
    return np.concatenate(blocks)


def source(function: ca.Function, arguments: Sequence[str]) -> str:
    """Return the text of `array_function`; the library is `xp` in it."""
    inputs = function.name_in()
    numbers = [name for name in inputs if name not in arguments]
    for name in numbers:
        if not name.isidentifier() or keyword.iskeyword(name) or OWN_NAMES.fullmatch(name):
            raise ValueError(f"the symbol {name!r} needs another name, which is free in Python")
    batch = [f"{name}[..., 0]" if function.numel_in(name) > 1 else name for name in inputs]
    lines = [
        f"zeros = xp.zeros_like({' + '.join(batch)})",
        "zero = xp.sum(zeros)",
        "one = zero + 1",
        *statements(function, LANGUAGE),
    ]
    outputs = [_whole(name, function.size_out(name)) for name in function.name_out()]
    lines.append(f"return {', '.join(outputs)}")
    signature = [*arguments, "*", *numbers] if numbers else arguments
    return "\n    ".join([f"def {function.name()}({', '.join(signature)}):", *lines]) + "\n"


def _number(value):
    # An array without axes, as PyTorch's functions of two arrays take no plain number.
    return f"zero + {float(value)!r}" if math.isfinite(value) else f"zero + float('{value}')"


def _read(name, shape, row, column):
    return f"zero + {name}" if shape == (1, 1) else f"{name}[..., {row}]"


def _element(name, shape, row, column):
    return f"{name}_{row}{column}"


def _call(name, operands):
    return f"xp.{name}({', '.join(operands)})"


LANGUAGE = Language(_number, _call, _read, _element, OPERATIONS)


def _whole(name, shape):
    """Return the text of an output as one array of the whole batch."""
    places = np.ndindex(*shape)
    parts = [f"xp.broadcast_to({_element(name, shape, *place)}, zeros.shape)" for place in places]
    if shape == (1, 1):
        return parts[0]
    stacked = f"xp.stack([{', '.join(parts)}], axis=-1)"
    if shape[1] == 1:
        return stacked
    return f"xp.reshape({stacked}, (*zeros.shape, {shape[0]}, {shape[1]}))"


def _check(given, lengths, xp):
    """Refuse what is no array of this library, of floats, of the right shape."""
    first = None
    for name, value in given.items():
        length = lengths[name]
        if length == 1 and isinstance(value, (int, float)):
            continue
        kind = getattr(value, "dtype", None)
        # Without its setting for float64, JAX takes such an array and makes float32 of it.
        if (
            kind not in (xp.float32, xp.float64)
            or xp.broadcast_to(value, value.shape).dtype != kind
        ):
            library = type(value).__module__.split(".")[0]
            raise TypeError(
                f"{name} must be {'a number or ' * (length == 1)}an array of {xp.__name__}, of"
                ' float32 or float64 (in JAX by jax.config.update("jax_enable_x64", True)), not'
                f" {shown(value) if kind is None else f'one of {library}, of {kind}'}"
            )
        if length > 1 and tuple(value.shape[-1:]) != (length,):
            raise ValueError(f"{name} must have shape (*batch, {length}), not {tuple(value.shape)}")
        first = first or (name, kind)
        if kind != first[1]:
            raise TypeError(f"{name} is {kind} and {first[0]} {first[1]}: give arrays of one kind")
