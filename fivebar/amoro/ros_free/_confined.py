"""The lab's modules in a confined process, where the robot is not: each step is asked of the one
who marks, so that whatever a script does here, its motion is the one that its efforts make.

This file is not imported by fivebar: its text is the program of the confined process, beside those
of `parallel_robot`, `plot_tools` and `rclpy`.
"""

import ast
import sys
import time
from types import ModuleType, SimpleNamespace

import numpy as np

MAKE, STEP, RESET = range(3)
KINDS = ("five_bar", "biglide")
PARTS = "q q_dot q_ddot passive passive_dot passive_ddot xi xi_dot xi_ddot efforts".split()
EPOCH = 1_600_000_000  # s
MOST_IDLE = 100_000  # calls of data_updated() with nothing new


def lab(command, left, right):
    """Return the state after a command, as the one who marks answers it; None: the time is over."""


class World:
    """What `parallel_robot` asks of the simulation."""

    def __init__(self):
        self.started = self.fresh = False
        self.idle, self.steps, self.slept, self.time = 0, 0, 0.0, 0.0

    def make(self, kind):
        if kind not in KINDS:
            raise ValueError(f"Robot({kind!r}): the known ones are {', '.join(KINDS)}")
        self._take(lab(MAKE, KINDS.index(kind), 0))

    def step(self, efforts):
        self._take(lab(STEP, *efforts))
        self.steps += 1
        self.time += 0.01
        return self.state.efforts.tolist()

    def reset(self):
        self._take(lab(RESET, 0, 0))
        self.time = 0.0

    def updated(self):
        if self.fresh and self.started:
            self.fresh, self.idle = False, 0
            return True
        self.idle += 1
        if self.idle > MOST_IDLE:
            raise SystemExit("data_updated() was called again and again with no new state")
        return False

    def _take(self, answer):
        if answer is None:
            raise KeyboardInterrupt
        self.state = SimpleNamespace(**dict(zip(PARTS, np.reshape(answer, (10, 2)))))
        self.fresh = True

    def clock(self):
        return EPOCH + self.steps * 0.01 + self.slept

    def sleep(self, seconds):
        self.slept += seconds


class Silent(ModuleType):
    """Stands for a module of windows and plots: whatever is called, nothing happens."""

    __all__ = ()

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args, **named):
        return self

    def __getitem__(self, key):
        return self

    def __iter__(self):
        return iter((self, self))


def install():
    """Put the lab's modules where a script looks for them."""
    import _lab_parallel_robot
    import _lab_plot_tools

    offered = {"parallel_robot": _lab_parallel_robot, "plot_tools": _lab_plot_tools}
    package = sys.modules["lab_amoro"] = ModuleType("lab_amoro")
    package.__path__ = []
    for name, module in offered.items():
        sys.modules[f"lab_amoro.{name}"] = module
        setattr(package, name, module)
    for name in ("matplotlib", "matplotlib.pyplot", "pyqtgraph", "pyqtgraph.Qt"):
        sys.modules[name] = Silent(name)


def run(source, name, arguments, beside):
    """Run a script as `python3 NAME ARGUMENTS` would; return the error that ended it, or 0.

    beside: the names of the modules in its folder, which it may import as those of a package.
    """
    import _lab_world
    from loading import OwnImports

    world = _lab_world.world = World()
    install()
    module = sys.modules["__main__"] = ModuleType("__main__")
    module.__file__ = name
    sys.argv[:] = [name, *arguments]
    kept = {word: getattr(time, word) for word in ("time", "monotonic", "perf_counter", "sleep")}
    time.time = time.monotonic = time.perf_counter = world.clock
    time.sleep = world.sleep
    try:
        script = OwnImports(beside).visit(ast.parse(source, name))
        exec(compile(script, name, "exec"), vars(module))
    except (KeyboardInterrupt, SystemExit):
        pass  # the time is over, or the script is
    except Exception as error:
        line, frame = 0, error.__traceback__
        while frame is not None:
            line = frame.tb_lineno if frame.tb_frame.f_code.co_filename == name else line
            frame = frame.tb_next
        return f"line {line}: {type(error).__name__}: {error}".removesuffix(": ")
    finally:
        vars(time).update(kept)
    return 0.0
