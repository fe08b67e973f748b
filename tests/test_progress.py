"""Progress bars are for terminals."""

import io
import os
import sys
from pathlib import Path

import pytest

import fivebar
from fivebar.base.progress import progress
from fivebar.base.workers import WorkerPool


class Stream(io.StringIO):
    terminal = False

    def isatty(self):
        return self.terminal


@pytest.mark.parametrize("terminal", [False, True])
def test_a_bar_only_on_a_terminal(terminal, monkeypatch):
    stream = Stream()
    stream.terminal = terminal
    monkeypatch.setattr(sys, "stderr", stream)
    assert list(progress(range(300), unit=" steps", mininterval=0)) == list(range(300))
    with progress(total=2) as bar:
        bar.set_description("name")
        bar.set_postfix_str("all well")
        bar.update(2)
    assert (
        ("300/300" in stream.getvalue() and "all well" in stream.getvalue())
        if terminal
        else not stream.getvalue()
    )


def test_a_bar_on_a_terminal_without_a_size(monkeypatch):
    ours, theirs = os.openpty()  # of 0 x 0, as are those of `script` without one around it
    with open(theirs, "w", encoding="utf-8") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        list(progress(range(3), unit=" steps", mininterval=0))
        assert os.get_terminal_size(theirs) == (0, 0)
        written = b""
        while not written.endswith(b"\n"):
            written += os.read(ours, 10_000)
    os.close(ours)
    assert b"0/3" in written and b"3/3" in written


def written_on_a_terminal():
    sys.stderr = Stream()
    sys.stderr.terminal = True
    list(progress(range(3), mininterval=0))
    return sys.stderr.getvalue()


def test_workers_write_no_bars_over_one_another(monkeypatch):
    monkeypatch.setattr(sys, "stderr", sys.stderr)
    assert "3/3" in written_on_a_terminal()
    with WorkerPool(1) as pool:
        assert pool.submit(written_on_a_terminal).result(timeout=60) == ""


def test_every_bar_is_made_here():
    package = Path(fivebar.__file__).parent
    users = [
        path.name for path in package.rglob("*.py") if "tqdm" in path.read_text(encoding="utf-8")
    ]
    assert users == ["progress.py"]


def test_a_simulation_has_a_bar_after_two_seconds(monkeypatch):
    asked = []

    def bar(periods, **options):
        asked.append((len(periods), options["delay"]))
        return periods

    monkeypatch.setattr("fivebar.simulation.simulate.progress", bar)
    robot, line = fivebar.FiveBar(), fivebar.line((0.09, 0.068), (0.085, 0.072), 0.2)
    fivebar.simulate(robot, fivebar.ComputedTorque(robot, 100.0, 20.0), line, control_period=0.01)
    assert asked == [(20, 2)]


def test_designs_and_generations_have_bars(monkeypatch):
    asked = []

    def bar(designs=None, **options):
        asked.append((len(designs) if designs else options["total"], options.get("delay", 0)))
        return progress(designs, **options)

    for module in ("figures", "optimum"):
        monkeypatch.setattr(f"fivebar.optimal_design.{module}.progress", bar)
    lengths = [0.09, 0.1, 0.11]
    fivebar.sweep("inscribed_circle", {"l1": lengths, "l2": lengths}, workers=1)
    assert asked == [(3, 2)]
    bounds = {"l1": (0.1, 0.2)}
    fivebar.design("bars", bounds, effort=0.05)
    fivebar.design(["bars", "workspace_area"], bounds, points=2, effort=0.05)
    assert asked[1:] == [(15, 0), (10, 0)]
