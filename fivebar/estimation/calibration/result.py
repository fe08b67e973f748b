"""A calibration: the robot, how well it is known, what the data cannot tell, which rows are off."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy import ndarray
from scipy.special import chdtrc, ndtri, stdtrit

from ...base.backend import HUGE, sign
from ...base.checks import number
from ...base.presentation import Plotted
from ...base.representation import one_line
from ...base.tables import TextFile
from ...models.dyads import SINGULAR
from ...models.robots import FiveBar
from ...paths.machine import Machine
from ...paths.placement import Placement
from ...paths.tool import Tool
from ..saving import read_json, write_json
from .fit import loss_slopes, residuals, spectrum
from .indistinguishable import combination, plainest, remedy
from .measured_robot import FRAMES, LENGTHS, PLACE, length_ok, place, robot_with, seen, sizes
from .outliers import outlying_rows
from .rows import MeasuredRows

TOLERANCE = 3e-3  # of a mean bar: a workshop's, as ISO 2768-m has it for bars of 100 mm
EXACT = 1e-12  # of a mean bar: smaller misses are rounding
KIND = "calibration of a five-bar"


@dataclass(frozen=True, eq=False)
class Calibration(Plotted):
    """A calibrated five-bar, from `calibrate`; printed, it is a report.

        true angle = ratio q + offset        measured point = (x0, y0) + scale R(turn) xi
        xi = C + along u_i2 + across v_i2, of joint C, or of a tool on the distal bar of a leg

    With J the Jacobian of the measured numbers by the unknowns, each over its sigma, the covariance
    of the unknowns is the variance of a weighted number times (J^T J)^-1 on what the data tell.

    Attributes
    ----------
    nominal : FiveBar
        The robot that the search began with.
    unknown : tuple of str
        The unknowns.
    rows : MeasuredRows
        What was measured, n rows.
    assembly : (n,) array
        Assembly modes of the rows.
    start, p : (16,) arrays
        All values before and after, in the order of UNKNOWNS.
    weight : (m,) array
        1 / sigma of the measured numbers.
    absolute : bool
        Whether the weights are 1/m, or relative.
    loss : str
        The loss function of the residuals.
    prior : (k,) array
        `sizes` of the unknowns over the standard deviations of their starts, 0 without one.
    notes : tuple of str
        What was converted, left out or put right.

    Examples
    --------
    >>> import fivebar as fb
    >>> drawn, built = fb.FiveBar(), fb.FiveBar(l11=0.0905, d=0.1185)
    >>> where = fb.measurement_poses(drawn, 6)
    >>> pose = fb.igm(built, where.xi, where.working)
    >>> data = {"q1": pose.q[:, 0], "q2": pose.q[:, 1], "x": pose.xi[:, 0], "y": pose.xi[:, 1]}
    >>> result = fb.calibrate(drawn, data, ("l11", "l12", "l21", "l22", "d"), sigma=1e-5)
    >>> round(result.values["l11"], 6), round(result.robot.d, 6)
    (0.0905, 0.1185)
    >>> result.sd["l11"] < 1e-5, result.indistinguishable, result.fits
    (True, (), True)
    """

    nominal: FiveBar
    unknown: tuple[str, ...]
    rows: MeasuredRows = field(repr=False)
    assembly: ndarray
    start: ndarray
    p: ndarray
    weight: ndarray
    absolute: bool
    loss: str
    prior: ndarray
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        lost = len(self.unknown) - self.rank
        return one_line(
            "Calibration",
            f"{len(self.unknown)} unknowns",
            f"{len(self.rows)} rows",
            f"RMS {1e3 * self.rms_before:.3g} -> {1e3 * self.rms:.3g} mm",
            f"{lost} not told" if lost else "",
            "the model does not fit" if self.fits is False else "",
        )

    def __str__(self) -> str:
        from .report import report

        return report(self)

    @cached_property
    def robot(self) -> FiveBar:
        """The robot with the calibrated lengths and the nominal one's masses."""
        return robot_with(self.nominal, self.p)

    @cached_property
    def values(self) -> dict[str, float]:
        """The unknowns by name: m, rad, rad per unit of q; scale: measured metres per metre."""
        return {name: float(self.p[PLACE[name]]) for name in self.unknown}

    @cached_property
    def free(self) -> ndarray:
        """Places (k,) of the unknowns among all values."""
        return np.array([PLACE[name] for name in self.unknown])

    @cached_property
    def sizes(self) -> ndarray:
        """Sizes (k,) by which the unknowns are compared: the mean bar, 1 rad, 1 over readings."""
        return sizes(self.nominal, self.rows.q, self.unknown)

    @cached_property
    def _residuals(self):
        """Return the weighted residuals (m,), and their derivatives by unknowns in sizes (m, k)."""
        off, jacobian = residuals(self.p, self.rows, self.assembly)
        jacobian = jacobian[:, self.free] * self.sizes * self.weight[:, None]
        return off * self.weight, jacobian

    @cached_property
    def _with_prior(self):
        """Return `_residuals` over those of what was known before."""
        off, jacobian = self._residuals
        moved = (self.p - self.start)[self.free] / self.sizes
        known = self.prior > 0
        own = np.diag(self.prior)[known]
        off = np.append(off, (self.prior * moved)[known])
        return off, np.vstack([jacobian, own])

    @cached_property
    def _spectrum(self):
        left, s, right, tolerance = spectrum(self._with_prior[1])
        return left, s, right, int((s > tolerance).sum())

    @property
    def rank(self) -> int:
        """How many combinations of the unknowns the data and priors tell."""
        return self._spectrum[3]

    @cached_property
    def working(self) -> ndarray:
        """Working modes (n, 2) of the rows, int8, 0 where the robot does not close."""
        return -sign(place(self.p, self.rows.q, self.assembly).sines, SINGULAR)

    @property
    def dof(self) -> int:
        """Degrees of freedom: measured numbers and priors minus the rank."""
        return len(self._with_prior[0]) - self.rank

    @cached_property
    def variance(self) -> float:
        """Variance of a weighted number: 1 where sigma is given, else from the residuals.

        It is inf without degrees of freedom; with a robust loss it is Huber's, the mean of psi^2
        over the squared mean of psi'.
        """
        if self.absolute and self.loss == "linear":
            return 1.0
        if self.dof <= 0:
            return np.inf
        off = self._residuals[0]
        if self.loss == "linear":
            return float(off @ off) / self.dof
        psi, slope = loss_slopes(self.loss, off)
        return float(psi @ psi) / self.dof / max(float(np.mean(slope)), 1e-3) ** 2

    @cached_property
    def covariance(self) -> ndarray:
        """(k, k) of the unknowns, SI, of what the data tell; what they do not tell: see `sd`."""
        _, s, right, rank = self._spectrum
        scaled = right[:rank].T / s[:rank]
        variance = self.variance if np.isfinite(self.variance) else 0.0
        return variance * (scaled @ scaled.T) * np.outer(self.sizes, self.sizes)

    @cached_property
    def sd(self) -> dict[str, float]:
        """Standard deviations by name; inf of an unknown that is not told by itself, and of all
        where the data show no scatter.
        """
        known = self.told & np.isfinite(self.variance)
        deviations = np.where(known, np.sqrt(np.diag(self.covariance)), np.inf)
        return dict(zip(self.unknown, deviations.tolist()))

    @cached_property
    def told(self) -> ndarray:
        """Whether the data tell each unknown by itself (k,), bool."""
        return ~(np.abs(self._null) > 1e-6).any(axis=0)

    @cached_property
    def _null(self):
        """Return the combinations that the data do not tell (k - rank, k), in sizes."""
        return self._spectrum[2][self.rank :]

    @cached_property
    def correlation(self) -> ndarray:
        """(k, k) of the unknowns, nan where one has no variance."""
        deviation = np.sqrt(np.diag(self.covariance))
        scale = np.where(deviation > 0, deviation, np.nan)
        return self.covariance / np.outer(scale, scale)

    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Return {name: (low, high)} that hold the true value with this probability.

        Student's t times `sd`, normal where sigma is given.

        Parameters
        ----------
        level : float
            The probability, if the model holds.

        Raises
        ------
        ValueError
            The level is not between 0 and 1.
        """
        level = number(level, "level", 0.0, 1.0, above=True)
        if level >= 1:
            raise ValueError(f"level must be below 1, not {level}")
        tail = 0.5 + level / 2
        far = float(ndtri(tail) if self.absolute else stdtrit(max(self.dof, 1), tail))
        result = {}
        for name, value in self.values.items():
            half = far * self.sd[name]
            result[name] = (value - half, value + half)
        return result

    @cached_property
    def residuals(self) -> ndarray:
        """Measured minus predicted points (n, 2), m.

        nan where not measured, and where the robot, near Type 2, just fails to close.
        """
        return self.rows.points - self.predict(self.rows.q, self.assembly)

    @cached_property
    def before(self) -> ndarray:
        """The start (16,) in the measuring frame that was found."""
        p = self.start.copy()
        p[FRAMES] = self.p[FRAMES]
        return p

    @cached_property
    def residuals_before(self) -> ndarray:
        """Measured minus predicted points (n, 2) with the values `before`."""
        return self.rows.points - seen(self.before, self.rows.q, self.assembly, derive=False)[0]

    @cached_property
    def rms(self) -> float:
        """RMS of the residuals of points and distances, m."""
        return float(np.sqrt(np.mean((self._residuals[0] / self.weight) ** 2)))

    @cached_property
    def rms_before(self) -> float:
        """RMS with the values `before`, of the rows that these reach."""
        points_only = replace(self.rows, loop=None)
        off = residuals(self.before, points_only, self.assembly, derive=False)[0]
        good = np.isfinite(off)
        return float(np.sqrt(np.mean(off[good] ** 2))) if good.any() else np.inf

    @property
    def chi2(self) -> float:
        """Sum of squares over sigma^2, those of priors among them."""
        return float(self._with_prior[0] @ self._with_prior[0])

    @property
    def p_value(self) -> float | None:
        """Probability of such a chi2 or a larger one by chance; None where sigma is not given."""
        return float(chdtrc(self.dof, self.chi2)) if self.absolute and self.dof > 0 else None

    @property
    def fits(self) -> bool | None:
        """Whether p is above 0.001; None where sigma is not given."""
        return None if self.p_value is None else self.p_value > 1e-3

    @cached_property
    def advised_priors(self) -> dict[str, float]:
        """{length: standard deviation about its start, m}: a workshop's tolerance.

        {} where the data tell all lengths better, where priors are given, where rows are wrong, or
        where the start is what these very rows gave.
        """
        tolerance = TOLERANCE * float(np.mean(self.start[:4]))
        lengths = [name for name in self.unknown if name in LENGTHS]
        moved = {name: abs(self.values[name] - self.start[PLACE[name]]) for name in lengths}
        poor = [name for name in lengths if tolerance < self.sd[name] < np.inf]
        from_drawing = any(moved[name] > 1e-3 * self.sd[name] for name in poor)
        if not from_drawing or self.prior.any() or self.fits is False or self.outliers:
            return {}
        return dict.fromkeys(lengths, tolerance)

    @cached_property
    def outliers(self) -> dict[str, float]:
        """{row: p} of outlying rows, p the probability of that by chance in any row, below 1 %."""
        if self.rms < EXACT * np.mean(self.start[:4]):
            return {}
        off, jacobian = self._residuals
        found = outlying_rows(off, jacobian, self.rank, self.rows.row_of, self.absolute)
        return {self.rows.where[row]: p for row, p in found.items()}

    @cached_property
    def indistinguishable(self) -> tuple[str, ...]:
        """Sentences on what these data cannot tell apart, each with a measurement that would."""
        if not len(self._null):
            return ()
        return tuple(
            f"{combination(vector, self.unknown, self.sizes)}: {remedy(self, vector)}"
            for vector in plainest(self._null)
        )

    @property
    def weakly_identified(self) -> tuple[str, ...]:
        """Sentences on the unknowns that are known to no better than a tenth of their size."""
        if not np.isfinite(self.variance):
            return (
                f"no deviation is known: {len(self._with_prior[0])} measured numbers for"
                f" {self.rank} combinations leave none over that would show their scatter: measure"
                " more rows, or give sigma, the standard deviation of a measured coordinate"
                " (--sigma)",
            )
        limits = zip(self.unknown, 0.1 * self.sizes)
        weak = [name for name, most in limits if most < self.sd[name] < np.inf]
        return (f"hardly known, as their sd says: {', '.join(weak)}",) if weak else ()

    def predict(self, q: Any, assembly: Any = -1) -> ndarray:
        """Return points (*batch, 2) in the measuring frame at readings q (*batch, 2).

        They are nan where the robot does not close.
        """
        q = np.asarray(q, float)
        modes = np.broadcast_to(np.asarray(assembly), q.shape[:-1]).ravel()
        return seen(self.p, q.reshape(-1, 2), modes, derive=False)[0].reshape(q.shape)

    @cached_property
    def machine(self) -> Machine:
        """The robot with the offsets and ratios of its readings, the measuring frame, and the modes
        of the rows.
        """
        offset1, offset2, ratio1, ratio2, x0, y0, turn, scale, *at, leg = self.p[5:].tolist()
        frame = Placement((x0, y0), turn, scale)
        modes = np.column_stack([self.working, self.assembly])
        in_order = sorted(map(tuple, np.unique(modes[modes.all(axis=1)], axis=0).tolist()))
        offset = (offset1, offset2)
        ratio = (ratio1, ratio2)
        tool = Tool(int(leg), *at) if any(at) else None
        return Machine(self.robot, offset, ratio, frame, tool=tool, measured=tuple(in_order))

    def to_json(self, path: TextFile) -> None:
        """Write all of it; `from_json` reads it back."""
        result = {
            "values": self.values,
            "sd": self.sd,
            "indistinguishable": self.indistinguishable,
            "robot": self.robot,
        }
        write_json(path, KIND, self, result=result)

    @classmethod
    def from_json(cls, path: TextFile) -> Calibration:
        """Return a calibration as `to_json` wrote it; ValueError for another file."""
        return read_json(path, KIND, cls, _check)


def _check(found):
    """Refuse a calibration whose robot cannot be, or does not close on its rows."""
    if not (length_ok(found.p) and length_ok(found.start)):
        raise ValueError("p and start must have lengths that a robot can have")
    if not (np.abs(found.rows.q) < HUGE).all() or not (found.weight > 1 / HUGE).all():
        raise ValueError("readings must be finite, and weights > 0")
    if not np.isfinite(found._residuals[1]).all():
        raise ValueError("the calibrated robot does not close on its rows")
    str(found)
