"""The charts of speed against accuracy: their runner, their files, their pages and the command."""

import json
import os
import re
import signal
import tempfile
import time
from base64 import b64encode
from dataclasses import replace
from html import escape, unescape
from types import SimpleNamespace

import numpy as np
import pytest

from fivebar.base.workers import WorkersDied
from fivebar.cli import main
from fivebar.study.speed_accuracy import catalogue, machine, making, runner
from fivebar.study.speed_accuracy.chart import OURS
from fivebar.study.speed_accuracy.findings import caption, failures, tables, words_of
from fivebar.study.speed_accuracy.page import write_page
from fivebar.study.speed_accuracy.picture import draw, method_styles, panels
from fivebar.study.speed_accuracy.runner import Worker, run
from fivebar.study.speed_accuracy.store import Partial, Result
from fivebar.visualization.style import INK
from tests.helpers import toy_chart

TOY = "tests.helpers.toy_chart"


def measured(folder):
    return run(TOY, folder, quick=True, progress=lambda: None)[0]


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setitem(catalogue.CHARTS, "toy", (TOY, "its failures"))


@pytest.fixture(scope="module")
def toy_result(tmp_path_factory):
    return measured(tmp_path_factory.mktemp("toy"))


@pytest.mark.deep
def test_every_failure_is_a_row_with_a_word(toy_result):
    words = {row["method"]: (row["status"], row["word"]) for row in toy_result.rows}
    assert words == {
        "<ours> & mine": ("ok", ""),
        "cruder": ("ok", ""),
        "astray": ("ok", ""),
        "nan": ("failed", "nan"),
        "singular": ("failed", "refused: singular"),
        "wrong": ("failed", "wrong branch in 23%"),
        "hangs": ("failed", "timeout, 1.5 s"),
        "crashes": ("failed", "crashed"),
        "after the crash": ("ok", ""),
        "needs more": ("left out", "no C compiler (cc, gcc, clang)"),
    }
    assert len(toy_result.rows) == 2 * 6 + 4
    assert {"cpu", "numpy", "compiler", "quick"} <= set(toy_result.about)
    assert all(row["seconds"] > 0 for row in toy_result.rows if row["status"] != "left out")


def test_failures_are_on_the_chart(toy_result):
    panel = toy_result.chart.panels[0][0]
    panels_axes = panels(toy_result).axes
    strip = panels_axes[1]
    notes = [text.get_text() for text in strip.texts]
    assert len(notes) == len(failures(toy_result, panel)) == 7
    for words in (
        "astray: error above 1 (2 times)",
        "hangs: timeout",
        "needs more: left out: no C",
    ):
        assert any(words in text for text in notes)
    assert sum(len(line.get_xdata()) for line in strip.lines) == 10
    for text in strip.texts:  # at the left of the strip, whatever its times are
        assert text.get_position()[0] < 0.05
        assert text.get_transform() == strip.get_yaxis_transform()
    # A failure stands above the points at its time.
    assert strip.get_shared_x_axes().joined(strip, panels_axes[0])


def test_each_attempt_is_a_point_on_the_chart():
    """By its time or its knob; a method of one knob is a line over all of these."""
    known = toy_chart.chart()
    (timed,) = known.panels[0]
    by_knob = replace(timed, title="by knob", x="knob", xlabel="knob", guide=(0.25, "a guide"))
    chart = replace(known, panels=((timed, by_knob),))
    rows = []
    for method in ("<ours> & mine", "cruder", "after the crash"):
        for knob in chart.method(method).knobs:
            seconds = {
                "seconds": 1e-3 * knob,
                "seconds_low": 8e-4 * knob,
                "seconds_high": 2e-3 * knob,
            }
            own = {"problem": "p", "method": method, "knob": knob, "status": "ok", "word": ""}
            rows.append(own | seconds | {"error": 0.1 / knob})
    figure = draw(Result(chart, {}, rows))
    left, right = (axes for axes in figure.axes if axes.get_xlabel())
    styles = method_styles(chart)
    looks = {(style["color"], str(style["ls"])) for style in styles.values()}
    assert len(looks) == len(styles)
    for method in chart.methods:  # ours in ink, filled
        style = styles[method.name]
        assert (style["color"] == INK) == (style["mfc"] == INK) == (method.family == OURS)
    for axes, x in ((left, "seconds"), (right, "knob")):
        for method, style in styles.items():
            own = [(row[x], row["error"]) for row in rows if row["method"] == method]
            if x == "knob" and len(own) == 1:
                (line,) = (
                    line
                    for line in axes.lines
                    if line.get_linestyle() == "--" and len(line.get_xdata()) == 2
                )
                assert line.get_xydata().tolist() == [[1, 0.1], [8, 0.1]]
                assert line.get_color() == style["color"] and line.get_linewidth() == style["lw"]
            elif own:
                drawn = [line for line in axes.lines if line.get_marker() == style["marker"]]
                assert [line.get_xydata().tolist() for line in drawn] == [list(map(list, own))]
    bars = [bar.tolist() for each in left.collections for bar in each.get_segments()]
    assert [[8e-4, 0.1], [2e-3, 0.1]] in [np.round(bar, 9).tolist() for bar in bars]
    assert len(bars) == len(rows) and not right.collections
    guide = next(line for line in right.lines if line.get_linestyle() == ":")
    assert guide.get_ydata().tolist() == (0.25 * guide.get_xdata()).tolist()
    assert figure.get_suptitle() == chart.title
    (legend,) = figure.legends
    assert len(legend.get_texts()) == len(chart.methods)
    # Of errors by the step to the first power, whose order is measured.
    assert legend.get_texts()[1].get_text() == "cruder, measured order 1.00"


def test_a_chart_is_made_into_a_folder(toy_result, tmp_path, monkeypatch):
    """What was measured is kept until all of it is written."""
    done = []
    partial = SimpleNamespace(done=lambda: done.append(sorted(p.name for p in tmp_path.iterdir())))
    runs = []

    def measured_before(module, folder, quick, progress):
        runs.append((module, folder, quick))
        return toy_result, partial

    monkeypatch.setattr(runner, "run", measured_before)
    monkeypatch.setattr("fivebar.base.tables.DPI", 50)
    results = making.make(["toy"], tmp_path, True, {"toy": (TOY, "about it")})
    assert runs == [(TOY, tmp_path, True)] and results == {"toy": toy_result}
    (files,) = done
    assert {"index.html", "toy.csv", "toy.png", "toy.svg"} <= set(files)


@pytest.mark.parametrize(
    "method, word",
    [
        ("cruder", None),
        ("nan", "nan"),
        ("singular", "refused: singular"),
        ("wrong", "wrong branch in 23%"),
    ],
)
def test_an_attempt_is_measured_or_named(method, word):
    row = runner.measure(toy_chart.chart(), "p", method, 2, 1e-4)
    assert row["seconds"] > 0 and row.get("word") == word
    if word is None:
        assert row["error"] == 0.05 and row["seconds_low"] <= row["seconds"] <= row["seconds_high"]


def test_libraries_are_told_with_their_versions():
    told = machine.describe()
    assert told["numpy"] == np.__version__ and told["cores"] == os.cpu_count()
    assert told["python"].count(".") == 2


def test_a_machine_without_linuxs_own_words_has_a_name(monkeypatch, tmp_path):
    monkeypatch.setattr(machine, "Path", lambda _: tmp_path / "none")
    monkeypatch.setattr(machine.platform, "processor", lambda: "")
    assert machine._processor() == machine.platform.machine()
    (tmp_path / "none").write_text("flags: fpu\nmodel name\t: A 1\nmodel name\t: B 2\n", "utf-8")
    assert machine._processor() == "A 1"


def test_the_page_has_what_is_found(toy_result, tmp_path):
    """Names are escaped, the picture is in it, and its links lead to the files beside it."""
    (tmp_path / "toy.png").write_bytes(b"the picture")
    write_page(tmp_path / "index.html", {"toy": toy_result})
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "A &lt;toy&gt; &amp; its failures" in page and "<toy>" not in page
    assert escape(caption(toy_result)) in page and b64encode(b"the picture").decode() in page
    for _, head, rows in tables(toy_result):
        assert all(escape(cell) in page for row in (head, *rows) for cell in row)
    links = re.findall(r'href="([^"]*)"', page)
    assert {"#toy", "toy.csv", "toy.svg"} <= set(links) and 'id="toy"' in page
    assert all(f"{key} {value}" in unescape(page) for key, value in toy_result.about.items())


def test_caption_is_made_of_the_measurements(toy_result):
    def timed(seconds):
        rows = [row | {"seconds": seconds.get(row["method"], 9.0)} for row in toy_result.rows]
        return caption(Result(toy_result.chart, {}, rows))

    ahead = timed({"<ours> & mine": 1e-3, "after the crash": 4e-3})
    assert ahead == "Fastest to reach 2 error levels: fivebar 2."
    behind = timed({"<ours> & mine": 1e-3, "after the crash": 5e-4})
    assert (
        behind
        == "Fastest to reach 2 error levels: fivebar 1; after the crash 1 (2 times as fast as fivebar)."
    )
    failed = [(None, f"wrong in {n}%") for n in (7, 30, 12)] + [(None, "nan")]
    assert words_of(failed) == "wrong (3 times), nan"
    failed = [(None, f"QP fails in {n}% of the steps") for n in (7, 30)]
    assert words_of(failed) == "QP fails (2 times)"


def test_the_table_has_each_method_and_its_failures(toy_result):
    ((title, head, rows),) = tables(toy_result)
    cells = {name: dict(zip(head[1:], values)) for name, *values in rows}
    # "cruder" never gets to 1e-2, and does not fail.
    names = [method.name for method in toy_result.chart.methods if method.name != "cruder"]
    assert title == "one panel" and list(cells) == names
    none = dict.fromkeys(("time to 0.01 (s)", "time to 0.0001 (s)", "time to 1e-09 (s)"), "-")
    assert cells["astray"] == none | {"failed": "error above 1 (2 times)"}
    assert float(cells["after the crash"]["time to 0.01 (s)"]) > 0
    assert cells["after the crash"]["time to 0.0001 (s)"] == "-"
    assert cells["needs more"]["failed"] == "left out: no C compiler (cc, gcc, clang)"


def test_an_error_of_ours_ends_the_run_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with Worker(TOY, 20.0, 0.0) as worker, pytest.raises(StopIteration):
        assert worker.measure("p", "singular", 1)["word"] == "refused: singular"
        assert [len(list(room.iterdir())) for room in tmp_path.iterdir()] == [1]
        # As where memory is short: not what the next attempt did.
        os.kill(worker.pool.submit(os.getpid).result(), signal.SIGKILL)
        time.sleep(0.5)
        assert worker.measure("p", "cruder", 1)["error"] == 0.1
        worker.measure("p", "no such method", 1)
    assert not list(tmp_path.iterdir())


def test_a_process_that_ends_at_its_start_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with Worker("no_such_chart", 20.0, 0.0) as worker:
        for _ in range(2):
            with pytest.raises(
                WorkersDied, match="ended at its start, .* attempt of no_such_chart"
            ):
                worker.measure("p", "cruder", 1)
            assert not list(tmp_path.iterdir())
        worker.module = TOY
        assert worker.measure("p", "cruder", 1)["error"] == 0.1


def test_an_interrupted_run_goes_on(tmp_path, monkeypatch):
    calls = []

    def interrupted(self, problem, method, knob):
        calls.append((method, knob))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return {"seconds": 1e-3, "error": 0.5}

    monkeypatch.setattr(Worker, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        measured(tmp_path)
    path = tmp_path / "toy.partial.jsonl"
    assert len(path.read_text("utf-8").splitlines()) == 1 + 3
    path.write_text(
        path.read_text("utf-8") + '{"problem": "p", "meth', encoding="utf-8"
    )  # cut off in the middle
    assert len(measured(tmp_path).rows) == 16
    assert calls.count(("<ours> & mine", 1)) == 1 and calls.count(calls[3]) == 2
    assert len(calls) == 4 + 12  # 15 that can run, 3 of them known


@pytest.mark.deep
def test_an_interrupted_command_keeps_the_charts_that_were_done(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("fivebar.cli.chart.CHARTS", {"toy": (TOY, ""), "other": (TOY, "")})
    monkeypatch.setattr(
        making.make, "__defaults__", (False, {"toy": (TOY, ""), "other": (TOY, "")})
    )
    columns = "seconds", "seconds_low", "seconds_high", "error"
    monkeypatch.setattr(Worker, "measure", lambda *_: dict.fromkeys(columns, 0.5))
    original, runs = runner.run, []

    def run_one(*arguments):
        runs.append(arguments)
        if len(runs) == 2:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(runner, "run", run_one)
    assert (
        main(["chart", "all", "--quick", "--out", str(tmp_path)]) == 130
    )  # as a shell says Ctrl-C
    assert "the same command goes on there" in capsys.readouterr().err
    assert (tmp_path / "toy.csv").exists() and (tmp_path / "toy.partial.jsonl").exists()
    monkeypatch.setattr(Worker, "measure", lambda *_: pytest.fail("measured again"))
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 0
    assert not (tmp_path / "toy.partial.jsonl").exists()


def test_another_kind_of_run_is_begun_anew(tmp_path):
    path = tmp_path / "x.partial.jsonl"
    row = {"problem": "p", "method": "m", "knob": 0.1}
    Partial(path, {"quick": True}).add(row)
    again = Partial(path, {"quick": True})
    assert again.rows == [row] and again.has("p", "m", 0.1)
    assert (
        Partial(path, {"quick": False}).rows == []
        and len(path.read_text("utf-8").splitlines()) == 1
    )


@pytest.mark.deep
def test_command(toy, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(toy_chart, "METHODS", toy_chart.METHODS[:4])
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 0
    names = ["toy.csv", "toy.png", "toy.svg", "index.html"]
    notes = capsys.readouterr()
    assert notes.out.split() == [str(tmp_path / name) for name in names] and not notes.err
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "A &lt;toy&gt; &amp; its failures" in page and "<toy>" not in page
    assert "&lt;ours&gt; &amp; mine" in page and "http" not in page.replace("http-equiv", "")
    assert not re.search(r'(src|href)="(?!data:|#|toy\.)', page)
    first, *lines = (tmp_path / "toy.csv").read_text("utf-8").splitlines()
    about = json.loads(first.split(": ", 1)[1])
    assert about["quick"] is True and about["cpu"] and len(lines) == 1 + 8


def test_unknown_chart(tmp_path, capsys):
    assert main(["chart", "geometrie", "--out", str(tmp_path / "none")]) == 2
    notes = capsys.readouterr().err
    assert all(name in notes for name in (*catalogue.CHARTS, "all", "geometrie"))
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    "call, together, count", [(2.0**-20, 105, 99), (0.00048828125, 1, 20), (0.5, 1, 3)]
)
def test_times_are_those_of_repeats_within_a_budget(call, together, count, monkeypatch):
    """A clock that only calls move: short calls are timed `together`, `count` samples of at most 0.01 s, at least 3."""
    now = [0.0]
    original = runner.timeit.Timer
    clock = SimpleNamespace(Timer=lambda work: original(work, timer=lambda: now[0]))
    monkeypatch.setattr(runner, "timeit", clock)

    def work():
        now[0] += call

    samples = runner.times_of(work, 1e-6, 0.01)
    assert samples.tolist() == [call] * count and now[0] == call * (1 + together * count)
    before = now[0]
    assert runner.times_of(work, 9.0, 1.0).tolist() == [9.0] and now[0] == before
