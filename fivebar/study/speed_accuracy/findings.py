"""What the measurements say: orders of convergence, who is fastest to an error, who fails."""

from __future__ import annotations

import math
import re
from collections import Counter, defaultdict
from collections.abc import Sequence

import numpy as np

from .chart import OURS, Panel
from .store import Result

Table = tuple[str, list[str], list[list[str]]]  # title, head, rows
ABOVE_ROUNDING = 10.0


def observed_order(steps: Sequence[float], errors: Sequence[float], rounding: float) -> float:
    """Return the slope of log error over log step between the two smallest steps clear of rounding.

    Rounding is the given one, or the smallest error where smaller steps have larger ones. nan where
    there are not two such steps.
    """
    order = np.argsort(steps)[::-1]
    steps = np.array(steps)[order]
    errors = np.array(errors)[order]
    least = int(np.argmin(errors))
    floor = max(rounding, errors[least]) if least < len(errors) - 1 else rounding
    clear = np.flatnonzero(errors[: least + 1] > ABOVE_ROUNDING * floor)
    if len(clear) < 2:
        return math.nan
    a, b = clear[-2:]
    return float(np.log(errors[a] / errors[b]) / np.log(steps[a] / steps[b]))


def orders(result: Result, panel: Panel) -> dict[str, float]:
    """Return {method: observed order} of those that have one, by the errors of a panel."""
    measured = {}
    for method in result.chart.methods:
        points = counted(result, panel, method.name)
        if method.order and points:
            steps = [result.chart.step(row["knob"]) for row in points]
            errors = [row[panel.y] for row in points]
            measured[method.name] = observed_order(steps, errors, panel.rounding)
    return {name: order for name, order in measured.items() if not math.isnan(order)}


def counted(result: Result, panel: Panel, method: str | None = None) -> list[dict]:
    """Return the rows that are points of a panel."""
    rows = result.of(panel.problem, method)
    return [row for row in rows if row.get(panel.y, math.inf) <= panel.ceiling]


def failures(result: Result, panel: Panel) -> dict[str, list[tuple[dict, str]]]:
    """Return {method: [(row, word), ...]} of what failed, was left out or is above the ceiling."""
    failed = defaultdict(list)
    for row in result.rows:
        word = row["word"]
        if row["status"] == "left out":
            word = f"left out: {word}"
        if row["status"] == "ok" and row.get(panel.y, 0.0) > panel.ceiling:
            word = f"error above {panel.ceiling:g}"
        if row["problem"] == panel.problem and word:
            failed[row["method"]].append((row, word))
    return dict(failed)


def words_of(failed: list[tuple[dict, str]]) -> str:
    """Return the words of the failures of one method, with how often each came; shares left out."""
    counts = Counter(re.sub(r" in \d+%( of the steps)?", "", word) for _, word in failed)
    return ", ".join(f"{word} ({n} times)" if n > 1 else word for word, n in counts.items())


def fastest(result: Result, panel: Panel, level: float) -> dict[str, float]:
    """Return {method: shortest time in s to an error of at most `level`}."""
    times: dict[str, float] = {}
    for row in counted(result, panel):
        if row[panel.y] <= level:
            name = row["method"]
            times[name] = min(row["seconds"], times.get(name, math.inf))
    return times


def caption(result: Result) -> str:
    """Return in a sentence who is fastest to the errors that the panels ask for."""
    families = {method.name: method.family for method in result.chart.methods}
    ratios = defaultdict(list)
    total = 0
    for panel in result.chart.all_panels:
        for level in panel.levels:
            times = fastest(result, panel, level)
            ours = min((times[n] for n in times if families[n] == OURS), default=math.inf)
            compared = [n for n in times if families[n] not in result.chart.excluded]
            if compared:
                best = min(compared, key=lambda name: times[name])
                name = OURS if families[best] == OURS else best
                ratios[name].append(ours / times[best])
                total += 1
    if not total:
        return "No error levels to compare."
    levels = f"{total} error level{'s' * (total > 1)}"
    notes = [f"Fastest to reach {levels}: {OURS} {len(ratios.pop(OURS, []))}"]
    for name, found in ratios.items():
        spread = " to ".join(dict.fromkeys(f"{ratio:.2g}" for ratio in (min(found), max(found))))
        words = f"{spread} times as fast as {OURS}".replace(
            "inf times as fast as", "not reached by"
        )
        notes.append(f"{name} {len(found)} ({words})")
    return f"{'; '.join(notes)}."


def tables(result: Result) -> list[Table]:
    """Return a table for each panel that compares: times to each error, and how methods failed."""
    made = []
    for panel in result.chart.all_panels:
        columns = {
            f"time to {level:g} (s)": fastest(result, panel, level) for level in panel.levels
        }
        failed = failures(result, panel)
        rows = []
        for method in result.chart.methods:
            values = [column.get(method.name) for column in columns.values()]
            word = words_of(failed.get(method.name, []))
            if word or any(values):
                cells = ["-" if value is None else f"{value:.2g}" for value in values]
                rows.append([method.name, *cells, word])
        if columns:
            made.append((panel.title, ["method", *columns, "failed"], rows))
    return made


def summary(result: Result) -> tuple[str, list[Table]]:
    """Return caption and tables of a chart."""
    own = result.chart.summary
    return own(result) if own else (caption(result), tables(result))
