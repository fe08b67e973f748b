"""Names of the charts, listed without loading any of them."""

# Name -> (module with a function `chart`, what the chart is about).
CHARTS = {
    name: (f"{__package__}.charts.{module}", words)
    for name, module, words in (
        ("geometry", "geometry", "where the end-effector is: ways to the direct geometric model"),
        ("derivatives", "derivatives", "velocity and acceleration, exact and from differences"),
        ("integrators", "integrators", "two seconds of free motion: integrators and coordinates"),
        ("trackers", "trackers", "the lab's task 1 at 100 Hz: controllers and QP solvers"),
        ("singularity-map", "contours", "Type-2 loci: contours of a grid, and the closed form"),
        ("stability", "stability", "which gains of sampled computed torque hold the robot"),
        ("chip", "chip", "what single precision costs in exported C"),
    )
}
