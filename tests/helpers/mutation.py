"""Mutation testing of a room by mutmut: which small changes of its source no test notices.

    pip install mutmut && python -m tests.helpers.mutation models --count 150 --seed 1 --keep mutation-models

mutates a copy of the tracked files, draws mutants at random, runs for each the tests that come to its function (without
the slowest, which `ROOMS` names), and prints the share killed and each survivor's lines. Not drawn: mutants that differ
in the letters of a text only, which are words of messages; mutmut leaves decorated functions alone.
"""

import argparse
import contextlib
import io
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter
from pathlib import Path

from . import ROOT

ROOMS = {  # room: its tests, less those that take long or are about other processes
    "models": (
        "tests/models", "tests/test_bad_input.py", "tests/test_described.py", "tests/simulation/test_friction.py",
        "--deselect=tests/models/test_accuracy.py::test_error", "--deselect=tests/models/test_accuracy.py::test_oracle",
        "--deselect=tests/models/test_biglide_accuracy.py::test_error",
    ),
    "singularities": ("tests/singularities", "--ignore=tests/singularities/test_aspect_families.py"),
    "simulation": ("tests/simulation", "tests/test_bad_input.py", "tests/control/test_loads.py"),
    "grading": (
        *(f"tests/grading/test_{name}.py" for name in "judge wire outputs fairness".split()),
        "-k", "not bwrap",
    ),
}  # fmt: skip
# Of grading what gives the points: the rest is about processes, files and words.
FILES = {"grading": ["judge.py", "values.py", "fits.py", "results.py", "exercise.py"]}
COPIED = ["labs", "notebooks", "README.md", ".readme", ".ci"]
ARGUMENTS = ["-p", "no:cacheprovider"]
MUTMUT = [sys.executable, "-m", "mutmut"]


def copied(room: str, folder: Path) -> None:
    """The tracked files, with mutmut's settings for a room."""
    for name in subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True).split("\0")[:-1]:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name, follow_symlinks=False)
    settings = {
        "source_paths": ["fivebar"], "only_mutate": [f"fivebar/{room}/{name}" for name in FILES.get(room, ["*"])],
        "also_copy": COPIED,
        "pytest_add_cli_args": ARGUMENTS, "pytest_add_cli_args_test_selection": list(ROOMS[room]),
    }  # fmt: skip
    with (folder / "pyproject.toml").open("a") as project:
        project.write("\n[tool.mutmut]\nuse_setproctitle = false\n")
        project.writelines(f"{name} = {json.dumps(value)}\n" for name, value in settings.items())
    # mutmut makes its mutants before it finds that none of them is asked for.
    subprocess.run([*MUTMUT, "run", "none of them"], cwd=folder, capture_output=True)
    if not (folder / "mutants/fivebar/_labs").exists():
        (folder / "mutants/fivebar/_labs").symlink_to("../labs")


def names(folder: Path) -> list[str]:
    """The mutants' names, in a fixed order."""
    found = sorted((folder / "mutants").rglob("*.meta"))
    return [name for path in found for name in json.loads(path.read_text())["exit_code_by_key"]]


def lines(folder: Path, name: str) -> tuple[str, str]:
    """What stood there, and what stands there now."""
    from mutmut.mutation.diff_apply import get_diff_for_mutant

    with contextlib.chdir(folder):
        shown = get_diff_for_mutant(name)
    parts = [[li[1:] for li in shown.splitlines() if re.match(rf"\{sign}(?!\{sign}\{sign})", li)] for sign in "-+"]
    return "\n".join(parts[0]), "\n".join(parts[1])


def without_texts(source: str) -> list[str]:
    """The words of some lines, texts emptied."""
    found = []
    try:
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            found.append('""' if token.type == tokenize.STRING else token.string)
    except (tokenize.TokenError, IndentationError):
        pass  # lines out of their context end early
    return found


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.helpers.mutation", description=__doc__.splitlines()[0])
    parser.add_argument("room", choices=ROOMS)
    parser.add_argument("--count", type=int, default=150, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="the copy's folder, which is used again where it is there")
    parser.add_argument("--only", nargs="+", help="these mutants in place of drawn ones")
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fivebar-mutation-"))
    if not (folder / "mutants").exists():
        copied(options.room, folder)
    every = names(folder)
    drawn, wanted = options.only or [], 0 if options.only else options.count
    for name in random.Random(options.seed).sample(every, len(every)):
        if len(drawn) >= wanted:
            break
        if len(set(map(tuple, map(without_texts, lines(folder, name))))) == 2:
            drawn.append(name)
    subprocess.run([*MUTMUT, "run", *drawn, "--max-children", "1"], cwd=folder, stdout=subprocess.DEVNULL)
    report = subprocess.run([*MUTMUT, "results", "--all", "true"], cwd=folder, capture_output=True, text=True).stdout
    status = dict(re.findall(r"^\s*(\S+): (.+)$", report, re.MULTILINE))
    found = Counter(status.get(name, "not run") for name in drawn)
    for name in drawn:
        if status.get(name) not in ("killed", "timeout"):
            print(
                f"{name}: {status.get(name)}",
                *("  " + line for part in lines(folder, name) for line in [part]),
                sep=os.linesep,
            )
    killed = found["killed"] + found["timeout"]
    print(
        f"{options.room}: {killed} of {len(drawn)} drawn from {len(every)} killed ({killed / len(drawn):.1%})",
        dict(found),
    )


if __name__ == "__main__":
    main()
