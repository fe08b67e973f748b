"""Pictures with Matplotlib, made with its figure objects: no global state, no window."""

from .drawing import drawing
from .graph import aspect_graph
from .maps import singularity_map
from .notebook_style import use_style
from .pose_panels import pose

__all__ = ["aspect_graph", "drawing", "pose", "singularity_map", "use_style"]
