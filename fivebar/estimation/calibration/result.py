"""A calibration: the robot found, how well it is known, what the data cannot tell, which rows are
off.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, ndtri, stdtrit

from ...base.backend import sign
from ...base.checks import number
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.tables import TextFile
from ...models.dyads import SINGULAR
from ...models.robots import FiveBar
from . import saving
from .fit import Task, loss_slopes, misses, solve, spectrum
from .indistinguishable import Remedies, combination, hardly_told, plainest
from .measured_robot import FRAME, PLACE, place, robot_with, seen, sizes
from .outliers import left_out, off_rows
from .rows import Rows
from .setpoints import Used

if TYPE_CHECKING:
    pass

DOUBT = 1e-3  # p-value below which the model does not fit


@dataclass(frozen=True, eq=False)
class Calibration(Used, Plotted):
    """What `calibrate` found; printed, it is a report.

    nominal: the robot it began with; unknown: names; rows: what was measured, (n,) rows; assembly
    (n,): their modes; start, p (13,): all values, before and found, in the order of UNKNOWNS;
    weight (m,): 1 / sigma of the measured numbers; absolute: whether these are m, or relative;
    loss; held (k,): unknowns at a bound; said: sentences on what was converted, left out, put
    right; bounds.
    """

    nominal: FiveBar
    unknown: tuple[str, ...]
    rows: Rows = field(repr=False)
    assembly: np.ndarray
    start: np.ndarray
    p: np.ndarray
    weight: np.ndarray
    absolute: bool
    loss: str = "linear"
    held: np.ndarray = field(default_factory=lambda: np.zeros(0, bool))
    notes: tuple[str, ...] = ()
    bounds: dict = field(default_factory=dict)

    def __repr__(self) -> str:
        fit = f"RMS {1e3 * self.rms_before:.3g} -> {1e3 * self.rms:.3g} mm"
        lost = f"{len(self.unknown) - self.rank} not told" if self.rank < len(self.unknown) else ""
        poor = "the model does not fit" if self.fits is False else ""
        return one_line(
            "Calibration",
            f"{len(self.unknown)} unknowns",
            f"{len(self.rows)} rows",
            fit,
            lost,
            poor,
        )

    def __str__(self) -> str:
        from .report import calibration_text

        return calibration_text(self)

    @cached_property
    def robot(self) -> FiveBar:
        """The robot with the lengths found; what it weighs is the nominal one's."""
        return robot_with(self.nominal, self.p)

    @cached_property
    def values(self) -> dict[str, float]:
        """The unknowns by name: m, rad, rad per unit of q; scale: measured metres per metre."""
        return {name: float(self.p[PLACE[name]]) for name in self.unknown}

    @cached_property
    def _free(self):
        return np.array([PLACE[name] for name in self.unknown])

    @cached_property
    def sizes(self) -> np.ndarray:
        """(k,) of the unknowns, by which they are compared: the mean bar, 1 rad, 1 rad over the
        largest reading.
        """
        return sizes(self.nominal, self.rows.q, self.unknown)

    @cached_property
    def _off(self):
        """Predicted minus measured, weighted (m,), and its Jacobian by the unknowns in units of
        their sizes (m, k).
        """
        off, jacobian = misses(self.p, self.rows, self.assembly)
        jacobian = jacobian[:, self._free] * self.sizes * self.weight[:, None]
        jacobian[:, self._held] = 0.0
        return off * self.weight, jacobian

    @cached_property
    def _held(self):
        return self.held if len(self.held) else np.zeros(len(self.unknown), bool)

    @cached_property
    def _spectrum(self):
        left, s, right, tolerance = spectrum(self._off[1])
        return left, s, right, int((s > tolerance).sum())

    @property
    def rank(self) -> int:
        """How many combinations of the unknowns the data tell."""
        return self._spectrum[3]

    @cached_property
    def working(self) -> np.ndarray:
        """Working modes (n, 2) of the rows, int8, 0 where the robot found does not close."""
        sines = place(self.p, self.rows.q, self.assembly).sines
        return np.stack([-sign(sine, SINGULAR) for sine in sines], axis=-1)

    @property
    def dof(self) -> int:
        """Measured numbers beyond those that the unknowns take up."""
        return len(self.weight) - self.rank

    @cached_property
    def variance(self) -> float:
        """Of a weighted number: 1 where sigma is given, else from the residuals; inf where there
        are no spare ones.
        """
        if self.absolute and self.loss == "linear":
            return 1.0
        if self.dof <= 0:
            return np.inf
        off = self._off[0]
        if self.loss == "linear":
            return float(off @ off) / self.dof
        # Huber's: mean psi^2 over (mean psi')^2.
        psi, slope = loss_slopes(self.loss, off)
        return float(psi @ psi) / self.dof / max(float(np.mean(slope)), 1e-3) ** 2

    @cached_property
    def covariance(self) -> np.ndarray:
        """(k, k) of the unknowns in SI units, of what the data tell; what they do not tell has
        none: see `sd`.
        """
        _, s, right, rank = self._spectrum
        scaled = right[:rank].T / s[:rank]
        variance = self.variance if np.isfinite(self.variance) else 0.0
        return variance * (scaled @ scaled.T) * np.outer(self.sizes, self.sizes)

    @cached_property
    def sd(self) -> dict[str, float]:
        """Standard deviations by name; inf of an unknown that the data do not tell by itself, or
        that is at a bound.
        """
        lost = self._lost | self._held | ~np.isfinite(self.variance)
        return {
            name: np.inf if out else float(np.sqrt(v))
            for name, out, v in zip(self.unknown, lost, np.diag(self.covariance))
        }

    @cached_property
    def _null(self):
        """Combinations that the data do not tell (unknowns - rank, k), in units of the sizes."""
        null = self._spectrum[2][self.rank :]
        return (
            null[np.abs(null[:, ~self._held]).max(axis=1, initial=0.0) > 1e-9]
            if len(null)
            else null
        )

    @cached_property
    def _lost(self):
        return (
            (np.abs(self._null) > 1e-6).any(axis=0)
            if len(self._null)
            else np.zeros(len(self.unknown), bool)
        )

    @cached_property
    def correlation(self) -> np.ndarray:
        """(k, k) of the unknowns, 0 where one has no variance."""
        deviation = np.sqrt(np.diag(self.covariance))
        scale = np.where(deviation > 0, deviation, np.inf)
        return self.covariance / np.outer(scale, scale)

    def intervals(
        self, level: float = 0.95, method: str = "linear"
    ) -> dict[str, tuple[float, float]]:
        """{name: (low, high)} that hold the true value with this probability, if the model holds.

        method: "linear", Student's t times `sd` (normal where sigma is given); or "profile", where
            a fit with that one
        value held is just as much worse: for intervals so wide that the model bends.
        """
        from .profile import profile

        level = number(level, "level", 0.0, 1.0, above=True)
        if method not in ("linear", "profile") or level >= 1:
            raise ValueError(
                f"level must be below 1, and method 'linear' or 'profile', not {level}, {method!r}"
            )
        if method == "profile" and self.loss != "linear":
            raise ValueError(
                f"method 'profile' is of least squares, loss='linear', not of {self.loss!r}"
            )
        far = float(
            ndtri(0.5 + level / 2) if self.absolute else stdtrit(max(self.dof, 1), 0.5 + level / 2)
        )
        if method == "profile":
            return {name: profile(self, name, far) for name in self.unknown}
        return {
            name: (value - far * self.sd[name], value + far * self.sd[name])
            for name, value in self.values.items()
        }

    @cached_property
    def residuals(self) -> np.ndarray:
        """Measured minus predicted points (n, 2), m; nan where not measured."""
        return self.rows.points - self.predict(self.rows.q, self.assembly)

    @cached_property
    def before(self) -> np.ndarray:
        """All values (13,) before: the start, but the frame, as far as it is unknown, laid on the
        points anew.
        """
        names, p = [name for name in self.unknown if name in FRAME], self.start.copy()
        own = [PLACE[name] for name in names]
        p[own] = self.p[own]
        return self._fitted(names, p)

    def _fitted(self, names, p):
        """p with these unknowns by least squares; as it is where they are none, or it does not
        reach every row.
        """
        if not names or not np.isfinite(misses(p, self.rows, self.assembly, derive=False)[0]).all():
            return p
        own = np.array([PLACE[name] for name in names])
        task = Task(self.rows, own, p, sizes(self.nominal, self.rows.q, names), self.weight)
        return solve(task, p, self.assembly)[0]

    @cached_property
    def residuals_before(self) -> np.ndarray:
        """Measured minus predicted points (n, 2) with the values `before`; nan too where these do
        not reach.
        """
        return self.rows.points - seen(self.before, self.rows.q, self.assembly, derive=False)[0]

    @cached_property
    def rms(self) -> float:
        """Of the measured numbers, points and distances, m."""
        return float(np.sqrt(np.mean((self._off[0] / self.weight) ** 2)))

    @cached_property
    def rms_before(self) -> float:
        """With the values `before`, of the rows that these reach."""
        off = misses(self.before, self.rows, self.assembly, derive=False)[0]
        good = np.isfinite(off)
        return float(np.sqrt(np.mean(off[good] ** 2))) if good.any() else np.inf

    @property
    def chi2(self) -> float:
        """Sum of squares over sigma^2."""
        return float(self._off[0] @ self._off[0])

    @property
    def p_value(self) -> float | None:
        """How likely noise of this sigma alone gives such a chi2 or a larger one; None where sigma
        is not given.
        """
        return float(chdtrc(self.dof, self.chi2)) if self.absolute and self.dof > 0 else None

    @property
    def fits(self) -> bool | None:
        """Whether the model explains the data to sigma; None where sigma is not given."""
        return None if self.p_value is None else self.p_value > DOUBT

    @cached_property
    def leave_one_out(self) -> float:
        """RMS, m, with which each row is predicted from all others; inf where a row alone tells
        something.
        """
        return left_out(
            self._off[0], self._spectrum[0][:, : self.rank], self.rows.row_of, self.weight
        )

    @cached_property
    def outliers(self) -> dict[str, float]:
        """Rows off all others, by line or number: probability of that by chance, in any row, below
        1 % (Bonferroni).
        """
        found = off_rows(*self._off, self.rank, self.rows.row_of, self.absolute)
        return {self.rows.where[row]: p for row, p in found.items()}

    @cached_property
    def indistinguishable(self) -> tuple[str, ...]:
        """What these data cannot tell apart, a sentence each, with a measurement that would; empty
        if all is told.
        """
        if not len(self._null):
            return ()
        remedies = self._remedies
        return tuple(
            f"{combination(vector, self.unknown, self.sizes, self.p)}:"
            f" {remedies.for_vector(vector, self.unknown)}"
            for vector in plainest(self._null)
        )

    @cached_property
    def weakly_identified(self) -> tuple[str, ...]:
        """What they tell so poorly that it is hardly known, a sentence each."""
        _, s, right, rank = self._spectrum
        sd = np.sqrt(self.variance) / s[:rank]
        return hardly_told(sd, right[:rank], self.unknown, self.sd)

    @cached_property
    def _remedies(self):
        axes = set(self.rows.asked[1].tolist())
        return Remedies(self.p, self.rows.q, self.assembly, axes, self._free, self.sizes)

    def refit(self, held: dict[str, float]) -> float:
        """chi2 of the best fit with some unknowns held at these values."""
        p = self.p.copy()
        p[[PLACE[name] for name in held]] = list(held.values())
        p = self._fitted([name for name in self.unknown if name not in held], p)
        off = misses(p, self.rows, self.assembly, derive=False)[0] * self.weight
        return float(np.nan_to_num(off @ off, nan=np.inf))

    def to_json(self, path: TextFile) -> None:
        """Write all of it; `from_json` reads it back."""
        saving.write_calibration(self, path)

    @classmethod
    def from_json(cls, path: TextFile) -> Calibration:
        """A calibration as `to_json` wrote it; ValueError for another file."""
        return cls(**saving.read_calibration(path))

    def to_toml(self, path: TextFile) -> None:
        """Write the robot found as `--robot FILE.toml` reads it; offsets and frame stand there as a
        comment.
        """
        saving.write_robot(self, path)
