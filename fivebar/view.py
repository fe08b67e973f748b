"""`fivebar.view` is `fivebar.pictures.view`."""

import sys

from .pictures import view

sys.modules[__name__] = view
