"""The public names as a user writes them, for mypy and never run; an `ignore` is an error that must be found."""

from collections.abc import Callable
from pathlib import Path
from typing import assert_type

import numpy as np

import fivebar as fb

robot, biglide = fb.FiveBar(l11=0.1, m=0.4), fb.Biglide()
fb.FiveBar(length=1.0)  # type: ignore[call-arg]
fb.dance()  # type: ignore[attr-defined]

pose = assert_type(fb.dgm(robot, (0.2, -0.1), assembly=-1), fb.Pose)
assert_type(fb.igm(biglide, np.zeros((5, 2)), working=(-1, 1), unreachable="nan"), fb.Pose)
assert_type(pose.xi, np.ndarray)
fb.dgm(pose, (0.2, -0.1))  # type: ignore[arg-type]
rates = assert_type(fb.ikm(pose, (0.1, 0.0)), fb.Rates)
assert_type(fb.dkm(pose, np.zeros(2)).xi_dot, np.ndarray)
fb.ikm2(pose, (0.0, 0.0))  # type: ignore[arg-type]
acc = assert_type(fb.dkm2(rates, (1.0, -2.0)), fb.Accelerations)
assert_type(fb.forward_dynamics(rates, (0.01, 0.02)), fb.Accelerations)
M, c = fb.dynamic_model(rates)
assert_type([M, c, fb.inverse_dynamics(acc), fb.energy(rates)], list[np.ndarray])
assert_type(fb.ikm2(fb.ikm(fb.dgm(biglide, (0, 0)), (0, 0)), (0, 0)), fb.Accelerations)

fb.singularity(pose, tol=1e-9)
fb.singularity_margins(pose)
fb.singularity_loci(robot)
fb.locus_distance(robot, (0.0, 0.1))
regions = fb.aspects(robot)
fb.largest_disc(regions[0], constraints=fb.Constraints(clearance=0.01))
fb.largest_rectangle(fb.aspect(robot, 1), constraints=fb.Constraints(half_planes=[(0, 1, 0)]))
area: float = fb.dexterous(robot, det_A=0.3, sin=0.1)[0].area

reference: fb.Trajectory = fb.line((0.09, 0.068), (0.0, 0.1), duration=2.0)
paths: list[fb.Trajectory] = [fb.circle((0, 0.1), 0.02, 1.0), fb.from_csv(Path("path.csv"))]
fb.check_path(robot, reference)
drawn: fb.Path = fb.path("drawing.svg", deviation=1e-5, placement=fb.Placement((0.0, 0.1), 0.1))
modes: tuple[int, int] = fb.place(robot, drawn, strokes=True).strokes[0][1].working
fb.path([(0.0, 0.0), (0.1, 0.0)], deviation="little")  # type: ignore[arg-type]

run = assert_type(
    fb.simulate(
        robot,
        fb.ComputedTorque(robot, 100, 20),
        reference,
        measurement=fb.Measurement(delay=1),
        start=rates,
    ),
    fb.Run,
)
fb.simulate(robot, fb.PD(robot, 1.0, 0.1), reference, measurement=fb.Measurement(delay="long"))  # type: ignore[arg-type]
again: fb.Run = fb.Run.from_csv("run.csv")
error: np.ndarray = run.error
runs = assert_type(fb.simulate_many(robot, fb.PD(robot, 1, 1), reference, rates), list[fb.Run])
fb.compare({"first": runs[0], "second": run})
plant = fb.LoadedRobot(robot, lambda t, q, q_dot, tau: tau - 0.1 * q_dot)
assert_type(fb.simulate(plant, fb.PD(robot, 1.0, 0.1), reference), fb.Run)
summary = fb.Summary({"steps": lambda run: len(run.t)}, out="runs", chunk=100)
rms: np.ndarray = fb.simulate_many([plant], fb.PD(robot, 1, 1), reference, summary=summary)["rms"]
fb.Summary(chunk="many")  # type: ignore[arg-type]

plan = assert_type(fb.plan(robot, (0.09, 0.068), (0.05, 0.0), 4.0), fb.Plan)
fb.plan(robot, (0.09, 0.068))  # type: ignore[call-arg]
fb.plan(robot, (0.09, 0.068), (0.05, 0.0), 4.0, objective=lambda m: m.tau[0] ** 2)
fb.plan(robot, (0.09, 0.068), (0.05, 0.0), 4.0, objective={"effort": 1.0, "own": lambda m: m.t})
fb.Constraints(functions={"up": lambda m: m.xi[1]})
fb.simulate(robot, fb.FeedForward(robot, 0.5, 0.05), plan)
fb.simulate(
    robot, fb.Tracker(robot, constraints=fb.Constraints(torque=0.006)), plan, torque_limit=0.006
)
fb.compile(robot, inputs=["q", "q_dot"], outputs=["xi", "M"], jit="auto")
address: str = fb.play(robot).fragment
header: str = fb.export(robot, "c", functions=["igm", "computed_torque"])
fb.page(run, "page.html")

timed = assert_type(
    fb.time_path(robot, fb.path([(0.05, 0.1), (0.0, 0.1)]), constraints=fb.Constraints(torque=0.1)),
    fb.TimedPath,
)
fb.time_path(robot, reference, constraints=fb.Constraints(torque=0.1))  # type: ignore[arg-type]
fb.simulate(robot, fb.FeedForward(robot, 0.2, 0.01), timed)

swept = fb.sweep(["det_A", "bars"], {"l1": [0.1, 0.12]}, table=(0.1, 0.1), workers=2)
columns: list[np.ndarray] = [swept["det_A"], swept.best("bars")]
fb.sweep("bars", fb.optimal_design.grid({"l1": [0.1]}), chunk="few")  # type: ignore[arg-type]
front: object = fb.design(
    {"bars": "min"}, {"l1": (0.1, 0.2)}, limits={"workspace_area": 0.1}, step=0.001
)

refuse: Callable[[str], Exception] = lambda text: fb.SingularityError(text, 0.0)  # noqa: E731
