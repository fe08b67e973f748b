"""Faults of machines and hands: full disks, interrupts, kills, two at once, odd places, locales, clocks.

Whatever happens, a file has its final name only when it is whole, and what had the name before stays.
"""

import contextlib
import io
import json
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.models import machine_code
from tests.helpers import ROOT
from tests.helpers.commands import ONE_BY_ONE, SAME, with_files
from tests.helpers.needs import need
from tests.helpers.writers import DIRECT, LINE, ROBOT, writers, writing_functions

NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))
ROUNDS = 60 if NIGHTLY else 3
WRITERS = writers()


def python(code, *arguments, **options):
    return subprocess.Popen(
        [sys.executable, *code, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        **options,
    )  # fmt: skip


def cli(*arguments, cwd, env=(), begin=("-m", "fivebar"), **options):
    """(exit code, stdout, stderr) of a command in a process of its own."""
    environment = {k: v for k, v in (os.environ | {"PYTHONPATH": str(ROOT)} | dict(env)).items() if v is not None}
    with python(begin, *arguments, cwd=cwd, env=environment, **options) as run:
        out, err = run.communicate(timeout=120)
    return run.returncode, out, err


def test_files_are_written_by_what_gives_them_their_name_last():
    assert writing_functions() == set(DIRECT), (
        "use tables.written, saved or replaced, or say in helpers/writers.py why not"
    )


@contextlib.contextmanager
def little_room(size):
    """No file may become larger; what a full disk says, without the rights to mount one."""
    before, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.parametrize("name", WRITERS)
def test_no_room_leaves_what_was_there(name, tmp_path):
    write, file = WRITERS[name]
    path = tmp_path / file
    path.write_bytes(b"before")
    with little_room(30), pytest.raises(OSError, match="too large|No space"):
        write(path)
    assert path.read_bytes() == b"before" and list(tmp_path.iterdir()) == [path]
    write(path)
    assert path.stat().st_size > 30 and list(tmp_path.iterdir()) == [path]


FULL = ["track", "--from", "0.09", "0.068", "--to", "0", "0.1", "--duration", "1", "--out"]


def test_a_full_disk_is_said_and_leaves_nothing(tmp_path):
    need("bubblewrap")
    place = tmp_path / "disk"
    place.mkdir()
    inside = f'"{sys.executable}" -m fivebar {" ".join(FULL)} {place}/run; echo "code $?"; ls -A {place}/run'
    run = subprocess.run(
        ["bwrap", "--dev-bind", "/", "/", "--size", "8192", "--tmpfs", place, "sh", "-c", inside], cwd=ROOT, text=True,
        capture_output=True, timeout=60,
    )  # fmt: skip
    assert "run.csv: No space left on device" in run.stderr and "Traceback" not in run.stderr, run.stderr
    assert run.stdout.endswith("code 1\n"), run.stdout


def test_a_folder_that_may_not_be_written(tmp_path):
    need("bubblewrap")
    inside = f'"{sys.executable}" -m fivebar {" ".join(FULL)} {tmp_path}/run'
    run = subprocess.run(
        ["bwrap", "--dev-bind", "/", "/", "--ro-bind", tmp_path, tmp_path, "sh", "-c", inside], cwd=ROOT, text=True,
        capture_output=True, timeout=60,
    )  # fmt: skip
    assert run.returncode == 1 and "Read-only" in run.stderr and "Traceback" not in run.stderr, run.stderr


# Interrupts and kills

WRITING = """import sys, fivebar as fb
run = fb.simulate(fb.FiveBar(), fb.ComputedTorque(fb.FiveBar(), 100, 20), fb.line((0.09, 0.068), (0.08, 0.075), 2.0))
print("ready", flush=True)
while True:
    run.to_csv(sys.argv[1])"""


def test_a_killed_writer_leaves_a_whole_file(tmp_path):
    draw, path = random.Random(1), tmp_path / "run.csv"
    with python(["-c", WRITING], path, cwd=ROOT) as one, python(["-c", WRITING], path, cwd=ROOT) as other:
        for each in (one, other):  # two processes with one output
            assert each.stdout.readline() == "ready\n"
        for _ in range(ROUNDS):
            time.sleep(draw.uniform(0.01, 0.2))
            if path.exists():
                assert len(fb.Run.from_csv(path).t) == 2001
        one.kill(), other.kill()
    assert len(fb.Run.from_csv(path).t) == 2001
    assert all(".part" in left.name for left in tmp_path.iterdir() if left != path)


def test_two_threads_with_one_output(tmp_path):
    run, faults = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE), []

    def write():
        try:
            for _ in range(10):
                run.to_csv(tmp_path / "run.csv")
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=write) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert not faults and len(fb.Run.from_csv(tmp_path / "run.csv").t) == len(run.t)
    assert len(list(tmp_path.iterdir())) == 1


def test_an_interrupt_at_any_time_says_so_and_leaves_nothing_half(tmp_path):
    draw = random.Random(2)
    with_files(tmp_path)
    commands = [["map", "--out", "a.png"], ["track", "--case", "task-1", "--out", "b"], [*FULL, "c"], *SAME]
    for k in range(ROUNDS):
        with python(
            ["-m", "fivebar"], *commands[k % len(commands)], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}
        ) as run:
            time.sleep(0.6 + draw.uniform(0, 0.8))  # by then the interpreter has begun with our own code
            run.send_signal(signal.SIGINT)
            _, err = run.communicate(timeout=30)
        if run.returncode != 0:  # it was not done before
            assert run.returncode in (1, 130, -signal.SIGINT)
            # Before `main` has begun, the interpreter itself may still be loading, and says it in its own way.
            assert "Traceback" not in err or ", in main" not in err, err
        for path in tmp_path.rglob("*"):
            assert path.is_dir() or path.stat().st_size > 0 and ".part" not in path.name, path


# Environments: the same data, to the byte


@pytest.fixture(scope="module")
def commas(tmp_path_factory):
    """A folder with a locale of decimal commas."""
    need("locales")
    place = tmp_path_factory.mktemp("locales")
    subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", place / "de_DE.UTF-8"], check=True, capture_output=True)
    return {"LOCPATH": str(place), "LC_ALL": "de_DE.UTF-8"}


ENVIRONMENTS = {
    "hash seed, time zone, no home": {"PYTHONHASHSEED": "7", "TZ": "Pacific/Chatham", "HOME": None},
    "few letters, no cache, narrow": {
        "LC_ALL": "C", "PYTHONUTF8": "0", "XDG_CACHE_HOME": "/dev/null/none", "HOME": "/nonexistent", "COLUMNS": "20",
    },
}  # fmt: skip


def seen(folder, env):
    """What they tell, and every file of data: all but pictures."""
    code, out, err = cli(json.dumps(SAME), cwd=with_files(folder), env=env, begin=["-c", ONE_BY_ONE])
    assert code == 0, err
    files = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.*") if path.suffix != ".png"}
    told, end = json.JSONDecoder().raw_decode(out)
    return told | {"real_time_factor": None, "others": out[end:].encode("ascii", "backslashreplace"), **files}


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return seen(tmp_path_factory.mktemp("usual"), {"PYTHONHASHSEED": "1"})


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_environment_changes_no_number(name, usual, tmp_path):
    assert seen(tmp_path, ENVIRONMENTS[name]) == usual


def test_decimal_commas_of_the_locale_change_no_number(commas, usual, tmp_path):
    assert seen(tmp_path, commas) == usual


COMMAS = """import locale, sys, fivebar as fb
robot, path = fb.FiveBar(), sys.argv[1]
def numbers():
    plan = fb.plan(robot, (0.09, 0.068), (0.08, 0.075), 0.5)
    plan.to_csv(path)
    jit = fb.compile(robot, ["q"], ["xi"], jit="auto")
    code = fb.export(robot, "c", path + ".h", functions=("dgm",))
    return fb.Plan.from_csv(path)(0.2)[0].tolist(), jit([0.1, 0.2]).full().tolist(), open(path + ".h").read()
before = numbers()
assert locale.setlocale(locale.LC_ALL, "de_DE.UTF-8") and locale.localeconv()["decimal_point"] == ","
assert numbers() == before"""


def test_a_program_that_sets_such_a_locale(commas, tmp_path):
    """As Qt does."""
    with python(["-c", COMMAS], tmp_path / "plan.csv", cwd=ROOT, env=os.environ | commas) as run:
        err = run.communicate(timeout=60)[1]
    assert run.returncode == 0, err


def test_a_umask_is_kept(tmp_path):
    before = os.umask(0o077)
    try:
        WRITERS["Run.to_csv"][0](tmp_path / "a.csv")
        WRITERS["Run.page"][0](tmp_path / "a.html")
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in tmp_path.iterdir()} == {0o600}


def test_no_home_at_all(monkeypatch):
    """A user without an account and without HOME, as in many containers: models are not compiled, or where one says."""
    for name in ("FIVEBAR_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)

    def nowhere():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", nowhere)
    if machine_code.c_compiler():
        with pytest.warns(RuntimeWarning, match="set FIVEBAR_CACHE to a folder; going on in CasADi"):
            assert fb.compile(ROBOT, ["q"], ["xi"], jit="auto")([0.1, 0.2]).shape == (2, 1)
        with pytest.raises(OSError, match="FIVEBAR_CACHE"):
            fb.compile(ROBOT, ["q"], ["xi"], jit=True)


def test_a_clock_that_jumps_changes_nothing(monkeypatch):
    usual = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE)
    draw = random.Random(3)
    monkeypatch.setattr(time, "time", lambda: draw.uniform(-1e9, 4e9))
    again = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE)
    assert np.array_equal(usual.q, again.q)
    assert fb.plan(ROBOT, (0.09, 0.068), (0.08, 0.075), 0.5, max_time=20.0).duration == 0.5


# Places

PLACE = "mes dossiers/été 日本 #1 %20 'a' \"b\""


def test_a_path_with_all_letters(tmp_path, monkeypatch, capsys):
    folder = tmp_path / PLACE
    folder.mkdir(parents=True)
    monkeypatch.chdir(folder)
    for name in ("Run.to_csv", "Run.plot", "Run.page", "Run.animate html", "Map.to_npz", "export c"):
        write, file = WRITERS[name]
        write(folder / f"é {file}")
        assert (folder / f"é {file}").stat().st_size > 0, name
    (folder / "mon chemin.csv").write_text(
        "t,x,y\n0,0.09,0.068\n0.1,0.088,0.068\n0.2,0.086,0.068\n0.3,0.085,0.068\n0.4,0.084,0.068\n0.5,0.084,0.068\n"
    )
    solution = ROOT / "tests/data/solutions/lab1.py"
    (folder / "ma réponse.py").write_bytes(solution.read_bytes())
    with_files(folder)
    for arguments in (
        *SAME, ["track", "mon chemin.csv", "--json"], ["map", "--path", "mon chemin.csv", "--out", "é.png"],
        ["check", "lab1", "ma réponse.py", "--html", "é.html"],
    ):  # fmt: skip
        assert main(arguments) == 0, (arguments, capsys.readouterr())


def test_models_are_compiled_in_such_a_path(tmp_path, monkeypatch):
    need("a C compiler")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / PLACE))
    assert fb.compile(ROBOT, ["q"], ["xi"], jit=True)([0.0, 0.0]).full()[0, 0] == pytest.approx(0.09)


def test_tables_of_windows(tmp_path):
    text = '# saved from C:\\new\\Users\\table.csv\r\nt (s),x,y,"C:\\temp\\source"\r\n0,0.09,0.068,"D:\\a,b"\r\n'
    text += "1,0.08,0.07,\\\\\\\\host\\\\share\r\n"
    text += "".join(f"{k},0.07,{0.07 + 0.001 * k},x\r\n" for k in range(2, 8))
    for encoding in ("utf-8", "utf-8-sig", "cp1252"):
        (tmp_path / "a.csv").write_bytes(text.encode(encoding))
        assert fb.from_csv(tmp_path / "a.csv")(7.0)[0] == pytest.approx([0.07, 0.077])
        assert fb.path(tmp_path / "a.csv").length > 0
    run, file = fb.simulate(ROBOT, fb.PD(ROBOT, 1, 1), LINE, duration=0.01), io.StringIO(newline="")
    run.to_csv(file)
    crlf = file.getvalue().replace("\r\n", "\n").replace("\n", "\r\n")
    (tmp_path / "run.csv").write_bytes(crlf.encode())
    assert np.array_equal(fb.Run.from_csv(tmp_path / "run.csv").q, run.q)
