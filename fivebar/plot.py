"""`fivebar.plot` is `fivebar.pictures.plot`."""

import sys

from .pictures import plot

sys.modules[__name__] = plot
