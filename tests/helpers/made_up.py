"""What fuzzing makes up: strange values, calls and files, of a Random alone: some microseconds each.

The Random is Hypothesis's, which can shrink what it drew, or Python's own, where a hundred thousand inputs are wanted.
"""

import io
import re
import struct
import zipfile
from functools import lru_cache

import numpy as np

from .odd_calls import POOL, SYMBOLS

SPECIAL = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    float("nan"),
    float("inf"),
    -float("inf"),
    1e308,
    -1e308,
    5e-324,
    1e-9,
    2.0**53,
]
LETTERS = "aAxyz019 .,;:-_/\\\"'\n\t\0%#é日\ud800\U0001f600\u202e"

WITHOUT_SYMBOLS = [value for value in POOL if not any(value is symbol for symbol in SYMBOLS)]


def a_float(rng):
    kind = rng.randrange(4)
    if kind == 0:
        return rng.choice(SPECIAL)
    if kind == 1:
        return struct.unpack("d", rng.getrandbits(64).to_bytes(8, "little"))[0]
    return rng.uniform(-2, 2)


def a_number(rng):
    kind = rng.randrange(4)
    if kind == 0:
        return rng.choice([0, 1, -1, True, False, None])
    return (
        rng.randint(-(10 ** rng.randrange(1, 25)), 10 ** rng.randrange(1, 25))
        if kind == 1
        else a_float(rng)
    )


def a_text(rng, most=5):
    return "".join(rng.choice(LETTERS) for _ in range(rng.randrange(most + 1)))


def an_array(rng, shape=None):
    """Of usual numbers, and now and then one that is not; now and then as tuples."""
    if shape is None:
        usual = [(2,), (3, 2), (2, 2), tuple(rng.randrange(5) for _ in range(rng.randrange(4)))]
        shape = rng.choice(usual)
    values = np.array([rng.uniform(-2, 2) for _ in range(int(np.prod(shape)))]).reshape(shape)
    if values.size and rng.randrange(2):
        values.flat[rng.randrange(values.size)] = a_float(rng)
    return (
        values
        if rng.randrange(3)
        else tuple(map(tuple, values))
        if values.ndim == 2
        else values.tolist()
    )


def anything(rng, depth=2):
    kind = rng.randrange(5 if depth else 3)
    if kind == 0:
        return a_text(rng)
    if kind == 1:
        return a_number(rng)
    if kind == 2:
        return rng.getrandbits(16).to_bytes(2, "little")
    if kind == 3:
        return [anything(rng, depth - 1) for _ in range(rng.randrange(4))]
    return {a_text(rng, 3): anything(rng, depth - 1) for _ in range(rng.randrange(4))}


def bent(rng, usual):
    """A usual value with its numbers changed a little or much: what a caller means, but wrong in one place."""
    if isinstance(usual, (bool, str)) or usual is None:
        return rng.choice([None, True, False, a_text(rng)])
    if isinstance(usual, (int, float)):
        return rng.choice([usual * rng.uniform(-3, 3), a_float(rng), rng.randint(-5, 5)])
    if (
        isinstance(usual, (tuple, list, np.ndarray))
        and len(np.shape(usual))
        and np.asarray(usual).dtype.kind in "if"
    ):
        return an_array(rng, np.shape(usual))
    return anything(rng)


def call(rng, case):
    """(arguments, those made strange) of a call like the case's."""
    names = rng.sample(list(case.usual), min(len(case.usual), rng.choice([1, 1, 2, 3])))
    arguments = dict(case.usual)
    for name in names:
        options = case.options.get(name)
        kind = rng.randrange(6 if options else 5)
        if kind == 0:
            arguments[name] = bent(rng, case.usual[name])
        elif kind < 4:
            arguments[name] = (a_number, an_array, anything)[kind - 1](rng)
        else:
            arguments[name] = rng.choice(
                options if kind == 5 else POOL if case.symbols else WITHOUT_SYMBOLS
            )
    return arguments, names


# Files

PIECES = [
    b"nan",
    b"-",
    b"1e999",
    b"-1e308",
    b"1e-320",
    b"null",
    b'"',
    b",",
    b";",
    b"[" * 3000,
    b"{}",
    b"[]",
    b'"x"',
    b"9" * 400,
    b"\n",
    b"\0",
    b"\xff",
    b"\xe9",
    b"\xef\xbb\xbf",
    b"#",
    b"<",
    b"&lt;",
    b"NaN",
    b"Infinity",
    b"true",
    b"0x10",
    b"1_000",
    b"\r",
    b"\t",
    b"1,5",
    b"0",
    b"-1",
    b"2.5",
    b"1e9",
    b"99999999999",
    b"[[1]]",
    b'{"a": 1}',
    b"-0.0",
    b"",
]
TOKEN = re.compile(rb'-?\d[\d.]*(?:[eE][-+]?\d+)?|"[^"\n]*"|\w+|[^\w\s]')


@lru_cache(maxsize=256)
def _spans(data):
    """Where words, numbers and signs are in a file; where its lines are."""
    lines = [match.span() for match in re.finditer(rb"[^\n]*\n|[^\n]+", data)]
    return [match.span() for match in TOKEN.finditer(data)], lines


def _piece(rng):
    kind = rng.randrange(6)
    if kind == 0:
        return repr(a_float(rng)).encode()
    return rng.randbytes(rng.randrange(7)) if kind == 1 else rng.choice(PIECES)


def _place(rng, data):
    """A word's, a line's, or any."""
    kind, (tokens, lines) = rng.randrange(8), _spans(data)
    if kind < 6 and tokens:
        return rng.choice(tokens if kind else lines)
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + rng.choice([0, 0, 1, 2, 5, 40]))


def _bent_bytes(rng, data):
    """With words, lines or any bytes dropped, doubled, exchanged for others of the file, or for something strange."""
    new, places = (
        data,
        sorted((_place(rng, data) for _ in range(rng.choice([1, 1, 1, 2, 3, 5]))), reverse=True),
    )
    for start, end in places:  # from the last, which leaves the others where they are
        what = rng.randrange(8)
        first, last = _place(rng, data) if what == 2 else (start, end)
        piece = (
            b""
            if what == 0
            else 2 * data[start:end]
            if what == 1
            else data[first:last]
            if what == 2
            else None
        )
        piece = _piece(rng) if piece is None else piece
        new = new[:start] + piece + new[end:]
    return new


@lru_cache(maxsize=64)
def _members(data):
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return [(each.filename, archive.read(each)) for each in archive.infolist()]


def a_file(rng, right):
    """Bytes: a right file changed in some places, of an archive also in a member; now and then anything."""
    if rng.randrange(40) == 0:
        return rng.randbytes(rng.randrange(61))
    data = rng.choice(right)
    if data[:2] == b"PK" and rng.randrange(4):
        members, out = list(_members(data)), io.BytesIO()
        k = rng.randrange(len(members))
        members[k] = members[k][0], _bent_bytes(rng, members[k][1])
        with zipfile.ZipFile(out, "w") as archive:
            for name, content in members:
                archive.writestr(name, content)
        return out.getvalue()
    return _bent_bytes(rng, data)
