"""Hypothesis against every public function and every reader: answers or documented errors, and soon.

Short here, and what fails is shrunk; with FIVEBAR_NIGHTLY=1 the same inputs are made by Python's own Random, 100,000 of
each in a row, of slow ones as many as FIVEBAR_NIGHT seconds (60) of the processor allow; another FIVEBAR_SEED makes
others. How many there were, and what came of them, is in the properties of the JUnit report.
"""

import os
import random
import re
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.helpers.made_up import a_file, call
from tests.helpers.odd_calls import Report, TookTooLong, _alarm, _one, _printed
from tests.helpers.odd_cases import CASES
from tests.helpers.once import ONCE, READ
from tests.helpers.readers import COVERS, OWN, readers, reading_functions

NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))
MOST, NIGHT, SEED = (
    100_000,
    float(os.environ.get("FIVEBAR_NIGHT", 60)),
    os.environ.get("FIVEBAR_SEED", ""),
)
SLOW_TO_BEGIN = {
    "plan": 1,
    "Tracker": 2,
    "simulate_many": 3,
}  # examples in the short mode, of a second each
CALM = [
    HealthCheck.too_slow,
    HealthCheck.data_too_large,
    HealthCheck.filter_too_much,
    HealthCheck.large_base_example,
]
HANG = 5.0  # s
FOUND = 5  # of a night's findings, after which there is enough to mend
MEMORY = (
    "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
)  # disks take 5 ms for a file that is written anew


def fuzz(name, made, one, examples, seconds, least):
    """Call one(made(rng)) so often, or as long as its seconds of the processor last: it returns what is wrong, or
    nothing."""
    end, count, failed = time.process_time() + seconds, 0, False

    def over():
        return count >= least and time.process_time() > end

    if NIGHTLY:
        wrong = {}  # by what it is, an input of each
        while count < MOST and len(wrong) < FOUND and not over():
            if what := one(made(random.Random(f"{name} {count} {SEED}"))):
                wrong.setdefault(re.sub(r"\d+", "0", what.partition("\n")[0])[:60], what)
            count += 1
        assert not wrong, "\n".join(wrong.values())
        return

    @settings(max_examples=examples, deadline=None, suppress_health_check=CALM, database=None)
    @given(st.randoms(use_true_random=False).map(made))
    def fuzzed(given):
        nonlocal count, failed
        if failed or not over():  # one that failed is shrunk, however long it takes
            count += 1
            failed = True
            what = one(given)
            assert not what, what
            failed = False

    fuzzed()


def noted(record_property, counts):
    for outcome, of in counts.items():
        record_property(outcome, of)
    if NIGHTLY:  # at once: a night may end early
        print(counts, file=sys.__stderr__, flush=True)


@pytest.mark.deep
@pytest.mark.parametrize("name", CASES)
def test_any_call_is_answered_or_refused(name, tmp_path, monkeypatch, record_property):
    monkeypatch.chdir(tmp_path)
    case, report = CASES[name], Report()
    with tempfile.TemporaryFile(dir=MEMORY) as out:

        def one(arguments):
            report.calls += 1
            _one(case, *arguments, report, out)
            return str(report.wrong.pop()) if report.wrong else ""

        try:
            fuzz(
                name,
                lambda rng: call(rng, case),
                one,
                SLOW_TO_BEGIN.get(name, 25),
                NIGHT if NIGHTLY else 0.15,
                3,
            )
        finally:
            noted(
                record_property,
                {"calls": report.calls, "answered": report.answered, **report.errors},
            )
    assert report.calls > 0


READERS = readers()


def holes(thing, depth=0):
    """Whether a value or what it holds is nan, in places where a reader promises numbers."""
    if isinstance(thing, np.ndarray):
        return thing.dtype.kind == "f" and np.isnan(thing).any()
    if isinstance(thing, float):
        return thing != thing
    if depth < 2 and hasattr(thing, "__dataclass_fields__"):
        return any(
            holes(getattr(thing, name, None), depth + 1) for name in thing.__dataclass_fields__
        )
    return False


# An empty cell, as measured, or judged row by row.
MAY_HOLD_NAN = {
    "Run",
    "from_log",
    "Map",
    "Study",
    "chart",
    "partial",
    "columns",
    "kept result",
    "designs.csv",
    "designs.npz",
    "Sweep.json",
    "Sweep.npz",
    "measured rows",
}


@pytest.mark.deep
@pytest.mark.parametrize("name", READERS)
def test_any_file_is_read_or_refused_with_its_name(name, record_property):
    reader, count = READERS[name], {"read": 0, "refused": 0}

    def read(path, data):
        """What is wrong with what came of it."""
        path.write_bytes(data)
        try:
            with _alarm(HANG):
                found = reader.read(path)
            count["read"] += 1
            return "a silent nan" if name not in MAY_HOLD_NAN and holes(found) else ""
        except reader.errors as error:
            count["refused"] += 1
            return (
                f"the file is not named: {error}"
                if reader.named and path.name not in str(error)
                else ""
            )
        except TookTooLong:
            return f"took longer than {HANG} s"
        except Exception as error:  # to be judged: that is what this is for
            return f"{type(error).__name__}: {error}"

    def fuzzed(folder, out):
        path = Path(folder) / reader.file

        def one(data):
            what = read(path, data)
            notes = os.fstat(out.fileno()).st_size and os.pread(out.fileno(), 300, 0)
            what = what or (f"printed {notes!r}" if notes else "")
            return what and f"{what}\nfrom {data!r}"

        for data in reader.right:
            path.write_bytes(data)
            reader.read(path)
        for data in (*ONCE.get(name, ()), *READ.get(name, ())):
            assert not (what := read(path, data)), f"{what}: {data[:300]!r}"
        assert count["read"] == len(READ.get(name, ())), "what once was found wrong is read now"
        fuzz(name, lambda rng: a_file(rng, reader.right), one, 60, NIGHT if NIGHTLY else 0.7, 20)

    try:
        with (
            tempfile.TemporaryDirectory(dir=MEMORY) as folder,
            tempfile.TemporaryFile(dir=MEMORY) as out,
            _printed(out),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("error")
            fuzzed(folder, out)
    finally:
        noted(record_property, count)
    assert sum(count.values()) >= 20


@pytest.mark.deep
def test_every_function_that_reads_a_file_is_in_a_list():
    own = {function for functions in OWN.values() for function in functions.split()}
    listed = set(COVERS) | own
    assert reading_functions() == listed, (
        "add a reader to tests/helpers/readers.py, or say there why it is none"
    )
    assert set(COVERS.values()) <= set(READERS) and not set(COVERS) & own
