"""The five-bar parallel robot and the biglide: exact models, singularities, simulation and control.

`import fivebar as fb` loads NumPy and the models; everything else comes with its first use: `fb.simulate`, `fb.aspects`
and the like, and with them CasADi, SciPy, Matplotlib, meshcat and Bokeh where they are needed.
"""

from importlib import import_module

from .dynamics import dynamic_model, energy, forward_dynamics, inverse_dynamics
from .errors import SingularityError, UnreachableError
from .geometry import Pose, dgm, igm
from .kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
from .robots import ROBOTS, Biglide, FiveBar
from .singularity import Singularity, singularity, singularity_margins

# Public name -> module. No module has the name of what it gives: as a package's attribute it would hide it.
_LATER = {
    "PD": "control",
    "ComputedTorque": "control",
    "FeedForward": "control",
    "Plan": "plans",
    "PlanError": "plans",
    "Run": "run",
    "Tracker": "tracker",
    "Trajectory": "trajectory",
    "aspect": "singularity_free",
    "aspects": "singularity_free",
    "check_path": "path_check",
    "circle": "trajectory",
    "compare": "comparison",
    "compile": "engine",
    "crossing_polynomial": "planner",
    "from_csv": "trajectory",
    "largest_disc": "inscribed",
    "largest_rectangle": "rectangles",
    "line": "trajectory",
    "locus_distance": "nearest_locus",
    "page": "pages",
    "plan": "planner",
    "polynomial": "trajectory",
    "simulate": "simulation",
    "simulate_many": "closed_loop",
    "singularity_loci": "loci",
    "singularity_map": "maps",
}


_PARTS = ("amoro", "grading", "linkages", "pages", "plot", "study", "view")


def __getattr__(name):
    if name in _PARTS:
        return import_module(f".{name}", __name__)
    if name not in _LATER:
        raise AttributeError(f"module 'fivebar' has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f".{_LATER[name]}", __name__), name)
    return value


def __dir__():
    return sorted([*globals(), *_LATER, *_PARTS])
