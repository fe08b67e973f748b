"""What a sweep gives: designs and their figures, in memory or read from the folder as they are
asked for.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import one_of, shown, whole
from ..base.presentation import Plotted
from ..base.representation import one_line
from ..base.tables import TextFile, write
from ..models.parameters import robot_of
from ..models.robots import Biglide, FiveBar
from .batch import place_of_design, robot_of_design
from .shards import MANIFEST, Chunk, read_chunk, read_manifest, shard, write_chunk, write_manifest

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True, eq=False)
class Sweep(Plotted):
    """Designs and their figures, from `sweep` or `Sweep.load`.

    Of a folder, chunks are read when asked for, one at a time: `chunks()`, `to_csv` and `best` take
    no more memory for more designs; sweep["det_A"] is one column (n,), of a figure or of what
    varies.
    """

    manifest: dict
    _parts: Sequence  # Chunks, or files

    def __repr__(self) -> str:
        done = "" if "done" in self.manifest else "not done yet"
        errors = sum(len(part.errors) for part in self.chunks()) if self.count <= 10**6 else 0
        notes = f"{errors} errors" if errors else ""
        return one_line(
            "Sweep",
            f"{', '.join(self.figures)} of {self.count} designs of {', '.join(self.names)}",
            notes,
            done,
        )

    def __len__(self) -> int:
        return self.count

    @property
    def names(self) -> tuple[str, ...]:
        """What varies."""
        return tuple(self.manifest["variables"])

    @property
    def figures(self) -> tuple[str, ...]:
        return tuple(each["name"] for each in self.manifest["figures"])

    @cached_property
    def count(self) -> int:
        if "done" in self.manifest:
            return self.manifest["done"]["designs"]
        return sum(len(part.rows) for part in self.chunks())

    @cached_property
    def robot(self) -> FiveBar | Biglide:
        """What the designs do not name."""
        given = {name: value for name, value in self.manifest["robot"].items() if name != "kind"}
        return robot_of({name: tuple(v) if isinstance(v, list) else v for name, v in given.items()})

    def chunks(self) -> Iterator[Chunk]:
        """rows (n, len(names)), values (n, len(figures)), errors [(row, message)], a chunk after
        the other.
        """
        for part in self._parts:
            yield self._read(part) if isinstance(part, Path) else part

    def _read(self, path):
        found = read_chunk(path)
        there, named = (
            (found.rows.shape[1], found.values.shape[1]),
            (len(self.names), len(self.figures)),
        )
        if there != named:
            raise ValueError(
                f"{path} has {there} columns of what varies and of figures, but {MANIFEST} names"
                f" {named}"
            )
        return found

    def __getitem__(self, name: str) -> np.ndarray:
        if name in self.figures:
            return np.concatenate(
                [part.values[:, self.figures.index(name)] for part in self.chunks()]
            )
        if name in self.names:
            return np.concatenate([part.rows[:, self.names.index(name)] for part in self.chunks()])
        raise KeyError(
            f"no column {shown(name)}; there are {', '.join((*self.names, *self.figures))}"
        )

    @cached_property
    def errors(self) -> tuple[tuple[int, str], ...]:
        """(design's number, message) of all that went wrong."""
        found, start = [], 0
        for part in self.chunks():
            found += [(start + k, text) for k, text in part.errors]
            start += len(part.rows)
        return tuple(found)

    def design(self, number: int) -> dict[str, float]:
        """What a design names."""
        number = whole(0, self.count - 1)(number, "number")
        for part in self.chunks():
            if number < len(part.rows):
                return dict(zip(self.names, part.rows[number].tolist()))
            number -= len(part.rows)
        raise IndexError(number)

    def rows(self, numbers: ArrayLike) -> dict[str, np.ndarray]:
        """What some designs name, as columns: designs of another sweep."""
        return {name: self[name][np.atleast_1d(numbers)] for name in self.names}

    def robot_at(self, number: int) -> FiveBar | Biglide:
        """The robot of a design."""
        row = np.array(list(self.design(number).values()))
        return robot_of_design(self.names, row, self.robot)

    def place_at(self, number: int) -> np.ndarray:
        """Where the task of a design is, (2,) m."""
        return place_of_design(self.names, np.array([list(self.design(number).values())]))[0]

    def best(
        self, figure: str | None = None, count: int = 1, sense: str | None = None
    ) -> np.ndarray:
        """Numbers of the best designs by a figure (None: the first), the best first; of equals the
        first.

        sense: "min" or "max"; None: the figure's own, of a function "max".
        """
        from .figures import FIGURES

        figure = figure or self.figures[0]
        if figure not in self.figures:
            raise ValueError(
                f"figure: {shown(figure)} was not swept; {', '.join(self.figures)} were"
            )
        count = whole(1, 10**7)(count, "count")
        if sense is None:
            sense = "min" if figure in FIGURES and FIGURES[figure].better == "small" else "max"
        sign = 1.0 if one_of("min", "max")(sense, "sense") == "min" else -1.0
        start, kept, at = 0, np.empty(0), np.empty(0, dtype=int)
        for part in self.chunks():
            value = sign * part.values[:, self.figures.index(figure)]
            kept, at = np.append(kept, value), np.append(at, start + np.arange(len(value)))
            start += len(value)
            good = np.flatnonzero(~np.isnan(kept))
            order = good[np.argsort(kept[good], kind="stable")[:count]]
            kept, at = kept[order], at[order]
        return at

    def to_csv(self, file: TextFile) -> None:
        """A row per design, floats with all their digits."""
        rows = (
            part
            for chunk in self.chunks()
            for part in np.hstack([chunk.rows, chunk.values]).tolist()
        )
        write(file, "sweep", self.manifest, (*self.names, *self.figures), rows)

    def save(self, folder: str | os.PathLike) -> None:
        """Put the sweep into a new folder, which `load` reads."""
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
    def load(cls, folder: str | os.PathLike) -> Sweep:
        """The sweep in a folder, also while it is being written: what is there of it, from its
        first chunk on.
        """
        return in_folder(Path(folder))


def in_folder(folder: Path) -> Sweep:
    """The Sweep in a folder."""
    manifest = read_manifest(folder)
    paths = []
    while (path := shard(folder, len(paths))).exists():
        paths.append(path)
    if "done" in manifest and len(paths) < manifest["done"]["chunks"]:
        raise ValueError(
            f"{folder} is said to be done, but {shard(folder, len(paths)).name} is missing"
        )
    return Sweep(manifest, tuple(paths))
