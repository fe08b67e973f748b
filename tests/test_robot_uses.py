"""What a robot's file says against each command and each function: the table holds, pair by pair."""

import inspect
import io
import re
import warnings
from contextlib import chdir, redirect_stderr, redirect_stdout, suppress
from functools import lru_cache
from glob import glob
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

import fivebar as fb
from fivebar.base.robot_uses import uses
from fivebar.cli import COMMANDS, main
from fivebar.constraints.constraints import CHECKS
from fivebar.paths.placing.tool_regions import tool_regions
from fivebar.paths.setpoints import setpoints
from tests.helpers import odd_cases, robot_uses_page

WORDS, USES = uses()
FUNCTIONS = sorted(user for user in USES if user.startswith("fb."))
BASE = {
    "": 'kind = "five-bar"\nl11 = 0.09\nl12 = 0.12\nl21 = 0.09\nl22 = 0.12\nd = 0.08\nm = 0.3\n'
    "zz1 = 0.002\nzz2 = 0.002\nfv1 = 0.0\ngravity = [0.0, 0.0]\n",
    "constraints": "torque = 5.0\nacceleration = 5.0\n",  # with which `jerk` has a least time
}
BIGLIDE = 'kind = "biglide"\nl1 = 0.28\nl2 = 0.28\nd = 0.4\nmf1 = 1.0\nmf2 = 1.0\nm = 3.0\n'
# Row -> its table and lines, each with an effect wherever it is used.
SAYS = {
    "biglide": ("", BIGLIDE),
    "lengths": ("", "l12 = 0.125"),
    "units": ("", 'l12 = "125 mm"'),
    "masses": ("", "m = 0.6"),
    "gravity": ("", "gravity = [0.0, -9.81]"),
    "friction": ("", "fv1 = 0.3"),
    "readings": ("readings", "offset = [0.1, 0.0]\nratio = [1.0, -2.0]"),
    "frame": ("frame", "shift = [0.01, 0.02]"),
    "tool": ("tool", "leg = 1\nalong = 0.01"),
    "measured": ("measured", "modes = [[-1, -1, -1]]"),
    "motors": ("constraints", 'motors = "ax-12a"'),
    "torque": ("constraints", "torque = 0.01"),
    "joint_speed": ("constraints", "joint_speed = 0.1"),
    "joint_acceleration": ("constraints", "joint_acceleration = 0.1"),
    "speed": ("constraints", "speed = 0.01"),
    "acceleration": ("constraints", "acceleration = 0.05"),
    "jerk": ("constraints", "jerk = 0.5"),
    "joints": ("constraints", "joints = [[3.0, 3.1], []]"),
    "half_planes": ("constraints", "half_planes = [[0.0, 1.0, 0.3]]"),
    "region": ("constraints", "region = [[0.3, 0.3], [0.4, 0.3], [0.3, 0.4]]"),
    "det_A": ("constraints", "det_A = 0.999"),
    "sin": ("constraints", "sin = 0.999"),
    "clearance": ("constraints", "clearance = 0.3"),
    "collisions": ("constraints", "collisions = {widths = 0.2}"),
}
# What differs from run to run, or names what was written.
VARIES = re.compile(r'.*"(real_time_factor|solve_time_s)".*\n')
CALLS = {
    "fb.amoro.models": (fb.amoro.models, {"robot": fb.FiveBar()}),
    "fb.from_bag": (fb.from_bag, {"path": "none.mcap", "robot": fb.FiveBar()}),
    "fb.setpoints": (setpoints, {"robot": fb.FiveBar(), "reference": odd_cases.LINE}),
    "fb.tool_regions": (
        tool_regions,
        {"tool": fb.Tool(1, 0.02), "robot": fb.FiveBar(), "constraints": fb.Constraints()},
    ),
}
OF_FILES = set(WORDS) - {"functions"}
LINE = "--from 0.02 0.14 --to 0.03 0.14"
LINES = {
    "track": f"track {LINE} --duration 0.1 --working 1 -1 --json",
    "plan": f"plan {LINE} --working 1 -1 --json --out plan",
    "draw": "draw line.csv --rate 50 --period 0.05 --json --out draw",
    "draw --at": "draw line.csv --rate 50 --period 0.05 --json --out draw --at 0.025 0.14",
    "draw --as-drawn": "draw placed.csv --rate 50 --period 0.05 --json --out draw --as-drawn",
    "map": "map --nodes 5 --fits 0.03 0.02 --json",
    "map --space joint": "map --space joint --nodes 5 --out joint.svg",
    "map --load": "map --load 0 -3 --nodes 5 --json",
    "play": "play --xi 0.02 0.14 --working 1 -1",
    "calibrate": "calibrate points.csv --json --out calibrate --unknown l11",
    "identify": "identify log.csv --json --out identify",
    "certify": "certify line.csv --working 1 -1",
    "sweep": "sweep worst_torque bars --motion motion.csv --working 1 -1 --grid l11=0.1 --json",
    "design": "design worst_torque bars --motion motion.csv --working 1 -1 --bound l11=0.09:0.1"
    " --bound l21=0.08:0.09 --effort 0.01 --points 2 --json",
    "export mjcf": "export --to mjcf",
    "export urdf": "export --to urdf",
    "export sdf": "export --to sdf",
    "export c": "export --to c",
    "export reprapfirmware": "export --to reprapfirmware --working 1 -1 --steps-per-turn 200",
    "export ros2_control": "export --to ros2_control",
}


def file_of(row):
    """Return the text of a robot file that says one thing more; None: no more."""
    tables = dict(BASE)
    if row == "biglide":
        tables[""] = ""
    if row is not None:
        table, lines = SAYS[row]
        old = tables.get(table, "").splitlines()
        names = {line.partition(" =")[0] for line in lines.splitlines()}
        kept = [line for line in old if line.partition(" =")[0] not in names]
        tables[table] = "\n".join([*kept, lines, ""])
    return "".join((f"[{name}]\n" if name else "") + text for name, text in tables.items())


@lru_cache
def folder():
    """Return a folder with what the commands read, of the base robot."""
    place = Path(mkdtemp())
    robot = fb.FiveBar(0.09, 0.12, 0.09, 0.12, 0.08, 0.002, 0.002, 0.3)
    place.joinpath("line.csv").write_text("x,y\n0.0,0.0\n0.01,0.0\n", "utf-8")
    place.joinpath("placed.csv").write_text("x,y\n0.02,0.14\n0.03,0.14\n", "utf-8")
    rows = [f"{k / 10},{0.02 + 1e-3 * k * k},{0.14 - 1e-3 * k}" for k in range(8)]
    place.joinpath("motion.csv").write_text("\n".join(["t,x,y", *rows]), "utf-8")
    poses = fb.measurement_poses(robot, 8)
    rows = [f"{q1},{q2},{x},{y}" for (q1, q2), (x, y) in zip(poses.q.tolist(), poses.xi.tolist())]
    place.joinpath("points.csv").write_text("\n".join(["q1,q2,x,y", *rows]), "utf-8")
    circle = fb.circle((0.0, 0.14), 0.03, 0.5)
    run = fb.simulate(robot, fb.ComputedTorque(robot, 400.0, 40.0, (1, -1)), circle, step=2e-3)
    rows = [
        ",".join(map(repr, [t, *q, *tau]))
        for t, q, tau in zip(*map(np.ndarray.tolist, (run.t, run.q, run.tau)))
    ]
    place.joinpath("log.csv").write_text("\n".join(["t,q1,q2,tau1,tau2", *rows]), "utf-8")
    return place


@lru_cache
def answer(user, row=None):
    """Return what a command gives for the robot file that says one thing more: its exit code, what
    it prints and writes by file, and what it says on stderr.
    """
    out, err = io.StringIO(), io.StringIO()
    with chdir(folder()), redirect_stdout(out), redirect_stderr(err):
        Path("robot.toml").write_text(file_of(row), "utf-8")
        for left in [*Path().glob("*/*"), *Path().glob("*.html")]:
            left.unlink()
        code = main([*LINES[user].split(), "--robot", "robot.toml"])
        # Other files say how long it took.
        names = "*/setpoints.csv", "*/robot.toml", "play.html"
        written = {name: Path(file).read_text("utf-8") for name in names for file in glob(name)}
    return code, {"": VARIES.sub("", out.getvalue()), **written}, err.getvalue()


# Masses have a weight under gravity alone: there `test_feasible` finds it.
SLOW = ("draw", "draw --at", "draw --as-drawn", "map", "map --load", "design")
PAIRS = [
    pytest.param(user, row, marks=[pytest.mark.deep] if user in SLOW else [])
    for user in LINES
    for row in sorted(OF_FILES)
    if (user, row) != ("map --load", "masses")
]


@pytest.mark.every(50)
@pytest.mark.parametrize("user, row", PAIRS)
def test_what_a_file_says_has_an_effect_or_is_refused_or_left_out_by_name(user, row, tmp_path):
    use = USES[user]
    code, out, err = answer(user, row)
    if row in use.refused:
        assert code == 2 and not out[""]
        assert f"{user} refuses a robot with {WORDS[row]}: {use.refused[row]}" in err
        return
    base, usual, _ = answer(user)
    assert base == 0, err
    if row in use.left_out:
        assert code == 0 and out == usual
        if row not in ("masses", "gravity", "friction", *use.unsaid):
            assert f"{user} leaves out" in err and WORDS[row] in err and use.left_out[row] in err
    elif row in use.kept:
        for name, text in (("said", file_of(row)), ("kept", out["*/robot.toml"])):
            (tmp_path / f"{name}.toml").write_text(text, "utf-8")
        said, kept = (fb.load_machine(tmp_path / f"{name}.toml") for name in ("said", "kept"))
        table, lines = SAYS[row]
        name = lines.partition(" =")[0] if table == "" else row
        places = {"constraints": "constraints", "": "robot"}
        owners = [getattr(each, places.get(table, ""), each) for each in (said, kept)]
        assert getattr(owners[0], name) == getattr(owners[1], name)
    else:
        assert (code, out) != (base, usual)


def machine(rows):
    """Return a Machine that says these rows, without other things."""
    text = file_of(None).replace("torque = 5.0\nacceleration = 5.0\n", "")
    for row in rows:
        table, lines = SAYS[row]
        if table:
            head = f"[{table}]\n"
            text = (
                text.replace(head, head + lines + "\n")
                if head in text
                else text + head + lines + "\n"
            )
    path = folder() / "machine.toml"
    path.write_text(BIGLIDE if rows == ["biglide"] else text, "utf-8")
    return fb.load_machine(path)


@pytest.mark.parametrize("user", FUNCTIONS)
def test_a_function_refuses_or_leaves_out_by_name_what_it_does_not_use(user):
    use = USES[user]
    call, usual = CALLS.get(user) or (
        odd_cases.CASES[user[3:]].call,
        odd_cases.CASES[user[3:]].usual,
    )
    beside = [row for row in use.left_out if SAYS.get(row, ("",))[0] and row not in use.unsaid]
    if "robot" in usual:
        several = isinstance(usual["robot"], list)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # as soon as it is said
            with pytest.raises(UserWarning, match=f"{user} leaves out") as caught:
                built = machine(beside)
                call(**{**usual, "robot": [built] * len(usual["robot"]) if several else built})
        said = str(caught.value)
        for row in beside:
            assert WORDS[row] in said and use.left_out[row] in said
        for row in use.refused:
            with pytest.raises(ValueError, match="refuses a robot with") as refused:
                call(**{**usual, "robot": machine([row])})
            assert WORDS[row] in str(refused.value) and use.refused[row] in str(refused.value)
    if "constraints" in usual:
        for row in set(beside) & set(CHECKS):
            limits = machine([row]).constraints
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                with pytest.raises(UserWarning, match=f"{user} leaves out {row}"):
                    call(**{**usual, "constraints": limits})
                with pytest.raises(ValueError, match=f"the constraint {row} is not kept here"):
                    own = fb.Constraints(**{row: getattr(limits, row)})
                    call(**{**usual, "constraints": own})


def test_the_table_has_every_row_for_every_command_and_function():
    for user, use in USES.items():
        rows = [*use.used, *use.kept, *use.left_out, *use.refused]
        assert sorted(rows) == sorted(WORDS), user
    commands = {user.split()[0] for user in LINES}
    assert set(USES) == {*LINES, *FUNCTIONS}
    for name in COMMANDS:
        with redirect_stdout(io.StringIO()) as out, suppress(SystemExit):
            main([name, "--help"])
        assert ("--robot " in out.getvalue()) == (name in commands), name
        told = "".join(out.getvalue().split())  # lines also end after a hyphen
        for user in USES:
            assert user.split()[0] != name or "".join(USES[user].words(user).split()) in told
    taking = set()
    for name in dir(fb):
        made = getattr(fb, name)
        if callable(made) and {"robot", "constraints"} & set(inspect.signature(made).parameters):
            taking.add(f"fb.{name}")
    # These hold their robot; `fb.export` asks as the command, by format.
    results = {f"fb.{name}" for name in "Identification Machine Pose Run TimedPath export".split()}
    assert taking - results <= set(FUNCTIONS)


def test_the_guide_prints_the_table():
    """Written anew by `python -m tests.helpers.robot_uses_page`."""
    assert robot_uses_page.PAGE.read_text("utf-8") == robot_uses_page.page()
