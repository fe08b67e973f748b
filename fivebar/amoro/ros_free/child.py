"""The child process of `fivebar run`: the script as `python3 script.py` would run it, on the
simulated robot.
"""

import _thread
import json
import linecache
import os
import random
import signal
import sys
import threading
from pathlib import Path
from types import ModuleType

import casadi  # noqa: F401  so that its import is not the script's time
import numpy as np

from ...base import old_numpy
from . import lenient, names, outputs, report
from . import world as place
from .clock import RealClock, SimulatedClock, real_monotonic, real_sleep
from .explain import explanation
from .tracebacks import last_place, print_exception
from .world import Stopped, World

WATCH = 0.2  # s between two looks at a script that may hang
LAST_GRACE = 5.0  # s for a hanging script to leave


def main():
    """sys.argv: [..., options as JSON, script, its arguments]."""
    options = json.loads(sys.argv[1])
    path, *rest = sys.argv[2:]
    for_data = os.dup(1) if options["json"] else None
    if for_data is not None:
        os.dup2(2, 1)  # what the script prints is not data
    with_names(options, path)
    code = Session(options, path, rest, for_data).run()
    sys.stdout.flush()
    sys.exit(code)


def with_names(options, path):
    """The lab's module names, the outputs' names, the random numbers and, if asked for, older
    NumPy.
    """
    outputs.folder, outputs.stem = outputs.start / options["plots"], Path(path).stem
    names.install()
    if not options["show"]:
        sys.meta_path.insert(0, names.KeepBackend())
    random.seed(options["seed"])
    np.random.seed(options["seed"])
    if options["lenient"]:
        lenient.install()
        report.say("lenient: arrays of one element pass for numbers, as they did in an older NumPy")


class Session:
    """One script on one world."""

    def __init__(self, options, path, rest, for_data):
        self.options, self.path, self.rest, self.for_data = options, path, rest, for_data
        self.file, self.folder = os.path.join(os.getcwd(), path), Path(path).resolve().parent
        clock = RealClock() if options["real_time"] else SimulatedClock()
        self.world = place.world = World(
            options["until"], clock, options["exact_acceleration"], self.give_up
        )
        self.hanging, self.done = None, False

    def run(self):
        """Return the script, then the report; gives the exit code."""
        signal.signal(signal.SIGINT, self._on_interrupt)
        self.world.clock.install()
        if not self.options["show"]:  # an open window waits for its user
            threading.Thread(target=self._watch, daemon=True).start()
        self.started = real_monotonic()
        code = self._script()
        self.world.ended = True
        self.wall = real_monotonic() - self.started
        self.done = True
        return self._report(code) or code

    def _script(self):
        try:
            exec(self._code(), self._main_module().__dict__)
            for thread in threading.enumerate():  # Python too waits for the script's own
                if not thread.daemon and thread is not threading.main_thread():
                    thread.join()
        except SystemExit as error:
            if error.code is None or isinstance(error.code, int):
                return error.code or 0
            print(error.code, file=sys.stderr)
            return 1
        except Stopped as stopped:
            report.say(f"ended: {stopped}", *self._place(stopped))
            return 1
        except KeyboardInterrupt as interrupt:
            if self.world.interrupted:
                return 0  # ours, and the script leaves it to Python
            print_exception(interrupt)
            return 130
        except BaseException as error:
            sys.stdout.flush()
            self._explain(error)
            return 1
        return 0

    def _code(self):
        source = Path(self.file).read_bytes()
        if self.options["lenient"]:
            return old_numpy.compiled(source, self.file)
        return compile(source, self.file, "exec", dont_inherit=True)

    def _main_module(self):
        sys.argv[:] = [self.path, *self.rest]
        sys.path.insert(0, str(self.folder))
        module = ModuleType("__main__")
        module.__file__, module.__builtins__ = self.file, sys.modules["builtins"]
        sys.modules["__main__"] = module
        return module

    def _explain(self, error):
        print_exception(error)
        place = last_place(error)
        if place is not None:
            lines = explanation(error, *place)
            if lines:
                report.say(*self._place(error), *lines)

    def _place(self, error):
        """Return where the script was, in words."""
        place = last_place(error)
        if place is None:
            return []
        frame, line = place
        file = frame.f_code.co_filename
        return [f"at {Path(file).name}, line {line}: {linecache.getline(file, line).strip()}"]

    def _report(self, code):
        """Write and print what there is; 1 where something could not be written."""
        os.chdir(outputs.start)
        run, failed = self.world.run(), 0
        try:
            if report.drawn():
                self._scopes()
            if "matplotlib.pyplot" in sys.modules and not self.options["show"]:
                from .figures import close_all

                close_all()
            report.write_files(run, self.options)
        except (OSError, ValueError) as error:
            report.say(str(error))
            failed = 1
        about = report.figures(self.world, run, self.wall) | {"exit_code": failed or code}
        if self.for_data is None:
            report.print_words(about)
        else:
            with os.fdopen(self.for_data, "w") as stream:
                report.print_json(about, stream)
        return failed

    def _scopes(self):
        if self.options["show"]:
            import matplotlib.pyplot as plt

            report.draw_scopes(plt.figure)
            plt.show()
        else:
            from matplotlib.figure import Figure

            report.draw_scopes(Figure).savefig(outputs.picture("scopes"))

    def give_up(self, why):
        """Leave a script that cannot be left otherwise."""
        self.done, self.wall = True, real_monotonic() - self.started
        report.say(f"ended: {why}")
        self._report(1)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(1)

    def _on_interrupt(self, signum, frame):
        if self.hanging:
            raise Stopped(self.hanging)
        raise KeyboardInterrupt

    def _watch(self):
        """In a thread of its own: interrupt a script that does not step for too long."""
        limit = self.options["timeout"]
        while not self.done:
            real_sleep(WATCH)
            if real_monotonic() - self.world.last_step < limit:
                continue
            never = "" if self.world.steps else "; it never called apply_efforts"
            self.hanging = (
                f"the script did not step for {limit:g} s of wall time (--timeout){never}"
            )
            _thread.interrupt_main()
            real_sleep(LAST_GRACE)
            if not self.done:
                self.give_up(self.hanging)
