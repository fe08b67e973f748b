"""`fivebar.pages` is `fivebar.pictures.pages`."""

import sys

from .pictures import pages

sys.modules[__name__] = pages
