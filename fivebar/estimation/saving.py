"""Write results to JSON files and read them back, by the fields of their dataclasses."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from types import NoneType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy import ndarray

from ..base.tables import STRANGE, TextFile, whole_text, written
from ..models.parameters import robot_of
from ..models.robots import Biglide, FiveBar, Robot

T = TypeVar("T")


def write_json(path: TextFile, kind: str, content: object, **more: object) -> None:
    """Write a dataclass or a dict as JSON; nan and infinity, which JSON lacks, as null."""
    with written(path) as out:
        json.dump({"fivebar": kind, **encode(content), **encode(more)}, out, indent=1)
        out.write("\n")


def read_json(path: TextFile, kind: str, cls: type[T], check: Callable[[T], Any]) -> T:
    """Return the dataclass that `write_json` wrote; ValueError for another file.

    Fields that the file lacks have their defaults. `check` refuses impossible results.
    """
    text, name = whole_text(path, f"a file of kind {kind!r}")
    try:
        content = json.loads(text)
        if content["fivebar"] != kind:
            raise ValueError(f"it is of the kind {content['fivebar']!r}")
        with np.errstate(all="raise"):
            result = decode(cls, content)
            check(result)
        return result
    except STRANGE as error:
        raise ValueError(
            f"{name}: not a file of kind {kind!r}: {type(error).__name__}: {error}"
        ) from None


def encode(value: Any) -> Any:
    """Return numbers, strings, lists and dicts in place of a value of a result."""
    if isinstance(value, (FiveBar, Biglide)):
        return encode(value.parameters)
    if is_dataclass(value):
        return {field.name: encode(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: encode(each) for key, each in value.items()}
    if isinstance(value, (ndarray, np.generic)):
        return encode(value.tolist())
    if isinstance(value, (tuple, list)):
        return [encode(each) for each in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def decode(kind: Any, value: Any) -> Any:
    """Return a value of this type, out of what `encode` made of it."""
    origin = get_origin(kind)
    options = get_args(kind)
    if NoneType in options:
        return None if value is None else decode(options[0], value)
    if kind is ndarray:
        return _array(value)
    if kind in (FiveBar, Robot):
        return robot_of(value)
    if is_dataclass(kind):
        types = get_type_hints(kind)
        fields = {name: decode(types[name], value[name]) for name in types if name in value}
        make: Any = kind
        return make(**fields)
    if origin is dict:
        return {key: decode(options[1], each) for key, each in value.items()}
    if origin is tuple and isinstance(value, list):
        return tuple(decode(options[0], each) for each in value)
    if kind is float:
        return np.inf if value is None else float(value)
    if not isinstance(value, origin or kind):
        raise ValueError(f"{value!r} is no {kind}")
    return value


def _array(value):
    array = np.array(value)
    if array.dtype == object:  # None stands for nan
        array = array.astype(float)
    if array.dtype.kind not in "bif":
        raise ValueError("its arrays must be of numbers")
    return array
