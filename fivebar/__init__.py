"""The five-bar parallel robot and the biglide: exact models, singularities, simulation and control.

`import fivebar as fb` loads NumPy and the models; everything else comes with its first use: `fb.simulate`, `fb.aspects`
and the like, and with them CasADi, SciPy, Matplotlib, meshcat and Bokeh where they are needed.
"""

import typing as _typing
from importlib import import_module as _import_module

from .errors import SingularityError, UnreachableError
from .models.dynamics import dynamic_model, energy, forward_dynamics, gravity_torques, inverse_dynamics
from .models.geometry import Pose, dgm, igm
from .models.kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
from .models.links import Link
from .models.loads import friction_torques, potential
from .models.named_robots import ROBOTS
from .models.robots import Biglide, FiveBar
from .singularities.margins import Singularity, singularity, singularity_margins

# Public name -> module. No module has the name of what it gives: as a package's attribute it would hide it.
_LATER = {
    "Bars": "singularities.bars",
    "Calibration": "measured.calibration",
    "ComputedTorque": "control.laws",
    "FeedForward": "control.laws",
    "Identification": "measured.identified",
    "Keep": "singularities.keep",
    "PD": "control.laws",
    "Path": "paths.curve",
    "Placement": "paths.placement",
    "Plan": "planning.plans",
    "PlanError": "planning.problem",
    "Run": "simulation.run",
    "TimedPath": "paths.timed_path",
    "TimingError": "paths.timing",
    "Tracker": "control.tracker",
    "Trajectory": "planning.trajectory",
    "aspect": "singularities.aspects",
    "aspects": "singularities.aspects",
    "calibrate": "measured.calibrate",
    "certify": "paths.certify",
    "check_path": "singularities.path",
    "circle": "planning.trajectory",
    "compare": "simulation.comparison",
    "compile": "models.compiled",
    "crossing_polynomial": "planning.crossing",
    "design": "designing.optimum",
    "dexterous": "singularities.dexterous",
    "exciting_trajectory": "measured.exciting",
    "export": "exporting.export",
    "from_csv": "planning.samples",
    "identify": "measured.identification",
    "largest_disc": "singularities.disc",
    "largest_rectangle": "singularities.rectangle",
    "line": "planning.trajectory",
    "locus_distance": "singularities.distance",
    "measurement_poses": "measured.poses",
    "page": "pictures.pages",
    "path": "paths.read",
    "place": "paths.place",
    "plan": "planning.plan",
    "play": "pictures.play",
    "polynomial": "planning.trajectory",
    "repeatability": "measured.repeatability",
    "routes": "singularities.passages",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.many",
    "singularity_loci": "singularities.loci",
    "singularity_map": "singularities.maps",
    "sweep": "designing.sweeping",
    "time_path": "paths.timing",
    "tip_error": "measured.tip_error",
}


_PARTS = ("amoro", "designing", "grading", "linkages", "pages", "plot", "study", "view")


if _typing.TYPE_CHECKING:  # the same, to a type checker
    from . import amoro, designing, grading, linkages, study
    from .control.laws import PD, ComputedTorque, FeedForward
    from .control.tracker import Tracker
    from .designing.optimum import design
    from .designing.sweeping import sweep
    from .exporting.export import export
    from .measured.calibrate import calibrate
    from .measured.calibration import Calibration
    from .measured.exciting import exciting_trajectory
    from .measured.identification import identify
    from .measured.identified import Identification
    from .measured.poses import measurement_poses
    from .measured.repeatability import repeatability
    from .measured.tip_error import tip_error
    from .models.compiled import compile
    from .paths.certify import certify
    from .paths.curve import Path
    from .paths.place import place
    from .paths.placement import Placement
    from .paths.read import path
    from .paths.timed_path import TimedPath
    from .paths.timing import TimingError, time_path
    from .pictures import pages, plot, view
    from .pictures.pages import page
    from .pictures.play import play
    from .planning.crossing import crossing_polynomial
    from .planning.plan import plan
    from .planning.plans import Plan
    from .planning.problem import PlanError
    from .planning.samples import from_csv
    from .planning.trajectory import Trajectory, circle, line, polynomial
    from .simulation.comparison import compare
    from .simulation.many import simulate_many
    from .simulation.run import Run
    from .simulation.simulate import simulate
    from .singularities.aspects import aspect, aspects
    from .singularities.bars import Bars
    from .singularities.dexterous import dexterous
    from .singularities.disc import largest_disc
    from .singularities.distance import locus_distance
    from .singularities.keep import Keep
    from .singularities.loci import singularity_loci
    from .singularities.maps import singularity_map
    from .singularities.passages import routes
    from .singularities.path import check_path
    from .singularities.rectangle import largest_rectangle
else:

    def __getattr__(name: str) -> object:
        if name in _PARTS:
            return _import_module(f".{name}", __name__)
        if name == "__version__":
            return _import_module("importlib.metadata").version(__name__)
        if name not in _LATER:
            raise AttributeError(f"module 'fivebar' has no attribute {name!r}")
        value = globals()[name] = getattr(_import_module(f".{_LATER[name]}", __name__), name)
        return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_LATER, *_PARTS])
