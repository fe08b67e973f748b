"""What the measurements say: orders of convergence, who is fastest to an error, who fails. Nothing is known before."""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from .chart import OURS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .chart import Panel
    from .store import Result

ABOVE_ROUNDING = 10.0
LEVEL = 1.1  # a ratio of times below it is no difference


def observed_order(steps: Sequence[float], errors: Sequence[float], rounding: float) -> float:
    """The slope of log error over log step between the two smallest steps whose errors are clear of rounding; or nan.

    Rounding is the given one, or the smallest error where smaller steps have larger ones.
    """
    order = np.argsort(steps)[::-1]
    steps, errors = np.asarray(steps, dtype=float)[order], np.asarray(errors, dtype=float)[order]
    if len(steps) < 2:
        return math.nan
    least = int(np.argmin(errors))
    floor = max(rounding, errors[least] if least < len(errors) - 1 else 0.0)
    clear = np.flatnonzero(errors[: least + 1] > ABOVE_ROUNDING * floor)
    if len(clear) < 2:
        return math.nan
    a, b = clear[-2:]
    return float(math.log(errors[a] / errors[b]) / math.log(steps[a] / steps[b]))


def orders(result: Result, panel: Panel) -> dict[str, float]:
    """{method: observed order} of those that have one, by this panel's errors."""
    found = {}
    for method in result.chart.methods:
        points = counted(result, panel, method.name)
        if method.order and points:
            steps = [result.chart.step(row["knob"]) for row in points]
            found[method.name] = observed_order(steps, [row[panel.y] for row in points], panel.rounding)
    return {name: order for name, order in found.items() if not math.isnan(order)}


def counted(result: Result, panel: Panel, method: str | None = None) -> list[dict]:
    """The rows that are points of a panel."""
    return [row for row in result.of(panel.problem, method) if row.get(panel.y, math.inf) <= panel.ceiling]


def failures(result: Result, panel: Panel) -> dict[str, list]:
    """{method: [(row, word), ...]}: failed and left-out attempts, and those with an error above the panel's ceiling."""
    found = {}
    for row in result.rows:
        if row["problem"] != panel.problem:
            continue
        if row["status"] == "left out":
            found.setdefault(row["method"], []).append((row, f"left out: {row['word']}"))
        elif row["status"] != "ok":
            found.setdefault(row["method"], []).append((row, row["word"]))
        elif panel.y in row and row[panel.y] > panel.ceiling:
            found.setdefault(row["method"], []).append((row, f"error above {panel.ceiling:g}"))
    return found


def words_of(failed: list) -> str:
    """The words of one method's failures, with how often each came; those that differ in a share only, together."""
    found = {}
    for _, word in failed:
        found.setdefault(re.sub(r"\d+%", "#%", word), []).append(word)
    parts = []
    for pattern, words in found.items():
        shares = sorted({int(share) for word in words for share in re.findall(r"(\d+)%", word)})
        ends = f"{shares[0]}-{shares[-1]}%" if len(shares) > 1 else f"{shares[0]}%" if shares else ""
        parts.append(pattern.replace("#%", ends) + (f" ({len(words)} times)" if len(words) > 1 else ""))
    return ", ".join(parts)


def caption(result: Result) -> str:
    """What the charts shows, in sentences, wins and losses of ours alike."""
    sentences = []
    for panel in (panel for row in result.chart.panels for panel in row):
        said = [*_standing(result, panel), *_each(result, panel), *_ratios(result, panel)]
        if said:
            sentences.append(f"{panel.title[0].upper()}{panel.title[1:]}: {'; '.join(said)}.")
    return "\n".join([*sentences, *_failed(result)])


def _standing(result, panel):
    """For each level how the fastest of ours stands to the fastest other, and which of ours are slower than that."""
    won, level_with, lost, alone, short, slower, named = {}, {}, {}, [], {}, {}, {}
    for level in panel.levels:
        mine, others, apart = _fastest(result, panel, level)
        if mine and apart:
            named.setdefault(apart[0]["method"], []).append((level, mine[0]["seconds"] / apart[0]["seconds"]))
        if mine and not others:
            alone.append(level)
        elif others and not mine:
            short.setdefault(others[0]["method"], []).append(level)
        elif mine:
            ratio, name = others[0]["seconds"] / mine[0]["seconds"], others[0]["method"]
            if max(ratio, 1 / ratio) < LEVEL:
                level_with.setdefault(name, []).append(level)
            else:
                (won if ratio > 1 else lost).setdefault(name, []).append((level, max(ratio, 1 / ratio)))
            behind = {row["method"]: row["seconds"] / others[0]["seconds"] for row in mine[1:]}
            slower = {name: (others[0]["method"], ratio) for name, ratio in behind.items() if ratio > LEVEL}
    ahead = [f"{_ratios_at(found)} as fast as {name}" for name, found in won.items()]
    ahead += [f"level with {name} (to {_levels(found)})" for name, found in level_with.items()]
    parts = ["fivebar is " + ", ".join(ahead)] if ahead else []
    if lost:
        parts.append("fivebar loses: " + ", ".join(f"{n} is {_ratios_at(found)} as fast" for n, found in lost.items()))
    parts += [f"only fivebar gets to {_levels(alone)}"] if alone else []
    parts += [f"fivebar does not get to {_levels(found)}, {name} does" for name, found in short.items()]
    if slower:
        listed = ", ".join(f"{name} ({_number(ratio)} ×)" for name, (_, ratio) in slower.items())
        parts.append(f"slower than {next(iter(slower.values()))[0]} are {listed}")
    parts += [f"apart from these, {name} is {_ratios_at(found)} as fast as fivebar" for name, found in named.items()]
    return parts


def _fastest(result, panel, level):
    """Of each method the fastest row with an error of at most `level`, by time: ours, the others, those apart."""
    best = {}
    for row in counted(result, panel):
        known = best.get(row["method"])
        if row[panel.y] <= level and (known is None or row["seconds"] < known["seconds"]):
            best[row["method"]] = row
    families = {method.name: method.family for method in result.chart.methods}
    ours, others, apart = [], [], []
    for row in sorted(best.values(), key=lambda row: row["seconds"]):
        family = families[row["method"]]
        (ours if family == OURS else apart if family in result.chart.apart else others).append(row)
    return ours, others, apart


def _each(result, panel):
    """For a panel that asks for it, the time of every method over that of the fastest of ours, level by level."""
    if not panel.each:
        return []
    columns = {}
    for level in panel.levels:
        mine, *others = _fastest(result, panel, level)
        for row in (row for part in others for row in part if mine):
            columns.setdefault(row["method"], {})[level] = _number(row["seconds"] / mine[0]["seconds"])
    listed = [f"{name} {', '.join(found.get(level, '-') for level in panel.levels)}" for name, found in columns.items()]
    return [f"times over the fastest of fivebar's to {_levels(panel.levels)}: {'; '.join(listed)}"] if listed else []


def _number(ratio):
    """Two digits, without an exponent."""
    return f"{float(f'{ratio:.2g}'):g}"


def _levels(levels):
    return ", ".join(f"{level:.0e}".replace("e-0", "e-") for level in levels)


def _ratios_at(found):
    return f"{', '.join(_number(ratio) for _, ratio in found)} × (to {_levels([level for level, _ in found])})"


def _ratios(result, panel):
    """Where the abscissa is neither time nor knob: the other methods' errors over ours, at the same abscissa."""
    if panel.x in ("seconds", "knob"):
        return []
    mine = {}
    families = {method.name: method.family for method in result.chart.methods}
    for row in counted(result, panel):
        if families[row["method"]] == OURS:
            mine[row["knob"]] = row[panel.y]
    ratios = {
        name: np.median([r[panel.y] / mine[r["knob"]] for r in counted(result, panel, name) if r["knob"] in mine])
        for name, family in families.items()
        if family != OURS and any(r["knob"] in mine for r in counted(result, panel, name))
    }
    if not ratios:
        return []
    return ["errors over fivebar's, median: " + ", ".join(f"{name} {ratio:.2g}" for name, ratio in ratios.items())]


def _failed(result):
    """Which methods failed how often on which problem, ours first."""
    sentences = []
    for problem, words in result.chart.problems.items():
        panel = next(panel for row in result.chart.panels for panel in row if panel.problem == problem)
        found = {
            name: failed for name, failed in failures(result, panel).items() if failed[0][0]["status"] != "left out"
        }
        totals = Counter(row["method"] for row in result.rows if row["problem"] == problem)
        families = {method.name: method.family for method in result.chart.methods}
        for ours in (True, False):
            own = [f"{n} {len(f)} of {totals[n]}" for n, f in found.items() if (families[n] == OURS) == ours]
            if own:
                sentences.append(f"Failed on “{words}”, {'of ours' if ours else 'of the others'}: {', '.join(own)}.")
    return sentences
