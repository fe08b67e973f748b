"""Linked pages: a mechanism drawn beside its plots, in one file for any browser, without a network."""

from .document import write
from .linked import page

__all__ = ["page", "write"]
