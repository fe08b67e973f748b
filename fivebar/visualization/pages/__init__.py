"""Linked pages: a mechanism drawn beside its plots, in one file for any browser, without a
network.
"""

from .document import Page
from .linked import page

__all__ = ["Page", "page"]
