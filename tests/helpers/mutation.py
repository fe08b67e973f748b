"""Mutation testing of a room by mutmut: which small changes of its source no test notices.

    pip install mutmut && python -m tests.helpers.mutation models --count 150 --seed 1 --keep mutation-models

mutates a copy of the tracked files, draws mutants at random, runs for each the tests that come to its function (without
the slowest, which `ROOMS` names; the fastest first, until one fails), and prints the share killed or justified and the
lines of each that is left. `tests/data/mutants.toml` has the justified ones, each with its reason. A kept copy is
brought up to date. Not drawn: mutants that differ in the letters of a text only, which are words of messages; mutmut
leaves decorated functions alone.
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
import tomllib
from bisect import bisect
from collections import Counter
from fnmatch import fnmatchcase
from itertools import accumulate
from pathlib import Path

import pytest

from . import DATA, ROOT

ROOMS = {  # room: its tests, less those that take long or are about other processes
    "models": (
        "tests/models", "tests/test_bad_input.py", "tests/test_described.py",
        "--ignore=tests/models/test_accuracy.py", "--ignore=tests/models/test_biglide_accuracy.py",
        "--deselect=tests/models/test_compiled.py::test_compiled_models_equal_numpy",
        "--deselect=tests/models/test_compiled.py::test_processes_that_build_at_once_do_not_meet",
    ),
    "singularities": (
        "tests/singularities", "tests/test_described.py",
        *(f"--ignore=tests/singularities/test_{name}_families.py" for name in ("aspect", "dexterous")),
        "-k", "not (drawn or command_line or any_robot or models_accept or slices or nothing_asked or rings_of or "
        "random_rectangles or rectangles_are_inside or aspects_3_and_6 or (circle and coaxial) or start2 or start3 or "
        "(flooded and (unequal or equal)) or (contains_is and grashof) or (bars_against and working1))",
    ),
    "simulation": (
        "tests/simulation", "tests/test_bad_input.py", "tests/control/test_loads.py", "tests/models/test_compiled.py",
        "-k", "not twelve_lines and not tracker and not compiled_models and not processes and not machine_code",
    ),
    "planning": (
        "tests/planning", "tests/singularities/test_path.py", "--ignore=tests/planning/test_loads.py",
        "-k", "not pictures and not by_way_of_a_pose and not random_problems and not too_little_acceleration",
    ),
    "paths": (
        "tests/paths", "--ignore=tests/paths/test_timing_by_collocation.py",
        "-k", "not what_is_kept_and_what_does_not_fit and not grazes_a_locus and not checker_is_short",
    ),
    "estimation": (
        "tests/estimation", "-k", "not without_any_margin and not never_refused and not a_hundred_thousand_rows",
    ),
    "optimal_design": (
        "tests/optimal_design", "--ignore=tests/optimal_design/test_dask.py",
        "--ignore=tests/optimal_design/test_killed.py",
    ),
    "control": ("tests/control", "-k", "not benchmark_runs"),
    "linkages": ("tests/linkages",),
    "exporters": ("tests/exporters",),
    "grading": tuple(f"tests/grading/test_{name}.py" for name in "judge values relations results".split()),
}  # fmt: skip
# What those that are left by these, and not justified, must pass too: in a process of its own, so that what is made
# at import is made of the mutant.
SLOW = {
    "models": (
        "tests/models/test_accuracy.py", "tests/models/test_biglide_accuracy.py", "tests/simulation/test_friction.py",
        "--deselect=tests/models/test_accuracy.py::test_oracle",
    ),
    "simulation": ("tests/simulation/test_encoders.py", "tests/estimation/test_replays.py"),
    "singularities": (
        "tests/singularities/test_dexterous.py", "tests/singularities/test_inscribed.py", "tests/planning/test_keep.py",
        "tests/planning/test_loads.py", "tests/singularities/test_aspect_families.py", "-k", "not nothing_asked",
    ),
    "planning": ("tests/planning/test_loads.py",),
    "paths": ("tests/paths/test_timing_by_collocation.py", "tests/cli/test_draw.py"),
    "estimation": ("tests/estimation/test_mistakes.py", "tests/estimation/test_near_type_2.py", "tests/cli/test_identify.py"),
    "optimal_design": ("tests/optimal_design/test_figures.py", "tests/optimal_design/test_killed.py", "tests/cli/test_designing.py"),
    "control": ("tests/control/test_tracker.py",),
    "linkages": ("tests/amoro", "tests/models/test_compiled.py"),
    "exporters": ("tests/cli/test_commands.py",),
}  # fmt: skip
# Of grading what gives the points: the rest is about processes, files and words.
FILES = {"grading": ["judge.py", "values.py", "relations.py", "results.py", "exercise.py"]}
COPIED = ["labs", "notebooks", "README.md", ".readme", ".ci"]
ARGUMENTS = ["-m", "", "-p", "no:cacheprovider", "-p", "tests.helpers.mutation"]  # deep tests, too
TABLE = DATA / "mutants.toml"
# Mutmut without its second run of all tests, and without its first of one that must fail: the first run, which measures
# their times, has passed or ended it all.
MUTMUT = [
    sys.executable, "-c",
    "from mutmut.__main__ import cli\n"
    "from mutmut.runners.harness import ListAllTestsResult, collected_test_names\n"
    "from mutmut.workers.isolation import ForkServerRunner as runner\n"
    "runner.run_clean_tests, runner.run_forced_fail = lambda self, tests: 0, lambda self: 1\n"
    "runner.list_all_tests = lambda self: ListAllTestsResult(ids=collected_test_names())\n"
    "cli()",
]  # fmt: skip


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list) -> None:
    """The fastest tests first, by the times that mutmut has measured, until these come to `--seconds`."""
    stored = Path("mutmut-stats.json")
    if not stored.exists():
        return
    times = json.loads(stored.read_text("utf-8"))["duration_by_test"]
    # Of about one time those of a file stay together: their fixtures are made once.
    items.sort(key=lambda item: bisect([0.1, 1.0], times.get(item.nodeid, 0.0)))
    spent = accumulate(times.get(item.nodeid, 0.0) for item in items)
    seconds = float(os.environ.get("MUTATION_SECONDS", "inf"))
    items[:] = [item for item, sum in zip(items, spent) if sum <= seconds]


def pytest_runtest_setup() -> None:
    """Each test starts with empty caches: what they keep may have been made by another function than the mutant."""
    for module in [module for name, module in sys.modules.items() if name.startswith("fivebar.")]:
        for each in vars(module).values():
            if hasattr(each, "cache_clear"):
                each.cache_clear()


def copied(room: str, folder: Path, arguments: list[str]) -> None:
    """The tracked files, with mutmut's settings for a room; of a copy that is there what has changed."""
    settings = {
        "source_paths": ["fivebar"], "only_mutate": [f"fivebar/{room}/{name}" for name in FILES.get(room, ["*"])],
        "also_copy": COPIED,
        "pytest_add_cli_args": arguments, "pytest_add_cli_args_test_selection": list(ROOMS[room]),
        "timeout_multiplier": 5.0,  # a mutant that hangs costs five times its tests in place of fifteen
        "timeout_constant": 8.0,  # and on a busy machine pytest alone takes seconds to begin
        "process_isolation": "forkserver",  # from a process in which no test has run
    }  # fmt: skip
    own = "\n[tool.mutmut]\nuse_setproctitle = false\n"
    own += "".join(f"{name} = {json.dumps(value)}\n" for name, value in settings.items())
    changed = False
    for name in subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True).split("\0")[
        :-1
    ]:
        if (ROOT / name).is_symlink():
            continue
        there, text = (
            folder / name,
            (ROOT / name).read_bytes() + own.encode() * (name == "pyproject.toml"),
        )
        if not there.exists() or there.read_bytes() != text:
            there.parent.mkdir(parents=True, exist_ok=True)
            there.write_bytes(text)
            shutil.copymode(ROOT / name, there)
            changed = True
    if not changed:
        return
    (folder / "mutants/mutmut-stats.json").unlink(
        missing_ok=True
    )  # which tests come to which function
    # mutmut makes its mutants before it finds that none of them is asked for.
    subprocess.run([*MUTMUT, "run", "none of them"], cwd=folder, capture_output=True)
    if not (folder / "mutants/fivebar/_labs").exists():
        (folder / "mutants/fivebar/_labs").symlink_to("../labs")


def names(folder: Path) -> list[str]:
    """The mutants' names, in a fixed order."""
    found = sorted((folder / "mutants").rglob("*.meta"))
    return [
        name for path in found for name in json.loads(path.read_text("utf-8"))["exit_code_by_key"]
    ]


def lines(folder: Path, name: str) -> tuple[str, str]:
    """What stood there, and what stands there now."""
    from mutmut.mutation.diff_apply import get_diff_for_mutant

    with contextlib.chdir(folder):
        shown = get_diff_for_mutant(name)
    parts = [
        [li[1:] for li in shown.splitlines() if re.match(rf"\{sign}(?!\{sign}\{sign})", li)]
        for sign in "-+"
    ]
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


def reason(table: list, name: str, was: str, now: str) -> str | None:
    """Why a mutant need not be killed: of the first entry of which it takes the one text and brings the other."""
    function = re.sub(
        r"^fivebar\.|\bx_|__mutmut_\d+$", "", name.replace("xǁ", "").replace("ǁ", ".")
    )
    for pattern, gone, come, why in table:
        brings = not come or now.count(come) > was.count(come)
        if fnmatchcase(function, pattern) and was.count(gone) > now.count(gone) and brings:
            return why
    return None


def killed_by(tests: tuple[str, ...], name: str, folder: Path) -> bool:
    """Whether a slow test fails with this mutant."""
    run = [sys.executable, "-m", "pytest", "-xq", *ARGUMENTS, *tests]
    environment = {**os.environ, "MUTANT_UNDER_TEST": name}
    return (
        bool(tests)
        and subprocess.run(
            run, cwd=folder / "mutants", capture_output=True, env=environment
        ).returncode
        == 1
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m tests.helpers.mutation", description=__doc__.splitlines()[0]
    )
    parser.add_argument("room", choices=ROOMS)
    parser.add_argument("--count", type=int, default=150, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--keep", type=Path, help="the copy's folder, which is used again where it is there"
    )
    parser.add_argument("--only", nargs="+", help="these mutants in place of drawn ones")
    parser.add_argument(
        "--files", nargs="+", help="draw from these files of the room, as regions disc"
    )
    parser.add_argument(
        "--fast", action="store_true", help="by the fast tests alone, without deep and slow ones"
    )
    parser.add_argument(
        "--seconds", default="inf", help="of tests at most for each mutant, the fastest"
    )
    options = parser.parse_args()
    os.environ["MUTATION_SECONDS"] = options.seconds
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fivebar-mutation-"))
    copied(options.room, folder, [*ARGUMENTS, *["-m", "not deep"] * options.fast])
    every = [
        name for name in names(folder) if not options.files or name.split(".")[2] in options.files
    ]
    drawn, wanted = options.only or [], 0 if options.only else options.count
    for name in random.Random(options.seed).sample(every, len(every)):
        if len(drawn) >= wanted:
            break
        if len(set(map(tuple, map(without_texts, lines(folder, name))))) == 2:
            drawn.append(name)
    subprocess.run(
        [*MUTMUT, "run", *drawn, "--max-children", "1"], cwd=folder, stdout=subprocess.DEVNULL
    )
    report = subprocess.run(
        [*MUTMUT, "results", "--all", "true"], cwd=folder, capture_output=True, text=True
    ).stdout
    status = dict(re.findall(r"^\s*(\S+): (.+)$", report, re.MULTILINE))
    if {status.get(name, "not checked") for name in drawn} == {"not checked"}:
        sys.exit(
            "no mutant was tried: the tests fail without one, as `mutmut run` in the copy's folder says"
        )
    table, found = tomllib.loads(TABLE.read_text("utf-8"))["justified"], Counter()
    for name in drawn:
        outcome = status.get(name, "not run")
        if outcome not in ("killed", "timeout"):
            was, now = lines(folder, name)
            if why := reason(table, name, was, now):
                outcome = "justified"
            elif not options.fast and killed_by(SLOW.get(options.room, ()), name, folder):
                found["killed"] += 1
                continue
            print(
                f"{name}: {outcome}{f', {why}' * bool(why)}",
                was,
                now,
                sep=os.linesep + "  ",
                flush=True,
            )
        found[outcome] += 1
    share = sum(found[way] for way in ("killed", "timeout", "justified")) / len(drawn)
    print(
        f"{options.room}: of {len(every)} mutants {len(drawn)} drawn, {share:.1%} killed or justified",
        dict(found),
    )


if __name__ == "__main__":
    main()
