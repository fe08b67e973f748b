"""Starts a worker process, as isolated as asked, and talks with it against the clock."""

from __future__ import annotations

import json
import os
import secrets
import selectors
import signal
import subprocess
import time
from pathlib import Path

from .launch import launch
from .wire import MOST_LINE, Lost, clean, message

MOST_OUTPUT = 64_000  # bytes kept of what a program prints
START_LIMIT = 20.0  # s, for the interpreter itself
ALIVE = 0.5  # s, after which a silent worker is looked after


class IsolationError(RuntimeError):
    """A worker cannot be isolated as asked; the message says what is missing."""


class KilledError(RuntimeError):
    """A submission's workers were killed again and again, and not by anything of its own: it cannot
    be judged.
    """


class SandboxWorker:
    """One worker process; ended by `close`, with all that it started."""

    def __init__(self, isolate: str, memory: int, cpu: int, packages: tuple[str, ...] = ()):
        self.nonce = secrets.token_hex(8)
        self.output = ""
        self._buffer = bytearray()
        self._room = MOST_OUTPUT
        request, self._out = os.pipe()
        self._in, reply = os.pipe()
        settings = {"read": request, "write": reply, "n": self.nonce, "memory": memory, "cpu": cpu}
        try:
            self._process, self._first = launch(isolate, settings, packages)
        except OSError as error:
            os.close(self._out)
            os.close(self._in)
            raise IsolationError(f"a worker process cannot be started: {error}") from None
        finally:
            os.close(request)
            os.close(reply)
        self._open, self._wrapped, self._cpu, self._begin = (
            True,
            isolate == "bwrap",
            cpu,
            time.monotonic(),
        )
        self._selector = selectors.DefaultSelector()
        output = self._process.stdout
        assert output is not None  # launch makes a pipe of it
        self._output = output
        self._text = output.fileno()
        for descriptor in (self._in, self._text):
            os.set_blocking(descriptor, False)
            self._selector.register(descriptor, selectors.EVENT_READ)
        os.set_blocking(self._out, False)

    def confined(self) -> dict:
        """Return its report before anything of the student's has run. Raises IsolationError, or
        Lost where it was killed.
        """
        try:
            report = self.receive(self.nonce, START_LIMIT)
        except Lost as lost:
            self.close()
            if lost.outside:
                raise
            raise IsolationError(
                f"the worker process did not start: {self.output.strip() or lost}"
            ) from None
        if report["k"] != "ready":
            self.close()
            raise IsolationError(f"the worker process cannot be confined: {clean(report['t'])}")
        return report

    def send(self, data: dict, limit: float) -> None:
        """Send a message, while it reads what the worker writes meanwhile. Raises Lost."""
        line = memoryview(json.dumps(data).encode() + b"\n")
        end = time.monotonic() + limit
        self._selector.register(self._out, selectors.EVENT_WRITE)
        try:
            while line:
                ready = self._ready(end)
                if self._in in ready and not self._fill():
                    raise self._end()
                if self._out in ready:
                    line = line[os.write(self._out, line[: 1 << 16]) :]
        except BrokenPipeError:
            raise self._end() from None
        finally:
            self._selector.unregister(self._out)

    def receive(self, nonce: str, limit: float) -> dict:
        """Return the next message, which must carry the nonce. Raises Lost."""
        end = time.monotonic() + limit
        while (stop := self._buffer.find(b"\n")) < 0:
            if self._in in self._ready(end) and not self._fill():
                raise self._end()
        line = bytes(self._buffer[:stop])
        del self._buffer[: stop + 1]
        return message(line, nonce)

    def _ready(self, end):
        """Return descriptors ready before the time `end`; what the program prints is kept aside.
        Raises Lost.
        """
        ready = set()
        while not ready:
            left = end - time.monotonic()
            if left <= 0:
                raise Lost("timeout")
            ready = {key.fd for key, _ in self._selector.select(min(left, ALIVE))}
            if not ready and self._process.poll() is not None:
                # And yet a pipe is open: bubblewrap was killed before its own child could follow.
                raise self._end()
        if self._text in ready:
            self._drain()
        return ready

    def _fill(self):
        piece = os.read(self._in, 1 << 16)
        self._buffer += piece
        if len(self._buffer) > 2 * MOST_LINE:
            raise Lost("flood", f"more than {MOST_LINE} bytes")
        return piece

    def _drain(self):
        """Keep the first of what the program printed; whether there may be more."""
        try:
            piece = os.read(self._text, 1 << 16)
        except BlockingIOError:
            return False
        if not piece:
            if self._text in self._selector.get_map():
                self._selector.unregister(self._text)
            return False
        kept = clean(piece[: self._room].decode(errors="replace"), MOST_OUTPUT)
        self._room -= len(piece[: self._room])
        self.output += kept
        return True

    def _end(self):
        """Return why the pipe is closed."""
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            return Lost("garbled", "closed the pipe of its answers")
        number = -code if code < 0 else code - 128  # bwrap gives 128 + signal
        if number == signal.SIGXCPU:
            return Lost("timeout", "its time on the processor is used up")
        # Nothing in the worker can send a signal, and no program uses more time on the processor
        # than has passed.
        if number == signal.SIGKILL and time.monotonic() - self._begin < self._cpu:
            return Lost("killed", "from outside: was the machine out of memory?", outside=True)
        if number in (
            signal.SIGSEGV,
            signal.SIGBUS,
            signal.SIGABRT,
            signal.SIGKILL,
            signal.SIGILL,
            signal.SIGFPE,
        ):
            return Lost("killed", f"signal {number} ({signal.strsignal(number)})")
        return Lost("exit", f"ended the process with status {code}")

    def close(self) -> None:
        """Kill the process and its group, waits for the end of all who held its pipes, and cleans
        up.
        """
        if not self._open:
            return
        try:
            if self._first is None:
                os.killpg(self._process.pid, signal.SIGKILL)
            else:  # with it all in its PID namespace end, and then bwrap itself
                signal.pidfd_send_signal(self._first, signal.SIGKILL)
        except ProcessLookupError:
            pass  # ended by itself
        if self._first is not None:
            os.close(self._first)
        elif self._wrapped:
            self._kill_orphan()
        self._process.wait()
        os.close(self._out)
        end = time.monotonic() + 2.0
        try:
            while self._in not in self._ready(end) or self._fill():
                self._buffer.clear()
            while self._drain():
                pass
        except Lost:
            pass
        self._selector.close()
        os.close(self._in)
        self._output.close()
        self._open = False

    def _kill_orphan(self):
        """End what a bubblewrap killed at its start has left: it has this worker's key on its
        command line.
        """
        for place in Path("/proc").glob("[0-9]*"):
            try:
                if self.nonce.encode() in (place / "cmdline").read_bytes():
                    os.kill(int(place.name), signal.SIGKILL)
            except OSError:
                continue  # it has ended, or is none of ours
