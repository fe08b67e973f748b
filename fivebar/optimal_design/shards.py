"""A folder of results as they come: a manifest, and a file for each chunk, written whole or not at
all.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..base.checks import strings, whole
from ..base.tables import STRANGE, arrays_in, written
from .designs import digest

MANIFEST = "manifest.json"
WHAT = "fivebar sweep"
ARRAYS = "designs", "values", "error_at"


class Chunk(NamedTuple):
    """rows (n, variables), values (n, figures), and what went wrong: [(row, message), ...]."""

    rows: np.ndarray
    values: np.ndarray
    errors: list[tuple[int, str]]


def shard(folder: Path, number: int) -> Path:
    return folder / f"chunk-{number:06d}.npz"


def begin(folder: Path, manifest: dict) -> dict:
    """The manifest in the folder, written if there is none; ValueError where it is of another
    sweep.
    """
    file = folder / MANIFEST
    if not file.exists():
        if strangers := sorted(path.name for path in folder.iterdir()):
            more = f" and {len(strangers) - 3} more" if len(strangers) > 3 else ""
            raise ValueError(
                f"out: {folder} holds {', '.join(strangers[:3])}{more} and no {MANIFEST}: give"
                " another"
            )
        write_manifest(folder, manifest)
        return manifest
    known = read_manifest(folder)
    own = {key: value for key, value in known.items() if key != "done"}
    for key in {**manifest, **own}:
        if own.get(key) != manifest.get(key):
            raise ValueError(
                f"out: {folder} holds another sweep, whose {key} is {_short(own.get(key))} and not "
                f"{_short(manifest.get(key))}: give another folder; nothing was written"
            )
    return known


def write_manifest(folder: Path, manifest: dict) -> None:
    with written(folder / MANIFEST) as out:
        out.write(json.dumps(manifest, indent=1, sort_keys=True) + "\n")


def read_manifest(folder: Path) -> dict:
    try:
        known = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        if known["what"] != WHAT:
            raise ValueError(f"it is of {known['what']!r}")
        (
            strings(known["variables"], "variables"),
            strings([each["name"] for each in known["figures"]], "figures"),
        )
        if not all(isinstance(known[name], dict) for name in ("robot", "choices", "designs")):
            raise ValueError("its robot, choices and designs are no tables")
        if "done" in known:
            for name in ("chunks", "designs"):
                whole(0, 10**15)(known["done"][name], name)
        return known
    except FileNotFoundError:
        raise ValueError(f"{folder} holds no sweep: there is no {MANIFEST}") from None
    except STRANGE as error:
        raise ValueError(f"{folder / MANIFEST} is not what a sweep left there ({error})") from None


def _short(value):
    words = json.dumps(value)
    return words if len(words) < 90 else words[:90] + "..."


def write_chunk(folder: Path, number: int, chunk: Chunk) -> None:
    """One chunk; the same bytes whenever it is written."""
    places = np.array([k for k, _ in chunk.errors], dtype=np.int64)
    texts = np.frombuffer(json.dumps([text for _, text in chunk.errors]).encode(), dtype=np.uint8)
    with written(shard(folder, number), binary=True) as out:
        np.savez(out, designs=chunk.rows, values=chunk.values, error_at=places, error_text=texts)


def read_chunk(path: Path) -> Chunk:
    """ValueError for a file that is none."""
    try:
        file = arrays_in(path)
        texts, rows, values, at = (
            json.loads(file["error_text"].tobytes()),
            *(file[name] for name in ARRAYS),
        )
        if (
            rows.ndim != 2
            or values.ndim != 2
            or len(rows) != len(values)
            or not rows.dtype == values.dtype == float
        ):
            raise ValueError(
                f"designs {rows.shape} of {rows.dtype}, values {values.shape} of {values.dtype}"
            )
        if (
            at.dtype.kind != "i"
            or at.shape != (len(texts),)
            or not all(isinstance(each, str) for each in texts)
        ):
            raise ValueError("its errors are no sentences, each of a row")
        return Chunk(rows, values, list(zip(at.tolist(), texts)))
    except (*STRANGE, OSError) as error:
        raise ValueError(
            f"{path} is no chunk of a sweep, or not whole ({type(error).__name__}: {error}): delete"
            " it to have it computed again"
        ) from None


def is_done(folder: Path, number: int, rows: np.ndarray) -> bool:
    """Whether this chunk is on disk; ValueError where what is there is of other designs."""
    path = shard(folder, number)
    if not path.exists():
        return False
    if digest(read_chunk(path).rows) != digest(rows):
        raise ValueError(
            f"out: {path} holds other designs than chunk {number} of these: they have changed"
            " since; give another folder; nothing was written"
        )
    return True
