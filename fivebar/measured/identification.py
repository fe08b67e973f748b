"""What a robot's masses and friction are, by a log of its motion and torques; and what that log cannot tell."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from ..checks import flag, modes, optional, positive, shown, strings, takes
from ..checks import robot as must_be_robot
from ..described import one_line
from ..models.parameters import robot_of
from ..models.robots import Robot
from ..simulation.logs import Gauges
from ..tables import STRANGE, BinaryFile, TextFile, saved, written
from .bodies import consistent as nearest_bodies
from .regression import Fit, fit, left_out_cost, price, smallest
from .regressor import ladder, linear_names
from .rows import Rows
from .samples import Samples, log_of, samples
from .suspicions import beyond_the_model, explain
from .told import EXACT, NEARLY, any_motion, independent, words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POOR = 0.3  # of the torque: where a model misses more, what may be wrong with the log is looked for
SURE = 4.0  # standard deviations, below 0 by which no friction and no mass can be


@dataclass(frozen=True, eq=False)
class Validation:
    """A second run, of which nothing was used: misfit, as the Identification's; ratio (2,): rms of what is missed of
    each motor's torque over the noise sigma of the first; t (n,), tau, predicted (n, 2), nan where nothing counts."""

    misfit: float
    ratio: tuple[float, float]
    t: np.ndarray
    tau: np.ndarray
    predicted: np.ndarray

    def __repr__(self) -> str:
        return one_line(
            "Validation", f"misses {100 * self.misfit:.3g} % of the torque, {max(self.ratio):.3g} times the noise"
        )


@dataclass(frozen=True, eq=False)
class Identification:
    """A robot identified from logs, from `identify`.

    robot: with the identified parameters; given: the robot it began with. values, sd: by name, of the chosen parameters,
    SI. chosen, in the order of the ladder; rejected {name: why}; indistinguishable: sentences; said: sentences on the
    log. noise (2,): N m, of a filtered row of each motor's torque; misfit: share of the torque's rms that is missed;
    p_value: of all that was left out being 0; cutoff: Hz, of the filters; correlation: of the chosen. t (n,) s, tau,
    predicted (n, 2) N m: the filtered rows, nan where they do not count. validation: of the second run, or None;
    bodies: whether the parameters were held to those that bodies can have.
    """

    robot: Robot
    given: Robot
    values: dict[str, float]
    sd: dict[str, float]
    chosen: tuple[str, ...]
    rejected: dict[str, str]
    indistinguishable: tuple[str, ...]
    said: tuple[str, ...]
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
        second = "" if self.validation is None else f"{max(self.validation.ratio):.3g} times the noise in a second run"
        missed = f"misses {100 * self.misfit:.3g} % of the {self.robot.words.effort}s"
        return one_line("Identification", " ".join(self.chosen), missed, second)

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """The table and the sentences."""
        found = [f"{'':8}{'value':>14}{'± 1 sd':>12}"]
        found += [f"  {name:<6}{value:>14.6g}{self.sd[name]:>12.2g}" for name, value in self.values.items()]
        noise = " and ".join(f"{each:.3g}" for each in self.noise)
        unit = self.robot.words.effort_unit
        found.append(
            f"misses {100 * self.misfit:.3g} % of the {self.robot.words.effort}s; noise of a row {noise} {unit}"
        )
        if self.validation is not None:
            first, second = self.validation.ratio
            missed = 100 * self.validation.misfit
            found.append(
                f"second run: misses {missed:.3g} %, {first:.3g} and {second:.3g} times the noise of the first"
            )
        found.append(f"what was left out is 0 with p = {self.p_value:.2g}")
        found += [f"left out: {name}: {why}" for name, why in self.rejected.items()]
        found += [f"not told apart: {sentence}" for sentence in self.indistinguishable]
        found += [f"of the log: {sentence}" for sentence in self.said]
        return found

    def plot(self, path: BinaryFile | None = None) -> Figure:
        """Matplotlib figure of torques measured, predicted and their difference; written to `path` if given."""
        from ..pictures.plot.identification import identification  # Matplotlib, which no regression needs

        return saved(identification(self), path)

    def to_json(self, path: TextFile) -> None:
        """Write all of it but the rows, which come from the log."""
        table = {name: getattr(self, name) for name in _PLAIN}
        table |= {
            "robot": self.robot.parameters,
            "given": self.given.parameters,
            "correlation": self.correlation.tolist(),
        }
        if self.validation is not None:
            table["validation"] = {"misfit": self.validation.misfit, "ratio": list(self.validation.ratio)}
        with written(path) as out:
            json.dump({"fivebar": "identification", **table}, out, indent=2)
            out.write("\n")

    @classmethod
    def from_json(cls, path: TextFile) -> Identification:
        """Read what `to_json` wrote, without rows; ValueError for what is not such a file."""
        text, name = (
            (path.read(), getattr(path, "name", "the open file"))
            if hasattr(path, "read")
            else (Path(path).read_text("utf-8"), path)
        )
        try:
            table = json.loads(text)
            if table.pop("fivebar") != "identification":
                raise ValueError("it is of another kind")
            table["validation"] = _read_validation(table.get("validation"))
            for key in ("robot", "given"):
                table[key] = robot_of(table[key])
            for key in ("chosen", "indistinguishable", "said", "noise"):
                table[key] = tuple(table[key])
            table["correlation"] = np.array(table["correlation"], dtype=float)
            return cls(**table, t=np.zeros(0), tau=np.zeros((0, 2)), predicted=np.zeros((0, 2)))
        except STRANGE as error:
            raise ValueError(
                f"{name}: not a file written by Identification.to_json: {type(error).__name__}: {error}"
            ) from None

    def to_toml(self, path: TextFile) -> None:
        """Write the robot as a file that `fivebar ... --robot FILE.toml` reads."""
        with written(path) as out:
            out.write("# identified by fivebar; SI units\n")
            for name, value in self.robot.parameters.items():
                shown_value = f"[{value[0]!r}, {value[1]!r}]" if name == "gravity" else repr(value)
                out.write(f"{name} = {shown_value}" + (f"  # ± {self.sd[name]:.2g}\n" if name in self.sd else "\n"))


_PLAIN = (
    "values",
    "sd",
    "chosen",
    "rejected",
    "indistinguishable",
    "said",
    "noise",
    "misfit",
    "p_value",
    "cutoff",
    "bodies",
)


def _read_validation(table):
    if table is None:
        return None
    left, right = table["ratio"]
    return Validation(table["misfit"], (left, right), np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2)))


@takes(
    robot=must_be_robot, unknown=optional(strings), assembly=modes(1), cutoff=optional(positive), consistent=flag,
)  # fmt: skip
def identify(
    robot: Robot, log: object, *, validate: object | None = None, unknown: Sequence[str] | None = None,
    assembly: int = -1, cutoff: float | None = None, consistent: bool = False, units: Mapping[str, str] | None = None,
    counts_per_turn: object = None, gear_ratio: object = 1.0, offset: object = (0.0, 0.0), torque_constant: object = None,
) -> Identification:  # fmt: skip
    """Inertial parameters and friction of a robot from logs of its motion and torques; gives an Identification.

    robot: of known lengths and gravity; its masses and friction count where they are not unknown.
    log: a Run, a CSV file, a mapping of arrays t, q1, q2, tau1, tau2, perhaps q1_dot, ...; or a list of these.
    validate: a second run, only predicted. unknown: names, None: all that the torque is linear in; the masses stay in
    the model, of the others the smallest set that the data do not reject (extended BIC, see `regression`).
    assembly: the mode of all logs. cutoff: Hz, of all filters; None: where the motion sinks into its noise
    (`derivatives`). consistent: hold to what bodies can have (`bodies`). units: {"q1": "deg"} of columns without one;
    counts_per_turn, gear_ratio, offset, torque_constant: as `Run.from_log`.
    ValueError for a log that says nothing or is not of this robot: what is wrong with it, as far as it can be told.
    """
    gauges = Gauges(counts_per_turn, gear_ratio, offset, torque_constant)
    logs = [log_of(each, robot, units, gauges) for each in (log if isinstance(log, (list, tuple)) else [log])]
    if not logs:
        raise ValueError("identify needs at least one log")
    names = linear_names(robot)
    sought = sought_names(robot, unknown)
    found = [samples(own, held, robot, assembly, cutoff) for own, held in logs]
    rows = _joined([each.rows for each in found])
    _must_say(rows, found)
    known = np.array([0.0 if name in sought else getattr(robot, name) for name in names])
    rows = replace(rows, tau=rows.tau - rows.W @ known)
    columns = [k for k, name in enumerate(names) if name in sought]
    told, folded = independent(any_motion(robot, assembly), columns, EXACT)
    sentences = words(robot, folded, everywhere=True)
    told, more = independent(rows.W, told, NEARLY)
    sentences += words(robot, more, everywhere=False)
    full = fit(rows, told)
    own = ladder(robot)["masses"]
    if full.misfit > POOR or _impossible(robot, [names[k] for k in told], full):
        explain(robot, logs, assembly, cutoff, full.misfit, _impossible)
    optional_ = [k for k, column in enumerate(told) if names[column] not in own]
    never = [k for k in optional_ if names[told[k]][0] == "f" and full.theta[k] < 0]
    kept = smallest(full.theta, full.cov, optional_, price(int(rows.counts.sum()), len(optional_)), never)
    out = [k for k in optional_ if k not in kept]
    p_value = float(chi2.sf(left_out_cost(full.theta, full.cov, out), max(len(out), 1)))
    chosen = [column for k, column in enumerate(told) if k not in out]
    last = fit(rows, chosen)
    theta = last.theta
    labels = [names[k] for k in chosen]
    if consistent:
        theta = nearest_bodies(robot, labels, theta, last.cov)
    result = _robot(robot, sought, labels, theta, last)
    sd = np.sqrt(np.diag(last.cov))
    values = dict(zip(labels, map(float, theta)))
    identified = Identification(
        robot=result, given=robot, values=values, sd=dict(zip(labels, map(float, sd))), chosen=tuple(labels),
        rejected={names[told[k]]: _why(robot, names[told[k]], full, k) for k in out},
        indistinguishable=tuple(sentences),
        said=tuple(dict.fromkeys([*(s for each in found for s in each.said), *beyond_the_model(robot, result, found, known, labels, theta, last)])),
        noise=tuple(map(float, last.sigma)), misfit=last.misfit, p_value=p_value, cutoff=min(each.cutoff for each in found),
        correlation=last.cov / np.outer(sd, sd), t=rows.t, tau=_shown(rows, rows.tau + rows.W @ known),
        predicted=_shown(rows, rows.W @ known + rows.W[:, :, chosen] @ theta), bodies=consistent,
    )  # fmt: skip
    if validate is None:
        return identified
    return replace(
        identified, validation=_validated(identified, log_of(validate, robot, units, gauges), assembly, cutoff)
    )


def sought_names(robot, unknown):
    names = linear_names(robot)
    if unknown is None:
        return names
    if wrong := [name for name in unknown if name not in names]:
        raise ValueError(
            f"unknown: no parameter {', '.join(map(repr, wrong))}; the torque is linear in {', '.join(names)}"
        )
    if not unknown:
        raise ValueError(f"unknown is empty: name some of {', '.join(names)}")
    return tuple(name for name in names if name in unknown)


def _joined(parts: Iterable[Rows]) -> Rows:
    parts, breaks, n = list(parts), [], 0
    for each in parts:
        breaks += [n + k for k in each.breaks]
        n += len(each.t)
    share = np.mean([each.share for each in parts], axis=0)
    whole = (np.concatenate([getattr(each, name) for each in parts]) for name in ("W", "tau", "counts", "t", "cover"))
    return Rows(*whole, tuple(breaks), (float(share[0]), float(share[1])))


def _must_say(rows, found):
    count = rows.counts.sum(axis=0)
    if count.min() < 2 * rows.W.shape[2]:
        why = " ".join(s for each in found for s in each.said)
        raise ValueError(
            f"only {count[0]} and {count[1]} independent rows of the two motors are left, at least {2 * rows.W.shape[2]} each are "
            f"needed: log longer, or faster motions{'. ' + why if why else ''}"
        )


def _impossible(robot, labels, found):
    """Names of masses and friction that come out surely below 0."""
    sd = np.sqrt(np.diag(found.cov))
    heavy = any(name in robot.turning_names for name in labels)
    own = () if heavy and len(labels) > 5 else ladder(robot)["masses"]
    own = own or ladder(robot)["masses"][:2]
    return [
        name for name, value, each in zip(labels, found.theta, sd)
        if (name in own or name[0] == "f") and value < -SURE * each
    ]  # fmt: skip


def _why(robot, name, full, k):
    value, sd = full.theta[k], np.sqrt(full.cov[k, k])
    if name[0] == "f" and value < 0:
        return f"friction would be {value:.3g} ± {sd:.2g}, less than none"
    return f"{value:.3g} ± {sd:.2g} with all others, not told from 0: below about {3.5 * sd:.2g} this log would not show it"


def _robot(robot, sought, labels, theta, found):
    values = dict.fromkeys(sought, 0.0) | dict(zip(labels, map(float, theta)))
    try:
        return replace(robot, **values)
    except ValueError as error:
        raise ValueError(
            f"the log asks for parameters that no robot has ({error}): its torques, modes or lengths are not this robot's, "
            "or consistent=True holds to what bodies can have"
        ) from None


def _shown(rows, values):
    """A row's torque as the mean of its samples, nan where none counts."""
    return np.where(rows.counts, values / np.sqrt(np.where(rows.counts, rows.cover, 1.0)), np.nan)


def _validated(found: Identification, second, assembly, cutoff) -> Validation:
    log, held = second
    rows = samples(log, held, found.given, assembly, found.cutoff if cutoff is None else cutoff).rows
    theta = np.array([getattr(found.robot, name) for name in linear_names(found.given)])
    predicted = rows.W @ theta
    missed = np.where(rows.counts, rows.tau - predicted, 0.0)
    count = np.maximum(rows.counts.sum(axis=0), 1)
    size = np.maximum((np.where(rows.counts, rows.tau, 0.0) ** 2).sum(axis=0), 1e-300)
    misfit = float(np.sqrt(np.mean((missed**2).sum(axis=0) / size)))
    ratio = np.sqrt((missed**2).sum(axis=0) / count) / np.array(found.noise)
    return Validation(
        misfit, (float(ratio[0]), float(ratio[1])), rows.t, _shown(rows, rows.tau), _shown(rows, predicted)
    )
