"""Methods that lose or fail, small and as their users write them, each with the numbers that show
it.

newton_dgm        direct geometric model by Newton on the loop closure
half_angle        the tangent half-angle formula
differentiation   rates by differences of positions
joint_space       forward dynamics in joint coordinates, across Type 2
energy_drift      integrators on a conservative motion
redundant         redundant coordinates with constraints, with and without stabilisation
crossing          computed torque through a Type-2 singularity
sampled           sampled computed torque at its limit of stability
integrators       the fixed-step and SciPy integrators that the above share
pictures          figures of their results
"""
