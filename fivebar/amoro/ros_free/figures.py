"""A Matplotlib backend without windows: what a window would have shown is written to a file when it closes.

Drawing in a loop costs nothing, as nobody looks: a figure is drawn once, for its file.
"""

import time

from matplotlib.backend_bases import FigureManagerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

from . import outputs

shown = 0


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

    @classmethod
    def pyplot_show(cls, *, block=None):
        """A blocking `show` ends when the user has closed all windows, so it closes them."""
        from matplotlib import _pylab_helpers, is_interactive

        for manager in _pylab_helpers.Gcf.get_all_fig_managers():
            manager.show()
        if block or (block is None and not is_interactive()):
            _pylab_helpers.Gcf.destroy_all()


class FigureCanvas(FigureCanvasAgg):
    manager_class = FigureManager

    def draw(self):
        """Left to the file's own drawing, which does not come here."""

    def draw_idle(self):
        """The same."""

    def flush_events(self):
        """No window has events."""

    def start_event_loop(self, timeout=0):
        """`plt.pause`: only the time passes."""
        time.sleep(max(timeout, 0))


def close_all():
    """Write what is still open at the end of the script."""
    from matplotlib import _pylab_helpers, is_interactive

    for manager in _pylab_helpers.Gcf.get_all_fig_managers():
        manager.is_open |= is_interactive()
    _pylab_helpers.Gcf.destroy_all()
