"""Commands of every kind, quick ones, the files that they read, and processes that run them."""

import os
import subprocess
import sys

import numpy as np

import fivebar as fb
from tests.helpers import ROOT

ROBOT = fb.FiveBar()
SAME = (
    ["track", "--from", "0.09", "0.068", "--to", "0.08", "0.075", "--duration", "0.3", "--json"],
    ["linkage", "four-bar", "0.2", "0.06", "0.16", "0.14", "--csv", "study.csv"],
    ["export", "--format", "c", "--out", "robot.h"],
    ["export", "--format", "mjcf", "--out", "robot.xml"],
    ["certify", "path.csv", "--out", "proof.json"],
    ["play", "--out", "play.html"],
    ["calibrate", "poses.csv", "--json"],
    ["identify", "log.csv", "--unknown", "zz1", "zz2", "m", "--json"],
    ["sweep", "workspace_area", "bars", "--grid", "l1=0.1:0.2:3", "--csv", "sweep.csv"],
)
ONE_BY_ONE = """import json, sys
from fivebar.cli import main
for arguments in json.loads(sys.argv[1]):
    assert main(arguments) == 0, arguments"""


def with_files(folder):
    """The files that these commands read."""
    poses = fb.measurement_poses(ROBOT, 8)
    log = fb.simulate(
        ROBOT, fb.ComputedTorque(ROBOT, 100, 20), fb.circle((0.06, 0.09), 0.02, 0.5), step=2e-3
    )
    for name, table in (
        ("path.csv", {"x": (0.05, 0.04, 0.04), "y": (0.09, 0.09, 0.1)}),
        ("poses.csv", dict(zip(("q1", "q2", "x", "y"), (*poses.q.T, *poses.xi.T)))),
        ("log.csv", dict(zip(("t", "q1", "q2", "tau1", "tau2"), (log.t, *log.q.T, *log.tau.T)))),
    ):
        np.savetxt(
            folder / name,
            np.stack(list(table.values()), axis=1),
            delimiter=",",
            header=",".join(table),
            comments="",
        )
    return folder


def python(code, *arguments, **options):
    return subprocess.Popen(
        [sys.executable, *code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def cli(*arguments, cwd, env=(), begin=("-m", "fivebar"), **options):
    """(exit code, stdout, stderr) of a command in a process of its own."""
    environment = {
        k: v
        for k, v in (os.environ | {"PYTHONPATH": str(ROOT)} | dict(env)).items()
        if v is not None
    }
    with python(begin, *arguments, cwd=cwd, env=environment, **options) as run:
        out, err = run.communicate(timeout=120)
    return run.returncode, out, err
