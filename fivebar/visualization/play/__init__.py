"""The live page: a five-bar and linkages to be dragged, computed in the browser by the models
themselves.
"""

from .live import LivePage, play

__all__ = ["LivePage", "play"]
