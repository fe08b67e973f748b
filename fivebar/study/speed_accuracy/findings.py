"""What the measurements say: orders of convergence, who is fastest to an error, who fails. Nothing
is known before.
"""

from __future__ import annotations

import math
import re
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
    """The slope of log error over log step between the two smallest steps whose errors are clear of
    rounding; or nan.

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
            found[method.name] = observed_order(
                steps, [row[panel.y] for row in points], panel.rounding
            )
    return {name: order for name, order in found.items() if not math.isnan(order)}


def counted(result: Result, panel: Panel, method: str | None = None) -> list[dict]:
    """The rows that are points of a panel."""
    return [
        row
        for row in result.of(panel.problem, method)
        if row.get(panel.y, math.inf) <= panel.ceiling
    ]


def failures(result: Result, panel: Panel) -> dict[str, list]:
    """{method: [(row, word), ...]}: failed and left-out attempts, and those with an error above the
    panel's ceiling.
    """
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
    """The words of one method's failures, with how often each came; those that differ in a share
    only, together.
    """
    found = {}
    for _, word in failed:
        found.setdefault(re.sub(r"\d+%", "#%", word), []).append(word)
    parts = []
    for pattern, words in found.items():
        shares = sorted({int(share) for word in words for share in re.findall(r"(\d+)%", word)})
        ends = (
            f"{shares[0]}-{shares[-1]}%" if len(shares) > 1 else f"{shares[0]}%" if shares else ""
        )
        parts.append(
            pattern.replace("#%", ends) + (f" ({len(words)} times)" if len(words) > 1 else "")
        )
    return ", ".join(parts)


def caption(result: Result) -> str:
    """What the chart shows in a sentence, wins and losses of ours alike; `table` has the
    numbers.
    """
    won, even, lost, short, named, alone = [], {}, {}, {}, {}, 0
    panels = [panel for row in result.chart.panels for panel in row]
    for panel, level in [(each, level) for each in panels for level in each.levels]:
        mine, others, apart = _fastest(result, panel, level)
        if mine and apart:
            named.setdefault(apart[0]["method"], []).append(
                mine[0]["seconds"] / apart[0]["seconds"]
            )
        if mine and others:
            ratio, name = others[0]["seconds"] / mine[0]["seconds"], others[0]["method"]
            if max(ratio, 1 / ratio) < LEVEL:
                even.setdefault(name, []).append(ratio)
            elif ratio > 1:
                won.append(ratio)
            else:
                lost.setdefault(name, []).append(1 / ratio)
        elif others:
            short.setdefault(others[0]["method"], []).append(level)
        alone += bool(mine and not others)
    total = (
        len(won)
        + alone
        + sum(len(found) for part in (even, lost, short) for found in part.values())
    )
    notes = []
    if total:
        first = {0: "none", total: "all"}.get(len(won) + alone, len(won) + alone)
        first = f"of {total} errors asked for, fivebar gets to {first} first"
        first += f", {_range(won)} times as fast as the next" if won else ""
        notes.append(
            first + (f", to {'all' if alone == total else alone} of them alone" if alone else "")
        )
    notes += [f"it is level with {name} {_times(found)}" for name, found in even.items()]
    notes += [
        f"it loses to {name} {_times(found)}, which is {_range(found)} times as fast"
        for name, found in lost.items()
    ]
    notes += [
        f"it does not get to {_levels(found)}, which {name} does" for name, found in short.items()
    ]
    notes += [
        f"apart from these, {name} is {_range(found)} times as fast as fivebar"
        for name, found in named.items()
    ]
    ratios = {}
    for panel in panels:
        for name, ratio in _ratios(result, panel).items():
            ratios.setdefault(name, []).append(ratio)
    if ratios:
        listed = ", ".join(f"{name} {_range(found)}" for name, found in ratios.items())
        notes.append(f"errors over fivebar's, in the median: {listed}")
    text = "; ".join(notes)
    return f"{text[:1].upper()}{text[1:]}." if text else "Nothing is to be compared."


def table(result: Result) -> list[tuple[str, list[str], list[list[str]]]]:
    """Per panel that compares: title, head, and per method the seconds it takes to each error, and
    how it failed.
    """
    tables = []
    for panel in (panel for row in result.chart.panels for panel in row):
        ratios, failed = _ratios(result, panel), failures(result, panel)
        if not (panel.levels or ratios):
            continue
        fastest = [
            {row["method"]: row for part in _fastest(result, panel, x) for row in part}
            for x in panel.levels
        ]
        rows = []
        for name in (method.name for method in result.chart.methods):
            cells = [
                _short(f"{found[name]['seconds']:.1e}") if name in found else "-"
                for found in fastest
            ]
            cells += [_short(f"{ratios[name]:.2g}") if name in ratios else "-"] if ratios else []
            if name in failed or set(cells) != {"-"}:
                rows.append([name, *cells, _failed(result, panel, failed.get(name))])
        head = [f"s, to {_levels([level])}" for level in panel.levels] + [
            "error over fivebar's, median"
        ] * bool(ratios)
        tables.append((panel.title, ["method", *head, "failed"], rows))
    return tables


def _failed(result, panel, failed):
    """How often and how a method failed on a panel's problem."""
    if not failed:
        return ""
    if failed[0][0]["status"] == "left out":
        return words_of(failed)
    total = sum(
        (row["problem"], row["method"]) == (panel.problem, failed[0][0]["method"])
        for row in result.rows
    )
    return f"{len(failed)} of {total}: {words_of(failed)}"


def _fastest(result, panel, level):
    """Of each method the fastest row with an error of at most `level`, by time: ours, the others,
    those apart.
    """
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


def _range(ratios):
    """From the least to the largest, with two digits."""
    shown = list(
        dict.fromkeys(_short(f"{float(f'{ratio:.2g}'):g}") for ratio in (min(ratios), max(ratios)))
    )
    return " to ".join(shown)


def _times(found):
    return f"{len(found)} times" if len(found) > 1 else "once"


def _levels(levels):
    return ", ".join(_short(f"{level:.0e}") for level in levels)


def _short(number):
    return re.sub(r"e([+-])0", r"e\1", number)


def _ratios(result, panel):
    """{method: its errors over ours at the same abscissa, median}, where the abscissa is neither
    time nor knob.
    """
    if panel.x in ("seconds", "knob"):
        return {}
    mine = {}
    families = {method.name: method.family for method in result.chart.methods}
    for row in counted(result, panel):
        if families[row["method"]] == OURS:
            mine[row["knob"]] = row[panel.y]
    return {
        name: float(
            np.median(
                [
                    r[panel.y] / mine[r["knob"]]
                    for r in counted(result, panel, name)
                    if r["knob"] in mine
                ]
            )
        )
        for name, family in families.items()
        if family != OURS and any(r["knob"] in mine for r in counted(result, panel, name))
    }
