"""Mutation testing of a room: which small changes of its source no test notices.

    pip install mutmut && python -m tests.helpers.mutation models --count 150 --seed 1

draws mutants at random among those that mutmut's operators make, puts the code of each into the imported function of a
forked process, and runs there the tests that come to that function (without the slowest, which `ROOMS` names; the
fastest first, until one fails). It prints the share killed or justified and the lines of each that is left.
`tests/data/mutants.toml` has the justified ones, each with its reason. Not drawn: mutants that differ in the letters of
a text only, which are words of messages, and defaults.
"""

import argparse
import ast
import difflib
import importlib
import io
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
import tokenize
import tomllib
import warnings
from bisect import bisect
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from types import CodeType

import pytest

from . import DATA, ROOT

ROOMS = {  # room: its tests, less those that take long or are about other processes
    "models": (
        "tests/models",
        "tests/test_bad_input.py",
        "tests/test_described.py",
        "--ignore=tests/models/test_accuracy.py",
        "--ignore=tests/models/test_biglide_accuracy.py",
        "--deselect=tests/models/test_compiled.py::test_compiled_models_equal_numpy",
        "--deselect=tests/models/test_compiled.py::test_processes_that_build_at_once_do_not_meet",
    ),
    "singularities": (
        "tests/singularities",
        "tests/test_described.py",
        *(
            f"--ignore=tests/singularities/test_{name}_families.py"
            for name in ("aspect", "dexterous")
        ),
        "-k",
        "not (drawn or command_line or any_robot or models_accept or slices or nothing_asked or rings_of or "
        "random_rectangles or rectangles_are_inside or aspects_3_and_6 or (circle and coaxial) or start2 or start3 or "
        "(flooded and (unequal or equal)) or (contains_is and grashof) or (bars_against and working1))",
    ),
    "simulation": (
        "tests/simulation",
        "tests/test_bad_input.py",
        "tests/control/test_loads.py",
        "tests/models/test_compiled.py",
        "tests/models/test_motors.py",
        "tests/paths/test_tool_runs.py",
        "tests/estimation/test_bags.py",
        "tests/visualization/test_view_scenes.py",
        "-k",
        "not twelve_lines and not tracker and not compiled_models and not processes and not machine_code",
    ),
    "planning": (
        "tests/planning",
        "tests/singularities/test_path.py",
        "-k",
        "not pictures and not by_way_of_a_pose and not random_problems and not too_little_acceleration",
    ),
    "paths": (
        "tests/paths",
        "--ignore=tests/paths/test_timing_by_collocation.py",
        "-k",
        "not what_is_kept_and_what_does_not_fit and not grazes_a_locus and not checker_is_short",
    ),
    "estimation": (
        "tests/estimation",
        "-k",
        "not without_any_margin and not never_refused and not a_hundred_thousand_rows",
    ),
    "optimal_design": (
        "tests/optimal_design",
        "--ignore=tests/optimal_design/test_dask.py",
        "--ignore=tests/optimal_design/test_killed.py",
    ),
    "control": ("tests/control", "-k", "not benchmark_runs"),
    "linkages": ("tests/linkages",),
    "exporters": ("tests/exporters",),
    # Scripts that a test runs in a process of their own run in a fork of this one, where the mutant is.
    "amoro": ("tests/amoro",),
    "cli": ("tests/cli", "tests/grading/test_cli.py"),
    "study": ("tests/study",),
    "grading": tuple(
        f"tests/grading/test_{name}.py" for name in "judge values relations results".split()
    ),
}
# What those that are left by these, and not justified, must pass too: in a process of its own, so that what is made
# at import is made of the mutant.
SLOW = {
    "models": (
        "tests/models/test_accuracy.py",
        "tests/models/test_biglide_accuracy.py",
        "tests/simulation/test_friction.py",
        "--deselect=tests/models/test_accuracy.py::test_oracle",
    ),
    "simulation": ("tests/simulation/test_encoders.py", "tests/estimation/test_replays.py"),
    "singularities": (
        "tests/singularities/test_dexterous.py",
        "tests/singularities/test_inscribed.py",
        "tests/planning/test_keep.py",
        "tests/planning/test_loads.py",
        "tests/singularities/test_aspect_families.py",
        "-k",
        "not nothing_asked",
    ),
    "paths": ("tests/paths/test_timing_by_collocation.py", "tests/cli/test_draw.py"),
    "estimation": (
        "tests/estimation/test_mistakes.py",
        "tests/estimation/test_near_type_2.py",
        "tests/cli/test_identify.py",
    ),
    "optimal_design": (
        "tests/optimal_design/test_figures.py",
        "tests/optimal_design/test_killed.py",
        "tests/cli/test_designing.py",
    ),
    "control": ("tests/control/test_tracker.py",),
    "linkages": ("tests/amoro", "tests/models/test_compiled.py"),
    "exporters": ("tests/cli/test_commands.py",),
}
# Of grading what gives the points: the rest is about processes, files and words.
FILES = {"grading": ["judge.py", "values.py", "relations.py", "results.py", "exercise.py"]}
ARGUMENTS = ["-q", "-p", "no:cacheprovider", "-p", "no:randomly", "--tb=no"]
TABLE = DATA / "mutants.toml"
SHOW_WARNING = warnings._showwarnmsg_impl


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
    function = name.removeprefix("fivebar.").rpartition(":")[0]
    for pattern, gone, come, why in table:
        brings = not come or now.count(come) > was.count(come)
        if fnmatchcase(function, pattern) and was.count(gone) > now.count(gone) and brings:
            return why
    return None


@dataclass
class Mutant:
    """A changed function: its module and name in it, its code, and the lines that stood and stand there."""

    name: str
    module: str
    function: str
    code: CodeType
    was: str
    now: str


def functions_in(code: CodeType) -> dict[str, CodeType]:
    """The functions and methods of a module, by their qualified names, in their order."""
    found = {}
    for each in code.co_consts:
        if isinstance(each, CodeType):
            if each.co_flags & 1:  # it has locals of its own: no class
                found[each.co_qualname] = each
            else:
                found |= functions_in(each)
    return found


def mutant(path: Path, source: str, changed: str, number: int) -> Mutant | None:
    """The mutant of two texts of a module; None where no function's own code is another."""
    before, after = (functions_in(compile(text, path, "exec")) for text in (source, changed))
    function = next((name for name in before if before[name] != after.get(name)), None)
    if function is None or function not in after:
        return None
    old, new = before[function], after[function]
    if (old.co_code, old.co_consts, old.co_names) == (new.co_code, new.co_consts, new.co_names):
        return None  # a default
    module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    shown = list(difflib.unified_diff(source.splitlines(), changed.splitlines(), n=0, lineterm=""))
    was, now = ("\n".join(line[1:] for line in shown[2:] if line[0] == sign) for sign in "-+")
    if without_texts(was) == without_texts(now):
        return None
    return Mutant(f"{module}.{function}:{number}", module, function, new, was, now)


def mutants_of(room: str, files: list[str] | None) -> Iterator[tuple[Path, int, Callable]]:
    """File, number and maker of each mutant of a room."""
    import libcst
    from mutmut.mutation.file_mutation import MutationVisitor, deep_replace
    from mutmut.mutation.mutators import mutation_operators
    from mutmut.mutation.pragma_handling import IgnoredCode

    class Visitor(MutationVisitor):
        def _skip_node_and_children(self, node):
            # Code is changed below what decorates it, which mutmut by itself cannot do.
            decorated = isinstance(node, libcst.FunctionDef) and node.decorators
            return not decorated and super()._skip_node_and_children(node)

    for path in sorted((ROOT / "fivebar" / room).rglob("*.py")):
        if path.name in FILES.get(room, [path.name]) and path.stem in (files or [path.stem]):
            source = path.read_text("utf-8")
            visitor = Visitor(mutation_operators, IgnoredCode(set(), set(), set()))
            module = libcst.MetadataWrapper(libcst.parse_module(source)).visit(visitor)
            for number, each in enumerate(visitor.mutations):
                if each.contained_by_top_level_function:

                    def make(path=path, source=source, module=module, number=number, each=each):
                        changed = deep_replace(module, each.original_node, each.mutated_node).code
                        return mutant(path, source, changed, number)

                    yield path, number, make


def function_of(module: str, name: str):
    """The function itself, below what decorates it."""
    found = importlib.import_module(module)
    for part in name.split("."):
        found = vars(found)[part]
    for inner in ("fget", "func", "__func__", "__wrapped__", "__wrapped__"):
        found = getattr(found, inner, found)
    return found


class Watch:
    """Which tests come to which functions, and what each takes of a processor.

    A test that takes longer than `longest` is left where it is then; 0: never. A test comes to what
    its fixtures come to, also where they were made for an earlier one.
    """

    def __init__(self, longest: float):
        self.longest = longest
        self.reached: set[str] = set()
        self.by_fixture: dict[object, set[str]] = {}
        self.tests: dict[str, tuple[float, list[str]]] = {}
        self.failed: set[str] = set()

    def reach(self, mutants: list[Mutant]) -> None:
        """Let each mutant's function, unchanged else, say that it was called."""
        for each in mutants:
            function = function_of(each.module, each.function)
            tree = ast.parse(Path(function.__code__.co_filename).read_text("utf-8"))
            node = tree
            for part in each.function.split("."):  # the last of a name: others are overloads
                node = next(n for n in node.body[::-1] if getattr(n, "name", None) == part)
            mark = f"{each.module}.{each.function}"
            node.body.insert(0, ast.parse(f"__reach__({mark!r})").body[0])
            code = compile(ast.fix_missing_locations(tree), function.__code__.co_filename, "exec")
            function.__globals__["__reach__"] = self.reached.add
            function.__code__ = functions_in(code)[each.function]

    def pytest_sessionstart(self):
        real = subprocess.run

        def run(command, *places, **names):
            if isinstance(command, list) and command[1:4] == ["-m", "fivebar", "run"]:
                return forked(command, self.reached, *places, **names)
            return real(command, *places, **names)

        subprocess.run = run

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        self.reached.clear()
        start = time.process_time()
        yield
        for definitions in item._fixtureinfo.name2fixturedefs.values():
            for definition in definitions:
                self.reached |= self.by_fixture.get(definition, set())
        self.tests[item.nodeid] = time.process_time() - start, sorted(self.reached)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef):
        before = set(self.reached)
        self.reached.clear()
        yield
        self.by_fixture.setdefault(fixturedef, set()).update(self.reached)
        self.reached |= before

    def pytest_runtest_setup(self):
        """Each test starts with empty caches: what they keep may have been made by another function than the mutant."""
        for module in [
            module for name, module in sys.modules.items() if name.startswith("fivebar.")
        ]:
            for each in vars(module).values():
                if hasattr(each, "cache_clear"):
                    each.cache_clear()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item):
        left = []

        def leave(_, frame):
            while frame and frame.f_code.co_filename != str(item.path):
                frame = frame.f_back
            if frame:  # what is about a test may not be left
                left.append(pytest.skip.Exception("it takes too long"))
                raise left[0]

        signal.signal(signal.SIGPROF, leave)
        signal.setitimer(signal.ITIMER_PROF, self.longest)
        outcome = yield
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        if left and outcome.excinfo:  # which CasADi makes a KeyboardInterrupt
            outcome.force_exception(left[0])

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.failed.add(report.nodeid)


def in_a_child(run: Callable[[], int], seconds: float) -> int | None:
    """The exit code of what runs in a forked process, silently; None where it takes longer than that of a processor."""
    child = os.fork()
    if not child:
        sys.stdout.flush()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(1, 2)
        limit = int(time.process_time() + seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
        try:
            code = int(run())
        finally:
            os._exit(code if "code" in locals() else 99)
    end = time.monotonic() + 20 * seconds + 60
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) if os.WIFEXITED(status) else None
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.05)


def forked(command: list[str], reached: set[str], cwd=None, env=None, **_):
    """What `subprocess.run` gives of `python -m fivebar run ...`, run by a fork of this process."""
    with (
        tempfile.TemporaryFile("w+", encoding="utf-8") as out,
        tempfile.TemporaryFile("w+", encoding="utf-8") as err,
        tempfile.TemporaryFile("w+", encoding="utf-8") as calls,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")  # Python's of threads in a process that forks
        child = os.fork()
        if not child:
            code = 99
            try:
                code = _run_script(command[3:], out, err, cwd, env)
            finally:
                for stream in (sys.stdout, sys.stderr):
                    stream.flush()
                json.dump(sorted(reached), calls)
                calls.flush()
                os._exit(code)
        end = time.monotonic() + 120.0
        while not (done := os.waitpid(child, os.WNOHANG))[0]:
            time.sleep(0.01)
            if time.monotonic() > end:
                os.kill(child, signal.SIGKILL)
        for file in (out, err, calls):
            file.seek(0)
        code = os.waitstatus_to_exitcode(done[1])
        reached.update(json.loads(calls.read() or "[]"))
        return subprocess.CompletedProcess(command, code, out.read(), err.read())


def _run_script(words: list[str], out, err, cwd, env) -> int:
    """The exit code of `fivebar run`, whose script runs in this process in place of another one."""
    from fivebar.amoro.ros_free import child, outputs
    from fivebar.cli import main

    os.dup2(out.fileno(), 1)
    os.dup2(err.fileno(), 2)
    sys.stdout, sys.stderr = (
        open(fd, "w", buffering=1, encoding="utf-8", closefd=False) for fd in (1, 2)
    )
    os.chdir(cwd or os.curdir)
    os.environ.update(env or {})
    outputs.start = Path.cwd()
    warnings.resetwarnings()
    for category in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
        warnings.simplefilter("ignore", category)
    warnings.filterwarnings("default", category=DeprecationWarning, module="__main__")
    warnings._showwarnmsg_impl = SHOW_WARNING

    def here(command, env, pass_fds):
        os.environ.update(env)
        if "matplotlib" in sys.modules and "MPLBACKEND" in env:
            import matplotlib

            matplotlib.rcParams["backend"] = env["MPLBACKEND"]
            matplotlib.use = lambda backend, *, force=True: None
        sys.argv[:] = ["-c", *command[4:]]
        child.main()

    subprocess.Popen = here
    try:
        return main(words)
    except SystemExit as ended:
        return ended.code or 0


def measured(mutants: list[Mutant], arguments: list[str], longest: float) -> dict:
    """Each test's time and the functions that it comes to; without those that fail as it is."""
    file = Path(tempfile.gettempdir()) / f"mutation-{os.getpid()}.json"

    def run():
        watch = Watch(longest)
        watch.reach(mutants)
        code = pytest.main(arguments, plugins=[watch])
        tests = {name: each for name, each in watch.tests.items() if name not in watch.failed}
        file.write_text(json.dumps([tests, sorted(watch.failed)]), "utf-8")
        return code

    code = in_a_child(run, 36000.0)
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"pytest ended with {code} without a mutant")
    tests, failed = json.loads(file.read_text("utf-8"))
    file.unlink()
    if failed:
        print("left out, as they fail without a mutant:", *failed, sep="\n  ")
    return tests


def outcome_of(each: Mutant, tests: dict, seconds: float, longest: float, slow: list[str]) -> str:
    mark = f"{each.module}.{each.function}"
    times = {name: spent for name, (spent, reached) in tests.items() if mark in reached}
    # Of about one time those of a file stay together: their fixtures are made once.
    order = sorted(times, key=lambda name: bisect([0.1, 1.0], times[name]))
    asked, total = [], 0.0
    for name in order:
        total += times[name]
        if total <= seconds or not asked:
            asked.append(name)

    def run(tests):
        function_of(each.module, each.function).__code__ = each.code
        return pytest.main([*ARGUMENTS, "-m", "", "-x", *tests], plugins=[Watch(longest)])

    outcome = "survived" if asked else "no tests"
    for chosen, most in ((asked, 20 + 5 * total), (slow, 1000.0)):
        code = in_a_child(lambda chosen=chosen: run(chosen), most) if chosen else 0
        if code is None:
            return "timeout"
        # A mutant of what ends a script interrupts pytest itself.
        if code in (pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.INTERRUPTED):
            return "killed"
        if code:
            raise RuntimeError(f"pytest ended with {code} on {each.name}: {chosen}")
    return outcome


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m tests.helpers.mutation", description=__doc__.splitlines()[0]
    )
    parser.add_argument("room", choices=ROOMS)
    parser.add_argument("--count", type=int, default=150, help="mutants drawn")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", help="these mutants in place of drawn ones")
    parser.add_argument("--tests", nargs="+", help="these tests in place of the room's")
    parser.add_argument(
        "--files", nargs="+", help="draw from these files of the room, as regions disc"
    )
    parser.add_argument(
        "--fast", action="store_true", help="by the fast tests alone, without deep and slow ones"
    )
    parser.add_argument(
        "--seconds", type=float, default=1e9, help="of tests at most for each mutant, the fastest"
    )
    parser.add_argument(
        "--longest", type=float, default=0.0, help="seconds for one test at most; 0: as it takes"
    )
    options = parser.parse_args()
    every = list(mutants_of(options.room, options.files))
    drawn: list[Mutant] = []
    for path, number, make in random.Random(options.seed).sample(every, len(every)):
        if len(drawn) >= (len(options.only) if options.only else options.count):
            break
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        wanted = options.only or [f"{module}.:{number}"]
        near = any(w.startswith(module) and w.endswith(f":{number}") for w in wanted)
        made = make() if near else None
        if made and (not options.only or made.name in options.only):
            drawn.append(made)
    selection = options.tests or ROOMS[options.room]
    arguments = [*ARGUMENTS, "-m", "not deep" if options.fast else "", *selection]
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    pytest.main([*arguments, "--collect-only", "-qq"])  # all is imported before the first fork
    tests = measured(drawn, arguments, options.longest)
    slow = [] if options.fast else list(SLOW.get(options.room, ()))
    table, found = tomllib.loads(TABLE.read_text("utf-8"))["justified"], Counter()
    for each in drawn:
        why = reason(table, each.name, each.was, each.now)
        outcome = outcome_of(each, tests, options.seconds, options.longest, [] if why else slow)
        print(end=".", file=sys.stderr, flush=True)
        if outcome not in ("killed", "timeout"):
            outcome = "justified" if why else outcome
            print(f"{each.name}: {outcome}{f', {why}' * bool(why)}")
            print(f"- {each.was}\n+ {each.now}", flush=True)
        found[outcome] += 1
    share = sum(found[way] for way in ("killed", "timeout", "justified")) / len(drawn)
    print(
        f"{options.room}: of {len(every)} mutants {len(drawn)} drawn, {share:.1%} killed or justified",
        dict(found),
    )


if __name__ == "__main__":
    main()
