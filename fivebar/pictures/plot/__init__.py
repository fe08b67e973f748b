"""Pictures with Matplotlib, made with its figure objects: no global state, no window."""

from .maps import singularity_map
from .pose_panels import pose

__all__ = ["pose", "singularity_map"]
