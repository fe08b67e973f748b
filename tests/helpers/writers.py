"""Everything that writes a file which a user names: what writes it, and under what name."""

import ast

import fivebar as fb
from fivebar import linkages
from fivebar.visualization.view import strip
from tests.helpers import functions_with

ROBOT = fb.FiveBar()
LINE = fb.line((0.09, 0.068), (0.08, 0.075), 0.2)


def writers():
    """{name: (function of a path, file name)}."""
    run = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE)
    plan = fb.plan(ROBOT, (0.09, 0.068), (0.08, 0.075), 0.5)
    study = linkages.study(linkages.FourBar(0.2, 0.06, 0.16, 0.14), samples=37)
    a_map = fb.singularity_map(ROBOT, shape=(20, 20))
    poses = fb.measurement_poses(ROBOT, 6)
    calibrated = fb.calibrate(ROBOT, dict(zip(("q1", "q2", "x", "y"), (*poses.q.T, *poses.xi.T))))
    best = fb.design("workspace_area", {"l1": (0.05, 0.3), "l2": (0.05, 0.3)}, effort=0.02)
    swept = fb.sweep("bars", {"l1": [0.1, 0.2]}, robot=ROBOT)
    timed = fb.time_path(
        ROBOT, fb.path([(0.05, 0.09), (0.04, 0.09)]), constraints=fb.Constraints(acceleration=5.0)
    )
    proof = fb.certify(ROBOT, fb.path([(0.05, 0.09), (0.04, 0.09)]))
    return {
        "Run.to_csv": (run.to_csv, "a.csv"),
        "Run.plot": (run.plot, "a.png"),
        "Run.plot svg": (run.plot, "a.svg"),
        "Run.page": (run.page, "a.html"),
        "Run.animate html": (run.animate, "a.html"),
        "Run.animate gif": (run.animate, "a.gif"),
        "Run.animate png": (run.animate, "a.png"),
        "Plan.to_csv": (plan.to_csv, "a.csv"),
        "Plan.plot": (plan.plot, "a.png"),
        "Study.to_csv": (study.to_csv, "a.csv"),
        "Study.plot": (study.plot, "a.pdf"),
        "Map.to_npz": (a_map.to_npz, "a.npz"),
        "Map.to_csv": (a_map.to_csv, "a.csv"),
        "Map.page": (a_map.page, "a.html"),
        "compare": (fb.compare({"a": run}).plot, "a.png"),
        "strip": (lambda path: strip(run, path), "a.svg"),
        "export": (lambda path: fb.export(ROBOT, "mjcf", path), "a.xml"),
        "export c": (lambda path: fb.export(ROBOT, "c", path), "a.h"),
        "Calibration.to_json": (calibrated.to_json, "a.json"),
        "Machine.save": (calibrated.machine.save, "a.toml"),
        "Design.save": (best.save, "a.json"),
        "Design.to_robot_file": (best.to_robot_file, "a.json"),
        "Sweep.to_csv": (swept.to_csv, "a.csv"),
        "TimedPath.to_csv": (timed.to_csv, "a.csv"),
        "Live.save": (fb.play(ROBOT).save, "a.html"),
        "Certificate.to_json": (proof.to_json, "a.json"),
    }


# Who writes without `tables.written`, `saved` and `replaced`, and why that may be.
DIRECT = {
    "base.tables:saved": "that is it",
    "base.tables:written": "that is it",
    "base.presentation:_repr_html_": "into memory",
    "visualization.plot.poses:strip_png": "into memory",
    "visualization.pages.fronts:save_page": "into memory",
    "visualization.plot.poses:save_strip": "Scene.save replaces",
    "models.machine_code:_build": "in a folder of its own, from which each file is moved as a whole",
    "study.speed_accuracy.store:add": "appends a line, cut ones are dropped",
    "cli.__init__:_flush": "into nothing",
    "grading.report.outputs:write_whole": "replaces",
    "amoro.ros_free.figures:destroy": "a script's windows",
    "amoro.ros_free.child:_scopes": "a script's scopes",
    "amoro.ros_free.child:_report": "a pipe",
}


def writing_functions():
    """module:function of every function that opens a file to write, or has Matplotlib or a Path write it."""
    return functions_with(_writes)


def _writes(node):
    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
    mode = [
        a.value
        for a in [*node.args, *(k.value for k in node.keywords)]
        if isinstance(a, ast.Constant)
    ]
    return name in {"savefig", "write_text", "write_bytes"} or (
        name in {"open", "fdopen"}
        and any(isinstance(m, str) and m[:1] in tuple("wax") and len(m) < 4 for m in mode)
    )
