"""What designs and fronts say and keep in files, and the words of what is asked for wrongly."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import optimize

import fivebar as fb
from fivebar.optimal_design import optimum
from fivebar.optimal_design.goals import limits_by_figure
from fivebar.optimal_design.optimum import DesignProblem
from fivebar.optimal_design.results import Front
from fivebar.optimal_design.task import task_of

D = fb.optimal_design
BOUNDS = {"l1": (0.1, 0.3), "l2": (0.1, 0.3), "d": (0.0, 0.2)}


def problem_of(goals, bounds=BOUNDS, limits=None, **choices):
    return DesignProblem(goals, bounds, limits or {}, fb.FiveBar(), None, task_of(choices), None)


def test_a_report_names_goals_bounds_and_gaps():
    problem = problem_of(
        {"workspace_area": "max", "bars": "max"},
        limits={"footprint": 1.0},
        table=(0.02, 0.02),
        poses=3,
    )
    lines = problem.design_of(np.array([0.2, 0.3, 0.0])).report.splitlines()
    assert lines[:3] == ["l1 = 0.2", "l2 = 0.3", "d = 0"]
    area = np.pi * (0.5**2 - 0.1**2)
    assert lines[3:5] == [f"workspace_area = {area:.6g} m² (max)", "bars = 1 m (max)"]
    assert lines[5].startswith("footprint = ") and lines[5].endswith(" m²")
    assert lines[8:10] == ["l2 = 0.3 is at its upper bound 0.3", "d = 0 is at its lower bound 0"]
    gap = 100 * (0.36 * np.pi - area) / (0.36 * np.pi)
    assert lines[-2:] == [
        f"no robot within the bounds passes workspace_area = {0.36 * np.pi:.6g};"
        f" this one is {gap:.3g} % off",
        "of bars no bound is known: it is the best that was found",
    ]


def test_a_design_of_a_motion_comes_back_without_it(tmp_path):
    """The file has the motion's hash, from which no motion can be made."""
    motion = fb.line((-0.01, 0.0), (0.01, 0.0), 1.0)
    path = [(-0.01, 0.0), (0.01, 0.0)]
    problem = problem_of("bars", {"l1": 0.1}, motion=motion, path=path, sin=0.1, motor=(1.0, 5.0))
    one = problem.design_of(np.array([0.1]))
    one.save(tmp_path / "one.json")
    written = json.loads((tmp_path / "one.json").read_text("utf-8"))["choices"]
    assert set(written) == {"motion", "path", "sin", "motor"}
    again = D.Design.load(tmp_path / "one.json")
    assert again.task.motion is None and again.task.path is None
    assert again.task.sin == 0.1 and again.task.motor == fb.Motor(1.0, 5.0)
    assert again.as_json() == one.as_json()
    one.to_robot_file(tmp_path / "robot.json")
    assert fb.load_robot(tmp_path / "robot.json") == one.robot


def test_files_that_hold_no_designs(tmp_path):
    with pytest.raises(ValueError, match="one.json holds no designs: there is no such file"):
        D.Design.load(tmp_path / "one.json")
    with pytest.raises(ValueError, match="front.json holds no designs: there is no such file"):
        Front.load(tmp_path)
    (tmp_path / "one.json").write_text("[1]", "utf-8")
    with pytest.raises(ValueError, match="one.json is not what a design left there .TypeError"):
        D.Design.load(tmp_path / "one.json")


@pytest.mark.parametrize("senses", [("max", "min"), ("min", "max")])
def test_the_knee_does_not_depend_on_units_or_senses(senses):
    """Three designs of which the middle one is nearest to both bests."""
    problem = problem_of(dict(zip(("workspace_area", "bars"), senses)))
    rows = [(0.1, 0.1), (0.14, 0.14), (0.3, 0.3)]
    designs = [problem.design_of(np.array([*row, 0.0])) for row in rows]
    front = Front(tuple(designs))
    f = np.stack([front["workspace_area"], front["bars"]], axis=1)
    share = (f - f.min(axis=0)) / np.ptp(f, axis=0)
    best = [1.0 if sense == "max" else 0.0 for sense in senses]
    away = np.linalg.norm(share - best, axis=1)
    assert front.knee is designs[int(away.argmin())]
    assert away.argmin() != away.argmax()


def test_a_path_or_motion_of_a_task_is_taken_as_it_is():
    path = fb.path([(0.0, 0.0), (0.01, 0.0)])
    assert task_of({"path": path}).path is path
    assert task_of({"table": None, "disc": 0.1}).disc == (0.0, 0.0, 0.1)
    assert task_of({"disc": (0.1, 0.2, 0.3)}).disc == (0.1, 0.2, 0.3)
    with pytest.raises(TypeError, match="^path: points"):
        task_of({"path": 3})
    with pytest.raises(TypeError, match="no choice tabel; the known ones are table, disc, poses"):
        task_of({"tabel": 1})
    with pytest.raises(ValueError, match="give a table or a disc, not both"):
        task_of({"table": (1, 1), "disc": 1.0})


@pytest.mark.parametrize(
    "bounds, error, words",
    [
        ({"l1": ("a", 0.2)}, ValueError, "bounds: l1's low must be"),
        ({"l1": (0.1, "b")}, ValueError, "bounds: l1's high must be"),
        ({"l1": (0.1, np.inf)}, ValueError, "bounds: l1's high must be"),
        ({"l1": (0.3, 0.2)}, ValueError, r"bounds: l1 = \(0.3, 0.2\) is the wrong way round"),
        ({"l1": (1, 2, 3)}, ValueError, r"bounds: l1 must be \(low, high\) or a number, not \("),
        ({"l1": None}, ValueError, r"bounds: l1 must be \(low, high\) or a number, not None"),
        ({}, TypeError, r"bounds must be a table, as \{'l1': \(0.05, 0.2\)\}, not \{\}"),
        (3, TypeError, "bounds must be a table, as"),
        (
            {"l3": (0.1, 0.2)},
            ValueError,
            "bounds: no parameter 'l3' of a design; the known ones are l1, l2, r1",
        ),
        ({"l1": (0.1, 0.2), "r1": 0.1}, ValueError, "bounds: r1 and l1 both set l11"),
        ({"l11": 0.1, "l1": (0.1, 0.2)}, ValueError, "bounds: l1 and l11 both set l11"),
    ],
)
def test_bounds_that_do_not_go(bounds, error, words):
    with pytest.raises(error, match=f"^{words}"):
        fb.design("workspace_area", bounds)


@pytest.mark.parametrize(
    "goals, error, words",
    [
        ([], ValueError, "goals: none is asked for; the known ones are "),
        (["bars", "footprint", "det_A", "sin"], ValueError, "goals: at most three, not 4"),
        ({"bars": "low"}, ValueError, 'goals: bars is to be "min" or "max", not \'low\''),
        ("mass", ValueError, "goals: no figure 'mass'; the known ones are "),
        ("det_A", ValueError, r"goals: det_A needs table=\.\.\. or disc=radius: "),
        ("time", ValueError, r"goals: time needs motion=\.\.\.: of the motion run faster"),
        ("tip_force", ValueError, r"goals: tip_force needs motor=\.\.\.: "),
    ],
)
def test_goals_that_do_not_go(goals, error, words):
    table = {} if goals in ("det_A", "time") else {"table": (0.1, 0.1)}
    with pytest.raises(error, match=f"^{words}"):
        fb.design(goals, {"l1": (0.1, 0.2)}, **table)


def test_a_number_is_a_limit_on_the_worse_side():
    task = task_of({"table": (0.1, 0.1)})
    limits = {"det_A": 0.5, "bars": 1, "sin": (None, 0.9), "footprint": (0, None)}
    ends = [limit[1:] for limit in limits_by_figure(limits, task, fb.FiveBar())]
    assert ends == [(0.5, np.inf), (-np.inf, 1.0), (-np.inf, 0.9), (0.0, np.inf)]
    assert limits_by_figure({"bars": (1.0, 1.0)}, task, fb.FiveBar())[0][1:] == (1.0, 1.0)
    assert limits_by_figure({}, task, fb.FiveBar()) == ()
    with pytest.raises(TypeError, match="limits must be a table, as {'det_A': 0.5}, not 3"):
        limits_by_figure(3, task, fb.FiveBar())


def nearest_locus(robot, points):
    """Distance from the loci in the modes (1, -1), by their points in steps of the angles."""
    q = np.linspace(0, 2 * np.pi, 6001)[:-1]
    half, l1, l2 = robot.d / 2, robot.l11, robot.l12
    circles = []
    for side in (-1, 1):  # a leg in line
        for radius in (l1 + l2, abs(l1 - l2)):
            circles.append(side * half + radius * np.exp(1j * q))
    for q1, q2 in parallel_bars(half, l1, l2):
        circles.append(q1 + 0 * q2)
    loci = np.concatenate(circles)
    z = points @ (1, 1j)
    return np.array([np.abs(loci - each).min() for each in z])


def parallel_bars(half, l1, l2):
    """Points in which both distal bars are in line: the end-effector midway between the elbows."""
    q1 = np.linspace(0, 2 * np.pi, 4001)[:-1, None]
    # |elbow 1 - elbow 2| = 2 l2, for q2 of each q1 by the law of cosines.
    elbow = -half + l1 * np.exp(1j * q1)
    away = elbow - half
    cosine = (np.abs(away) ** 2 + l1**2 - 4 * l2**2) / (2 * l1 * np.abs(away))
    good = np.abs(cosine) <= 1
    for sign in (1, -1):
        q2 = np.angle(away[good]) + sign * np.arccos(cosine[good])
        other = half + l1 * np.exp(1j * q2)
        yield (elbow[good] + other) / 2, q2


@pytest.mark.every(2)
@pytest.mark.parametrize(
    "lengths", [(1.2, 1.0, 1.6), (0.9, 1.1, 0.6), (1.0, 1.3, 2.9), (0.5, 1.6, 1.8)]
)
def test_the_inscribed_circle_is_the_largest_on_the_axis(lengths):
    """Of all heights above the highest locus on the axis, by distances from drawn loci."""
    l1, l2, d = lengths
    robot = fb.FiveBar(l1, l2, l1, l2, d)
    radius = fb.sweep("inscribed_circle", [robot])["inscribed_circle"][0]
    top = np.sqrt((l1 + l2) ** 2 - (d / 2) ** 2)
    y = np.linspace(0, top, 801)[1:-1]
    pose = fb.igm(robot, np.stack([0 * y, y], axis=1), (1, -1), unreachable="nan")
    above = np.flatnonzero(~(pose.assembly == pose.assembly[-1]))
    y = y[above[-1] + 1 if len(above) else 0 :]
    expected = nearest_locus(robot, np.stack([0 * y, y], axis=1)).max()
    assert radius == pytest.approx(expected, rel=3e-3)


@pytest.mark.every(2)
@pytest.mark.parametrize("l2", [0.03, 4e-3, 4e-4, 1e-5])
def test_a_circle_of_short_distal_bars_is_above_its_locus(l2):
    """It touches both legs' outer circles and, below it, the locus on the axis."""
    l1, half = 1.0, 0.9
    locus = np.sqrt(l1**2 - (half - l2) ** 2)  # both distal bars in one horizontal line
    s = l1 + l2 + locus
    radius = (s**2 - half**2) / (2 * s) - locus
    robot = fb.FiveBar(l1, l2, l1, l2, 2 * half)
    done = fb.sweep(["inscribed_circle", "inscribed_conditioning"], [robot])
    assert done["inscribed_circle"][0] == pytest.approx(radius, rel=1e-6)
    assert 0 < done["inscribed_conditioning"][0] < 1


def test_how_a_front_is_searched(monkeypatch):
    """Twenty designs for each parameter that varies; then twenty for each of the front's points."""
    asked = []

    def evolve(problem, low, high, size, generations, rng, callback):
        asked.append(("evolve", size, generations, callback))
        x = rng.uniform(low, high, (size, len(low)))
        return (x, *problem(x))

    def refine(problem, low, high, x, f, chosen, members, generations, rng, callback):
        asked.append(("refine", members, generations, callback))
        assert len(chosen) == 6 and (f == problem(x)[0]).all()
        return (x[chosen], *problem(x[chosen]))

    monkeypatch.setattr(optimum, "evolve", evolve)
    monkeypatch.setattr(optimum, "refine", refine)
    bounds = {name: (0.1, 0.2) for name in ("l11", "l12", "l21", "l22")} | {"d": 0.1}
    front = fb.design(["workspace_area", "bars"], bounds, points=6, effort=0.033)
    assert [call[:3] for call in asked] == [("evolve", 80, 4), ("refine", 20, 4)]
    assert asked[0][3].__name__ == asked[1][3].__name__ == "update"
    areas = front["workspace_area"]
    assert (np.diff(areas) > 0).all() and (np.diff(front["bars"]) > 0).all()
    asked.clear()
    fb.design(["workspace_area", "bars"], {"l1": (0.1, 0.2)}, points=6, effort=0.01)
    assert [call[:3] for call in asked] == [("evolve", 60, 1), ("refine", 20, 1)]
    asked.clear()
    monkeypatch.setattr(optimum, "thinned", lambda f, front, count: front[:6].tolist())
    fb.design(["workspace_area", "bars"], {"l1": (0.1, 0.2)}, points=70, effort=0.01)
    assert asked[0][1] == 70


def test_how_one_goal_is_searched(monkeypatch):
    """By SciPy, over what varies alone: 300 generations of 20 designs for each, evenly begun."""
    given = {}

    def differential_evolution(goal, bounds, **options):
        given.update(options, bounds=bounds)
        x = np.array([[0.15, 0.2], [0.1, 0.15]])  # two designs, in columns
        given["values"] = goal(x)
        return SimpleNamespace(x=x[:, 0])

    monkeypatch.setattr(optimize, "differential_evolution", differential_evolution)
    bounds = {"l1": (0.1, 0.2), "d": 0.05, "l2": (0.1, 0.3)}
    one = fb.design("bars", bounds, limits={"bars": 0.6}, effort=0.5, seed=3)
    assert one.parameters == {"l1": 0.15, "d": 0.05, "l2": 0.1}
    assert given["bounds"] == [(0.1, 0.2), (0.1, 0.3)]
    assert given["values"] == pytest.approx([0.5, 1e30 * (1 + 0.1 / 0.6)])
    assert (given["maxiter"], given["popsize"], given["init"]) == (150, 20, "halton")
    assert (given["tol"], given["polish"], given["updating"]) == (1e-10, False, "deferred")
    assert given["vectorized"] and given["callback"](None, convergence=0.0) is None
    same = np.random.default_rng(3).random()
    assert given["rng"].random() == same


def test_a_triangle_has_at_most_ten_thousand_parts():
    for count in (1, 10**4 + 1, 2.5):
        with pytest.raises(ValueError, match="^triangle: its count must be "):
            D.triangle(count)
    assert len(D.triangle(2)) == 1


def test_a_path_is_told_by_its_points():
    """The same line elsewhere, run the other way, or of the same end or beginning, is another path."""
    hashes = set()
    for points in (
        [(0, 0), (0.01, 0)],
        [(0, 0.1), (0.01, 0.1)],
        [(0.01, 0), (0, 0)],
        [(0.02, 0), (0.01, 0)],
        [(0, 0), (0, 0.01)],
    ):
        about = task_of({"path": points}).about["path"]
        assert about["length"] == pytest.approx(0.01)
        hashes.add(about["sha256"])
    assert len(hashes) == 5
