"""One spelling of the elementary functions for Python floats, NumPy arrays and CasADi symbols.

Equations are written on components. A component is a float (one pose), an array (a batch) or a
CasADi symbol.
"""

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np

EPS = np.finfo(float).eps
HUGE = 1e60  # of coordinates, rates, torques: of what is larger, products might overflow
_FLOAT = np.dtype(float)
_EXACT = ContextVar("exact", default=False)


@contextmanager
def as_numbers() -> Iterator[None]:
    """Give CasADi symbols the limits of numbers within the block: rounding forgiven, nan beyond.

    For models in another language. It costs comparisons, and its derivatives are of no use.
    """
    token = _EXACT.set(True)
    try:
        yield
    finally:
        _EXACT.reset(token)


@contextmanager
def numpy_on_symbols() -> Iterator[None]:
    """Leave out CasADi's warning that a function of NumPy was called on its symbols."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _chosen(condition, value, otherwise):
    import casadi

    return casadi.if_else(condition, value, otherwise)


def is_symbolic(x):
    """Return whether x is a CasADi matrix, without importing CasADi."""
    return type(x).__module__.startswith("casadi")


def _module(x):
    if isinstance(x, float):
        return math
    if is_symbolic(x):
        import casadi

        return casadi
    return np


def sin(x):
    return _module(x).sin(x)


def cos(x):
    return _module(x).cos(x)


def sqrt(x):
    return _module(x).sqrt(x)


def minimum(x, y):
    return _module(x).fmin(x, y) if is_symbolic(x) else np.minimum(x, y)


def maximum(x, y):
    return _module(x).fmax(x, y) if is_symbolic(x) else np.maximum(x, y)


def hypot(x, y):
    return _module(x).hypot(x, y)


def copysign(x, y):
    return _module(x).copysign(x, y)


def atan2(y, x):
    """Return the angle of (x, y) in (-pi, pi]."""
    angle = _module(y).atan2(y, x)
    if isinstance(angle, float):
        return math.pi if angle == -math.pi else angle
    if is_symbolic(angle):
        return _chosen(angle == -math.pi, math.pi, angle) if _EXACT.get() else angle
    return np.where(angle == -np.pi, np.pi, angle)


def wrap(angle):
    """Return an angle (rad) modulo 2 pi, in (-pi, pi]; small ones to the last bit."""
    return angle - 2 * math.pi * _module(angle).ceil(angle / (2 * math.pi) - 0.5)


def sqrt_or_nan(square, floor):
    """Return sqrt(square), 0 for rounding errors in [floor, 0), nan below.

    CasADi symbols get a bare sqrt. floor: a number, or a function that returns it where needed.
    """
    if is_symbolic(square):
        if not _EXACT.get():
            return sqrt(square)
        floor = floor() if callable(floor) else floor
        return _chosen(square >= floor, sqrt(_chosen(square >= 0, square, 0.0)), math.nan)
    if isinstance(square, float) and square >= 0:
        return math.sqrt(square)
    if not isinstance(square, float) and (square.size == 0 or square.min() >= 0):
        return np.sqrt(square)
    floor = floor() if callable(floor) else floor
    if isinstance(square, float):
        return 0.0 if square >= floor else math.nan
    return np.where(square >= floor, np.sqrt(np.maximum(square, 0.0)), np.nan)


def where_zero(x, value, otherwise):
    """Return value() where x is 0, else otherwise; CasADi symbols get otherwise."""
    if isinstance(x, float):
        return value() if x == 0 else otherwise
    if is_symbolic(x) and _EXACT.get():
        return _chosen(x == 0, value(), otherwise)
    return otherwise if is_symbolic(x) or x.all() else np.where(x == 0, value(), otherwise)


def reciprocal_or_nan(x, floor):
    """Return 1 / x, nan where x <= floor; CasADi symbols get a bare division."""
    if isinstance(x, float):
        return 1.0 / x if x > floor else math.nan
    if is_symbolic(x) and _EXACT.get():
        return _chosen(x > floor, 1.0 / x, math.nan)
    if is_symbolic(x) or x.size == 0 or np.all(x.min() > floor):
        return 1.0 / x
    return 1.0 / np.where(x > floor, x, np.nan)


def sign(x, tolerance):
    """Return +1, -1, or 0 where |x| <= tolerance or x is nan, as int8; of symbols CasADi's sign."""
    if is_symbolic(x):
        return (x > tolerance) - (x < -tolerance) if _EXACT.get() else _module(x).sign(x)
    return np.subtract(x > tolerance, x < -tolerance, dtype=np.int8)


def unpack(v, name):
    """Return both components of v (*batch, 2): floats without a batch, else contiguous arrays."""
    if is_symbolic(v) and type(v).__name__ == "DM":
        v = v.full().ravel()  # CasADi's numbers are numbers
    if is_symbolic(v):
        if v.numel() != 2:
            raise ValueError(
                f"{name} must be a CasADi 2 x 1 vector, not {v.shape[0]} x {v.shape[1]}"
            )
        return v[0], v[1]
    array = real_numbers(v, name, "of shape (2,) or (*batch, 2)")
    if array.ndim == 0:
        raise ValueError(
            f"{name} must be two numbers in one argument, (a, b), not the single number {array:g}"
        )
    if array.shape[-1] != 2:
        raise ValueError(f"{name} must have shape (2,) or (*batch, 2), not {array.shape}")
    if array.ndim == 1:
        x, y = array.tolist()
        if not (-HUGE < x < HUGE and -HUGE < y < HUGE):
            _refuse_huge(array, name)
        return x, y
    if not (np.abs(array) < HUGE).all():
        _refuse_huge(array, name)
    return np.ascontiguousarray(array[..., 0]), np.ascontiguousarray(array[..., 1])


def real_numbers(v, name, shape=""):
    """Return v as an array of floats; ValueError for anything but real numbers, also for texts.

    What a masked array hides is nan.
    """
    try:
        if isinstance(v, np.ma.MaskedArray):
            v = v.astype(float).filled(np.nan)
        array = np.asarray(v)
        if array.dtype is _FLOAT:
            return array
        if (
            array.dtype.kind == "O"
            and not any(map(_is_a_word, array.flat))
            or array.dtype.kind in "fiu"
        ):
            return array.astype(float)
    except Exception:  # Whatever a class of the caller raises when it is taken for an array.
        array = None
    raise ValueError(f"{name} must be real numbers{shape and ' '}{shape}, not {repr(v)[:80]}")


def _is_a_word(x):
    return x is None or isinstance(x, (str, bytes, bool, complex))


def finite_numbers(v, name):
    """Return v as an array of floats below HUGE in size."""
    array = real_numbers(v, name)
    if not (np.abs(array) < HUGE).all():
        _refuse_huge(array, name)
    return array


def _refuse_huge(array, name):
    """Raise ValueError for the first of an array's numbers that is not finite, or too large."""
    good = np.abs(array) < HUGE
    index = tuple(int(i) for i in np.argwhere(~good)[0])
    what = "finite" if not np.isfinite(array[index]) else f"below {HUGE:g} in size"
    if array.ndim < 2 and array.size <= 2:
        raise ValueError(
            f"{name} must be {what}, not"
            f" {array.tolist() if array.ndim == 0 else tuple(array.tolist())}"
        )
    raise ValueError(
        f"{name} must be {what}, but {name}[{', '.join(map(str, index))}] is {array[index]}"
    )


def unpack_for(known, v, name):
    """Return `unpack` of a value whose batch must fit that of `known`, a component."""
    components = unpack(v, name)
    if isinstance(known, np.ndarray) and isinstance(components[0], np.ndarray):
        try:
            np.broadcast_shapes(known.shape, components[0].shape)
        except ValueError:
            shape = (*components[0].shape, 2)
            raise ValueError(
                f"{name} of shape {shape} does not fit a batch of poses of shape {known.shape}"
            ) from None
    return components


def pack(*components):
    """Return components as one array (*batch, n), or a CasADi n x 1 vector."""
    symbol = next((c for c in components if is_symbolic(c)), None)
    if symbol is not None:
        return _module(symbol).vertcat(*components)
    if all(isinstance(c, float) for c in components):
        return np.array(components)
    return np.stack(np.broadcast_arrays(*components), axis=-1)


def pack_matrix(a, b, c, d):
    """Return [[a, b], [c, d]] as one array (*batch, 2, 2), or a CasADi 2 x 2 matrix."""
    flat = pack(a, b, c, d)
    if is_symbolic(flat):
        return _module(flat).horzcat(_module(flat).vertcat(a, c), _module(flat).vertcat(b, d))
    return flat.reshape(*flat.shape[:-1], 2, 2)


def pairs(z):
    """Return complex numbers (*batch,) as points (*batch, 2)."""
    return np.stack([z.real, z.imag], axis=-1)


def check_modes(modes, name):
    """Return modes as int8; ValueError for any other than +1 and -1."""
    modes = real_numbers(modes, name)
    wrong = ~((modes == 1) | (modes == -1))
    if wrong.any():
        raise ValueError(f"{name} must be +1 or -1, not {modes[wrong].flat[0]}")
    return modes.astype(np.int8)  # of unsigned ones the negative would be 255


def first_index(mask):
    """Return the number of true entries and the index of the first, a tuple of ints."""
    mask = np.asarray(mask)
    return int(mask.sum()), tuple(int(i) for i in np.argwhere(mask)[0])
