"""The result of a sweep: designs and their figures, in memory or read from a folder when needed."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..base.checks import one_of, shown, whole
from ..base.presentation import Plotted
from ..base.shards import ChunkedTable
from ..models.links import Link, knowing_links
from ..models.robots import Biglide, FiveBar
from .batch import place_of_design, robot_of_design
from .figures import FIGURES, Figure
from .goals import SENSE
from .results import robot_of_plain


class Sweep(ChunkedTable, Plotted):
    """Designs and their figures, from `sweep` or `Sweep.load`.

    `sweep["det_A"]` is one column (n,), of a figure or of what varies. Of a folder, chunks are read
    one at a time: `chunks()` and `to_csv` take no more memory for more designs.
    """

    kind = "sweep"
    cases = "designs"

    @cached_property
    def robot(self) -> FiveBar | Biglide:
        """What the designs do not name."""
        parameters = dict(self.manifest["robot"])
        parameters.pop("kind", None)
        robot = robot_of_plain(parameters)
        links = {name: Link(**link) for name, link in self.manifest.get("links", {}).items()}
        return knowing_links(robot, links)

    @cached_property
    def known(self) -> dict[str, Figure]:
        """{name: Figure} of those of fivebar: a function of one's own may have such a name, too."""
        kinds = {figure["name"]: figure["kind"] for figure in self.manifest["figures"]}
        return {name: each for name, each in FIGURES.items() if kinds.get(name) == each.kind}

    def design(self, number: int) -> dict[str, float]:
        """Return what a design names."""
        number = whole(0, self.count - 1)(number, "number")
        return {name: float(self[name][number]) for name in self.names}

    def robot_at(self, number: int) -> FiveBar | Biglide:
        """Return the robot of a design."""
        return robot_of_design(self.names, self._row(number), self.robot)

    def place_at(self, number: int) -> np.ndarray:
        """Return the origin of a design's task, (2,) m."""
        return place_of_design(self.names, self._row(number)[None])[0]

    def _row(self, number):
        return np.array(list(self.design(number).values()))

    def best(
        self, figure: str | None = None, count: int = 1, sense: str | None = None
    ) -> np.ndarray:
        """Return the numbers of the best designs by a figure, the best first.

        Designs whose figure is nan or infinite are left out.

        Parameters
        ----------
        figure : str
            None: the first.
        count : int
        sense : {"min", "max"}
            None: the figure's own, of a function "max".
        """
        figure = figure or self.figures[0]
        if figure not in self.figures:
            known = ", ".join(self.figures)
            raise ValueError(f"figure: {shown(figure)} was not swept; {known} were")
        count = whole(1, 10**7)(count, "best: its count")
        if sense is None:
            sense = SENSE[self.known[figure].better] if figure in self.known else "max"
        values = self[figure]
        valid = np.flatnonzero(np.isfinite(values))
        if one_of("min", "max")(sense, "sense") == "max":
            values = -values
        return valid[np.argsort(values[valid], kind="stable")[:count]]

    def why_not_finite(self, *figures: str) -> str:
        """Return in words how many designs have one of these figures, and why others may not; ""
        where all have one.
        """
        having = int(np.isfinite([self[figure] for figure in figures]).any(axis=0).sum())
        if having == self.count:
            return ""
        words = f"{' or '.join(figures)} is finite in {having or 'none'} of {self.count} designs"
        for name, value in self.manifest["choices"].items():
            if name in ("table", "disc"):
                words += (
                    f"; {name} = {value} m is out of reach, or a singularity is in it: task_x and"
                    " task_y, 0 where no design names them, move it"
                )
        return words
