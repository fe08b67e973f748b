"""The functions of a notebook's session as a program, which can be run in a process of its own."""

from __future__ import annotations

import builtins
import inspect
import re
import textwrap
from bisect import bisect_right
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from .submission import Submission


def session_program(
    functions: dict[str, Callable], numbers: dict[str, float]
) -> tuple[Submission, Callable[[int], str]] | None:
    """Return a program of these functions, of what they use, and of the session's numbers; and a
    line of it in words. None where the source of a function is not to be had.
    """
    modules = {getattr(function, "__module__", "") for function in functions.values()}
    lines = [f"{name} = {number!r}\n" for name, number in numbers.items()]
    texts: list[str] = []
    waiting, seen = [*functions.items()], set(numbers)
    while waiting:
        name, value = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        if not isinstance(value, FunctionType) or value.__module__ not in modules:
            lines.append(_brought(name, value))
            continue
        try:
            text = textwrap.dedent(inspect.getsource(value))
        except (OSError, TypeError):
            return None
        texts.append(re.sub(rf"\bdef {value.__name__}\b", f"def {name}", text, count=1))
        space = value.__globals__
        for key in _names(value.__code__):
            if key in space and not hasattr(builtins, key):
                waiting.append((key, space[key]))
    names, starts, line = [], [], 1 + sum(text.count("\n") for text in lines)
    for text in texts:
        names.append(text.split("(")[0].removeprefix("def ").split(" =")[0].strip())
        starts.append(line)
        line += text.count("\n")

    def where(line):
        at = bisect_right(starts, line) - 1
        if at < 0:
            return f"line {line}"
        return f"line {line - starts[at] + 1} of {names[at]}"

    return Submission("this session", "".join([*lines, *texts])), where


def _names(code: CodeType) -> Iterator[str]:
    """Yield the names that a function's code takes from outside, those of functions in it too."""
    yield from code.co_names
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _names(part)


def _brought(name: str, value: Any) -> str:
    """Return a line that gives a name the same value: an import, or an array."""
    if isinstance(value, ModuleType):
        return f"import {value.__name__} as {name}\n"
    if isinstance(value, np.ndarray):
        return f"{name} = __import__('numpy').array({value.tolist()!r})\n"
    module, own = getattr(value, "__module__", None), getattr(value, "__name__", None)
    if module and own:
        return f"from {module} import {own} as {name}\n"
    return f"{name} = {value!r}\n"
