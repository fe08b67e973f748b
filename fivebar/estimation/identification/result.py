"""What an identification gives: a robot, how sure its values are, what was left out and what a log
cannot tell.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...base.checks import flag, number, strings, table_of, two_numbers
from ...base.checks import text as words
from ...base.presentation import Plotted
from ...base.representation import one_line, table
from ...base.tables import STRANGE, TextFile, whole_text, written
from ...models.parameters import robot_of
from ...models.robots import Robot

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, eq=False)
class Validation:
    """A second run, of which nothing was used: misfit, as the Identification's; ratio (2,): rms of
    what is missed of each motor's torque over the noise sigma of the first; t (n,), tau, predicted
    (n, 2), nan where nothing counts.
    """

    misfit: float
    ratio: tuple[float, float]
    t: np.ndarray
    tau: np.ndarray
    predicted: np.ndarray

    def __repr__(self) -> str:
        return one_line(
            "Validation",
            f"misses {100 * self.misfit:.3g} % of the torque, {max(self.ratio):.3g} times the"
            " noise",
        )


@dataclass(frozen=True, eq=False)
class Identification(Plotted):
    """A robot identified from logs, from `identify`.

    robot: with the identified parameters; given: the robot it began with. values, sd: by name, of
        those chosen, SI.
    chosen: in the order of the ladder; rejected {name: why}; indistinguishable: sentences; said:
    sentences on the log. noise (2,): N m, of a filtered row of each motor's torque; misfit: share
    of the torque's rms that is missed;
    p_value: of all that was left out being 0; cutoff: Hz, of the filters; correlation: of the
    chosen. t (n,) s, tau, predicted (n, 2) N m: the filtered rows, nan where they do not count.
    validation: of the second run, or None;
    bodies: whether the parameters were held to those that bodies can have.
    """

    robot: Robot
    given: Robot
    values: dict[str, float]
    sd: dict[str, float]
    chosen: tuple[str, ...]
    rejected: dict[str, str]
    indistinguishable: tuple[str, ...]
    notes: tuple[str, ...]
    noise: tuple[float, float]
    misfit: float
    p_value: float
    cutoff: float
    correlation: np.ndarray
    t: np.ndarray
    tau: np.ndarray
    predicted: np.ndarray
    validation: Validation | None = None
    bodies: bool = False

    def __repr__(self) -> str:
        second = (
            ""
            if self.validation is None
            else f"{max(self.validation.ratio):.3g} times the noise in a second run"
        )
        missed = f"misses {100 * self.misfit:.3g} % of the {self.robot.words.effort}s"
        return one_line("Identification", " ".join(self.chosen), missed, second)

    def _repr_html_(self) -> str:
        rows = {
            name: f"{value:.6g} ± {self.sd[name]:.2g} {self._unit(name)}"
            for name, value in self.values.items()
        }
        return table(repr(self), rows)

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def _unit(self, name):
        words = self.robot.words
        friction = {"fv": f"{words.effort_unit} s/{words.unit}", "fs": words.effort_unit}
        return {"zz": "kg m²", "mx": "kg m", "my": "kg m", **friction}.get(name[:2], "kg")

    def lines(self) -> list[str]:
        """The table and the sentences."""
        found = [f"{'':8}{'value':>14}{'± 1 sd':>12}"]
        found += [
            f"  {name:<6}{value:>14.6g}{self.sd[name]:>12.2g}  {self._unit(name)}"
            for name, value in self.values.items()
        ]
        noise = " and ".join(f"{each:.3g}" for each in self.noise)
        unit = self.robot.words.effort_unit
        found.append(
            f"misses {100 * self.misfit:.3g} % of the {self.robot.words.effort}s; noise of a row"
            f" {noise} {unit}"
        )
        if self.validation is not None:
            first, second = self.validation.ratio
            missed = 100 * self.validation.misfit
            found.append(
                f"second run: misses {missed:.3g} %, {first:.3g} and {second:.3g} times the noise"
                " of the first"
            )
        found.append(
            f"what was left out is 0 with p = {self.p_value:.2g}"
            + ("; the deviations count that it need not be" if self.rejected else "")
        )
        found += [f"left out: {name}: {why}" for name, why in self.rejected.items()]
        found += [f"not told apart: {sentence}" for sentence in self.indistinguishable]
        found += [f"of the log: {sentence}" for sentence in self.notes]
        return found

    @property
    def table(self) -> dict:
        """All of it but the rows, as plain numbers and words."""
        found = {name: getattr(self, name) for name in _PLAIN}
        found |= {
            "robot": self.robot.parameters,
            "given": self.given.parameters,
            "correlation": self.correlation.tolist(),
        }
        if self.validation is not None:
            found["validation"] = {
                "misfit": self.validation.misfit,
                "ratio": list(self.validation.ratio),
            }
        return found

    def to_json(self, path: TextFile) -> None:
        """Write all of it but the rows, which come from the log."""
        with written(path) as out:
            json.dump({"fivebar": "identification", **self.table}, out, indent=2)
            out.write("\n")

    @classmethod
    def from_json(cls, path: TextFile) -> Identification:
        """Read what `to_json` wrote, without rows; ValueError for what is not such a file."""
        text, name = whole_text(path, "an identification")
        try:
            table = json.loads(text)
            if table.pop("fivebar") != "identification":
                raise ValueError("it is of another kind")
            table["validation"] = _read_validation(table.get("validation"))
            for key in ("robot", "given"):
                table[key] = robot_of(table[key])
            for key in ("chosen", "indistinguishable", "notes"):
                table[key] = tuple(strings(table[key], key))
            for key, rule in {"values": number, "sd": number, "rejected": words}.items():
                table[key] = table_of(rule)(table[key], key)
            for key in ("misfit", "p_value", "cutoff"):
                table[key] = number(table[key], key)
            table["noise"], table["bodies"] = (
                two_numbers(table["noise"], "noise"),
                flag(table["bodies"], "bodies"),
            )
            if not set(table["chosen"]) == set(table["values"]) == set(table["sd"]):
                raise ValueError(
                    "what is chosen, its values and their sd are not of the same names"
                )
            table["correlation"] = np.array(table["correlation"], dtype=float)
            return cls(**table, t=np.zeros(0), tau=np.zeros((0, 2)), predicted=np.zeros((0, 2)))
        except STRANGE as error:
            raise ValueError(
                f"{name}: not a file written by Identification.to_json: {type(error).__name__}:"
                f" {error}"
            ) from None

    def to_toml(self, path: TextFile) -> None:
        """Write the robot as a file that `fivebar ... --robot FILE.toml` reads."""
        with written(path) as out:
            out.write("# identified by fivebar; SI units\n")
            for name, value in self.robot.parameters.items():
                shown_value = f"[{value[0]!r}, {value[1]!r}]" if name == "gravity" else repr(value)
                out.write(
                    f"{name} = {shown_value}"
                    + (f"  # ± {self.sd[name]:.2g}\n" if name in self.sd else "\n")
                )


_PLAIN = (
    "values",
    "sd",
    "chosen",
    "rejected",
    "indistinguishable",
    "notes",
    "noise",
    "misfit",
    "p_value",
    "cutoff",
    "bodies",
)


def _read_validation(table):
    if table is None:
        return None
    misfit, ratio = number(table["misfit"], "misfit"), two_numbers(table["ratio"], "ratio")
    return Validation(misfit, ratio, np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2)))
