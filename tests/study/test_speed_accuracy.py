"""The charts of speed against accuracy: their runner, their files, their pages and the command."""

import io
import json
import re
import tempfile
from types import SimpleNamespace

import pytest
from PIL import Image

from fivebar.cli import main
from fivebar.study.speed_accuracy import chart as declared
from fivebar.study.speed_accuracy import machine, making, runner
from fivebar.study.speed_accuracy.findings import caption, failures, table, words_of
from fivebar.study.speed_accuracy.picture import figure
from fivebar.study.speed_accuracy.runner import Worker, run
from fivebar.study.speed_accuracy.store import Partial, Result, from_csv
from tests.helpers import toy_chart


def test_a_picture_is_redrawn_from_its_csv(toy_result, toy, tmp_path):
    drawn = making.draw(toy_result, tmp_path)
    toy_result.to_csv(tmp_path / "toy.csv")
    assert making.draw(making.redraw(tmp_path / "toy.csv", "toy"), tmp_path) == drawn


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setitem(declared.MODULES, "toy", "tests.helpers.toy_chart")
    monkeypatch.setitem(machine.NEEDED, "C compiler", lambda: "no C compiler (cc, gcc, clang)")


@pytest.fixture(scope="module")
def toy_result(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(declared.MODULES, "toy", "tests.helpers.toy_chart")
        patch.setitem(machine.NEEDED, "C compiler", lambda: "no C compiler (cc, gcc, clang)")
        return run("toy", tmp_path_factory.mktemp("toy"), quick=True)[0]


def test_every_failure_is_a_row_with_a_word(toy_result):
    words = {row["method"]: (row["status"], row["word"]) for row in toy_result.rows}
    assert words == {
        "<ours> & mine": ("ok", ""), "cruder": ("ok", ""), "astray": ("ok", ""), "nan": ("failed", "nan"),
        "singular": ("failed", "refused: singular"), "wrong": ("failed", "wrong branch in 23%"),
        "hangs": ("failed", "timeout, 1.5 s"), "crashes": ("failed", "crashed"), "after the crash": ("ok", ""),
        "needs more": ("left out", "no C compiler (cc, gcc, clang)"),
    }  # fmt: skip
    assert len(toy_result.rows) == 2 * 6 + 4 and {"cpu", "numpy", "compiler", "quick"} <= set(
        toy_result.about
    )
    assert all(row["seconds"] > 0 for row in toy_result.rows if row["status"] != "left out")


def test_failures_are_on_the_chart(toy_result):
    made = figure(toy_result)
    panel = toy_result.chart.panels[0][0]
    strip = made.axes[1]
    notes = [text.get_text() for text in strip.texts]
    assert len(notes) == len(failures(toy_result, panel)) == 7
    for words in (
        "astray: error above 1 (2 times)",
        "hangs: timeout, 1.5 s",
        "needs more: left out: no C compiler (cc",
    ):
        assert any(words in text for text in notes)
    assert sum(len(line.get_xdata()) for line in strip.lines) == 10


def test_caption_is_made_of_the_measurements(toy_result):
    def timed(seconds):
        rows = [
            row | {"seconds": seconds[row["method"]]} if row["method"] in seconds else row
            for row in toy_result.rows
        ]
        return caption(Result(toy_result.chart, {}, rows))

    ahead = timed({"<ours> & mine": 1e-3, "cruder": 1.0, "after the crash": 4e-3})
    assert (
        ahead
        == "Of 2 errors asked for, fivebar gets to all first, 4 times as fast as the next, to 1 of them alone."
    )
    behind = timed({"<ours> & mine": 1e-3, "cruder": 1.0, "after the crash": 5e-4})
    assert (
        "gets to 1 first" in behind
        and "loses to after the crash once, which is 2 times as fast." in behind
    )
    assert (
        words_of([(None, f"wrong in {n}%") for n in (7, 30, 12)] + [(None, "nan")])
        == "wrong in 7-30% (3 times), nan"
    )


def test_the_table_has_each_method_and_its_failures(toy_result):
    (title, head, rows), cells = table(toy_result)[0], {}
    for name, *found in rows:
        cells[name] = dict(zip(head[1:], found))
    names = [
        method.name for method in toy_result.chart.methods if method.name != "cruder"
    ]  # never at 1e-2, nor failed
    assert title == "one panel" and list(cells) == names
    failed = "2 of 2: error above 1 (2 times)"
    assert cells["astray"] == {
        "s, to 1e-2": "-",
        "s, to 1e-4": "-",
        "s, to 1e-9": "-",
        "failed": failed,
    }
    assert (
        float(cells["after the crash"]["s, to 1e-2"]) > 0
        and cells["after the crash"]["s, to 1e-4"] == "-"
    )
    assert cells["needs more"]["failed"] == "left out: no C compiler (cc, gcc, clang)"


def test_the_page_has_the_pictures_words_as_text(toy_result, tmp_path, monkeypatch):
    """Its picture is the PNG without title and verdict, whose pixels are none of a panel's."""
    monkeypatch.setattr(making, "DPI", 80)
    bare = Image.open(io.BytesIO(making.draw(toy_result, tmp_path))).convert("L")
    whole = Image.open(tmp_path / "toy.png").convert("L")
    lines = [
        k
        for k in range(whole.height)
        if whole.crop((0, k, whole.width, k + bare.height)).tobytes() == bare.tobytes()
    ]
    assert len(lines) == 1 and 0.3 * making.DPI < lines[0] < 0.5 * making.DPI
    assert min(whole.crop((0, 0, whole.width, lines[0])).tobytes()) < 100 > min(bare.tobytes())
    assert whole.height - lines[0] - bare.height > 0.1 * making.DPI


def test_an_error_of_ours_ends_the_run_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with Worker("tests.helpers.toy_chart", 20.0, 0.0) as worker, pytest.raises(StopIteration):
        assert worker.measure("p", "singular", 1)["word"] == "refused: singular"
        assert [len(list(room.iterdir())) for room in tmp_path.iterdir()] == [1]
        worker.process.kill()  # as where memory is short: not what the next attempt did
        worker.process.join(10)
        assert worker.measure("p", "cruder", 1)["error"] == 0.1
        worker.measure("p", "no such method", 1)
    assert not list(tmp_path.iterdir())


def test_an_interrupted_run_goes_on(toy, tmp_path, monkeypatch):
    calls = []

    def interrupted(self, problem, method, knob):
        calls.append((method, knob))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return {"seconds": 1e-3, "error": 0.5}

    monkeypatch.setattr(Worker, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run("toy", tmp_path, quick=True)
    path = tmp_path / "toy.partial.jsonl"
    assert len(path.read_text().splitlines()) == 1 + 3
    path.write_text(path.read_text() + '{"problem": "p", "meth')  # cut off in the middle
    result, _ = run("toy", tmp_path, quick=True)
    assert (
        len(result.rows) == 16
        and calls.count(("<ours> & mine", 1)) == 1
        and calls.count(calls[3]) == 2
    )
    assert len(calls) == 4 + 12  # 15 that can run, 3 of them known


def test_an_interrupted_command_keeps_the_charts_that_were_done(toy, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(declared.MODULES, "other", "tests.helpers.toy_chart")
    monkeypatch.setattr(
        Worker,
        "measure",
        lambda *_: dict.fromkeys(("seconds", "seconds_low", "seconds_high", "error"), 0.5),
    )
    original, seen = runner.run, []

    def run_one(name, *rest):
        seen.append(name)
        if seen == ["toy", "other"]:
            raise KeyboardInterrupt
        return original(name, *rest)

    monkeypatch.setattr(runner, "run", run_one)
    monkeypatch.setattr("fivebar.study.speed_accuracy.chart_names", lambda peers: ("toy", "other"))
    assert main(["chart", "all", "--quick", "--out", str(tmp_path)]) == 1
    assert "the same command goes on there" in capsys.readouterr().err
    assert (tmp_path / "toy.csv").exists() and (tmp_path / "toy.partial.jsonl").exists()
    monkeypatch.setattr(Worker, "measure", lambda *_: pytest.fail("measured again"))
    monkeypatch.setattr("fivebar.study.speed_accuracy.chart_names", lambda peers: ("toy",))
    assert main(["chart", "all", "--quick", "--out", str(tmp_path)]) == 0
    assert not (tmp_path / "toy.partial.jsonl").exists()


def test_another_kind_of_run_is_begun_anew(tmp_path):
    path = tmp_path / "x.partial.jsonl"
    first = Partial(path, {"quick": True})
    row = {"problem": "p", "method": "m", "knob": 0.1}
    first.add(row)
    assert Partial(path, {"quick": True}).rows == [row] and Partial(path, {"quick": True}).has(
        "p", "m", 0.1
    )
    assert Partial(path, {"quick": False}).rows == [] and len(path.read_text().splitlines()) == 1


def test_command(toy, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(toy_chart, "METHODS", toy_chart.METHODS[:4])
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 0
    names = ["toy.csv", "toy.png", "toy.svg", "index.html"]
    notes = capsys.readouterr()
    assert notes.out.split() == [str(tmp_path / name) for name in names] and not notes.err
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert (
        "A &lt;toy&gt; &amp; its failures" in page
        and "<toy>" not in page
        and "&lt;ours&gt; &amp; mine" in page
    )
    assert not re.search(r'(src|href)="(?!data:|#|toy\.)', page) and "http" not in page.replace(
        "http-equiv", ""
    )
    about = json.loads((tmp_path / "toy.csv").read_text().splitlines()[0].split(": ", 1)[1])
    assert about["quick"] is True and about["cpu"]
    assert len(from_csv(tmp_path / "toy.csv", toy_chart.chart()).rows) == 8


def test_unknown_chart(tmp_path, capsys):
    assert main(["chart", "geometrie", "--out", str(tmp_path / "none")]) == 2
    notes = capsys.readouterr().err
    assert (
        all(name in notes for name in (*declared.MODULES, "all", "geometrie"))
        and not (tmp_path / "none").exists()
    )


def test_a_csv_that_is_none(tmp_path):
    chart, path = toy_chart.chart(), tmp_path / "x.csv"
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="line 1: not a CSV file of the chart toy"):
        from_csv(path, chart)
    path.write_text("# fivebar chart toy, SI units: {}\nproblem,method,knob\np,m,x\n")
    with pytest.raises(ValueError, match="line 3: not numbers"):
        from_csv(path, chart)
    path.write_text("# fivebar chart toy, SI units: {}\nproblem,method,knob\np,of old,1\n")
    with pytest.raises(
        ValueError, match="line 3: the chart toy has no method 'of old' on a problem 'p'"
    ):
        from_csv(path, chart)


def test_a_csv_of_another_version_is_refused_before_anything_is_measured(
    toy, tmp_path, monkeypatch, capsys
):
    (tmp_path / "geometry.csv").write_text(
        "# fivebar chart geometry, SI units: {}\nproblem,method,knob\none,old,1\n"
    )
    monkeypatch.setattr(Worker, "measure", lambda *_: pytest.fail("measured"))
    assert main(["chart", "toy", "--quick", "--out", str(tmp_path)]) == 1
    assert "geometry.csv" in capsys.readouterr().err


@pytest.mark.parametrize(
    "call, together, count", [(2.0**-20, 105, 99), (0.00048828125, 1, 20), (0.5, 1, 3)]
)
def test_times_are_those_of_repeats_within_a_budget(call, together, count, monkeypatch):
    """A clock that only calls move: short calls are timed `together`, `count` samples of at most 0.01 s, at least 3."""
    now = [0.0]
    monkeypatch.setattr(runner, "time", SimpleNamespace(perf_counter=lambda: now[0]))

    def work():
        now[0] += call

    samples = runner.times_of(work, 1e-6, 0.01)
    assert samples.tolist() == [call] * count and now[0] == call * (1 + together * count)
    before = now[0]
    assert runner.times_of(work, 9.0, 1.0).tolist() == [9.0] and now[0] == before
