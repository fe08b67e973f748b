"""Two runs that write into one folder, and what a killed one left there."""

import subprocess
import sys
import threading
from pathlib import Path

import pytest

import fivebar as fb
from fivebar.base.folders import FolderError, locked_folder
from fivebar.base.tables import is_part, replaced, written
from fivebar.cli import main

PART = ".plan.csv.4711-0.part"


def test_two_runs_write_their_files_one_after_the_other(tmp_path):
    order = []

    def second():
        with locked_folder(tmp_path):
            order.append("second")

    other = threading.Thread(target=second)
    with locked_folder(tmp_path):
        other.start()
        other.join(0.2)
        order.append("first")
    other.join(60)
    assert order == ["first", "second"]


def test_work_that_takes_long_is_refused_at_once(tmp_path):
    with locked_folder(tmp_path, "sweep"):
        with pytest.raises(FolderError, match="another sweep writes to"):
            with locked_folder(tmp_path, "sweep"):
                pass


def test_what_a_killed_process_left_half_written_is_removed_by_the_next(tmp_path):
    """A file to which no folder belongs, as of `map --out`; what living processes write stays."""
    code = "import sys, time; from fivebar.base.tables import written\n" + (
        "with written(sys.argv[1]) as file: print(file.name, flush=True); time.sleep(60)"
    )
    writers = []
    for name in ("killed.csv", "living.csv"):
        command = [sys.executable, "-c", code, str(tmp_path / name)]
        writers.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
    killed, living = (Path(writer.stdout.readline().strip()) for writer in writers)
    writers[0].terminate()
    writers[0].wait()
    (tmp_path / ".mine.part").touch()
    assert killed.exists()
    with written(tmp_path / "next.csv") as file:
        assert not killed.exists() and living.exists() and Path(file.name).exists()
    assert (tmp_path / "next.csv").exists() and (tmp_path / ".mine.part").exists()
    writers[1].terminate()
    for writer in writers:
        writer.communicate()


@pytest.mark.deep
def test_what_a_killed_run_left_is_removed_by_the_next(tmp_path):
    with replaced(tmp_path / "plan.csv") as part:
        name = part.rsplit("/", 1)[1]
        open(part, "w", encoding="utf-8").close()
    assert is_part(PART) and is_part(name)
    (tmp_path / PART).touch()
    (tmp_path / "mine.part").touch()
    ends = ["--from", "0.09", "0.068", "--to", "0.08", "0.075", "--duration", "0.5"]
    assert main(["plan", *ends, "--out", str(tmp_path)]) == 0
    assert not (tmp_path / PART).exists() and (tmp_path / "mine.part").exists()
    assert (tmp_path / "plan.png").exists()


@pytest.mark.deep
def test_a_front_is_saved_beside_nothing_half_written(tmp_path):
    front = fb.design(
        {"bars": "min", "workspace_area": "max"},
        {"l1": (0.08, 0.2), "l2": (0.08, 0.2)},
        table=(0.05, 0.04),
        points=3,
        effort=0.1,
    )
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / PART).touch()
    front.save(tmp_path)
    assert not (tmp_path / "robots" / PART).exists() and (tmp_path / "index.html").exists()
