"""Mechanisms in motion: a page that needs no server and no network, the same in a notebook, as GIF
and as a strip.
"""

from .scenes import Scene, scene, strip
from .shows import ITEMS

SHOWS = tuple(ITEMS)

__all__ = ["SHOWS", "Scene", "scene", "strip"]
