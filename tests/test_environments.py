"""Other machines' settings: locales, time zones, umasks, homes, clocks, paths; the same data, to the byte."""

import io
import itertools
import json
import os
import random
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.models import machine_code
from tests.helpers import ROOT
from tests.helpers.commands import ONE_BY_ONE, SAME, cli, python, with_files
from tests.helpers.needs import need
from tests.helpers.writers import LINE, ROBOT

RUN = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE)


@pytest.fixture(scope="module")
def commas(tmp_path_factory):
    """A folder with a locale of decimal commas."""
    need("locales")
    place = tmp_path_factory.mktemp("locales")
    subprocess.run(
        ["localedef", "-i", "de_DE", "-f", "UTF-8", place / "de_DE.UTF-8"],
        check=True,
        capture_output=True,
    )
    return {"LOCPATH": str(place), "LC_ALL": "de_DE.UTF-8"}


ENVIRONMENTS = {
    "hash seed, time zone, no home": {"PYTHONHASHSEED": "7", "TZ": "Pacific/Chatham", "HOME": None},
    "few letters, no cache, narrow": {
        "LC_ALL": "C",
        "PYTHONUTF8": "0",
        "XDG_CACHE_HOME": "/dev/null/none",
        "HOME": "/dev/null",
        "COLUMNS": "20",
    },
}


def seen(folder, env):
    """What they tell, and every file of data: all but pictures."""
    code, out, err = cli(
        json.dumps(SAME), cwd=with_files(folder), env=env, begin=["-c", ONE_BY_ONE]
    )
    assert code == 0, err
    files = {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*.*")
        if path.suffix != ".png"
    }
    told, end = json.JSONDecoder().raw_decode(out)
    return told | {
        "real_time_factor": None,
        "others": out[end:].encode("ascii", "backslashreplace"),
        **files,
    }


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    return seen(tmp_path_factory.mktemp("usual"), {"PYTHONHASHSEED": "1"})


@pytest.mark.deep
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_environment_changes_no_number(name, usual, tmp_path):
    assert seen(tmp_path, ENVIRONMENTS[name]) == usual


@pytest.mark.deep
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


@pytest.mark.deep
def test_a_program_that_sets_such_a_locale(commas, tmp_path):
    """As Qt does."""
    with python(["-c", COMMAS], tmp_path / "plan.csv", cwd=ROOT, env=os.environ | commas) as run:
        err = run.communicate(timeout=60)[1]
    assert run.returncode == 0, err


def test_a_umask_is_kept(tmp_path):
    before = os.umask(0o077)
    try:
        RUN.to_csv(tmp_path / "a.csv")
        RUN.page(tmp_path / "a.html")
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
        with pytest.warns(
            RuntimeWarning, match="set FIVEBAR_CACHE to a folder; going on in CasADi"
        ):
            assert fb.compile(ROBOT, ["q"], ["xi"], jit="auto")([0.1, 0.2]).shape == (2, 1)
        with pytest.raises(OSError, match="FIVEBAR_CACHE"):
            fb.compile(ROBOT, ["q"], ["xi"], jit=True)


@pytest.mark.deep
def test_a_clock_that_jumps_changes_nothing(monkeypatch):
    """Nor one that runs ahead, as where others have the processor."""

    def done():
        ends = fb.igm(ROBOT, (0.05, 0.09)), fb.igm(ROBOT, (0.08, 0.075), (-1, 1))
        plan = fb.plan(ROBOT, *ends, 0.5)
        return (
            plan.tried,
            plan.pieces.xi,
            fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE).q,
        )

    usual, draw, ahead = done(), random.Random(3), itertools.count(step=100.0)
    monkeypatch.setattr(time, "time", lambda: draw.uniform(-1e9, 4e9))
    monkeypatch.setattr(time, "perf_counter", lambda: next(ahead))
    again = done()
    assert usual[0].ways > 1 and usual[0] == again[0]
    assert all(map(np.array_equal, usual[1:], again[1:]))


# Places

PLACE = "mes dossiers/été 日本 #1 %20 'a' \"b\""


@pytest.mark.deep
def test_a_path_with_all_letters(tmp_path, monkeypatch, capsys):
    folder = tmp_path / PLACE
    folder.mkdir(parents=True)
    monkeypatch.chdir(folder)
    for write, end in (
        (RUN.to_csv, "csv"),
        (RUN.plot, "png"),
        (RUN.page, "html"),
        (RUN.animate, "html"),
        (fb.singularity_map(ROBOT, shape=(20, 20)).to_npz, "npz"),
        (lambda path: fb.export(ROBOT, "c", path), "h"),
    ):
        path = folder / f"é.{end}"
        path.unlink(missing_ok=True)
        write(path)
        assert path.stat().st_size > 0, end
    (folder / "mon chemin.csv").write_text(
        "t,x,y\n0,0.09,0.068\n0.1,0.088,0.068\n0.2,0.086,0.068\n0.3,0.085,0.068\n0.4,0.084,0.068\n0.5,0.084,0.068\n",
        encoding="utf-8",
    )
    solution = ROOT / "tests/data/solutions/lab1.py"
    (folder / "ma réponse.py").write_bytes(solution.read_bytes())
    with_files(folder)
    for arguments in (
        *SAME,
        ["track", "mon chemin.csv", "--json"],
        ["map", "--path", "mon chemin.csv", "--out", "é.png"],
        ["check", "lab1", "ma réponse.py", "--html", "é.html"],
    ):
        assert main(arguments) == 0, (arguments, capsys.readouterr())


def test_models_are_compiled_in_such_a_path(tmp_path, monkeypatch):
    need("a C compiler")
    need("UTF-8 in file names")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / PLACE))
    assert fb.compile(ROBOT, ["q"], ["xi"], jit=True)([0.0, 0.0]).full()[0, 0] == pytest.approx(
        0.09
    )


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
