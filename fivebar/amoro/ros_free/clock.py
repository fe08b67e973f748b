"""The script's clock: simulated time in place of the computer's, so that a run is the same whenever
it is made.
"""

import sys
import time
from functools import cache
from pathlib import Path

from .tracebacks import STANDARD

EPOCH = 1_600_000_000  # s; any fixed one
STEP = 0.01  # s of simulated time in each call of apply_efforts

real_monotonic, real_sleep = time.monotonic, time.sleep


class SimulatedClock:
    """Simulated time plus what the script slept. It stands still while the script computes."""

    def __init__(self):
        self.steps, self.slept = 0, 0.0

    def elapsed(self):
        return self.steps * 10_000_000 + round(1e9 * self.slept)

    def tick(self):
        self.steps += 1

    def sleep(self, seconds):
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        self.slept += seconds

    def install(self):
        """Put it behind the functions of `time`, before the script can import them."""
        time.time = lambda: EPOCH + self.elapsed() / 1e9
        time.time_ns = lambda: EPOCH * 1_000_000_000 + self.elapsed()
        time.perf_counter, time.perf_counter_ns = lambda: self.elapsed() / 1e9, self.elapsed
        time.monotonic_ns = self.elapsed
        # In Python's own modules these two wait for other threads and processes, which take real
        # time.
        time.monotonic = lambda: (
            real_monotonic() if _waits(sys._getframe(1)) else self.elapsed() / 1e9
        )
        time.sleep = lambda seconds: (real_sleep if _waits(sys._getframe(1)) else self.sleep)(
            seconds
        )


def _waits(frame):
    """Return whether this frame is of Python's own library."""
    return _is_pythons(frame.f_code.co_filename)


@cache
def _is_pythons(file):
    path = Path(file).resolve()
    return STANDARD in path.parents and "site-packages" not in path.parts


class RealClock:
    """The computer's own clock; each step ends no earlier than its 10 ms are over."""

    def __init__(self):
        self.due = None

    def tick(self):
        now = real_monotonic()
        self.due = now + STEP if self.due is None else max(self.due + STEP, now - STEP)
        if self.due > now:
            real_sleep(self.due - now)

    def install(self):
        """Nothing to put anywhere."""
