"""The result of a sweep: designs and their figures, in memory or read from a folder when needed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ..base.checks import one_of, shown, whole
from ..base.presentation import Plotted
from ..base.representation import one_line
from ..base.tables import TextFile, write
from ..models.robots import Biglide, FiveBar
from .batch import place_of_design, robot_of_design
from .goals import SENSE
from .results import robot_of_plain
from .shards import MANIFEST, Chunk, read_chunk, read_manifest, shard, write_chunk, write_manifest


@dataclass(frozen=True, eq=False)
class Sweep(Plotted):
    """Designs and their figures, from `sweep` or `Sweep.load`.

    `sweep["det_A"]` is one column (n,), of a figure or of what varies. Of a folder, chunks are read
    one at a time: `chunks()` and `to_csv` take no more memory for more designs.
    """

    manifest: dict
    _parts: Sequence  # Chunks, or files

    def __repr__(self) -> str:
        errors = len(self.errors) if self.count <= 10**6 else 0
        figures = ", ".join(self.figures)
        names = ", ".join(self.names)
        return one_line(
            "Sweep",
            f"{figures} of {self.count} designs of {names}",
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

    @cached_property
    def robot(self) -> FiveBar | Biglide:
        """What the designs do not name."""
        parameters = dict(self.manifest["robot"])
        parameters.pop("kind", None)
        return robot_of_plain(parameters)

    def chunks(self) -> Iterator[Chunk]:
        """Yield chunks: rows (n, len(names)), values (n, len(figures)), errors [(row, message)]."""
        for part in self._parts:
            yield self._read(part) if isinstance(part, Path) else part

    def _read(self, path):
        chunk = read_chunk(path)
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
        """(design's number, message) of all that went wrong."""
        errors = []
        start = 0
        for part in self.chunks():
            errors += [(start + k, text) for k, text in part.errors]
            start += len(part.rows)
        return tuple(errors)

    def design(self, number: int) -> dict[str, float]:
        """Return what a design names."""
        number = whole(0, self.count - 1)(number, "number")
        return {name: float(self[name][number]) for name in self.names}

    def robot_at(self, number: int) -> FiveBar | Biglide:
        """Return the robot of a design."""
        row = np.array(list(self.design(number).values()))
        return robot_of_design(self.names, row, self.robot)

    def place_at(self, number: int) -> np.ndarray:
        """Return the origin of a design's task, (2,) m."""
        return place_of_design(self.names, np.array([list(self.design(number).values())]))[0]

    def best(
        self,
        figure: str | None = None,
        count: int = 1,
        sense: str | None = None,
    ) -> np.ndarray:
        """Return the numbers of the best designs by a figure, the best first.

        Parameters
        ----------
        figure : str
            None: the first.
        count : int
        sense : {"min", "max"}
            None: the figure's own, of a function "max".
        """
        from .figures import FIGURES

        figure = figure or self.figures[0]
        if figure not in self.figures:
            known = ", ".join(self.figures)
            raise ValueError(f"figure: {shown(figure)} was not swept; {known} were")
        count = whole(1, 10**7)(count, "count")
        if sense is None:
            sense = SENSE[FIGURES[figure].better] if figure in FIGURES else "max"
        values = self[figure]
        valid = np.flatnonzero(~np.isnan(values))
        if one_of("min", "max")(sense, "sense") == "max":
            values = -values
        return valid[np.argsort(values[valid], kind="stable")[:count]]

    def to_csv(self, file: TextFile) -> None:
        """Write a row per design, floats with all their digits."""
        tables = (np.hstack([chunk.rows, chunk.values]).tolist() for chunk in self.chunks())
        rows = (row for table in tables for row in table)
        write(
            file,
            "sweep",
            self.manifest,
            (*self.names, *self.figures),
            rows,
        )

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
        """Return the sweep in a folder, up to its first missing chunk while it is being written."""
        return in_folder(Path(folder))


def in_folder(folder: Path) -> Sweep:
    """Return the Sweep in a folder."""
    manifest = read_manifest(folder)
    paths: list[Path] = []
    while (path := shard(folder, len(paths))).exists():
        paths.append(path)
    if "done" in manifest and len(paths) < manifest["done"]["chunks"]:
        raise ValueError(f"{folder} is said to be done, but {path.name} is missing")
    return Sweep(manifest, tuple(paths))
