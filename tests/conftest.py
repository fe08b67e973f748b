"""What several test files draw from: the source's reference numbers, robots and poses."""

import gc
import json
import os
import signal
import sys
import zlib
from collections import Counter
from contextlib import suppress
from importlib import import_module

# One test runs on each core: threads of the linear algebra would only wait for each other.
# Before NumPy is imported in the processes that run the tests, which inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")  # PyTorch's
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")  # JAX's

import hypothesis
import numpy as np
import pytest

import fivebar as fb
from tests.helpers import DATA, ROOT
from tests.helpers.needs import lacking, need

# What collecting makes, it keeps: to look through it for garbage again and again took a third of its time.
gc.disable()

# A job in the background ignores Ctrl-C, and so would every program that a test starts and interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)
CLOCKED = [hypothesis.HealthCheck.too_slow]  # a busy machine is no fault of a test's
EXAMPLES = 1000 if os.environ.get("FIVEBAR_NIGHTLY") else 25
hypothesis.settings.register_profile(
    "fivebar", deadline=None, max_examples=EXAMPLES, derandomize=True, suppress_health_check=CLOCKED
)
hypothesis.settings.load_profile("fivebar")

UNEQUAL = fb.FiveBar(l11=0.11, l12=0.14, l21=0.08, l22=0.12, d=0.09, zz1=0.003, zz2=0.0015, m=0.7)


@pytest.fixture(autouse=True, scope="session")
def cache_folder_of_the_tests(tmp_path_factory):
    """A cache of the tests' own: what they check is no try of whoever runs them."""
    if "FIVEBAR_CACHE" not in os.environ:
        os.environ["FIVEBAR_CACHE"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def five_bar_numbers():
    return json.loads((DATA / "five_bar.json").read_text("utf-8"))


@pytest.fixture(params=["amoro", "unequal"])
def robot(request):
    return {"amoro": fb.FiveBar(), "unequal": UNEQUAL}[request.param]


@pytest.fixture
def reachable(robot):
    """(xi, working) of 500 poses of `robot` with a sine of at least 0.05 everywhere, all working modes."""
    rng = np.random.default_rng(7)
    xi = rng.uniform(-0.25, 0.25, (6000, 2))
    working = rng.choice([-1, 1], (6000, 2))
    pose = fb.igm(robot, xi, working, unreachable="nan")
    good = (np.abs(np.stack([*pose.sines, pose.det_A])) > 0.05).all(axis=0)
    return xi[good][:500], working[good][:500]


@pytest.fixture
def compiler(tmp_path, monkeypatch):
    """A C compiler, with a cache of its own."""
    need("a C compiler")
    monkeypatch.setenv("FIVEBAR_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture(params=["process", "bwrap"])
def isolate(request):
    """Both ways to confine a student's program."""
    if request.param == "bwrap":
        need("bubblewrap")
    return request.param


def pytest_addoption(parser):
    parser.addoption(
        "--deep-part", default="1/1", metavar="K/N", help="the Kth of N parts of the deep tests"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session):
    """Of the whole suite, let each worker begin to import at another file.

    In a new clone pytest has to rewrite the asserts of every file: each worker then finds rewritten what the others began
    with. A file that cannot be imported is left to be reported when it is collected.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    if not worker or sys.dont_write_bytecode or "tests" not in session.config.args:
        return
    files = sorted((ROOT / "tests").rglob("test_*.py"))
    begin = int(worker) * len(files) // int(os.environ["PYTEST_XDIST_WORKER_COUNT"])
    for file in files[begin:] + files[:begin]:
        with suppress(Exception, pytest.skip.Exception):
            import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Of a test that is marked every(n), each nth case runs by default; the others are deep.

    The parts of the deep tests are drawn by their names: a new test moves no other one.
    """
    counts = Counter()
    part, parts = map(int, config.getoption("--deep-part").split("/"))
    here, elsewhere = [], []
    for item in items:
        every = item.get_closest_marker("every")
        if every:
            if counts[item.function] % every.args[0]:
                item.add_marker("deep")
            counts[item.function] += 1
        is_deep = item.get_closest_marker("deep")
        its_part = zlib.crc32(item.nodeid.encode()) % parts + 1
        (elsewhere if is_deep and its_part != part else here).append(item)
    config.hook.pytest_deselected(items=elsewhere)
    items[:] = here


def pytest_collection_finish():
    """From here on there is garbage, but not among what was collected; and less often than Python looks for it."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


def pytest_terminal_summary(terminalreporter):
    stats = terminalreporter.stats
    lines = list(
        lacking(report for kind in ("skipped", "failed", "error") for report in stats.get(kind, ()))
    )
    if lines:
        terminalreporter.section("not on this machine")
        for line in lines:
            terminalreporter.line(line)
