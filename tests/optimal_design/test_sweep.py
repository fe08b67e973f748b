"""Sweeps: the same bytes whatever the executor and however interrupted, refusals that say which, flat memory."""

import json
import resource
import subprocess
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.shards import begin
from tests.helpers import ROOT

D = fb.optimal_design
BOUNDS = {"l1": (0.05, 0.2), "l2": (0.05, 0.3), "d": (0.0, 0.5), "task_y": (0.05, 0.3)}
FIGURES = ["det_A", "tip_speed", "workspace_area"]
CHOICES = dict(table=(0.1, 0.06), motor=(1.0, 4.0), poses=(7, 5), chunk=50)


def swept(out=None, executor=None, count=330, **more):
    return fb.sweep(FIGURES, D.sample(BOUNDS, count), executor, out, **CHOICES | more)


def bytes_of(out):
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "out"
    swept(out, workers=1)
    return bytes_of(out)


@pytest.mark.parametrize("kind", ["own pool", "processes", "threads", "one thread"])
def test_the_bytes_are_the_same_whatever_the_executor(kind, whole, tmp_path):
    makers = {
        "processes": ProcessPoolExecutor,
        "threads": ThreadPoolExecutor,
        "one thread": ThreadPoolExecutor,
    }
    if kind == "own pool":
        swept(tmp_path / "out", workers=2)
    else:
        with makers[kind](1 if kind == "one thread" else 2) as executor:
            swept(tmp_path / "out", executor)
            assert executor.submit(int).result() == 0  # it is the caller's still
    assert bytes_of(tmp_path / "out") == whole


def test_interrupted_at_any_chunk_it_goes_on_and_computes_each_once(whole, tmp_path):
    calls: list[float] = []
    stops: list[int] = []

    def counted(robot):
        calls.append(robot.l11)
        if len(calls) in stops:
            raise KeyboardInterrupt
        return robot.l11

    for stop in (1, 120, 290):
        out, designs = tmp_path / str(stop), D.sample({"l1": (0.1, 0.2), "d": (0.05, 0.1)}, 300)
        calls.clear()
        stops.append(stop)
        with pytest.raises(KeyboardInterrupt):
            fb.sweep(counted, designs, out=out, workers=1, chunk=50)
        assert len(list(out.glob("chunk-*.npz"))) == (stop - 1) // 50
        assert "not done yet" in repr(D.Sweep.load(out))
        begun = len(calls)
        stops.clear()
        done = fb.sweep(counted, designs, out=out, workers=1, chunk=50)
        assert len(calls) - begun == 300 - (begun - 1) // 50 * 50 and done.errors == ()
        again = len(calls)
        fb.sweep(counted, designs, out=out, workers=1, chunk=50)
        assert len(calls) == again


def test_what_is_in_memory_is_what_is_on_disk(whole, tmp_path):
    here = swept()
    here.save(tmp_path / "saved")
    assert bytes_of(tmp_path / "saved") == whole
    there = D.Sweep.load(tmp_path / "saved")
    for name in (*here.names, *here.figures):
        np.testing.assert_array_equal(here[name], there[name])
    assert here.errors == there.errors and len(here.errors) > 10
    assert (
        repr(there)
        == f"<Sweep: det_A, tip_speed, workspace_area of 330 designs of l1, l2, d, task_y, {len(here.errors)} errors>"
    )
    order = here.best("tip_speed", 5)
    assert (
        here["tip_speed"][order]
        == np.sort(here["tip_speed"][~np.isnan(here["tip_speed"])])[::-1][:5]
    ).all()
    there.to_csv(tmp_path / "table.csv")
    lines = (tmp_path / "table.csv").read_text("utf-8").splitlines()
    assert lines[1] == "l1,l2,d,task_y,det_A,tip_speed,workspace_area" and len(lines) == 332
    assert [float(cell) for cell in lines[2].split(",")][:4] == list(here.design(0).values())
    k = int(order[0])
    assert here.robot_at(k) == fb.FiveBar(
        *(here.design(k)[name] for name in ("l1", "l2", "l1", "l2", "d"))
    )


def test_designs_come_in_many_ways(tmp_path):
    rows = {"l1": [0.1, 0.12, 0.14], "d": [0.1, 0.11, 0.12]}
    (tmp_path / "designs.csv").write_text(
        "l1,d\n" + "".join(f"{a},{b}\n" for a, b in zip(*rows.values())), encoding="utf-8"
    )
    np.savez(tmp_path / "designs.npz", **rows)
    robots = [fb.FiveBar(l11=a, l21=a, d=b) for a, b in zip(*rows.values())]
    tables = [dict(zip(rows, pair)) for pair in zip(*rows.values())]
    ways = [
        rows,
        tmp_path / "designs.csv",
        str(tmp_path / "designs.npz"),
        robots,
        iter(robots),
        tables,
        iter(tables),
    ]
    found = [fb.sweep("workspace_area", way, workers=1, chunk=2)["workspace_area"] for way in ways]
    assert len({tuple(values) for values in found}) == 1
    grid = D.grid({"l1": [0.1, 0.2], "l2": [0.1, 0.2, 0.3], "d": 0.1})
    assert len(grid) == 6 and np.concatenate(list(grid.chunks(4))).tolist()[1] == [0.1, 0.2, 0.1]
    parts = [np.concatenate(list(D.sample(BOUNDS, 100, seed=3).chunks(size))) for size in (7, 100)]
    np.testing.assert_array_equal(*parts)  # whatever the chunk
    rows = np.concatenate(list(D.sample({"l1": (0, 1), "d": (2, 4)}, 4096).chunks(4096))) - (0, 2)
    cells = np.histogram2d(*(rows / (1, 2)).T, bins=16, range=[(0, 1)] * 2)[0]
    assert cells.min() >= 12 and cells.max() <= 20  # evenly: of independent ones 16 +- 4 each
    late = D.sample(BOUNDS, 10**12)._rows(10**12 - 3, 10**12)
    assert (
        (late >= [low for low, _ in BOUNDS.values()])
        & (late <= [high for _, high in BOUNDS.values()])
    ).all()
    corners = np.concatenate(list(D.triangle(6).chunks(100)))
    assert (corners[:, 2] <= corners[:, :2].sum(axis=1)).all() and np.allclose(
        corners.sum(axis=1), 3
    )


@pytest.mark.parametrize(
    "change, notes",
    [
        (
            dict(figure=["det_A"]),
            "holds another sweep, whose figures is .* and not .* nothing was written",
        ),
        (dict(chunk=60), "holds another sweep, whose chunk is 50 and not 60"),
        (dict(motor=(1.0, 5.0)), "holds another sweep, whose choices is"),
        (dict(robot=fb.FiveBar(l11=0.1)), "holds another sweep, whose robot is"),
        (dict(seed=1), "holds another sweep, whose designs is"),
    ],
)
def test_the_folder_of_another_sweep_is_left_alone(change, notes, whole, tmp_path):
    out = tmp_path / "out"
    swept(out)
    options = CHOICES | {k: v for k, v in change.items() if k not in ("figure", "seed")}
    with pytest.raises(ValueError, match=notes):
        fb.sweep(
            change.get("figure", FIGURES),
            D.sample(BOUNDS, 330, change.get("seed", 0)),
            out=out,
            **options,
        )
    assert bytes_of(out) == whole


def test_a_table_is_saved_into_an_empty_folder_and_read_from_a_whole_one(tmp_path):
    table = fb.sweep("workspace_area", [{"l1": 0.1}, {"l1": 0.11}], chunk=1, workers=1)
    with pytest.raises(KeyError, match="no column 'l2'; there are l1, workspace_area"):
        table["l2"]
    folder = tmp_path / "table"
    table.save(folder)
    assert np.array_equal(D.Sweep.load(folder)["workspace_area"], table["workspace_area"])
    with pytest.raises(ValueError, match="folder: .*table is not empty"):
        table.save(folder)
    manifest = json.loads((folder / "manifest.json").read_text("utf-8"))
    manifest["variables"].append("l2")
    (folder / "manifest.json").write_text(json.dumps(manifest), "utf-8")
    words = r"has \(1, 1\) columns of what varies and of figures, but manifest.json names \(2, 1\)"
    with pytest.raises(ValueError, match=words):
        D.Sweep.load(folder)["l1"]
    (folder / "chunk-000001.npz").unlink()
    with pytest.raises(ValueError, match="is said to be done, but chunk-000001.npz is missing"):
        D.Sweep.load(folder)


def test_designs_that_come_one_by_one_and_have_changed(tmp_path):
    rows = [{"l1": 0.1 + k / 1000} for k in range(6)]
    fb.sweep("workspace_area", rows, out=tmp_path / "out", chunk=2, workers=1)
    before = bytes_of(tmp_path / "out")
    for changed in ([*rows[:4], {"l1": 0.2}, rows[5]], rows[:4]):
        with pytest.raises(ValueError, match="another sweep, whose designs is"):
            fb.sweep("workspace_area", changed, out=tmp_path / "out", chunk=2, workers=1)
    assert bytes_of(tmp_path / "out") == before


OWN = """
import fivebar as fb

K = {constant}

def helper(robot):
    return {factor} * robot.l11

def made(offset):
    def own(robot):
        return K + helper(robot) + offset
    return own

print(fb.sweep(made({offset}), [{{"l1": 0.1}}], out="out", workers=1)["own"][0])
"""


@pytest.mark.deep
def test_a_figure_is_another_one_where_what_it_uses_has_changed(tmp_path):
    """A file that is edited and run again: its constants, its functions and its closures."""

    def ran(constant=2, factor=3, offset=4):
        (tmp_path / "own.py").write_text(OWN.format(**locals()), "utf-8")
        command = [sys.executable, "own.py"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        return done.stdout + done.stderr

    found = ran()
    assert float(found) == pytest.approx(6.3) and ran() == found  # from the folder
    for change in ({"constant": 3}, {"factor": 2}, {"offset": 5}):
        assert "out: out holds another sweep, whose figures is" in ran(**change)


def test_the_first_difference_of_two_sweeps_is_shown(tmp_path):
    figures = [{"name": f"figure_{k}"} for k in range(20)]
    known = {"what": "fivebar sweep", "variables": []} | dict.fromkeys(
        ("robot", "choices", "designs"), {}
    )
    begin(tmp_path, known | {"figures": figures}, "sweep")
    with pytest.raises(ValueError, match="another sweep") as error:
        begin(tmp_path, known | {"figures": [*figures[:-1], {"name": "last"}]}, "sweep")
    before, now = str(error.value).split(" and not ")
    assert 'figure_19"}]' in before and '"last"}]' in now


FULL = """
import resource, sys
import fivebar as fb
if sys.argv[2] == "full":
    resource.setrlimit(resource.RLIMIT_FSIZE, (6000, resource.RLIM_INFINITY))
designs = [{"l1": 0.1 + k / 1000} for k in range(400)]
fb.sweep(fb.optimal_design.FIGURES["bars"], designs, out=sys.argv[1], workers=1, chunk=int(sys.argv[3]))
"""


@pytest.mark.deep
def test_a_full_disk_says_so_and_leaves_nothing_half(tmp_path):
    """A limit on the size of files is to a writing process what a full disk is."""
    command = [sys.executable, "-c", FULL, tmp_path / "out"]
    run = subprocess.run([*command, "full", "400"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 1 and "OSError: [Errno 27]" in run.stderr
    assert f"what was done stays in {tmp_path / 'out'}" in run.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["manifest.json"]
    assert subprocess.run([*command, "roomy", "400"], cwd=ROOT).returncode == 0
    assert len(D.Sweep.load(tmp_path / "out")) == 400


MEMORY = """
import resource, sys
import fivebar as fb
count = int(sys.argv[1])
done = fb.sweep(["workspace_area", "bars"], fb.optimal_design.sample({"l1": (0.05, 0.2), "l2": (0.05, 0.3)}, count),
                out=sys.argv[2], workers=1)
assert len(done) == count and len(done.best("workspace_area", 10)) == 10
done.to_csv(sys.argv[2] + ".csv")
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.deep
def test_memory_is_flat_in_the_number_of_designs(tmp_path):
    peak = [
        int(
            subprocess.run(
                [sys.executable, "-c", MEMORY, str(count), tmp_path / str(count)],
                cwd=ROOT,
                capture_output=True,
                text=True,
                check=True,
            ).stdout
        )
        for count in (10_000, 100_000)
    ]
    assert peak[1] - peak[0] < 12_000  # kB; the larger table alone has 3200 of them


def test_two_sweeps_into_one_folder(tmp_path):
    started, go = threading.Event(), threading.Event()

    def slow(robot):
        started.set()
        go.wait(20)
        return 1.0

    def first():
        fb.sweep(slow, {"l1": [0.1]}, out=tmp_path / "out", workers=1)

    thread = threading.Thread(target=first)
    thread.start()
    assert started.wait(20)
    with pytest.raises(ValueError, match="another sweep writes to"):
        fb.sweep(slow, {"l1": [0.1]}, out=tmp_path / "out", workers=1)
    go.set()
    thread.join()
    assert len(D.Sweep.load(tmp_path / "out")) == 1


class Strange(Exception):
    pass


def test_what_is_raised_travels_and_what_cannot_travel_is_said():
    def strange(robot):
        raise Strange("so")

    done = fb.sweep(strange, {"l1": [0.1] * 30}, workers=2)  # forked workers have it
    assert len(done.errors) == 30 and done.errors[0] == (0, "strange: Strange: so")
    with (
        ProcessPoolExecutor(1) as executor,
        pytest.raises(ValueError, match="cannot be sent to another process"),
    ):
        fb.sweep(strange, {"l1": [0.1]}, executor)


def test_an_executor_that_takes_no_more(tmp_path):
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(
        RuntimeError, match="takes no more work.*What was done is in .*; the same call goes on"
    ):
        swept(tmp_path / "out", executor)
    with pytest.raises(
        TypeError, match="executor must be a concurrent.futures.Executor, not 'dask'"
    ):
        swept(executor="dask")


def test_the_manifest_says_what_it_is_of(whole):
    about = json.loads(whole["manifest.json"])
    assert (
        about["what"] == "fivebar sweep"
        and about["done"]["designs"] == 330
        and about["done"]["chunks"] == 7
    )
    assert fb.Motor(**about["choices"]["motor"]) == fb.Motor(1.0, 4.0)
    assert resource.getpagesize()  # the module is of Unix, as the limit of a file's size above
