"""Pictures with Matplotlib, made with its figure objects, without a window.

Files keep their text as text, in fonts of Type 42, also those of figures of one's own.
"""

from matplotlib import rcParams

from .drawing import drawing
from .graph import aspect_graph
from .maps import singularity_map
from .notebook_style import use_style
from .pose_panels import pose

# Outlines of letters (Type 3) are refused by journals, and cannot be searched. Matplotlib reads
# these when a figure is saved, so no figure can bring them along.
rcParams |= {"pdf.fonttype": 42, "ps.fonttype": 42, "svg.fonttype": "none"}

__all__ = ["aspect_graph", "drawing", "pose", "singularity_map", "use_style"]
