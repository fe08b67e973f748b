"""A student's program in a process of its own: ask it one function with many rows, get one Reply
for each.
"""

from __future__ import annotations

import os
import re
import secrets
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from inspect import getsource
from math import isfinite

import numpy as np

from ...base import old_numpy
from .cell.stand_in import ARRAYS
from .places import bwrap_trouble
from .replies import KINDS, Reply
from .sandbox import MOST_OUTPUT, IsolationError, KilledError, SandboxWorker
from .submission import Submission
from .wire import Change, Garbled, Lost, clean, outlined, place, reply, told, value, whole

MOST_LOSSES = 3  # workers that a file may cost until it is loaded
MOST_KILLED = 5  # workers of a submission that something else may kill
MOST_NAMES = 1000  # of functions listed
# In limits for one call: what all asks of a submission may take together, with what it loads.
MOST_CALLS = 60
LIMIT = 2.0  # s, for one call
LATE = 0.5  # s, by which a call may end later: a worker that does not end it itself is killed
LOAD_LIMIT = 10.0  # s, for the whole file: SciPy may come from a slow disk


@dataclass(frozen=True)
class Tried:
    """Changes of a program to be tried: of each row that is asked, the numbers of its changes in
    the list for this function and wave, None for no list.

    apart: functions that are not changed; made: the steps in which it is changed before, as in
    `cell.changes.Trials`; watched: whether the values of all places are shown instead, with, of
    each row, the place whose visits are told, and (place, the numbers of its visits) for those in
    which others are put.
    """

    function: str
    apart: tuple[str, ...]
    wave: int | None = None
    made: tuple = ()
    watched: bool = False
    numbers: list[list] = field(default_factory=list)


class Student:
    """A submission's functions, called in a worker process. A context manager.

    isolate: "process" (limits, a system-call filter, an unprivileged user under root) or "bwrap"
    (also hides the disk and the network); limit: seconds for one call; total: for one `ask`;
    memory: bytes; modules: name -> source of those beside the file that it may import; packages:
    that it may import beside NumPy and SciPy. `names`: the functions found; `outline`: as
    `outlined` returns it; `constants`: the numbers to which the file itself gives a name;
    `form`: in which right functions give vectors and matrices, of `stand_in.FORMS`;
    `trouble`: Reply of the first statement that failed when the file was run, or None; `output`:
    what it printed; `notes`: sentences for the one who grades. The thread that asks must outlive
    the worker: it dies with it (Linux). Raises IsolationError where the
    worker cannot be isolated so, and, whatever is asked, KilledError where something else kills it
    again and again.
    """

    def __init__(
        self,
        submission: Submission,
        isolate: str = "process",
        limit: float = LIMIT,
        total: float = 20.0,
        memory: int = 1 << 30,
        cpu: int = 60,
        modules: dict[str, str] | None = None,
        packages: tuple[str, ...] = (),
    ):
        if isolate not in ("process", "bwrap"):
            raise ValueError(f'isolate is "process" or "bwrap", not {isolate!r}')
        if sys.platform == "win32":
            raise IsolationError(
                "a student's program can be confined on Linux and macOS only: on Windows use WSL"
            )
        if isolate == "bwrap" and bwrap_trouble():
            raise IsolationError(f"bwrap cannot isolate a worker here: {bwrap_trouble()}")
        self._submission, self._isolate = submission, isolate
        self._limit, self._total, self._memory, self._cpu = limit, total, memory, cpu
        self._lines = submission.source.split("\n")
        self._modules = modules or {}
        self._packages = packages
        self._skip: list = []
        self._killed = 0
        # SymPy takes seconds to load, and Matplotlib makes its list of fonts anew each time.
        self._load_limit = LOAD_LIMIT * (3 if packages else 1)
        self._budget = MOST_LOSSES * self._load_limit + MOST_CALLS * limit
        self._worker = None
        self._hopeless = False
        self.form = ARRAYS
        self._output = ""
        self.names = ()
        self.constants: dict = {}
        self.outline: dict = {}
        self.changes: list[Change] = []
        self._tried: Tried | None = None
        self.count = 0  # of changes
        self.trouble = None
        self.notes = ()
        self.mended: list[Reply] = []
        self._load()
        if self.trouble is not None and old_numpy.refused(self.trouble.text):
            self._mend(self.trouble)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def output(self) -> str:
        """What the program printed, from its start, capped."""
        return self._output + (self._worker.output if self._worker else "")

    def close(self) -> None:
        """End the worker process."""
        if self._worker is not None:
            self._worker.close()
            self._output = self.output[:MOST_OUTPUT]
            self._worker = None

    def ask(
        self,
        function: str,
        rows: list,
        constants: dict | None = None,
        limit: float | None = None,
        given: dict[str, Callable] | None = None,
        tried: Tried | None = None,
    ) -> list[Reply]:
        """Return a Reply for each row of `function(*row)`; the rest is not asked where the time for
        all is over.

        constants: other values for names in `constants`, with which the file is run anew; limit:
            seconds for one call.
        given: name -> right(row), which stands in for the program's own function, as in `StandIn`;
        for good, so that nothing else should be asked of this Student.
        tried: the changes of the file with which the rows are asked; `count` is then how many there
        are, and `changes` holds those asked, in the order of their numbers, if they are few.
        What only today's NumPy refuses is asked again as it ran before; `mended` holds the first
        refusal.
        """
        self._tried = tried
        replies = self._ask(function, rows, constants, limit, given or {})
        refused = [
            reply
            for reply in replies
            if reply.kind == "exception" and old_numpy.refused(reply.text)
        ]
        # What a change that is tried makes of an array is no sign of an old file.
        is_its_own = not tried or not (tried.made or any(tried.numbers))
        if refused and is_its_own and not self.mended:
            self._mend(refused[0])
            return self._ask(function, rows, constants, limit, given or {})
        return replies

    def _ask(self, function, rows, constants, limit, given):
        rows = [list(map(_number, row)) for row in rows]
        constants = {name: _number(part) for name, part in (constants or {}).items()}
        limit = limit or self._limit
        replies, left = [], self._total
        while len(replies) < len(rows):
            if min(self._budget, left) <= 0:
                late = Reply("unasked", text="the calls before it took all of the time")
                return replies + [late] * (len(rows) - len(replies))
            if self._worker is None and not self._hopeless:
                self._load()
            if self._worker is None:
                return replies + [self.trouble] * (len(rows) - len(replies))
            start, used, done = time.monotonic(), self._used, len(replies)
            self._used = True
            try:
                self._batch(
                    function, rows[len(replies) :], constants, limit, start + left, replies, given
                )
                if any(answer.kind == "memory" for answer in replies):
                    self.close()  # what filled it may still be there
                break
            except Lost as end:
                if end.outside:
                    self._count_killed()
                    continue
                lost = Reply(end.kind, text=end.text or f"no answer within {limit:g} s")
            finally:
                self._budget -= time.monotonic() - start
            left -= time.monotonic() - start
            self.close()
            # An earlier ask may have broken the worker: this one gets one of its own.
            again = used and len(replies) == done and lost.kind != "timeout"
            if left > 0 and not again:
                replies.append(lost)
        return replies

    def _mend(self, refused):
        """Run the file once more, as it ran with the NumPy of its year."""
        self.mended.append(refused)
        self.trouble, self._skip = None, []
        self.close()
        self._load()

    def _batch(self, function, rows, constants, limit, end, replies, given):
        """Append a Reply per row as they come, until the time `end`. Raises Lost."""
        nonce, tried = secrets.token_hex(8), self._tried
        request = {
            "n": nonce,
            "function": function,
            "rows": rows,
            "constants": constants,
            "given": [*given],
            # A call that waits for right answers must not be ended while it reads one.
            "limit": 0 if given else limit,
            "form": self.form,
            "tried": tried and vars(tried) | {"numbers": tried.numbers[len(replies) :]},
        }
        self._worker.send(request, limit)
        data = self._worker.receive(
            nonce, min(self._load_limit if constants else limit, end - time.monotonic())
        )
        if data.get("k") == "missing":
            replies += [self._missing(function, data.get("absent"))] * len(rows)
            return
        if tried:
            self.changes, self.count = told(data.get("changes")), whole(data.get("count"))
        for _ in rows:
            until = min(time.monotonic() + limit + LATE, end)
            while (data := self._worker.receive(nonce, until - time.monotonic())).get(
                "k"
            ) == "asks":
                self._worker.send(_answer(data, given), limit)
            replies.append(reply(data, self._lines))

    def _missing(self, function, absent):
        if absent and isinstance(absent, list):
            names = ", ".join(name for name in absent if isinstance(name, str))
            return Reply("missing", text=clean(f"the file has no constant {names}"))
        if self.trouble is not None and re.search(rf"\b{function}\b", self._submission.source):
            return replace(self.trouble, kind="import")
        alike = next((name for name in self.names if _bare(name) == _bare(function)), "")
        return Reply(
            "missing",
            text=f"no function {function}" + (f": is your {alike} meant?" if alike else ""),
        )

    def _count_killed(self):
        """Close what is left of a worker that something else killed. Raises KilledError at the last
        of many.
        """
        self.close()
        self._killed += 1
        if self._killed == MOST_KILLED:
            raise KilledError(
                f"something killed its process {MOST_KILLED} times: where memory is short, grade"
                " fewer at a time"
            )

    def _load(self):
        """Start a new worker with the student's file run in it, as far as it goes."""
        losses = 0
        while losses < MOST_LOSSES:
            self._used, at = False, None
            self._worker = SandboxWorker(self._isolate, self._memory, self._cpu, self._packages)
            start = time.monotonic()
            try:
                self._note(self._worker.confined())
                start = time.monotonic()
                end = start + self._load_limit
                nonce = secrets.token_hex(8)
                request = {"n": nonce, "source": self._submission.source, "skip": self._skip}
                request["old_numpy"] = getsource(old_numpy) if self.mended else ""
                request |= {
                    "notebook": self._submission.kind == "notebook",
                    "modules": self._modules,
                }
                self._worker.send(request, self._load_limit)
                while (data := self._worker.receive(nonce, end - time.monotonic())).get(
                    "k"
                ) == "at":
                    at = data
                self._loaded(data)
                return
            except Lost as lost:
                if lost.outside:
                    self._count_killed()
                    continue
                losses += 1
                text = lost.text or f"not done within {self._load_limit:g} s"
                text = f"{KINDS[lost.kind]}: {text}"
                line, source = place(at and at.get("l"), self._lines)
                self.trouble = self.trouble or Reply("import", None, text, line, source)
                self.close()
                if at is None or type(at.get("i")) is not int:
                    break
                self._skip.append(at["i"])
            finally:
                self._budget -= time.monotonic() - start
        self._hopeless = True

    def _loaded(self, data):
        names, numbers, trouble = data.get("names"), data.get("numbers"), data.get("trouble")
        whole = (
            isinstance(names, list)
            and isinstance(numbers, dict)
            and isinstance(trouble, dict | None)
        )
        if data.get("k") != "loaded" or not whole:
            raise Garbled("a message that is not the end of the file")
        self.outline = outlined(data.get("outline"))
        self.names = tuple(clean(name) for name in names[:MOST_NAMES] if isinstance(name, str))
        self.constants = {
            name: n
            for name, n in list(numbers.items())[:MOST_NAMES]
            if type(n) is float and isfinite(n)
        }
        if trouble is not None and self.trouble is None:
            found = reply(trouble, self._lines)
            self.trouble = replace(found, kind="import", text=found.text or KINDS[found.kind])

    def _note(self, report):
        notes = []
        if report["uid"] != os.getuid():
            notes.append(f"running as root: the student's program runs as user {report['uid']}")
        if self._isolate == "process" and not report["filter"]:
            notes.append(
                "the kernel cannot filter system calls (seccomp): files and signals are not"
                " protected"
            )
        if self._isolate == "process" and not report["landlock"]:
            notes.append(
                "the kernel cannot hide files (Landlock): the student's program reads what its user"
                " can read"
            )
        self.notes = tuple(notes)


def _bare(name):
    """Return a name without what is easily mistyped: dgmPassive and dgm_passive are alike."""
    return name.replace("_", "").lower()


def _answer(data, given):
    """Return what a right function answers to a question of the program's. Raises Garbled."""
    name, row = data.get("f"), value(data.get("row"))
    if not isinstance(name, str) or name not in given or not isinstance(row, list):
        raise Garbled("a question that cannot be answered")
    return given[name](row)


def _number(part):
    """Return a value that JSON can hold, of a NumPy one."""
    return part.tolist() if isinstance(part, np.generic | np.ndarray) else part
