"""The five-bar parallel robot and the biglide: exact models, singularities, simulation and control.

A function that takes a robot also takes the name of one (`fb.ROBOTS`), its file, or a Machine.

Each name is imported at its first use: `fb.dgm` brings NumPy, and `fb.simulate`, `fb.aspects` and
the like bring CasADi, SciPy, Matplotlib, meshcat and Bokeh where they are needed.
"""

import typing as _typing
from importlib import import_module as _import_module

from .base import presentation as _presentation
from .base import robot_uses as _robot_uses

# Public name -> module. No module has the name of what it gives: as a package's attribute it would
# hide it.
_MODULES = {
    "Accelerations": "models.kinematics",
    "aspect": "singularities.aspects",
    "aspects": "singularities.aspects",
    "Biglide": "models.robots",
    "calibrate": "estimation.calibration.calibrate",
    "Calibration": "estimation.calibration.result",
    "certify": "paths.certificates.certify",
    "check_path": "constraints.path_check",
    "circle": "planning.trajectory",
    "Collocation": "planning.plan",
    "compare": "optimal_design.comparison",
    "compile": "models.compiled",
    "ComputedTorque": "control.laws",
    "Constraints": "constraints.constraints",
    "crossing_polynomial": "planning.crossing",
    "design": "optimal_design.optimum",
    "dexterous": "singularities.dexterous",
    "dgm": "models.geometry",
    "dkm": "models.kinematics",
    "dkm2": "models.kinematics",
    "dynamic_model": "models.dynamics",
    "energy": "models.dynamics",
    "exciting_trajectory": "estimation.identification.exciting",
    "export": "exporters.export",
    "FeedForward": "control.laws",
    "FiveBar": "models.robots",
    "forward_dynamics": "models.dynamics",
    "friction_torques": "models.loads",
    "from_csv": "planning.samples",
    "from_bag": "estimation.logs.measured_runs",
    "from_log": "estimation.logs.measured_runs",
    "Gcode": "exporters.gcode",
    "gravity_torques": "models.dynamics",
    "Identification": "estimation.identification.result",
    "identify": "estimation.identification.identify",
    "igm": "models.geometry",
    "ikm": "models.kinematics",
    "ikm2": "models.kinematics",
    "Integrator": "simulation.settings",
    "inverse_dynamics": "models.dynamics",
    "largest_disc": "constraints.disc",
    "largest_rectangle": "constraints.rectangle",
    "line": "planning.trajectory",
    "Link": "models.links",
    "LinkCollisions": "constraints.link_collisions",
    "load_machine": "paths.machine",
    "load_robot": "models.robot_files",
    "LoadedRobot": "models.loaded_robot",
    "locus_distance": "singularities.distance",
    "Machine": "paths.machine",
    "Measurement": "simulation.settings",
    "measurement_poses": "estimation.calibration.poses",
    "Motor": "models.motors",
    "MOTORS": "models.motors",
    "page": "visualization.pages",
    "Path": "paths.curve",
    "path": "paths.reading.read",
    "PD": "control.laws",
    "place": "paths.placing.place",
    "Placement": "paths.placement",
    "Plan": "planning.plans",
    "plan": "planning.plan",
    "PlanError": "planning.problem",
    "play": "visualization.play",
    "polynomial": "planning.trajectory",
    "Pose": "models.geometry",
    "potential": "models.loads",
    "Rates": "models.kinematics",
    "repeatability": "estimation.calibration.repeatability",
    "replay": "estimation.logs.replays",
    "ROBOTS": "models.named_robots",
    "routes": "singularities.passages",
    "Run": "simulation.run",
    "simulate": "simulation.simulate",
    "simulate_many": "simulation.many",
    "Singularity": "singularities.margins",
    "singularity": "singularities.margins",
    "singularity_loci": "singularities.loci",
    "singularity_map": "singularities.maps",
    "singularity_margins": "singularities.margins",
    "SingularityError": "base.errors",
    "stepper": "simulation.stepping",
    "Summary": "simulation.summaries",
    "sweep": "optimal_design.sweeping",
    "time_path": "paths.timing.time_path",
    "TimedPath": "paths.timing.timed_path",
    "TimingError": "paths.timing.time_path",
    "tip_error": "estimation.calibration.tip_error",
    "Tool": "paths.tool",
    "Tracker": "control.tracker",
    "Trajectory": "planning.trajectory",
    "UnreachableError": "base.errors",
}


# Rooms that are used by name, and three of the room `visualization`.
_PARTS = {
    "amoro": "amoro",
    "grading": "grading",
    "linkages": "linkages",
    "optimal_design": "optimal_design",
    "pages": "visualization.pages",
    "plot": "visualization.plot",
    "study": "study",
    "view": "visualization.view",
}

__all__ = sorted([*_MODULES, *_PARTS])

_presentation.load_presenters = lambda: _import_module(".visualization.presenters", __name__)
_robot_uses.machine_room = lambda: _import_module(".paths.machine", __name__)


if _typing.TYPE_CHECKING:  # the same names, for a type checker
    from . import amoro, grading, linkages, optimal_design, study
    from .base.errors import SingularityError, UnreachableError
    from .constraints.constraints import Constraints
    from .constraints.disc import largest_disc
    from .constraints.link_collisions import LinkCollisions
    from .constraints.path_check import check_path
    from .constraints.rectangle import largest_rectangle
    from .control.laws import PD, ComputedTorque, FeedForward
    from .control.tracker import Tracker
    from .estimation.calibration.calibrate import calibrate
    from .estimation.calibration.poses import measurement_poses
    from .estimation.calibration.repeatability import repeatability
    from .estimation.calibration.result import Calibration
    from .estimation.calibration.tip_error import tip_error
    from .estimation.identification.exciting import exciting_trajectory
    from .estimation.identification.identify import identify
    from .estimation.identification.result import Identification
    from .estimation.logs.measured_runs import from_bag, from_log
    from .estimation.logs.replays import replay
    from .exporters.export import export
    from .exporters.gcode import Gcode
    from .models.compiled import compile
    from .models.dynamics import (
        dynamic_model,
        energy,
        forward_dynamics,
        gravity_torques,
        inverse_dynamics,
    )
    from .models.geometry import Pose, dgm, igm
    from .models.kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
    from .models.links import Link
    from .models.loaded_robot import LoadedRobot
    from .models.loads import friction_torques, potential
    from .models.motors import MOTORS, Motor
    from .models.named_robots import ROBOTS
    from .models.robot_files import load_robot
    from .models.robots import Biglide, FiveBar
    from .optimal_design.comparison import compare
    from .optimal_design.optimum import design
    from .optimal_design.sweeping import sweep
    from .paths.certificates.certify import certify
    from .paths.curve import Path
    from .paths.machine import Machine, load_machine
    from .paths.placement import Placement
    from .paths.placing.place import place
    from .paths.reading.read import path
    from .paths.timing.time_path import TimingError, time_path
    from .paths.timing.timed_path import TimedPath
    from .paths.tool import Tool
    from .planning.crossing import crossing_polynomial
    from .planning.plan import Collocation, plan
    from .planning.plans import Plan
    from .planning.problem import PlanError
    from .planning.samples import from_csv
    from .planning.trajectory import Trajectory, circle, line, polynomial
    from .simulation.many import simulate_many
    from .simulation.run import Run
    from .simulation.settings import Integrator, Measurement
    from .simulation.simulate import simulate
    from .simulation.stepping import stepper
    from .simulation.summaries import Summary
    from .singularities.aspects import aspect, aspects
    from .singularities.dexterous import dexterous
    from .singularities.distance import locus_distance
    from .singularities.loci import singularity_loci
    from .singularities.maps import singularity_map
    from .singularities.margins import Singularity, singularity, singularity_margins
    from .singularities.passages import routes
    from .visualization import pages, plot, view
    from .visualization.pages import page
    from .visualization.play import play
else:

    def __getattr__(name: str) -> object:
        if name in _PARTS:
            return _import_module(f".{_PARTS[name]}", __name__)
        if name == "__version__":
            return _import_module("importlib.metadata").version(__name__)
        if name not in _MODULES:
            raise AttributeError(f"module 'fivebar' has no attribute {name!r}")
        value = globals()[name] = getattr(_import_module(f".{_MODULES[name]}", __name__), name)
        return value


def __dir__() -> list[str]:
    return __all__
