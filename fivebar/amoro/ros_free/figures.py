"""A Matplotlib backend without windows: what a window would have shown is written to a file when it
closes.

Drawing in a loop costs nothing, as nobody looks: a figure is drawn once, for its file. Animations
run, on the script's clock, while a window would wait for its user.
"""

import math
import sys
import time

from matplotlib.backend_bases import CloseEvent, FigureManagerBase, TimerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

from . import outputs
from . import world as place

MOST_FRAMES = (
    2000  # without a step of the robot: then the user has seen enough, and closes the windows
)

shown = 0
timers: dict = {}  # those that run, and when they are due, s


class FigureManager(FigureManagerBase):
    """A window in name: open from its first `show` until it is closed."""

    is_open = False

    def show(self):
        self.is_open = True

    def destroy(self):
        global shown
        if self.is_open:
            self.is_open = False
            shown += 1
            self.canvas.figure.savefig(outputs.picture(f"figure_{shown}"))
            self.canvas.callbacks.process("close_event", CloseEvent("close_event", self.canvas))

    @classmethod
    def pyplot_show(cls, *, block=None):
        """A blocking `show` ends when the user has closed all windows, so it closes them."""
        from matplotlib import _pylab_helpers, is_interactive

        for manager in _pylab_helpers.Gcf.get_all_fig_managers():
            manager.show()
        if block or (block is None and not is_interactive()):
            _run_timers(math.inf)
            _pylab_helpers.Gcf.destroy_all()


class Timer(TimerBase):
    """Of an animation, or the script's own."""

    def _timer_start(self):
        timers[self] = time.monotonic() + self.interval / 1e3
        for callback, *_ in self.callbacks:
            animation = getattr(callback, "__self__", None)
            if hasattr(animation, "_repeat"):
                animation._repeat = False  # who has seen it once closes the window

    def _timer_stop(self):
        timers.pop(self, None)


class FigureCanvas(FigureCanvasAgg):
    manager_class = FigureManager
    _timer_cls = Timer
    is_started = False

    def draw(self):
        """Left to the file's own drawing, which does not come here."""

    def draw_idle(self):
        """The same."""

    def buffer_rgba(self):
        """Return the picture itself, for scripts that make films of it."""
        if not self.is_saving():
            super().draw()
        return super().buffer_rgba()

    def flush_events(self):
        """No window has events."""

    def start_event_loop(self, timeout=0):
        """`plt.pause`: nothing happens but what the timers do."""
        _run_timers(time.monotonic() + max(timeout, 0))


def _run_timers(end):
    """What happens in open windows up to this time, s, or until no timer runs."""
    from matplotlib import _pylab_helpers

    if "matplotlib.animation" in sys.modules:  # each starts with the first drawing of its figure
        for manager in _pylab_helpers.Gcf.get_all_fig_managers():
            if not manager.canvas.is_started:
                manager.canvas.is_started = True
                FigureCanvasAgg.draw(manager.canvas)
    steps, frames = place.world.steps, 0
    while timers and frames < MOST_FRAMES:
        timer = min(timers, key=timers.get)
        if timers[timer] > end:
            break
        time.sleep(max(timers[timer] - time.monotonic(), 0))
        if timer.single_shot:
            timer.stop()
        try:
            timer._on_timer()
        except BaseException:  # Ctrl-C above all: it ends the animations, not only this wait
            timers.clear()
            raise
        if timer in timers:
            timers[timer] += timer.interval / 1e3
        steps, frames = place.world.steps, frames + 1 if steps == place.world.steps else 0
    if end < math.inf:
        time.sleep(max(end - time.monotonic(), 0))


def close_all():
    """Write what is still open at the end of the script."""
    from matplotlib import _pylab_helpers, is_interactive

    for manager in _pylab_helpers.Gcf.get_all_fig_managers():
        manager.is_open |= is_interactive()
    _pylab_helpers.Gcf.destroy_all()
