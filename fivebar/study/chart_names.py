"""The charts of speed against accuracy by name, with what each is about, for whoever lists them
without loading one.
"""

# Name -> (module with a function `chart()`, words).
CHARTS = {
    "geometry": ("geometry", "where the end-effector is: ways to the direct geometric model"),
    "derivatives": ("derivatives", "velocity and acceleration, exact and from differences"),
    "integrators": ("integrators", "two seconds of free motion: integrators and coordinates"),
    "trackers": ("trackers", "the lab's task 1 at 100 Hz: controllers and QP solvers"),
    "singularity-map": ("contours", "Type-2 loci: contours of a grid, and the closed form"),
    "stability": ("stability", "which gains of sampled computed torque hold the robot"),
    "chip": ("chip", "what single precision costs in exported C"),
    "simulators": ("simulators", "the same motion in five other programs"),
}
PEERS = ("simulators",)  # need packages that fivebar does not: only when asked for
