"""Hypothesis against every public function and every reader: answers or documented errors, and soon.

Short here; with FIVEBAR_NIGHTLY=1 100,000 inputs each, of slow ones as many as FIVEBAR_NIGHT seconds (60) allow. How
many there were, and what came of them, is in the properties of the JUnit report.
"""

import os
import tempfile
import time
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from tests.helpers.odd_calls import POOL, SYMBOLS, Report, _alarm, _one, _printed
from tests.helpers.odd_cases import CASES
from tests.helpers.readers import COVERS, OWN, readers, reading_functions

NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))
MOST, NIGHT, HANG = (100_000, float(os.environ.get("FIVEBAR_NIGHT", 60)), 5.0) if NIGHTLY else (25, 0.15, 5.0)
SLOW_TO_BEGIN = {"plan": 1, "Tracker": 2, "simulate_many": 3}  # examples in the short mode, of a second each
CALM = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much, HealthCheck.large_base_example]


def calm(count):
    return settings(max_examples=count, deadline=None, suppress_health_check=CALM, database=None)


class Budget:
    """Its seconds are over: the inputs left are passed over, but for those that shrink one which failed."""

    def __init__(self, seconds, least):
        self.end, self.least, self.calls, self.failed = time.perf_counter() + seconds, least, 0, False

    def over(self):
        return not self.failed and self.calls >= self.least and time.perf_counter() > self.end

    @contextmanager
    def one(self):
        self.calls += 1
        try:
            yield
        except BaseException:
            self.failed = True
            raise


# Functions

NUMBERS = st.one_of(st.floats(), st.floats(-2, 2), st.integers(), st.sampled_from([0, 1, -1, True, None]))
ARRAYS = st.one_of(
    arrays(float, array_shapes(min_dims=0, max_dims=3, max_side=4), elements=st.floats(-2, 2)),
    arrays(float, st.sampled_from([(2,), (3, 2), (2, 2)]), elements=st.floats()),
    st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), max_size=4),
)
OTHERS = st.recursive(
    st.one_of(NUMBERS, st.text(max_size=5), st.binary(max_size=4)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=3), inner, max_size=3)),
    max_leaves=5,
)


def one_of(values):
    """One of some values, of which CasADi's can neither be compared nor hashed."""
    return st.integers(0, len(values) - 1).map(values.__getitem__)


def bent(usual):
    """A usual value with its numbers changed a little or much: what a caller means, but wrong in one place."""
    if isinstance(usual, (bool, str)) or usual is None:
        return st.one_of(st.none(), st.booleans(), st.text(max_size=5))
    if isinstance(usual, (int, float)):
        return st.one_of(st.floats(-3, 3).map(lambda k: usual * k), st.floats(), st.integers(-5, 5))
    if isinstance(usual, (tuple, list, np.ndarray)) and len(np.shape(usual)) and np.asarray(usual).dtype.kind in "if":
        return arrays(float, np.shape(usual), elements=st.one_of(st.floats(-1, 1), st.floats()))
    return OTHERS


@st.composite
def calls(draw, case):
    """(arguments, those made strange)."""
    names = draw(st.lists(st.sampled_from(list(case.usual)), min_size=1, max_size=3, unique=True))
    arguments = dict(case.usual)
    pool = [value for value in POOL if case.symbols or not any(value is symbol for symbol in SYMBOLS)]
    for name in names:
        kinds = [bent(case.usual[name]), NUMBERS, ARRAYS, OTHERS, one_of(pool)]
        arguments[name] = draw(st.one_of(*kinds, *(one_of(of) for of in [case.options.get(name)] if of)))
    return arguments, names


@pytest.mark.parametrize("name", CASES)
def test_any_call_is_answered_or_refused(name, tmp_path, monkeypatch, record_property):
    monkeypatch.chdir(tmp_path)
    case, budget, report = CASES[name], Budget(NIGHT, 3), Report()

    @calm(MOST if NIGHTLY else SLOW_TO_BEGIN.get(name, MOST))
    @given(calls(case))
    def fuzzed(call):
        if budget.over():
            return
        with budget.one(), tempfile.TemporaryFile() as out:
            _one(case, *call, report, out)
            assert not report.wrong, report.wrong.pop()

    fuzzed()
    record_property("calls", budget.calls)
    record_property("answered", report.answered)
    assert budget.calls > 0


# Readers

READERS = readers()
PIECES = [
    b"nan", b"-", b"1e999", b"-1e308", b"null", b'"', b",", b";", b"[" * 3000, b"{}", b"9" * 400, b"\n", b"\0", b"\xff",
    b"\xe9", b"\xef\xbb\xbf", b"#", b"<", b"&lt;", b"NaN", b"Infinity", b"true", b"0x10", b"1_000", b"\r", b"\t",
    b"1,5",
]  # fmt: skip
BITS = st.one_of(st.sampled_from(PIECES), st.binary(max_size=6), st.floats().map(lambda x: repr(x).encode()))


@st.composite
def files(draw, reader):
    """Bytes: a right file with some places changed, parts dropped or doubled; now and then anything."""
    data = draw(st.sampled_from(reader.right))
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(data)))
        to = min(len(data), at + draw(st.sampled_from([0, 0, 1, 2, 5, 40])))
        kind = draw(st.integers(0, 9))
        data = data[:at] + (b"" if kind == 0 else 2 * data[at:to] if kind == 1 else draw(BITS)) + data[to:]
    return draw(st.binary(max_size=60)) if draw(st.integers(0, 14)) == 0 else data


def holes(thing, depth=0):
    """Whether a value or what it holds is nan, in places where a reader promises numbers."""
    if isinstance(thing, np.ndarray):
        return thing.dtype.kind == "f" and np.isnan(thing).any()
    if isinstance(thing, float):
        return thing != thing
    if depth < 2 and hasattr(thing, "__dataclass_fields__"):
        return any(holes(getattr(thing, name, None), depth + 1) for name in thing.__dataclass_fields__)
    return False


# An empty cell, as measured, or judged row by row.
MAY_HOLD_NAN = {"Run", "Map", "Study", "chart", "partial", "columns", "kept result", "designs.csv", "designs.npz"}


@pytest.mark.parametrize("name", READERS)
def test_any_file_is_read_or_refused_with_its_name(name, record_property):
    reader, count = READERS[name], {"read": 0, "refused": 0}
    budget = Budget(NIGHT if NIGHTLY else 0.7, 20)

    @calm(MOST if NIGHTLY else 60)
    @given(files(reader))
    def fuzzed(data):
        if budget.over():
            return
        with budget.one(), tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as out:
            path = Path(folder) / reader.file
            path.write_bytes(data)
            with _printed(out), warnings.catch_warnings(), _alarm(HANG), np.errstate(all="ignore"):
                warnings.simplefilter("error")
                try:
                    found = reader.read(path)
                    count["read"] += 1
                    assert name in MAY_HOLD_NAN or not holes(found), "a silent nan"
                except reader.errors as error:
                    count["refused"] += 1
                    assert not reader.named or path.name in str(error), f"the file is not named: {error}"
            assert os.fstat(out.fileno()).st_size == 0, os.pread(out.fileno(), 300, 0)

    for data in reader.right:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / reader.file).write_bytes(data)
            reader.read(Path(folder) / reader.file)
    fuzzed()
    for outcome, of in count.items():
        record_property(outcome, of)
    assert sum(count.values()) >= 20


def test_every_function_that_reads_a_file_is_in_a_list():
    own = {function for functions in OWN.values() for function in functions.split()}
    listed = set(COVERS) | own
    assert reading_functions() == listed, "add a reader to tests/helpers/readers.py, or say there why it is none"
    assert set(COVERS.values()) <= set(READERS) and not set(COVERS) & own
