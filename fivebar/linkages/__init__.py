"""Linkages: chains of the robot's drives and dyads, from positions to accelerations, driving
torques and studies.
"""

from .curves import Curve, coupler_curves, type_2_curves
from .dynamics import driving_torque, equivalent_inertia, potential
from .five_bar import FiveBarLinkage
from .four_bar import DeadCentre, FourBar, dead_centres, time_ratio, transmission_range
from .limits import CrankRange, crank_range
from .motion import Body, Motion
from .moving import move
from .six_bar_press import GRAVITY, PRESSES, PRINTED, REPAIRED, SixBarPress
from .slider_crank import SliderCrank
from .straight_line import StraightLine, Straightness, straight_line, straightness
from .study import Study, study
from .verdict import verdict

__all__ = [
    "Body",
    "CrankRange",
    "Curve",
    "DeadCentre",
    "FiveBarLinkage",
    "FourBar",
    "GRAVITY",
    "Motion",
    "PRESSES",
    "PRINTED",
    "REPAIRED",
    "SixBarPress",
    "SliderCrank",
    "StraightLine",
    "Straightness",
    "Study",
    "coupler_curves",
    "crank_range",
    "dead_centres",
    "driving_torque",
    "equivalent_inertia",
    "move",
    "potential",
    "straight_line",
    "straightness",
    "study",
    "time_ratio",
    "transmission_range",
    "type_2_curves",
    "verdict",
]
