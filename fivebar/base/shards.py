"""Tables of many cases and their figures, computed in chunks over an executor.

In a folder they are a manifest and a file for each chunk, written whole or not at all.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import os
import pickle
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from .checks import shown, strings, whole
from .folders import locked_folder
from .progress import progress
from .representation import one_line
from .tables import STRANGE, TextFile, arrays_in, write, written
from .workers import WorkersDied, compute_chunks

MANIFEST = "manifest.json"
MOST_NUMBERS = 2 * 10**8  # in memory, 1.6 GB, where there is no folder
# What does not change while a function counts or remembers; a list and a dict might.
PLAIN = int | float | complex | str | bytes | tuple | np.ndarray | np.generic
MOST_LISTED = 10**6  # cases of which a table says how many errors they have


class Chunk(NamedTuple):
    """Cases: rows (n, variables), values (n, figures), and errors [(row, message), ...]."""

    rows: np.ndarray
    values: np.ndarray
    errors: list[tuple[int, str]]


@dataclass(frozen=True, eq=False)
class ChunkedTable:
    """Cases and their figures, in memory or in a folder.

    `table["name"]` is one column (n,), of a figure or of what varies. Of a folder, chunks are read
    one at a time: `chunks()` and `to_csv` take no more memory for more cases.
    """

    manifest: dict
    _parts: Sequence  # Chunks, or files
    kind: ClassVar[str]  # "sweep"
    cases: ClassVar[str]  # "designs"

    def __repr__(self) -> str:
        errors = len(self.errors) if self.count <= MOST_LISTED else 0
        return one_line(
            type(self).__name__,
            f"{', '.join(self.figures)} of {self.count} {self.cases} of {', '.join(self.names)}",
            f"{errors} errors" if errors else "",
            "" if "done" in self.manifest else "not done yet",
        )

    def __len__(self) -> int:
        return self.count

    @property
    def names(self) -> tuple[str, ...]:
        """What varies."""
        return tuple(self.manifest["variables"])

    @property
    def figures(self) -> tuple[str, ...]:
        return tuple(figure["name"] for figure in self.manifest["figures"])

    @cached_property
    def count(self) -> int:
        if "done" in self.manifest:
            return self.manifest["done"]["designs"]
        return sum(len(part.rows) for part in self.chunks())

    def chunks(self) -> Iterator[Chunk]:
        """Yield chunks: rows (n, len(names)), values (n, len(figures)), errors [(row, message)]."""
        for part in self._parts:
            yield self._read(part) if isinstance(part, Path) else part

    def _read(self, path):
        chunk = read_chunk(path, self.kind)
        widths = chunk.rows.shape[1], chunk.values.shape[1]
        named = len(self.names), len(self.figures)
        if widths != named:
            raise ValueError(
                f"{path} has {widths} columns of what varies and of figures, but {MANIFEST} names"
                f" {named}"
            )
        return chunk

    def __getitem__(self, name: str) -> np.ndarray:
        columns = *self.names, *self.figures
        if name not in columns:
            raise KeyError(f"no column {shown(name)}; there are {', '.join(columns)}")
        k = columns.index(name)
        return np.concatenate([np.hstack(part[:2])[:, k] for part in self.chunks()])

    @cached_property
    def errors(self) -> tuple[tuple[int, str], ...]:
        """(case's number, message) of all that went wrong."""
        errors = []
        start = 0
        for part in self.chunks():
            errors += [(start + k, text) for k, text in part.errors]
            start += len(part.rows)
        return tuple(errors)

    def to_csv(self, file: TextFile) -> None:
        """Write a row per case, floats with all their digits."""
        tables = (np.hstack([chunk.rows, chunk.values]).tolist() for chunk in self.chunks())
        rows = (row for table in tables for row in table)
        write(file, self.kind, self.manifest, (*self.names, *self.figures), rows)

    def save(self, folder: str | os.PathLike) -> None:
        """Put the table into a new folder, which `load` reads."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise ValueError(f"folder: {folder} is not empty")
        for number, part in enumerate(self._parts):
            if isinstance(part, Path):
                shutil.copyfile(part, shard(folder, number))
            else:
                write_chunk(folder, number, part)
        write_manifest(folder, self.manifest)

    @classmethod
    def load(cls, folder: str | os.PathLike) -> Self:
        """Return the table in a folder, up to its first missing chunk while it is being written."""
        folder = Path(folder)
        manifest = read_manifest(folder, cls.kind)
        paths: list[Path] = []
        while (path := shard(folder, len(paths))).exists():
            paths.append(path)
        if "done" in manifest and len(paths) < manifest["done"]["chunks"]:
            raise ValueError(f"{folder} is said to be done, but {path.name} is missing")
        return cls(manifest, tuple(paths))

    @classmethod
    def compute(
        cls,
        compute: Callable[[np.ndarray], Chunk],
        chunks: Iterator[np.ndarray],
        count: int,
        about: dict[str, Any],
        executor: Executor | None,
        workers: int | None,
        out: str | os.PathLike | None,
    ) -> Self:
        """Return the table of chunks that `compute` makes of chunks of rows (n, variables).

        Parameters
        ----------
        compute, executor, workers
            As of `workers.compute_chunks`.
        chunks
            Rows; all but the last chunk of about["chunk"] cases.
        count : int
            Cases in all.
        about : dict
            The manifest: "variables", "figures" [{"name": ...}], "chunk", and the tables "robot",
            "choices" and "designs".
        out : path
            A folder, which gets each chunk when it is done; the same call goes on there. None: all
            is kept in memory.
        """
        manifest = {"what": f"fivebar {cls.kind}", **about}
        done = {"chunks": math.ceil(count / about["chunk"]), "designs": count}
        numbers = count * (len(about["variables"]) + len(about["figures"]))
        if out is None and numbers > MOST_NUMBERS:
            raise ValueError(
                f"{count} {cls.cases} are {numbers:.3g} numbers, more than {MOST_NUMBERS:g} in"
                " memory; give out=..., a folder for them"
            )
        numbered = enumerate(chunks)
        with progress(total=done["chunks"], unit=" chunks") as bar:

            def computed(left):
                for number, part in compute_chunks(compute, left, executor, workers):
                    yield number, part
                    bar.update()

            if out is None:
                parts = dict(computed(numbered))
                return cls(manifest | {"done": done}, tuple(parts[k] for k in sorted(parts)))
            folder = Path(out)
            with locked_folder(folder, cls.kind):
                begin(folder, manifest, cls.kind)
                _on_disk(folder, computed, numbered, bar, cls.kind)
                write_manifest(folder, manifest | {"done": done})
            return cls.load(folder)


def _on_disk(folder, computed, chunks, bar, kind):
    def missing():
        for number, rows in chunks:
            if is_done(folder, number, rows, kind):
                bar.update()
            else:
                yield number, rows

    try:
        for number, part in computed(missing()):
            write_chunk(folder, number, part)
    except WorkersDied as error:
        raise RuntimeError(
            f"{error}. What was done is in {folder}; the same call goes on from there"
        ) from None
    except OSError as error:
        error.strerror = f"{error.strerror}; what was done stays in {folder}"
        raise


def code_hash(function: Callable) -> str:
    """Return a hash of a user's function, by which a folder knows that it is the same.

    It is one of its source, of the functions that this calls in its turn, and of the numbers,
    texts, tuples, arrays and dataclasses among its variables from outside.
    """
    found = hashlib.sha256()
    functions = [function]
    for each in functions:
        found.update(_source(each).encode())
        # What another module calls is that module's own.
        if not inspect.isfunction(each) or each.__module__ != function.__module__:
            continue
        outer = inspect.getclosurevars(each)
        for name, value in sorted({**outer.nonlocals, **outer.globals}.items()):
            if inspect.isfunction(value) and value not in functions:
                functions.append(value)
            elif isinstance(value, PLAIN) or is_dataclass(value):
                with suppress(Exception):  # whatever an object of a user raises
                    found.update(pickle.dumps((name, value)))
    return found.hexdigest()


def _source(function):
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):  # written at a prompt, or compiled
        code = getattr(function, "__code__", None)
        return repr((code.co_code, code.co_consts) if code else type(function))


def shard(folder: Path, number: int) -> Path:
    """Return the file of a chunk."""
    return folder / f"chunk-{number:06d}.npz"


def begin(folder: Path, manifest: dict, kind: str) -> None:
    """Write the manifest into a folder, or check that the one there is the same.

    ValueError where it is of another table, or where the folder holds something else.
    """
    if not (folder / MANIFEST).exists():
        if others := sorted(path.name for path in folder.iterdir()):
            raise ValueError(
                f"out: {folder} holds {', '.join(others[:3])} and no {MANIFEST}: give another"
            )
        write_manifest(folder, manifest)
    known = read_manifest(folder, kind)
    for key in {**manifest, **known}:
        if key != "done" and known.get(key) != manifest.get(key):
            texts = [json.dumps(one.get(key)) for one in (known, manifest)]
            # From a little before the first difference on.
            first = max(len(os.path.commonprefix(texts)) - 30, 0)
            before, now = ("..." * bool(first) + text[first:][:90] for text in texts)
            raise ValueError(
                f"out: {folder} holds another {kind}, whose {key} is {before} and not {now}: give"
                " another folder; nothing was written"
            )


def write_manifest(folder: Path, manifest: dict) -> None:
    """Write the manifest of a table."""
    with written(folder / MANIFEST) as out:
        out.write(json.dumps(manifest, indent=1, sort_keys=True) + "\n")


def read_manifest(folder: Path, kind: str) -> dict:
    """Return the manifest of a table; ValueError where there is none or it is damaged."""
    file = folder / MANIFEST
    try:
        known = json.loads(file.read_text(encoding="utf-8"))
        if known["what"] != f"fivebar {kind}":
            raise ValueError(f"it is of {known['what']!r}")
        strings(known["variables"], "variables")
        strings([figure["name"] for figure in known["figures"]], "figures")
        if not all(isinstance(known[name], dict) for name in ("robot", "choices", "designs")):
            raise ValueError("its robot, choices and designs are no tables")
        for name in ("chunks", "designs") if "done" in known else ():
            whole(0, 10**15)(known["done"][name], name)
        return known
    except FileNotFoundError:
        raise ValueError(f"{folder} holds no {kind}: there is no {MANIFEST}") from None
    except STRANGE as error:
        raise ValueError(f"{file} is not what a {kind} left there ({error})") from None


def write_chunk(folder: Path, number: int, chunk: Chunk) -> None:
    """Write one chunk; the same bytes whenever it is written."""
    places = np.array([k for k, _ in chunk.errors], dtype=np.int64)
    texts = np.frombuffer(json.dumps([text for _, text in chunk.errors]).encode(), dtype=np.uint8)
    with written(shard(folder, number), binary=True) as out:
        np.savez(out, designs=chunk.rows, values=chunk.values, error_at=places, error_text=texts)


def read_chunk(path: Path, kind: str) -> Chunk:
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
        return Chunk(rows, values, list(zip(places.tolist(), texts)))
    except (*STRANGE, OSError) as error:
        raise ValueError(
            f"{path} is no chunk of a {kind}, or not whole ({type(error).__name__}: {error}):"
            " delete it to have it computed again"
        ) from None


def is_done(folder: Path, number: int, rows: np.ndarray, kind: str) -> bool:
    """Return whether a chunk is on disk; ValueError where its cases are others."""
    path = shard(folder, number)
    if not path.exists():
        return False
    if not np.array_equal(read_chunk(path, kind).rows, rows, equal_nan=True):
        raise ValueError(f"out: {path} holds other cases than chunk {number} of these")
    return True
