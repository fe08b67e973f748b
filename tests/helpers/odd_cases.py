"""Usual calls of every public function, of which `odd_calls` makes strange ones."""

import atexit
import inspect
import shutil
import tempfile
from pathlib import Path as File
from types import ModuleType

import numpy as np
from scipy.optimize import brentq

import fivebar as fb
from fivebar import linkages
from fivebar.amoro.models import models
from fivebar.paths.curve import Path
from fivebar.paths.pieces import Line
from tests.helpers.odd_calls import ACCELERATIONS, FOUR_BAR, LINE, POSE, RATES, ROBOT, Case

HOME = (0.09, 0.068)
FOLDER = File(tempfile.mkdtemp(prefix="fivebar-odd-"))
atexit.register(shutil.rmtree, FOLDER)
CSV = FOLDER / "path.csv"
ROBOT_FILE = FOLDER / "kept.toml"
ROBOT.save(ROBOT_FILE)
CSV.write_text(
    "t,x,y\n" + "\n".join(f"{k / 10},{0.09 - 0.001 * k},0.068" for k in range(8)), encoding="utf-8"
)
GAINS = {"robot": ROBOT, "kp": 100.0, "kd": 20.0, "working": (-1, -1)}
CROSSING = (
    brentq(lambda x: fb.igm(ROBOT, (x, 0.05)).det_A, -0.09, -0.085, xtol=1e-16),
    0.05,
)  # of Type 2
CONTROLLER = fb.ComputedTorque(ROBOT, 100.0, 20.0)
STROKE = Path([Line(HOME, (0.08, 0.07))])
PLAN = fb.plan(ROBOT, HOME, (0.08, 0.075), 0.5)
RUN = fb.simulate(ROBOT, CONTROLLER, LINE)
TIMED = fb.time_path(
    ROBOT, fb.path([HOME, (0.08, 0.075)]), gap=0.01, constraints=fb.Constraints(torque=0.1)
)
MOTION = linkages.move(FOUR_BAR, np.array([0.1, 0.3]), 2.0)
STUDY = linkages.study(FOUR_BAR)
MASSIVE = linkages.Body(1.0, 0.1)
MEASURED = fb.measurement_poses(ROBOT, 8)
POINTS = dict(zip(("q1", "q2", "x", "y"), (*MEASURED.q.T, *MEASURED.xi.T)))
CALIBRATED = fb.calibrate(ROBOT, POINTS)
LOG = fb.simulate(ROBOT, CONTROLLER, fb.circle((0.06, 0.09), 0.02, 0.5), duration=0.5, step=2e-3)
BAG = FOLDER / "bag"
LOG.to_bag(BAG)
LOG = {"t": LOG.t, "q": LOG.q, "tau": LOG.tau}
ASPECT = fb.aspect(ROBOT, 1)
KEEP = fb.Constraints(half_planes=[(0, 1, 0)])
JOINTS = dict(
    zip(
        ("q11", "q12", "q21", "q22"),
        (0.2, *POSE.q_passive[:1].tolist(), -0.1, float(POSE.q_passive[1])),
    )
)
JOINT_RATES = dict(q11D=0.1, q12D=0.2, q21D=0.3, q22D=0.4)
LAB = models(ROBOT)
HUGE_NUMBERS = {
    name: [1e6, 1e9, 10**9, 10**20, 1e-9, 1e-3, 1.0, 0.01]
    for name in (
        "duration",
        "control_period",
        "step",
        "delay",
        "horizon",
        "turns",
        "samples",
        "tolerance",
        "period",
        "seconds",
    )
}


def _simulated(call, **more):
    usual = dict(
        robot=ROBOT,
        controller=CONTROLLER,
        reference=LINE,
        duration=0.02,
        start=None,
        control_period=0.01,
        step=0.001,
        torque_limit=None,
        measurement=None,
        integrator=None,
    )
    # A Trajectory can be called, but not as a controller: what it says then is its own.
    return Case(call, usual | more, 20.0, ("Trajectory.__call__",), options=HUGE_NUMBERS)


def _up(motion):
    return motion.xi[1]


def _rubbed(t, q, q_dot, tau):
    return tau - 0.01 * q_dot


def _many(**given):
    return fb.simulate_many(**given)


TASK = dict(
    table=(0.06, 0.04),
    disc=None,
    poses=(3, 3),
    working=(1, -1),
    motor=(1.0, 2.0),
    motion=LINE,
    path=None,
    tolerances={"q": 1e-3},
    stiffness=10.0,
    det_A=0.1,
    sin=0.1,
    margin=0.0,
)


def _swept(figure, designs, executor, out, robot, chunk, workers, **task):
    return fb.sweep(
        figure, designs, executor, out, robot=robot, chunk=chunk, workers=workers, **task
    )


def _compared(runs, figures, table, working):
    return fb.compare(runs, figures, table=table, working=working)


def _designed(goals, bounds, limits, robot, step, points, seed, effort, executor, **task):
    return fb.design(
        goals,
        bounds,
        limits=limits,
        robot=robot,
        step=step,
        points=points,
        seed=seed,
        effort=effort,
        executor=executor,
        **task,
    )


LINK = fb.Link(0.3, 0.04, 0.01, 0.001)
HEAVY = fb.FiveBar(
    mx11=0.01,
    my11=1e-3,
    mx21=0.01,
    my21=-1e-3,
    zz12=-1e-4,
    zz22=1e-4,
    my12=1e-3,
    my22=-1e-3,
    gravity=(0.1, -9.81),
    fv1=0.01,
    fv2=0.01,
    fs1=0.01,
    fs2=0.01,
    fv12=1e-3,
    fv22=1e-3,
)
HEAVY_RATES = fb.dkm(fb.dgm(HEAVY, (0.2, -0.1)), (0.7, -1.1))
SIDES = dict(ground=0.2, crank=0.06, coupler=0.16, rocker=0.14)
SLIDER_BODIES = {f"{link}_body": MASSIVE for link in ("crank", "rod", "slider", "guide")}
BODIES = dict(crank_body=MASSIVE, coupler_body=MASSIVE, rocker_body=MASSIVE)
PRESS = {name: getattr(linkages.REPAIRED, name) for name in linkages.REPAIRED.__dataclass_fields__}
# What is said of a path that no file can have, and of a dict that holds no runs.
WORDS_OF_FILES = (
    "null",
    "a page compares Runs",
    "the open file",
    "no quantity",
    "at least one run",
    "no robot",
)

CASES = {
    # models
    "FiveBar": Case(
        fb.FiveBar, {name: getattr(HEAVY, name) for name in HEAVY.__dataclass_fields__}
    ),
    "from_links": Case(
        fb.FiveBar.from_links,
        dict(
            l11=0.09,
            l12=0.09,
            l21=0.09,
            l22=0.09,
            d=0.1,
            links={"11": LINK, "12": LINK, "21": LINK, "22": 0.2},
            payload=0.1,
            gravity=(0.0, -9.81),
            rotor=(1e-4, 1e-4),
            viscous=(0.1, 0.1),
            coulomb=(0.1, 0.1),
            elbows=(0.1, 0.1),
        ),
        words=("zz", "mx", "my", "fs", "fv", "m = "),
    ),
    "Link": Case(fb.Link, dict(mass=1.0, x=0.05, y=0.01, inertia=0.004), words=("mass", "inertia")),
    "Biglide": Case(
        fb.Biglide,
        dict(
            l1=0.28,
            l2=0.28,
            d=0.4,
            mf1=1.0,
            mf2=1.0,
            m=3.0,
            zz1=-1e-3,
            zz2=1e-3,
            my1=1e-3,
            my2=-1e-3,
            gravity=(0.0, -9.81),
            fv1=0.1,
            fv2=0.1,
            fs1=0.1,
            fs2=0.1,
        ),
    ),
    "gravity_torques": Case(fb.gravity_torques, dict(pose=HEAVY_RATES.pose)),
    "potential": Case(fb.potential, dict(pose=HEAVY_RATES.pose)),
    "friction_torques": Case(fb.friction_torques, dict(rates=HEAVY_RATES)),
    "dgm": Case(fb.dgm, dict(robot=ROBOT, q=(0.2, -0.1), assembly=-1, unreachable="raise")),
    "igm": Case(fb.igm, dict(robot=ROBOT, xi=HOME, working=(-1, -1), unreachable="raise")),
    "dkm": Case(fb.dkm, dict(pose=POSE, q_dot=(0.7, -1.1))),
    "ikm": Case(fb.ikm, dict(pose=POSE, xi_dot=(0.1, 0.2))),
    "dkm2": Case(fb.dkm2, dict(rates=RATES, q_ddot=(0.7, -1.1))),
    "ikm2": Case(fb.ikm2, dict(rates=RATES, xi_ddot=(0.1, 0.2))),
    "dynamic_model": Case(fb.dynamic_model, dict(rates=RATES)),
    "inverse_dynamics": Case(fb.inverse_dynamics, dict(accelerations=ACCELERATIONS)),
    "forward_dynamics": Case(fb.forward_dynamics, dict(rates=RATES, tau=(0.1, 0.2))),
    "energy": Case(fb.energy, dict(rates=RATES)),
    "load_robot": Case(fb.load_robot, dict(path=ROBOT_FILE), words=WORDS_OF_FILES),
    "load_machine": Case(fb.load_machine, dict(path=ROBOT_FILE), words=WORDS_OF_FILES),
    "compile": Case(
        fb.compile,
        dict(
            robot=ROBOT,
            inputs=["q"],
            outputs=["xi"],
            assembly=-1,
            working=(-1, -1),
            jit=False,
            to=np,
            source=False,
        ),
        words=("no input", "no output"),
    ),
    "export": Case(
        fb.export,
        dict(
            robot=ROBOT,
            format="mjcf",
            out=FOLDER / "robot.xml",
            start=POSE,
            step=0.001,
            closure=None,
            functions=None,
            name="robot",
            machine=None,
            dialect=None,
            working=None,
            homing_deg=None,
            steps_per_turn=None,
            plugin=None,
        ),
        words=(
            *WORDS_OF_FILES,
            "to write, a path",
            "is no option of",
            "no function",
            "written of a TimedPath",
        ),
        options={
            "format": ["c", "sdf", "urdf", "gcode", "reprapfirmware", "ros2_control"],
            "closure": ["joint"],
            "functions": [("igm",), ["dance"], []],
        },
    ),
    "play": Case(
        fb.play,
        dict(robot=ROBOT, pose=POSE, branch=None, tool=fb.Tool(1, 0.01)),
        5.0,
        words=(
            "leave it out",
            "another robot",
            "a linkage's",
            "single one",
            "nothing to show",
            "paper's",
        ),
        options={
            "robot": [FOUR_BAR, linkages.SliderCrank(0.1, 0.3)],
            "pose": [None],
            "branch": [1, -1],
        },
    ),
    # what the models give, made by hand
    "Pose": Case(fb.Pose, dict(robot=ROBOT, point=HOME, _build=lambda: None), nan=True),
    "Rates": Case(fb.Rates, dict(pose=POSE, _q_dot=(0.0, 0.0), _xi_dot=(0.0, 0.0)), nan=True),
    "Accelerations": Case(
        fb.Accelerations, dict(rates=RATES, _q_ddot=(0.0, 0.0), _xi_ddot=(0.0, 0.0)), nan=True
    ),
    "Plan": Case(
        fb.Plan, dict(problem=PLAN.problem, pieces=PLAN.pieces, objective=1.0, status=""), nan=True
    ),
    "Run": Case(
        fb.Run,
        {n: getattr(RUN, n) for n in ("robot", "t", "q", "q_dot", "xi", "tau", "energy")},
        nan=True,
    ),
    "Trajectory": Case(fb.Trajectory, dict(start=0.0, duration=1.0, _motion=LINE), nan=True),
    "PlanError": Case(fb.PlanError, dict(message="x", violations={}), nan=True),
    "UnreachableError": Case(fb.UnreachableError, dict(message="x", gap=0.1), nan=True),
    "SingularityError": Case(fb.SingularityError, dict(message="x", margin=0.1), nan=True),
    # Python's own enum looks its values up in a dict, and CasADi's cannot be keys.
    "Singularity": Case(fb.Singularity, dict(value=1), words=("Singularity",), symbols=False),
    # singularities
    "singularity": Case(fb.singularity, dict(pose=POSE, tol=1e-9)),
    "singularity_margins": Case(fb.singularity_margins, dict(pose=POSE)),
    "singularity_loci": Case(fb.singularity_loci, dict(robot=ROBOT), 10.0),
    "singularity_map": Case(
        fb.singularity_map,
        dict(
            robot=ROBOT,
            field="parallel",
            space="task",
            window=(-0.1, 0.1, -0.1, 0.1),
            shape=(11, 11),
            tool=fb.Tool(1, 0.01),
        ),
        10.0,
        options={"shape": [(10**6, 10**6), (2, 2), (3, 10**20), 1e3, (5.0, 5.0)]},
        words=("nodes",),
    ),
    "locus_distance": Case(fb.locus_distance, dict(robot=ROBOT, xi=HOME, working=None), 10.0),
    "aspects": Case(fb.aspects, dict(robot=ROBOT), 10.0),
    "aspect": Case(fb.aspect, dict(robot=ROBOT, number=1), 10.0),
    "check_path": Case(
        fb.check_path,
        dict(robot=ROBOT, path=LINE, working=(-1, -1), tolerance=None, constraints=KEEP),
        10.0,
    ),
    "Constraints": Case(
        fb.Constraints,
        dict(
            motors="xl430-w250",
            torque=0.1,
            joint_speed=None,
            joint_acceleration=None,
            speed=0.1,
            acceleration=None,
            jerk=None,
            joints=((-1.0, 2.0), (-3.0, 3.0)),
            half_planes=[(0, 1, 0)],
            region=None,
            det_A=0.1,
            sin=0.1,
            clearance=0.0,
            collisions=None,
            functions={"up": _up},
        ),
    ),
    "LinkCollisions": Case(
        fb.LinkCollisions, dict(widths=0.01, layers=(1, 2, 1, 3), posts=0.01, post_layers=(1,))
    ),
    "place": Case(
        fb.place,
        dict(
            robot=ROBOT,
            path=STROKE,
            page=None,
            working=(-1, -1),
            turn=0.0,
            scale=1.0,
            constraints=fb.Constraints(clearance=0.001),
            strokes=False,
            tool=None,
        ),
        20.0,
        words=("place:",),
    ),
    "certify": Case(
        fb.certify,
        dict(
            robot=ROBOT,
            path=STROKE,
            tolerances=1e-4,
            constraints=fb.Constraints(det_A=0.01, sin=0.01),
            working=(-1, -1),
        ),
        10.0,
        options={"tolerances": [{"l11": 1e-3}, {"l13": 1e-3}, {"d": -1.0}]},
    ),
    "dexterous": Case(fb.dexterous, dict(robot=ROBOT, det_A=0.3, sin=0.1), 10.0),
    "largest_disc": Case(fb.largest_disc, dict(aspect=ASPECT, constraints=KEEP), 10.0),
    "largest_rectangle": Case(
        fb.largest_rectangle, dict(aspect=ASPECT, constraints=None, ratio=1.0), 20.0
    ),
    "routes": Case(
        fb.routes, dict(robot=ROBOT, start=POSE, goal=fb.igm(ROBOT, HOME, (1, 1))), 10.0
    ),
    # designs
    "sweep": Case(
        _swept,
        dict(
            figure=["bars", "tip_speed", "worst_torque"],
            designs={"l1": [0.1, 0.12], "zz": 0.002},
            executor=None,
            out=None,
            robot=ROBOT,
            chunk=5,
            workers=1,
            **TASK,
        ),
        20.0,
        ("no choice", "no parameter", "column", "designs must", "out:"),
        options={
            "disc": [0.1, (0, 0.1, 0.05)],
            "figure": ["footprint", {"own": lambda robot: 1.0}],
        },
    ),
    "design": Case(
        _designed,
        dict(
            goals=["bars", "workspace_area"],
            bounds={"l1": (0.1, 0.2), "l2": (0.1, 0.2)},
            limits={"bars": 0.7},
            robot=ROBOT,
            step=None,
            points=4,
            seed=0,
            effort=0.02,
            executor=None,
            **TASK | {"table": None},
        ),
        30.0,
        ("nothing within the bounds", "no choice", "bounds", "limits"),
        options={"goals": ["bars", {"bars": "max"}], "limits": [{}, {"bars": (None, 1.0)}]},
    ),
    # motions
    "line": Case(fb.line, dict(a=HOME, b=(0.0, 0.1), duration=1.0)),
    "circle": Case(fb.circle, dict(center=HOME, radius=0.01, period=1.0)),
    "polynomial": Case(fb.polynomial, dict(conditions=[(0.0, {0: HOME}), (1.0, {0: (0.0, 0.1)})])),
    "from_csv": Case(
        fb.from_csv,
        dict(path=CSV, smoothing=0.0, kind="spline", deviation=None, units=(), columns=()),
        words=WORDS_OF_FILES,
        options={"kind": ["polyline"], "deviation": [1e-4], "units": [["mm"], {"t": "ms"}]},
    ),
    "path": Case(
        fb.path,
        dict(
            points_or_file=[(0.0, 0.0), (0.1, 0.0), (0.1, 0.1)],
            deviation=1e-4,
            curvature=False,
            placement=None,
            units=None,
            columns=None,
            kind=None,
            pen_values=None,
        ),
        words=(*WORDS_OF_FILES, "points", "nothing is drawn", "stroke"),
        options={"points_or_file": [CSV]},
    ),
    "Path": Case(
        fb.Path,
        dict(
            pieces=STROKE.pieces,
            pen=(True,) * len(STROKE.pieces),
            dwells={0.0: 0.1},
            feed=None,
            notes=(),
            lines=None,
            tool=None,
            rests_for_pen=True,
            origin=None,
        ),
        words=("Path:", "pieces"),
    ),
    "Machine": Case(
        fb.Machine,
        dict(
            robot=ROBOT,
            offset=(0.1, 0.0),
            ratio=(1.0, 1.0),
            frame=fb.Placement((0.1, 0.0)),
            constraints=fb.Constraints(),
            tool=fb.Tool(1, 0.01),
            measured=((-1, -1, -1),),
        ),
    ),
    "Tool": Case(fb.Tool, dict(leg=1, along=0.01, across=0.02)),
    "Gcode": Case(
        fb.Gcode,
        dict(
            firmware="grbl",
            axes=("X", "Y"),
            unit="steps",
            per_turn=3200.0,
            gear=2.0,
            feed="units",
            deviation=1e-5,
            speed_error=0.01,
            max_feed=1e4,
            pen="M3",
            down=1000.0,
            up=0.0,
            approach=0.1,
        ),
        options={
            "firmware": ["marlin", "grbl2"],
            "unit": ["deg", "mm"],
            "pen": ["Z", "servo"],
            "feed": ["inverse"],
        },
    ),
    "Placement": Case(fb.Placement, dict(shift=(0.1, 0.0), turn=0.3, scale=2.0)),
    "crossing_polynomial": Case(
        fb.crossing_polynomial,
        dict(
            robot=ROBOT,
            start=HOME,
            goal=(0.05, 0.0),
            crossing=CROSSING,
            velocity=(-0.1, -0.1),
            times=(0.0, 1.0, 2.0),
            acceleration=(0.0, 0.0),
            working=(-1, -1),
        ),
    ),
    "Collocation": Case(fb.Collocation, dict(degree=3, intervals=4, tolerance=1e-2, max_time=2.0)),
    "plan": Case(
        fb.plan,
        dict(
            robot=ROBOT,
            start=HOME,
            goal=(0.08, 0.075),
            duration=0.5,
            via=(),
            objective="effort",
            constraints=None,
            collocation=fb.Collocation(intervals=4, tolerance=1e-2, max_time=2.0),
        ),
        30.0,
    ),
    "time_path": Case(
        fb.time_path,
        dict(
            robot=ROBOT,
            path=TIMED.path,
            duration=None,
            working=(-1, -1),
            constraints=fb.Constraints(torque=0.1),
            gap=0.01,
            max_time=2.0,
        ),
        20.0,
        ("least time", "rests for"),
    ),
    "TimedPath": Case(
        fb.TimedPath,
        {name: getattr(TIMED, name) for name in fb.TimedPath.__dataclass_fields__},
        nan=True,
    ),
    "TimingError": Case(fb.TimingError, dict(message="x", s=0.0, proved=True), nan=True),
    # control and simulation
    "PD": Case(fb.PD, GAINS | {"gravity": False, "assembly": -1}),
    "ComputedTorque": Case(fb.ComputedTorque, GAINS | {"assembly": -1}),
    "FeedForward": Case(fb.FeedForward, GAINS | {"ahead": 0.005}),
    "Tracker": Case(
        fb.Tracker,
        dict(
            robot=ROBOT,
            horizon=5,
            period=0.01,
            seconds=None,
            constraints=None,
            delay=0,
            encoder_resolution=None,
            position=1e4,
            acceleration=10.0,
            torque_rate=100.0,
            assembly=-1,
            jit=False,
        ),
        20.0,
        options=HUGE_NUMBERS,
    ),
    "Motor": Case(
        fb.Motor,
        dict(
            stall_torque=0.1,
            no_load_speed=300.0,
            largest_torque=0.05,
            rotor_inertia=1e-7,
            gear=20.0,
            efficiency=0.8,
            source="a data sheet",
        ),
    ),
    "Measurement": Case(fb.Measurement, dict(delay=1, encoder_resolution=1e-4)),
    "Integrator": Case(fb.Integrator, dict(method=None, chart="auto", tolerance=1e-9, jit=False)),
    "simulate": _simulated(fb.simulate),
    "simulate_many": Case(
        _many,
        dict(
            robot=[ROBOT, ROBOT],
            controller=CONTROLLER,
            reference=LINE,
            starts=None,
            duration=0.02,
            step=0.001,
            control_period=0.01,
            torque_limit=None,
            measurement=None,
            integrator=None,
            summary=None,
        ),
        20.0,
        ("robots", "controllers", "starts"),
        options=HUGE_NUMBERS,
    ),
    "LoadedRobot": Case(fb.LoadedRobot, dict(robot=ROBOT, torques=_rubbed)),
    "Summary": Case(
        fb.Summary, dict(functions={"rows": len}, executor=None, out=None, chunk=10, workers=1)
    ),
    "stepper": Case(
        fb.stepper,
        dict(robot=ROBOT, period=0.01, to=np, controller=CONTROLLER),
        5.0,
        ("a compiled loop needs",),
    ),
    "compare": Case(
        _compared,
        dict(
            runs={"one": ROBOT, "two": fb.FiveBar(d=0.1)},
            figures=["bars", "det_A"],
            table=(-0.01, 0.01, 0.1, 0.12),
            working=(1, -1),
        ),
        options={"runs": [{"one": RUN}]},
    ),
    # logs
    "from_bag": Case(
        fb.from_bag,
        dict(
            path=BAG,
            topic=None,
            joints=("left_motor", "right_motor"),
            robot=ROBOT,
            assembly=None,
            gear_ratio=1.0,
            offset=(0.0, 0.0),
            torque_constant=None,
        ),
        words=("is no bag that can be read", "no messages sensor_msgs/JointState"),
    ),
    "from_log": Case(
        fb.from_log,
        dict(
            t=RUN.t,
            q1=RUN.q[:, 0],
            q2=RUN.q[:, 1],
            tau1=RUN.tau[:, 0],
            tau2=RUN.tau[:, 1],
            robot=ROBOT,
            assembly=None,
            units=None,
            columns=None,
            counts_per_turn=None,
            gear_ratio=1.0,
            offset=(0.0, 0.0),
            torque_constant=None,
            more=None,
        ),
        words=("the log", "a log", "rows", "column", "times", *WORDS_OF_FILES),
    ),
    "replay": Case(fb.replay, dict(run=RUN, robot=None, restart=None), words=("the run",)),
    "identify": Case(
        fb.identify,
        dict(
            robot=ROBOT,
            log=LOG,
            validate=None,
            unknown=["zz1", "zz2", "m"],
            assembly=-1,
            cutoff=None,
            units=None,
            columns=None,
            counts_per_turn=None,
            gear_ratio=1.0,
            offset=(0.0, 0.0),
            torque_constant=None,
        ),
        20.0,
        (
            "the log",
            "a log",
            "the model misses",
            "hardly",
            "rows",
            "sampling rate",
            "known are",
            *LOG,
            *WORDS_OF_FILES,
        ),
        options={
            "log": [
                {"t": [0, 1]},
                {"t": np.arange(9.0), "q": np.ones((9, 2)), "tau": np.ones((9, 2))},
                RUN,
            ]
        },
    ),
    "exciting_trajectory": Case(
        fb.exciting_trajectory,
        dict(
            robot=ROBOT,
            period=2.0,
            cycles=1,
            harmonics=2,
            rate=9.0,
            acceleration=None,
            torque=None,
            margin=0.3,
            working=(-1, -1),
            assembly=-1,
            unknown=["zz1", "zz2", "m"],
            seed=0,
            starts=1,
        ),
        30.0,
        ("no motion was found", "hardly a pose", "no parameter"),
    ),
    "Identification": Case(
        fb.Identification, {name: None for name in fb.Identification.__dataclass_fields__}, nan=True
    ),
    "page": Case(
        fb.page,
        dict(subject=RUN, path=FOLDER / "page.html", show=None, title=None),
        10.0,
        WORDS_OF_FILES,
    ),
    # what was measured
    "calibrate": Case(
        fb.calibrate,
        dict(
            robot=ROBOT,
            data=POINTS,
            unknown=("l11", "d"),
            tool=None,
            start={"offset1": 0.0},
            sigma=1e-5,
            priors={"l11": 1e-4},
            loss="linear",
            mistakes="raise",
            units=("rad",),
            columns=(),
        ),
        10.0,
        words=(
            "x, y move by",
            "no mode is noted",
            "does not close",
            "the open file",
            "no robot has the lengths",
        ),
        options={
            "unknown": [("l13",), ("scale", "l11")],
            "loss": ["huber"],
            "mistakes": ["keep"],
            "start": [{"l11": -1.0}, {"d": 0.2}, {"x": 1.0}],
        },
    ),
    "Calibration": Case(
        fb.Calibration,
        {
            name: getattr(CALIBRATED, name)
            for name in (
                "nominal",
                "unknown",
                "rows",
                "assembly",
                "start",
                "p",
                "weight",
                "absolute",
                "loss",
                "prior",
            )
        },
        nan=True,
    ),
    "measurement_poses": Case(
        fb.measurement_poses,
        dict(
            robot=ROBOT,
            n=5,
            unknown=("l11", "l12"),
            tool=None,
            margin=0.3,
            working=[(-1, -1)],
            window=(-0.1, 0.1, -0.2, 0.2),
            start={},
        ),
        10.0,
        words=("no pose keeps", "keep the margin"),
        options={"n": [1, 12]},
    ),
    "tip_error": Case(
        fb.tip_error,
        dict(
            robot=ROBOT,
            tolerances={"l11": 1e-4},
            poses=HOME,
            tool=None,
            working=(-1, -1),
            samples=50,
            seed=1,
        ),
        words=("samples",),
    ),
    "repeatability": Case(fb.repeatability, dict(points=np.eye(2), commanded=(0.0, 0.1))),
    # linkages
    "lk.Body": Case(linkages.Body, dict(mass=1.0, inertia=0.1, centre=None)),
    "lk.FourBar": Case(
        linkages.FourBar, SIDES | BODIES | dict(point=(0.1, 0.0), base=(0.0, 0.0), tilt=0.1)
    ),
    "lk.SliderCrank": Case(
        linkages.SliderCrank,
        dict(crank=0.1, rod=0.3, offset=0.01, held="guide", **SLIDER_BODIES),
        words=("link",),
    ),
    "lk.SixBarPress": Case(linkages.SixBarPress, PRESS, words=("mass", "inertia")),
    "lk.FiveBarLinkage": Case(linkages.FiveBarLinkage, dict(robot=ROBOT, motors=(1, 5))),
    "lk.move": Case(
        linkages.move,
        dict(linkage=FOUR_BAR, q=0.3, q_dot=1.0, q_ddot=0.0, branch=1, unreachable="raise"),
    ),
    "lk.crank_range": Case(linkages.crank_range, dict(linkage=FOUR_BAR, branch=1)),
    "lk.dead_centres": Case(linkages.dead_centres, dict(four_bar=FOUR_BAR, branch=1)),
    "lk.time_ratio": Case(linkages.time_ratio, dict(four_bar=FOUR_BAR, branch=1)),
    "lk.transmission_range": Case(linkages.transmission_range, dict(four_bar=FOUR_BAR)),
    "lk.coupler_curves": Case(
        linkages.coupler_curves, dict(four_bar=FOUR_BAR, label="a", samples=90)
    ),
    "lk.type_2_curves": Case(linkages.type_2_curves, dict(robot=ROBOT, samples=90)),
    "lk.straight_line": Case(linkages.straight_line, dict(name="watt"), words=("straight-line",)),
    "lk.straightness": Case(
        linkages.straightness, dict(mechanism=linkages.straight_line("watt"), samples=101)
    ),
    "lk.driving_torque": Case(
        linkages.driving_torque,
        dict(motion=MOTION, load={"M": (1.0, 0.0)}, gravity=(0.0, -9.81)),
        words=("no point",),
    ),
    "lk.equivalent_inertia": Case(linkages.equivalent_inertia, dict(motion=MOTION)),
    "lk.potential": Case(linkages.potential, dict(motion=MOTION, gravity=(0.0, -9.81))),
    "lk.study": Case(
        linkages.study,
        dict(
            linkage=FOUR_BAR,
            speed=6.0,
            turns=1.0,
            drive="turn",
            branch=1,
            start=None,
            between=None,
            samples=37,
            load=None,
            gravity=(0.0, 0.0),
            quantities=None,
        ),
        words=("no quantity", "no point", "no range of its own"),
        options=HUGE_NUMBERS | {"drive": ["swing", "until-lock"]},
    ),
    "lk.verdict": Case(linkages.verdict, dict(linkage=FOUR_BAR, branch=1)),
    # what linkages give, made by hand
    "lk.CrankRange": Case(linkages.CrankRange, dict(intervals=(), full=True), nan=True),
    "lk.Curve": Case(linkages.Curve, dict(label="a", points=np.zeros((3, 2))), nan=True),
    "lk.DeadCentre": Case(
        linkages.DeadCentre, dict(kind="folded", crank=0.1, rocker=0.2), nan=True
    ),
    "lk.StraightLine": Case(
        linkages.StraightLine,
        dict(
            linkage=FOUR_BAR, branch=1, through=(0, 0), direction=(1, 0), stroke=(0, 1), source=""
        ),
        nan=True,
    ),
    "lk.Straightness": Case(
        linkages.Straightness, dict(stroke=1.0, deviation=0.1, band=0.1), nan=True
    ),
    "lk.Motion": Case(
        linkages.Motion,
        {n: getattr(MOTION, n) for n in linkages.Motion.__dataclass_fields__},
        nan=True,
    ),
    "lk.Study": Case(
        linkages.Study,
        {n: getattr(STUDY, n) for n in linkages.Study.__dataclass_fields__},
        nan=True,
    ),
    # the lab's functions
    "models": Case(models, dict(robot=ROBOT)),
    "lab.dgm": Case(LAB.dgm, dict(q11=0.2, q21=-0.1, assembly_mode=-1)),
    "lab.igm": Case(LAB.igm, dict(x=0.09, y=0.068, gamma1=-1, gamma2=-1)),
    "lab.dgm_passive": Case(LAB.dgm_passive, dict(q11=0.2, q21=-0.1, assembly_mode=-1)),
    "lab.dkm": Case(LAB.dkm, JOINTS | dict(q11D=0.1, q21D=0.2)),
    "lab.ikm": Case(LAB.ikm, JOINTS | dict(xD=0.1, yD=0.2)),
    "lab.dkm_passive": Case(LAB.dkm_passive, JOINTS | dict(q11D=0.1, q21D=0.2, xD=0.1, yD=0.2)),
    "lab.dkm2": Case(LAB.dkm2, JOINTS | JOINT_RATES | dict(q11DD=0.1, q21DD=0.2)),
    "lab.ikm2": Case(LAB.ikm2, JOINTS | JOINT_RATES | dict(xDD=0.1, yDD=0.2)),
    "lab.dkm2_passive": Case(
        LAB.dkm2_passive, JOINTS | JOINT_RATES | dict(q11DD=0.1, q21DD=0.2, xDD=0.1, yDD=0.2)
    ),
    "lab.dynamic_model": Case(LAB.dynamic_model, JOINTS | JOINT_RATES),
}


def public_names():
    """Every public function and class, as CASES calls them."""
    found = set()
    for prefix, module, names in (
        ("", fb, dir(fb)),
        ("lk.", linkages, linkages.__all__),
        ("lab.", LAB, vars(LAB)),
    ):
        for name in names:
            thing = getattr(module, name)
            ours = getattr(thing, "__module__", "").startswith("fivebar")
            if (
                callable(thing)
                and ours
                and not name.startswith("_")
                and not isinstance(thing, ModuleType)
            ):
                found.add(prefix + name)
    return found | {"models", "from_links"}


def parameters_missed():
    """(function, parameter) that no odd call ever makes strange."""
    missed = []
    for name, case in CASES.items():
        if case.nan or case.call in (_many, _swept, _designed) or name == "Singularity":
            continue
        own = [p for p in inspect.signature(case.call).parameters if not p.startswith("_")]
        missed += [(name, p) for p in own if p not in case.usual]
    return missed
