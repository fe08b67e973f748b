"""The five-bar parallel robot and the biglide: exact models, singularities, simulation and control.

`import fivebar as fb` loads NumPy and the models; everything else comes with its first use: `fb.simulate`, `fb.aspects`
and the like, and with them CasADi, SciPy, Matplotlib, meshcat and Bokeh where they are needed.
"""

from importlib import import_module

from .errors import SingularityError, UnreachableError
from .models.dynamics import dynamic_model, energy, forward_dynamics, inverse_dynamics
from .models.geometry import Pose, dgm, igm
from .models.kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
from .models.robots import ROBOTS, Biglide, FiveBar
from .singularities.margins import Singularity, singularity, singularity_margins

# Public name -> module. No module has the name of what it gives: as a package's attribute it would hide it.
_LATER = {
    "PD": "control.laws",
    "ComputedTorque": "control.laws",
    "FeedForward": "control.laws",
    "Plan": "planning.plans",
    "PlanError": "planning.problem",
    "Run": "simulation.run",
    "Tracker": "control.tracker",
    "Trajectory": "planning.trajectory",
    "aspect": "singularities.aspects",
    "aspects": "singularities.aspects",
    "check_path": "singularities.path",
    "circle": "planning.trajectory",
    "compare": "simulation.comparison",
    "compile": "models.compiled",
    "crossing_polynomial": "planning.crossing",
    "from_csv": "planning.trajectory",
    "largest_disc": "singularities.disc",
    "largest_rectangle": "singularities.rectangle",
    "line": "planning.trajectory",
    "locus_distance": "singularities.distance",
    "page": "pictures.pages",
    "plan": "planning.plan",
    "polynomial": "planning.trajectory",
    "routes": "singularities.passages",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.many",
    "singularity_loci": "singularities.loci",
    "singularity_map": "singularities.maps",
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
