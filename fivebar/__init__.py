"""The five-bar parallel robot: exact models, singularities, simulation and control."""

from .dynamics import dynamic_model, energy, forward_dynamics, inverse_dynamics
from .errors import SingularityError, UnreachableError
from .geometry import Pose, dgm, igm
from .kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
from .robots import ROBOTS, FiveBar
