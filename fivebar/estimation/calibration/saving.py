"""A calibration as a file, and its robot as a file for `--robot`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.backend import HUGE, finite_numbers
from ...base.checks import shown
from ...base.tables import STRANGE, TextFile, whole_text, written
from ...models.parameters import robot_of
from .fit import LOSSES, misses
from .measured_robot import FRAME, READING, UNKNOWNS, length_ok
from .rows import Rows

if TYPE_CHECKING:
    from .result import Calibration

KIND = "calibration of a five-bar"
ARRAYS = "assembly", "start", "p", "weight", "held"
PLAIN = "unknown", "absolute", "loss", "notes", "bounds"


def write_calibration(found: Calibration, path: TextFile) -> None:
    """Everything as JSON, in SI units; nan, which JSON has not, as null."""
    rows = {
        name: _plain(value)
        for name, value in vars(found.rows).items()
        if name in Rows.__dataclass_fields__
    }
    about = {name: _plain(getattr(found, name)) for name in (*PLAIN, *ARRAYS)}
    result = {
        "values": found.values,
        "sd": {k: v if np.isfinite(v) else None for k, v in found.sd.items()},
    }
    result |= {"indistinguishable": found.indistinguishable, "robot": found.robot.parameters}
    with written(path) as out:
        content = {
            "fivebar": KIND,
            "nominal": found.nominal.parameters,
            **about,
            "rows": rows,
            "result": result,
        }
        json.dump(content, out, indent=1)
        out.write("\n")


def read_calibration(path: TextFile) -> dict[str, Any]:
    """Arguments of the Calibration in a file."""
    text, name = whole_text(path, "a calibration")
    try:
        content = json.loads(text)
        if content["fivebar"] != KIND:
            raise ValueError(f"it says {content['fivebar']!r}")
        rows = {
            k: _array(v) if isinstance(v, list) and k not in ("where", "notes", "stated") else v
            for k, v in content["rows"].items()
        }
        rows |= dict(
            where=tuple(rows["where"]), notes=tuple(rows["notes"]), stated=frozenset(rows["stated"])
        )
        found = {key: content[key] for key in PLAIN} | {key: _array(content[key]) for key in ARRAYS}
        found |= dict(unknown=tuple(found["unknown"]), notes=tuple(found["notes"]))
        found["held"] = found["held"].astype(bool)
        found["bounds"] = {key: tuple(pair) for key, pair in found["bounds"].items()}
        found["assembly"] = _whole(found["assembly"]).astype(np.int8)
        for key, kind in (("working", np.int8), ("assembly", np.int8), ("to", int)):
            rows[key] = _whole(rows[key]).astype(kind)
        for key in ("q", "points", "working"):
            rows[key] = rows[key].reshape(-1, 2)
        return _fitting(found | dict(nominal=robot_of(content["nominal"]), rows=Rows(**rows)))
    except STRANGE as error:
        raise ValueError(
            f"{name}: not a calibration as to_json writes it: {type(error).__name__}: {error}"
        ) from None


def _fitting(found):
    """Refused where its parts are not of the same rows and unknowns, or its robot does not close on
    its rows.
    """
    rows, unknown, n = found["rows"], found["unknown"], len(found["rows"].q)
    if (
        not set(found["bounds"]) <= set(unknown) <= set(UNKNOWNS)
        or len(set(unknown)) != len(unknown)
        or not unknown
    ):
        raise ValueError(f"unknown and bounds name {shown(unknown)} and {shown(found['bounds'])}")
    if found["loss"] not in LOSSES or not isinstance(found["absolute"], bool):
        raise ValueError(f"loss is {shown(found['loss'])}, and absolute {shown(found['absolute'])}")
    for name in ("assembly", "distance", "to", "sigma", "where"):
        _has_shape(getattr(rows, name), name, (n,))
    for name in ("points", "working"):
        _has_shape(getattr(rows, name), name, (n, 2))
    finite_numbers(rows.q, "q")
    for name in ("points", "distance", "sigma"):
        finite_numbers(np.where(np.isnan(array := getattr(rows, name)), 0.0, array), name)
    if not (rows.to < n).all() or not np.isin(found["assembly"], (-1, 1)).all():
        raise ValueError("to must be numbers of rows, and assembly modes -1 or 1")
    for name, shape in (
        ("assembly", n),
        ("p", len(UNKNOWNS)),
        ("start", len(UNKNOWNS)),
        ("weight", len(rows.numbers)),
    ):
        finite_numbers(_has_shape(found[name], name, (shape,)), name)
        if name in ("p", "start") and not length_ok(found[name]):
            raise ValueError(
                f"with its {name} no robot can be built: {shown(found[name].tolist())}"
            )
    if len(found["held"]):
        _has_shape(found["held"], "held", (len(unknown),))
    off = misses(found["p"], rows, found["assembly"])
    if not (found["weight"] > 1 / HUGE).all() or not all(np.isfinite(each).all() for each in off):
        raise ValueError("its robot does not close on its rows, or a weight is not > 0")
    return found


def _whole(array):
    if not (np.abs(array) < 2**31).all() or (array % 1).any():
        raise ValueError(f"{shown(array)} are no whole numbers")
    return array


def _has_shape(value, name, shape):
    if np.shape(value) != shape:
        raise ValueError(f"{name} must have shape {shape}, not {np.shape(value)}")
    return value


def write_robot(found: Calibration, path: TextFile) -> None:
    """The robot's parameters by name as TOML."""
    values = dict(zip(UNKNOWNS, found.p))
    with written(path) as out:
        out.write(
            "# A calibrated robot, SI units. Not the robot's own, but of how it was read and"
            " measured:\n"
        )
        for name in (*READING, *FRAME):
            out.write(f"# {name} = {float(values[name])!r}\n")
        for name, value in found.robot.parameters.items():
            sd = found.sd.get(name)
            known = (
                ""
                if sd is None
                else f"  # sd {sd:.2g}"
                if np.isfinite(sd)
                else "  # not told by itself"
            )
            out.write(f"{name} = {list(value) if isinstance(value, tuple) else value!r}{known}\n")


def _plain(value):
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f":
            return [
                _plain(row) if np.ndim(row) else (None if np.isnan(row) else float(row))
                for row in value
            ]
        return value.tolist()
    if isinstance(value, dict):
        return {k: [None if np.isinf(v) else v for v in pair] for k, pair in value.items()}
    return sorted(value) if isinstance(value, frozenset) else value


def _array(values):
    return np.array(
        [
            (
                [np.nan if v is None else v for v in row]
                if isinstance(row, list)
                else (np.nan if row is None else row)
            )
            for row in values
        ]
    )
