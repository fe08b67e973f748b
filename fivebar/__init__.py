"""The five-bar parallel robot: exact models, singularities, simulation and control.

`import fivebar as fb` loads NumPy and nothing heavier; CasADi, SciPy, Matplotlib and meshcat come with what uses them.
"""

from .control import PD, ComputedTorque
from .dynamics import dynamic_model, energy, forward_dynamics, inverse_dynamics
from .errors import SingularityError, UnreachableError
from .geometry import Pose, dgm, igm
from .kinematics import Accelerations, Rates, dkm, dkm2, ikm, ikm2
from .robots import ROBOTS, FiveBar
from .run import Run
from .simulation import simulate
from .trajectory import Trajectory, circle, from_csv, line, polynomial
