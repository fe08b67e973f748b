"""The world behind a lab script: one robot, stepped by its efforts, with bounds on what cannot end
by itself.
"""

import math
import signal
import threading

import numpy as np

from ...models.geometry import dgm
from ...models.kinematics import dkm
from ...models.robots import Biglide, FiveBar
from ...simulation.plant import Plant
from ...simulation.simulate import TOLERANCE, run_of
from .clock import STEP, real_monotonic, real_sleep
from .states import lab_state

ROBOTS = {"five_bar": FiveBar, "biglide": Biglide}
ROWS = 10  # of a run in each step
MOST_IDLE = 100_000  # calls of data_updated() with nothing new: the next would not be different
# Steps that a script may still make after its KeyboardInterrupt, to bring the motors to rest.
GRACE = 100
# s in which the main thread, which has just begun this one, comes to where it waits for Ctrl-C.
SETTLING = 0.05
MOST_STOPS = 3  # times that a script may swallow `Stopped`

world = None  # of this process; set before the script begins


class Stopped(BaseException):
    """The script was ended by the runtime, as it would not have ended itself; no `except Exception`
    catches it.
    """


class World:
    """until: s of simulated time after which the script gets its KeyboardInterrupt; exact: joint
    accelerations.

    give_up: called in place of a further `Stopped` when the script has swallowed some.
    """

    def __init__(self, until, clock, exact, give_up):
        self.until, self.clock, self.exact, self.give_up = (
            math.ceil(until / STEP - 1e-6),
            clock,
            exact,
            give_up,
        )
        self.kind = self.plant = self.failure = self.motion = None
        self.steps = self.since_reset = self.idle = self.stops = 0
        self.resets = []  # times, s
        self.fresh = self.started = self.interrupted = self.ended = False
        self.last_step = real_monotonic()

    @property
    def time(self):
        """Simulated time since the last reset, s."""
        return self.since_reset / 100

    def make(self, kind):
        """The robot of this name, at rest at its home."""
        if self.kind is not None:
            raise RuntimeError(
                f"Robot({kind!r}): there is a Robot already; fivebar run simulates one in each"
                " script"
            )
        if kind not in ROBOTS:
            raise ValueError(
                f"Robot({kind!r}): no such robot; the known ones are {', '.join(map(repr, ROBOTS))}"
            )
        self.kind = kind
        self._to_home()

    def _to_home(self):
        robot = ROBOTS[self.kind]()
        home = dkm(dgm(robot, (0.0, 0.0)), (0.0, 0.0))
        self.plant, self.efforts = Plant(robot, home, TOLERANCE), []
        self.since_reset, self.fresh, self.failure = 0, True, None
        self.state = lab_state(self.plant, np.zeros(2), None, STEP, self.exact)

    def reset(self):
        """Back to home, at time 0; the clock goes on."""
        self.motion = self.run()
        if self.since_reset:
            self.resets.append(self.steps / 100)
        self._to_home()

    def step(self, efforts):
        """Return one step of the simulation under two efforts; gives them as floats, or None where
        the time is over.
        """
        if self._over():
            return None
        if self.failure is not None:
            raise self.failure
        tau = np.array(
            [_number(value, side, self) for value, side in zip(efforts, ("left", "right"))]
        )
        plant = self.plant
        try:
            plant.advance((self.since_reset + 1) * STEP, tau)
        except ArithmeticError as error:
            self.failure = ArithmeticError(
                f"apply_efforts at t = {self.time:g} s: efforts {tau}"
                f" {plant.robot.words.effort_unit} drive the robot faster than can be followed"
                f" ({error})"
            )
            raise self.failure from None
        self.efforts.append(tau)
        self.since_reset += 1
        self.steps += 1
        self.idle, self.fresh, self.last_step = 0, True, real_monotonic()
        self.state = lab_state(plant, tau, self.state, STEP, self.exact)
        self.clock.tick()
        return tau.tolist()

    def updated(self):
        """Return whether the state is new since the last call."""
        if self._over():
            return False
        if self.fresh and self.started:
            self.fresh = False
            return True
        self.idle += 1
        if self.idle > MOST_IDLE:
            why = f"the last apply_efforts was at t = {self.time:g} s"
            if not self.started:
                why = "start_robot(robot) was never called"
            elif not self.steps:
                why = "the script never called apply_efforts (or start_oscillate)"
            self.stop(f"data_updated() was called {MOST_IDLE} times with no new state: {why}")
        return False

    def _over(self):
        """Return whether the time is over; KeyboardInterrupt, then Stopped, in the main thread,
        where Ctrl-C goes.
        """
        if self.steps < self.until:
            return False
        main = threading.main_thread()
        first, self.interrupted = not self.interrupted, True
        if threading.current_thread() is not main:
            if self.ended:
                raise SystemExit  # there is nobody left who could end this thread
            if first:
                real_sleep(SETTLING)
                signal.pthread_kill(main.ident, signal.SIGINT)
            return True  # until the main thread ends this one, nothing moves
        if first:
            self.idle = 0
            raise KeyboardInterrupt
        if self.steps >= self.until + GRACE:
            self.stop(
                f"the script got its KeyboardInterrupt at {self.until * STEP:g} s of simulated"
                f" time, as from Ctrl-C, and was still stepping {GRACE * STEP:g} s later"
            )
        return False

    def stop(self, why):
        """End the script: by an exception, or where it swallows that, by leaving it."""
        self.stops += 1
        if self.stops > MOST_STOPS:
            self.give_up(f"{why} (and it swallowed the exception that should end it)")
        raise Stopped(why)

    def run(self):
        """Return the Run since the last reset, or if there was no step since, the one before; None
        where there is none.
        """
        if not self.since_reset:
            return self.motion
        t = np.arange(self.since_reset * ROWS + 1) * (STEP / ROWS)
        tau = np.repeat(self.efforts, ROWS, axis=0)
        return run_of(self.plant.robot, t, self.plant.rows(t), tau, plant=self.plant)


def _number(value, side, world):
    """Return an effort as a float: a number, or an array of one."""
    array = np.asarray(value)
    where = f"apply_efforts at t = {world.time:g} s: the {side} effort"
    if array.size != 1 or array.dtype.kind not in "iuf":
        what = f"an array of shape {array.shape}" if array.ndim else repr(value)
        raise TypeError(f"{where} is {what}, not one number")
    number = float(array.reshape(()))
    if not math.isfinite(number):
        raise ValueError(f"{where} is {number}")
    return number
