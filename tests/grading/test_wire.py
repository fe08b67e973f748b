"""What comes from a worker is read as a stranger's text; what the worker gives up, it gives up."""

import json
import os
import struct
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fivebar.grading.worker import places
from fivebar.grading.worker.cell import filter as system_calls
from fivebar.grading.worker.replies import KINDS, Reply
from fivebar.grading.worker.wire import Garbled, clean, message, reply

PLAIN = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["~", "re", "im", "shape", "data", "type", "text"]), inner, max_size=4
        )
        | st.fixed_dictionaries(
            {"~": st.just("array"), "shape": st.lists(st.integers(-1, 3)), "data": st.lists(inner)}
        )
    ),
)


@pytest.mark.deep
@given(
    st.dictionaries(st.sampled_from(list("nkvtls")), PLAIN),
    st.sampled_from([*KINDS, "ready"]) | PLAIN,
    PLAIN,
)
def test_no_message_breaks_its_reader(data, kind, value):
    line = json.dumps(data | {"n": "right", "k": kind, "v": value}).encode()
    try:
        found = reply(message(line, "right"), ["a", "b"])
    except Garbled:
        return
    assert isinstance(found, Reply) and found.kind == kind and repr(found)


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"[]",
        b"\xff",
        b"[" * 5000,
        b'{"n": "wrong"}',
        b'{"n": "right", "v": ' + b"9" * 5000 + b"}",
    ],
)
def test_lines_that_are_no_messages_are_refused(line):
    with pytest.raises(Garbled):
        message(line, "right")


def test_text_is_made_safe_for_a_terminal():
    assert clean("a\x1b[2J\r\x00\ud800\u202eb\té", 9) == "a\ufffd[2J\ufffd\ufffd\ufffd\ufffd"
    assert clean("é\tb\n") == "é\tb\n"


def outcome(program, machine, number, arguments=(), architecture=None):
    """What a filter program says of a system call: a machine of its five instructions."""
    words = dict(
        enumerate(
            struct.unpack(
                "=16I",
                struct.pack(
                    "=II7Q",
                    number,
                    architecture or machine,
                    0,
                    *[
                        value & 0xFFFFFFFFFFFFFFFF
                        for value in (*arguments, *[0] * (6 - len(arguments)))
                    ],
                ),
            )
        )
    )
    at, word = 0, None
    while True:
        code, yes, no, operand = program[at]
        at += 1
        if code == 0x20:
            word = words[operand // 4]
        elif code == 0x06:
            return {
                0x7FFF0000: "allow",
                0x00050001: "refuse",
                0x00050026: "unknown",
                0x80000000: "kill",
            }[operand]
        else:
            true = {0x15: word == operand, 0x35: word >= operand, 0x45: bool(word & operand)}[code]
            at += yes if true else no


@pytest.mark.parametrize(
    ("machine", "architecture", "numbers"),
    [
        (
            "x86_64",
            0xC000003E,
            {
                "read": 0,
                "mmap": 9,
                "openat": 257,
                "fork": 57,
                "clone": 56,
                "kill": 62,
                "socket": 41,
                "unlink": 87,
                "fcntl": 72,
                "ioctl": 16,
                "prlimit64": 302,
                "open": 2,
                "execve": 59,
            },
        ),
        (
            "aarch64",
            0xC00000B7,
            {
                "read": 63,
                "mmap": 222,
                "openat": 56,
                "clone": 220,
                "kill": 129,
                "socket": 198,
                "unlinkat": 35,
                "fcntl": 25,
                "ioctl": 29,
                "prlimit64": 261,
                "execve": 221,
            },
        ),
    ],
)
def test_the_filter_lets_calculations_through_and_little_else(machine, architecture, numbers):
    program = system_calls.program(machine)

    def says(name, *arguments):
        return outcome(program, architecture, numbers[name], arguments)

    assert {says(n) for n in ("read", "mmap")} == {"allow"}
    assert {
        says(n)
        for n in numbers
        if n in ("fork", "clone", "kill", "socket", "unlink", "unlinkat", "execve")
    } == {"refuse"}
    assert says("openat", -100, 0, os.O_RDONLY | os.O_CLOEXEC) == "allow"
    for flags in (
        os.O_WRONLY,
        os.O_RDWR,
        os.O_CREAT,
        os.O_TRUNC,
        os.O_APPEND | os.O_WRONLY,
        0o20200000,
    ):
        assert says("openat", -100, 0, flags) == "refuse"
    assert says("fcntl", 3, 2) == "allow" and {says("fcntl", 3, c) for c in (8, 10, 15)} == {
        "refuse"
    }
    assert (
        says("ioctl", 0, 0x5401) == "allow" and says("ioctl", 0, 0x5412) == "refuse"
    )  # TIOCSTI types into a terminal
    assert says("prlimit64", 0, 9) == "allow" and says("prlimit64", 1, 9) == "refuse"
    newer = {
        number: outcome(program, architecture, number)
        for number in (425, 435, 436, 437, 439, 447, 500, 10_000)
    }
    assert [number for number, notes in newer.items() if notes == "allow"] == [436, 439]
    assert {notes for notes in newer.values()} == {"allow", "unknown"}
    assert (
        outcome(program, architecture, numbers["read"], architecture=0x40000003) == "kill"
    )  # 32-bit
    assert outcome(program, architecture, 0x40000000) == "unknown"


def test_without_the_filter_the_limit_on_processes_stops_forks():
    program = f"""
import os, sys
sys.path.insert(0, {str(places.CELL)!r})
import filter
filter.install = lambda: False
import confine
report = confine.confine({{
    "paths": [], "memory": 1 << 30, "cpu": 10, "uid": 61_200 if os.getuid() == 0 else None, "moved": False,
    "readable": None, "listable": (), "parent": None,
}})
assert not report["filter"]
try:
    os.fork()
except BlockingIOError:
    print("refused")
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert run.stdout == "refused\n", run.stderr
