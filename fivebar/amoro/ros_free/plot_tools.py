"""The lab's `lab_amoro.plot_tools` in our words: scopes that keep what they are given, for a
picture at the end.
"""

import numpy as np

__all__ = ["QtGui", "Scope", "np"]

scopes: list = []


class Scope:
    """Two curves over time; min_y, max_y: the limits of the lab's axis, widened where a curve
    leaves them.
    """

    def __init__(self, title, min_y, max_y):
        self.title, self.limits = str(title), (float(min_y), float(max_y))
        self.points = []
        scopes.append(self)

    def update(self, time, y1, y2):
        """Add a point to both curves."""
        try:
            self.points.append((float(time), *(float(np.asarray(y).reshape(())) for y in (y1, y2))))
        except (TypeError, ValueError):
            raise TypeError(
                f"Scope {self.title!r}: update needs three numbers, not {time!r}, {y1!r}, {y2!r}"
            ) from None


class QtGui:
    """Of the windows' toolkit, what the lab's scripts call."""

    class QApplication:
        def __init__(self, argv):
            pass

        def exec_(self):
            """No window waits for its user."""
            return 0

        @staticmethod
        def processEvents():
            """No window has events."""
