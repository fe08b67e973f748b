"""Hostile programs earn nothing and break nothing, in either kind of isolation."""

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import fivebar
from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import Submission

from ..helpers.attacks import ATTACKS, SELF_HARM
from ..helpers.processes import descendants

HONEST = "def double(x):\n    return 2 * x\n"


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A folder that all may write to, with the secret in a file, and in the environment; checked afterwards."""
    secret = random.random() + 1
    monkeypatch.setenv("SECRET", repr(secret))
    (tmp_path / "secrets.txt").write_text(repr(secret), encoding="utf-8")
    (tmp_path / "results.json").write_text('{"score": 0}', encoding="utf-8")
    for folder in (tmp_path, *tmp_path.parents[:3]):
        folder.chmod(folder.stat().st_mode | 0o005)
    tmp_path.chmod(0o777)
    for file in tmp_path.iterdir():
        file.chmod(0o666)
    yield Scene(tmp_path, secret)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["results.json", "secrets.txt"]
    assert (tmp_path / "results.json").read_text("utf-8") == '{"score": 0}'
    assert (tmp_path / "secrets.txt").read_text("utf-8") == repr(secret)


class Scene:
    def __init__(self, folder, secret):
        self.folder, self.secret = folder, secret
        self.mark = f"left-{os.getpid()}-{random.randrange(10**9)}"

    def source(self, code):
        for word, text in {
            "GRADER": os.getpid(),
            "FOLDER": self.folder,
            "SECRETS": self.folder / "secrets.txt",
            "PACKAGE": fivebar.__file__,
            "MARK": self.mark,
        }.items():
            code = code.replace(word, str(text))
        return HONEST + code

    def left_behind(self):
        return [
            p
            for folder in ("/tmp", "/var/tmp", "/dev/shm")
            for p in Path(folder).glob(f"{self.mark}*")
        ]


def processes(nonces):
    """Living processes with one of the nonces on their command line, which children inherit."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            line, state = (
                (place / "cmdline").read_bytes(),
                (place / "stat").read_text("utf-8").rpartition(")")[2].split()[0],
            )
        except OSError:
            continue
        if state != "Z" and any(nonce.encode() in line for nonce in nonces):
            found.append(place.name)
    return found


def workers(monkeypatch):
    """Every worker that will be started."""
    from fivebar.grading.worker import student

    started, kind = [], student.SandboxWorker
    monkeypatch.setattr(
        student, "SandboxWorker", lambda *a: started.append(kind(*a)) or started[-1]
    )
    return started


def numbers(value):
    """All numbers in a value, however deep."""
    if isinstance(value, list):
        return [n for part in value for n in numbers(part)]
    if isinstance(value, np.ndarray):
        return [n for part in value.ravel().tolist() for n in numbers(part)]
    return [value] if isinstance(value, int | float | complex) else []


@pytest.mark.every(5)
@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_earns_nothing_and_breaks_nothing(name, isolate, scene, monkeypatch):
    code, kinds, limit = ATTACKS[name]
    started = workers(monkeypatch)
    before, others = set(os.listdir("/proc/self/fd")), set(descendants(os.getpid()))
    with Student(Submission("evil.py", scene.source(code)), isolate, memory=400_000_000) as student:
        assert student.trouble is None or name == "patched json", student.trouble
        reply = student.ask("evil", [(1.25,)], limit=limit)[0]
        later = student.ask("double", [(1.5,)], limit=5)[0]
    assert reply.kind in kinds, reply
    assert scene.secret * 1.25 not in numbers(reply.value) and scene.secret not in numbers(
        reply.value
    )
    assert reply.kind == "exception" or repr(scene.secret) not in f"{reply}{student.output}"
    assert later.value == 3.0 or name in SELF_HARM, later
    assert (
        reply.text.isprintable()
        and student.output.replace("\n", "").replace("\t", "").isprintable()
    )
    assert (
        len(reply.text) <= 500
        and len(repr(reply.value)) < 200_000
        and len(student.output) <= 64_000
    )
    assert not processes([worker.nonce for worker in started])
    assert not scene.left_behind()
    assert set(os.listdir("/proc/self/fd")) <= before and set(descendants(os.getpid())) <= others


def test_what_reads_only_finds_nothing(isolate, scene):
    """Attacks that return lists return them empty, and the values are what they claim to be and no more."""
    for name, empty in (("modules", []), ("own environment", []), ("inherited descriptors", 0)):
        with Student(Submission("evil.py", scene.source(ATTACKS[name][0])), isolate) as student:
            assert student.ask("evil", [(1.0,)])[0].value == empty, name
    with Student(
        Submission("evil.py", scene.source(ATTACKS["always pleased"][0])), isolate
    ) as student:
        assert type(came := student.ask("evil", [(1.0,)])[0].value) is float and came == 0.0
    for name in ("an endless generator", "a class of a strange name"):
        with Student(Submission("evil.py", scene.source(ATTACKS[name][0])), isolate) as student:
            assert student.ask("evil", [(1.0,)])[0].value["~"] == "other"


@pytest.mark.parametrize(
    "code", ["import os\nos._exit(0)\n", "while True: pass\n", "import sys\nsys.exit()\n"]
)
def test_a_file_that_ends_or_hangs_on_import_is_still_graded(code, isolate, monkeypatch):
    monkeypatch.setattr("fivebar.grading.worker.student.LOAD_LIMIT", 1.0)
    source = f"a = 1\n{code}def double(x): return 2 * x\n"
    with Student(Submission("evil.py", source), isolate) as student:
        assert student.ask("double", [(1.5,)])[0].value == 3.0
        assert student.trouble.kind == "import" and student.trouble.source == code.splitlines()[-1]


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "code",
    [
        "(" * 100_000,
        "x = " + "-" * 50_000 + "1",
        "def double(x): return 2 * x\n" + "a" * 900_000 + ".b" * 40_000,
        "x = 0\n" * 100_000,
        "\0",
        'import os, sys\nfor n in range(3, 60):\n    try: os.write(n, b"[" * 10)\n    except OSError: pass\n',
        "import sys\nsys.modules.clear()",
        "del __builtins__\n__name__ = None",
        "import builtins\nfor n in list(vars(builtins)): delattr(builtins, n)",
    ],
    ids=range(9),
)
def test_a_file_that_breaks_its_reader_breaks_only_itself(code, isolate, monkeypatch):
    started = workers(monkeypatch)
    monkeypatch.setattr("fivebar.grading.worker.student.LOAD_LIMIT", 1.0)
    with Student(Submission("evil.py", code), isolate, memory=400_000_000) as student:
        reply = student.ask("igm", [(1.0,)])[0]
    assert reply.kind in ("import", "missing", "garbled", "exit", "exception")
    assert not processes([worker.nonce for worker in started])


DEEP = []
for _ in range(150):
    DEEP = [DEEP]
FORGED = [
    {"k": "loaded", "names": [1, {}, "x" * 9999, "\x1b"], "trouble": None},
    {"k": "loaded", "names": {}, "trouble": []},
    {"k": "loaded", "names": [], "trouble": {"k": "value", "v": {"~": "array"}}},
    {"k": "loaded", "names": [], "trouble": {"k": "exception", "t": "x" * 9999, "l": -(10**30)}},
    {"k": "loaded", "names": [], "trouble": {"k": 5, "l": {}}},
    {"k": "at", "i": "all", "l": 1e300},
    {"k": "at", "i": 10**300, "l": True},
    {"k": "missing", "absent": [{"a": "\x1b"}] * 1000},
    {"k": "value", "s": float("nan")},
    {"k": "value", "s": -1, "v": 1},
    {"k": "value", "s": 0, "v": {"~": "array", "shape": [10**9, 0, 10**9], "data": []}},
    {"k": "value", "s": 0, "v": {"~": "array", "shape": [True, 1.5], "data": [1]}},
    {"k": "value", "s": 0, "v": {"~": "array", "shape": [10**6] * 5 + [0], "data": []}},
    {"k": "value", "s": 0, "v": {"~": ["array"], "re": None}},
    {
        "k": "value",
        "s": 0,
        "v": {"~": "array", "shape": [2], "data": [{"~": "array", "shape": [1], "data": [1]}, 2]},
    },
    {"k": "value", "s": 0, "v": {"~": "other", "type": DEEP, "text": ""}},
    {"k": "missing", "absent": [DEEP, "a"]},
    {"k": "at", "i": 0, "l": DEEP},
    {"k": ["value"], "s": 0},
    {"k": "ready", "uid": 0},
]


@pytest.mark.deep
@pytest.mark.parametrize("where", ["import", "call"])
def test_forged_messages_are_only_claims(where):
    """Each in the place of the worker's own, with the right nonce, at import or in a call."""
    for forged in FORGED:
        code = f"""
import json, os, sys
def forge():
    frame = sys._getframe()
    while "sink" not in frame.f_locals:
        frame = frame.f_back
    nan = float("nan")
    nonce, message = frame.f_locals["nonce"], {forged!r}
    os.write(frame.f_locals["sink"], (json.dumps(message | {{"n": nonce}}) + "\\n").encode())
def evil(x):
    forge()
    os._exit(0)
{"forge()" if where == "import" else ""}
"""
        with Student(Submission("evil.py", HONEST + code), limit=5) as student:
            replies = student.ask("evil", [(1.0,), (2.0,)])
            assert len(replies) == 2 and len(repr(replies)) < 4000
            assert all(type(reply.kind) is str and reply.text.isprintable() for reply in replies)
            later = student.ask("double", [(1.5,)])[0]
            assert later.value == 3.0 or where == "import", (forged, later)
            assert all(name.isprintable() for name in student.names)
            assert student.trouble is None or (
                where == "import" and len(student.trouble.text) <= 600
            )


def test_a_function_cannot_go_missing_between_two_answers():
    code = """
import json, os, sys
def evil(x):
    frame = sys._getframe()
    while "sink" not in frame.f_locals:
        frame = frame.f_back
    if x == 2:
        os.write(frame.f_locals["sink"], b'{"n": "%s", "k": "missing"}\\n' % frame.f_locals["nonce"].encode())
    return x
"""
    with Student(Submission("evil.py", HONEST + code)) as student:
        replies = student.ask("evil", [(1.0,), (2.0,), (3.0,)])
    assert [reply.kind for reply in replies] == ["value", "missing", "value"]


def test_two_asks_are_never_mixed_up(isolate):
    """Lines left over by one ask carry its nonce: the next ask does not take them for answers."""
    code = HONEST + ATTACKS["left-over lines"][0]
    with Student(Submission("evil.py", code), isolate) as student:
        student.ask("evil", [(1.0,)])
        replies = student.ask("double", [(float(i),) for i in range(5)])
        assert [r.value for r in replies] == [0.0, 2.0, 4.0, 6.0, 8.0]


@pytest.mark.every(2)
def test_a_grader_that_is_killed_leaves_no_worker_and_no_file(isolate, tmp_path):
    program = (
        "from fivebar.grading.worker.student import Student\nfrom fivebar.grading.worker.submission import Submission\n"
        f"student = Student(Submission('a.py', 'import time\\ndef f(): time.sleep(1000)'), {isolate!r}, limit=1000)\n"
        "print(student._worker.nonce, flush=True)\nstudent.ask('f', [()])\n"
    )
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=environment
    ) as grader:
        nonce = grader.stdout.readline().strip()
        alive = processes([nonce])
        grader.kill()
    assert alive
    end = time.monotonic() + 60
    while processes([nonce]) and time.monotonic() < end:
        time.sleep(0.02)
    assert not processes([nonce])
    assert list(tmp_path.iterdir()) == []
