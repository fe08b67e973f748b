"""The live page: a five-bar and linkages to be dragged, computed in the browser by the models
themselves.
"""

from .live import Live, play

__all__ = ["Live", "play"]
