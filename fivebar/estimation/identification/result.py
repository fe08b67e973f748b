"""An identification: a robot, how sure its values are, and what a log cannot tell."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy import ndarray

from ...base.presentation import Plotted
from ...base.representation import one_line, table
from ...base.tables import TextFile
from ...models.parameter_units import units_of
from ...models.robots import Robot
from ..saving import encode, read_json, write_json

KIND = "identification"


def _no_rows():
    return np.zeros((0, 2))


@dataclass(frozen=True, eq=False)
class Validation:
    """A second run, of which nothing was used.

    misfit: as the Identification's; ratio (2,): rms of what is missed of each motor's torque over
    the noise of the first; t (n,), tau, predicted (n, 2), nan where nothing counts.
    """

    misfit: float
    ratio: tuple[float, ...]
    t: ndarray = field(default_factory=lambda: np.zeros(0))
    tau: ndarray = field(default_factory=_no_rows)
    predicted: ndarray = field(default_factory=_no_rows)

    def __repr__(self) -> str:
        missed = f"misses {100 * self.misfit:.3g} % of the torque"
        return one_line("Validation", f"{missed}, {max(self.ratio):.3g} times the noise")


@dataclass(frozen=True, eq=False)
class Identification(Plotted):
    """Identified masses and friction of a robot, from `identify`; printed, it is a report.

        tau = W(q, q', q'') theta

    Attributes
    ----------
    robot : FiveBar or Biglide
        The robot with the identified parameters.
    given : FiveBar or Biglide
        The robot that the identification began with.
    values, sd : dict
        The chosen parameters and their standard deviations by name, SI units.
    chosen : tuple of str
        The names of the chosen parameters, in the order of the ladder.
    rejected : dict
        {name: why the parameter was left out}.
    indistinguishable : tuple of str
        Sentences on what no motion, or not this log, tells.
    notes : tuple of str
        Sentences on the log.
    noise : (2,)
        Standard deviation of a filtered row of each motor's torque, N m.
    misfit : float
        Share of the torque's rms that the model misses.
    p_value : float
        Probability of what was left out, if all of it is 0.
    cutoff : float
        Cut-off of the filters, Hz.
    correlation : (k, k) array
        Correlations of the chosen parameters.
    t, tau, predicted : (n,), (n, 2) and (n, 2) arrays
        The filtered rows, s and N m; nan where a row does not count.
    validation : Validation, optional
        The prediction of a second run.

    Examples
    --------
    >>> import fivebar as fb
    >>> robot, circle = fb.FiveBar(m=0.6), fb.circle((0.06, 0.09), 0.02, 0.5)
    >>> log = fb.simulate(robot, fb.ComputedTorque(robot, 100, 20), circle, step=2e-3)
    >>> result = fb.identify(fb.FiveBar(), log, unknown=["zz1", "zz2", "m"])
    >>> result.chosen, round(result.robot.m, 2), result.misfit < 0.01
    (('zz1', 'zz2', 'm'), 0.6, True)
    """

    robot: Robot
    given: Robot
    values: dict[str, float]
    sd: dict[str, float]
    chosen: tuple[str, ...]
    rejected: dict[str, str]
    indistinguishable: tuple[str, ...]
    notes: tuple[str, ...]
    noise: tuple[float, ...]
    misfit: float
    p_value: float
    cutoff: float
    correlation: ndarray
    validation: Validation | None = None
    t: ndarray = field(default_factory=lambda: np.zeros(0))
    tau: ndarray = field(default_factory=_no_rows)
    predicted: ndarray = field(default_factory=_no_rows)

    def __repr__(self) -> str:
        second = ""
        if self.validation is not None:
            second = f"{max(self.validation.ratio):.3g} times the noise in a second run"
        return one_line("Identification", " ".join(self.chosen), self._missed(self.misfit), second)

    def _missed(self, misfit):
        return f"misses {100 * misfit:.3g} % of the {self.robot.words.effort}s"

    def _repr_html_(self) -> str:
        rows = {
            name: f"{value:.6g} ± {self.sd[name]:.2g} {self._unit(name)}"
            for name, value in self.values.items()
        }
        return table(repr(self), rows)

    def __str__(self) -> str:
        left, right = self.noise
        lines = [f"{'':8}{'value':>14}{'± 1 sd':>12}"]
        for name, value in self.values.items():
            sd = self.sd[name]
            unit = self._unit(name)
            lines.append(f"  {name:<6}{value:>14.6g}{sd:>12.2g}  {unit}")
        lines.append(
            f"{self._missed(self.misfit)}; noise of a row {left:.3g} and {right:.3g}"
            f" {self.robot.words.effort_unit}"
        )
        if self.validation is not None:
            first, second = self.validation.ratio
            lines.append(
                f"second run: misses {100 * self.validation.misfit:.3g} %, {first:.3g} and"
                f" {second:.3g} times the noise of the first"
            )
        count = "; the deviations count that it need not be" if self.rejected else ""
        lines.append(f"what was left out is 0 with p = {self.p_value:.2g}{count}")
        lines += [f"left out: {name}: {why}" for name, why in self.rejected.items()]
        lines += [f"not told apart: {sentence}" for sentence in self.indistinguishable]
        lines += [f"of the log: {sentence}" for sentence in self.notes]
        return "\n".join(lines)

    def _unit(self, name):
        return next(iter(units_of(name, self.robot.turns)))

    @property
    def table(self) -> dict:
        """All of it but the rows, as plain numbers and strings."""
        plain = encode(self)
        for part in (plain, plain["validation"] or {}):
            for name in ("t", "tau", "predicted"):
                part.pop(name, None)
        return plain

    def to_json(self, path: TextFile) -> None:
        """Write all of it but the rows, which come from the log."""
        write_json(path, KIND, self.table)

    @classmethod
    def from_json(cls, path: TextFile) -> Identification:
        """Read what `to_json` wrote, without rows; ValueError for another file."""
        return read_json(path, KIND, cls, str)
