"""A folder of a sweep: a manifest, and a file for each chunk, written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..base.checks import strings, whole
from ..base.tables import STRANGE, arrays_in, written

MANIFEST = "manifest.json"
WHAT = "fivebar sweep"


class Chunk(NamedTuple):
    """Designs rows (n, variables), their values (n, figures), and errors [(row, message), ...]."""

    rows: np.ndarray
    values: np.ndarray
    errors: list[tuple[int, str]]


def shard(folder: Path, number: int) -> Path:
    """Return the file of a chunk."""
    return folder / f"chunk-{number:06d}.npz"


def begin(folder: Path, manifest: dict) -> None:
    """Write the manifest into a folder, or check that the one there is the same.

    ValueError where it is of another sweep, or where the folder holds something else.
    """
    if not (folder / MANIFEST).exists():
        if others := sorted(path.name for path in folder.iterdir()):
            raise ValueError(
                f"out: {folder} holds {', '.join(others[:3])} and no {MANIFEST}: give another"
            )
        write_manifest(folder, manifest)
    known = read_manifest(folder)
    for key in {**manifest, **known}:
        if key != "done" and known.get(key) != manifest.get(key):
            before, now = (json.dumps(one.get(key))[:90] for one in (known, manifest))
            raise ValueError(
                f"out: {folder} holds another sweep, whose {key} is {before} and not {now}: give"
                " another folder; nothing was written"
            )


def write_manifest(folder: Path, manifest: dict) -> None:
    """Write the manifest of a sweep."""
    with written(folder / MANIFEST) as out:
        out.write(json.dumps(manifest, indent=1, sort_keys=True) + "\n")


def read_manifest(folder: Path) -> dict:
    """Return the manifest of a sweep; ValueError where there is none or it is damaged."""
    file = folder / MANIFEST
    try:
        known = json.loads(file.read_text(encoding="utf-8"))
        if known["what"] != WHAT:
            raise ValueError(f"it is of {known['what']!r}")
        strings(known["variables"], "variables")
        strings([figure["name"] for figure in known["figures"]], "figures")
        if not all(isinstance(known[name], dict) for name in ("robot", "choices", "designs")):
            raise ValueError("its robot, choices and designs are no tables")
        for name in ("chunks", "designs") if "done" in known else ():
            whole(0, 10**15)(known["done"][name], name)
        return known
    except FileNotFoundError:
        raise ValueError(f"{folder} holds no sweep: there is no {MANIFEST}") from None
    except STRANGE as error:
        raise ValueError(f"{file} is not what a sweep left there ({error})") from None


def write_chunk(folder: Path, number: int, chunk: Chunk) -> None:
    """Write one chunk; the same bytes whenever it is written."""
    places = np.array([k for k, _ in chunk.errors], dtype=np.int64)
    texts = np.frombuffer(
        json.dumps([text for _, text in chunk.errors]).encode(),
        dtype=np.uint8,
    )
    with written(shard(folder, number), binary=True) as out:
        np.savez(
            out,
            designs=chunk.rows,
            values=chunk.values,
            error_at=places,
            error_text=texts,
        )


def read_chunk(path: Path) -> Chunk:
    """Return the chunk in a file; ValueError for a file that holds none."""
    try:
        file = arrays_in(path)
        rows, values, places = (file[name] for name in ("designs", "values", "error_at"))
        texts = strings(json.loads(file["error_text"].tobytes()), "errors")
        for name, array in (("designs", rows), ("values", values)):
            if array.ndim != 2 or array.dtype != float or len(array) != len(rows):
                raise ValueError(f"{name} of shape {array.shape}, {array.dtype}")
        if places.dtype.kind != "i" or places.shape != (len(texts),):
            raise ValueError("its errors are not one a row")
        return Chunk(
            rows,
            values,
            list(zip(places.tolist(), texts)),
        )
    except (*STRANGE, OSError) as error:
        raise ValueError(
            f"{path} is no chunk of a sweep, or not whole ({type(error).__name__}: {error}): delete"
            " it to have it computed again"
        ) from None


def is_done(folder: Path, number: int, rows: np.ndarray) -> bool:
    """Return whether a chunk is on disk; ValueError where its designs are others."""
    path = shard(folder, number)
    if not path.exists():
        return False
    if not np.array_equal(read_chunk(path).rows, rows, equal_nan=True):
        raise ValueError(f"out: {path} holds other designs than chunk {number} of these")
    return True
