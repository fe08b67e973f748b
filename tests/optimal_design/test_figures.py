"""Figures of merit against the models one pose at a time, published values, and what a motion really asks for."""

import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.parameters import parameters_of
from fivebar.optimal_design.batch import robots_of_designs
from fivebar.optimal_design.task import SAMPLES, task_of
from fivebar.paths.pieces import Arc
from tests.helpers import DATA

D = fb.optimal_design
REFERENCE = json.loads((DATA / "workspace.json").read_text("utf-8"))
TASK = dict(
    table=(0.06, 0.04),
    poses=(5, 4),
    motor=(0.7, 5.0),
    stiffness=30.0,
    tolerances={"q": 2e-3, "l": 1e-4, "d": 3e-4},
)
NAMES = [
    name
    for name, figure in D.FIGURES.items()
    if figure.kind == "poses" and "disc" not in figure.needs
]


@pytest.fixture(scope="module")
def swept():
    bounds = {
        "l11": (0.08, 0.16),
        "l12": (0.09, 0.2),
        "l21": (0.08, 0.16),
        "l22": (0.09, 0.2),
        "d": (0, 0.15),
    }
    done = fb.sweep(
        NAMES,
        D.sample(bounds | {"task_x": (-0.02, 0.02), "task_y": (0.08, 0.2)}, 400, seed=4),
        **TASK,
    )
    assert done.errors == ()
    good = np.flatnonzero((done["det_A"] > 0.2) & (done["sin"] > 0.2))
    assert 20 < len(good) < 380
    return done, good


def poses_of(done, k):
    """The poses of one design, by the public functions."""
    x, y = np.meshgrid(np.linspace(-0.03, 0.03, 5), np.linspace(-0.02, 0.02, 4))
    points = np.stack([x, y], axis=-1).reshape(-1, 2) + done.place_at(k)
    return fb.igm(done.robot_at(k), points, (1, -1), unreachable="nan")


def test_figures_over_a_table_are_those_of_the_models(swept):
    done, good = swept
    angle = np.linspace(0, 2 * np.pi, 3601)
    ways = np.stack([np.cos(angle), np.sin(angle)])
    for k in good[:20]:
        pose = poses_of(done, k)
        margins = fb.singularity_margins(pose)
        J = np.linalg.solve(pose.A, pose.B)
        box = np.concatenate(
            [
                pose.xi,
                *np.moveaxis(pose.elbows, 1, 0),
                [(-pose.robot.d / 2, 0), (pose.robot.d / 2, 0)],
            ]
        )
        wanted = {
            "det_A": np.abs(pose.det_A).min(),
            "sin": np.abs(margins.serial).min(),
            "transmission_angle": margins.transmission_angle.min(),
            "conditioning": (1 / np.linalg.cond(J)).min(),
            "stiffness": np.linalg.eigvalsh(30.0 * np.linalg.inv(J @ np.swapaxes(J, 1, 2))).min(),
            "footprint": np.prod(np.ptp(box, axis=0)),
            "tip_speed": 5.0 / np.abs(np.linalg.solve(pose.B, pose.A) @ ways).max(),
            "tip_force": 0.7 / np.abs(np.swapaxes(J, 1, 2) @ ways).max(),
        }
        for name, value in wanted.items():
            near = (
                1e-6 if name.startswith("tip") else 1e-12
            )  # of directions in steps of a tenth of a degree
            assert done[name][k] == pytest.approx(value, rel=near), name
        weights = np.outer([0.5, 1, 1, 0.5], [0.5, 1, 1, 1, 0.5]).ravel()
        mean = (weights / np.linalg.cond(J)).sum() / weights.sum()
        assert done["global_conditioning"][k] == pytest.approx(mean, rel=1e-12)


def test_the_worst_tip_error_is_that_of_the_direct_model(swept):
    """Each corner of the box of tolerances, a thousandth of their size: the direct model moves by as much."""
    done, good = swept
    small, names = 1e-3, ("l11", "l12", "l21", "l22", "d")
    for k in good[:4]:
        pose, robot, worst = poses_of(done, k), done.robot_at(k), 0.0
        size = small * np.array([1e-4, 1e-4, 1e-4, 1e-4, 3e-4, 2e-3, 2e-3])
        for corner in np.array(np.meshgrid(*[(-1, 1)] * 7)).reshape(7, -1).T * size:
            other = fb.FiveBar(**{name: getattr(robot, name) + e for name, e in zip(names, corner)})
            moved = fb.dgm(other, pose.q + corner[5:], pose.assembly).xi
            worst = max(worst, np.linalg.norm(moved - pose.xi, axis=1).max() / small)
        assert done["worst_tip_error"][k] == pytest.approx(worst, rel=1e-3)


def test_where_the_table_is_not_reached_or_a_singularity_crosses_it(swept):
    done, _ = swept
    out = done["reach"] < 0
    crossed = (done["reach"] > 1e-3) & np.isnan(done["det_A"])
    assert out.any() and crossed.any()
    for k in np.flatnonzero(crossed)[:5]:
        signs = np.sign(poses_of(done, k).det_A)
        assert {1.0, -1.0} <= set(signs)
    for name in NAMES:
        if name != "reach":
            np.testing.assert_array_equal(np.isnan(done[name]), out | np.isnan(done["det_A"]), name)


@pytest.mark.parametrize(
    "task", [{"table": (-0.03, 0.05, -0.02, 0.04)}, {"disc": (0.01, 0.0, 0.03)}]
)
def test_reach_is_the_least_over_the_whole_table(task):
    """Whatever the nodes are; compared with points so dense that each is a near one of any other."""
    lengths = {"l1": (0.05, 0.2), "l2": (0.05, 0.2), "d": (0, 0.15)}
    places = D.sample(lengths | {"task_x": (-0.05, 0.05), "task_y": (0.0, 0.25)}, 60, seed=2)
    done = fb.sweep(["reach", "det_A"], places, poses=2, **task)
    x, y = np.meshgrid(np.linspace(-0.03, 0.05, 401), np.linspace(-0.03, 0.04, 401))
    points = np.stack([x, y], axis=-1).reshape(-1, 2)
    if "disc" in task:
        points = points[np.hypot(*(points - (0.01, 0.0)).T) <= 0.03]
    else:
        points = points[points[:, 1] >= -0.02]
    outside = 0
    for k in range(done.count):
        robot = done.robot_at(k)
        margin = fb.igm(robot, points + done.place_at(k), (1, -1), unreachable="nan").reach_margin
        base = np.array([(-robot.d / 2, 0.0), (robot.d / 2, 0.0)])
        near = np.linalg.norm(points + done.place_at(k) - base[:, None], axis=-1).min()
        if near > 1e-3:  # no base joint is in it
            outside += 1
            assert done["reach"][k] == pytest.approx(margin.min(), abs=4e-4)
        else:
            assert done["reach"][k] < 0
        assert done["reach"][k] >= 0 or np.isnan(done["det_A"][k])
    assert 20 < outside < 60


def test_a_table_between_whose_nodes_is_a_gap_is_out_of_reach():
    """The gap is a disc about a base joint, above which the table's lower edge has no node."""
    designs = {"l1": [0.11], "l2": [0.07], "d": 0.04, "task_y": [0.0798]}
    task = dict(table=(0.12, 0.08), poses=(3, 7))
    done = fb.sweep(["reach", "det_A"], designs, **task)
    assert done["reach"][0] == pytest.approx(0.0398 - 0.04, rel=1e-9) and np.isnan(done["det_A"][0])
    with pytest.raises(fb.UnreachableError):
        fb.igm(done.robot_at(0), (-0.02, 0.0398), (1, -1))


@pytest.mark.parametrize("size", [1e-2, 1.0, 1e2])
def test_a_table_as_large_as_the_reach_is_reached(size):
    """At two corners a leg is stretched: the hypotenuse of a 3-4-5 triangle from its base joint."""
    lengths = {"l1": 3 * size, "l2": 2 * size, "d": 2 * size, "task_y": 3.75 * size}
    done = fb.sweep(["reach", "sin"], lengths, table=(4 * size, size / 2), poses=(7, 3))
    assert abs(done["reach"][0]) < 1e-14 * size and done["sin"][0] < 1e-7


def test_no_robot_passes_a_bound(swept):
    done, _ = swept
    names = ("l11", "l12", "l21", "l22", "d")
    rows = np.array([[getattr(done.robot_at(k), name) for name in names] for k in range(0, 400, 8)])
    robots = robots_of_designs(names, rows, fb.FiveBar())
    bounded = [name for name in NAMES if D.FIGURES[name].bound]
    assert len(bounded) == 7
    for name in bounded:
        figure = D.FIGURES[name]
        sign = 1 if figure.better == "large" else -1
        bound = figure.bound(robots, task_of(TASK))
        passed = sign * done[name][::8] > sign * bound * (1 + sign * 1e-12)
        assert not passed.any() and np.isfinite(done[name][::8]).any(), name


def test_where_both_legs_are_stretched_nothing_is_warned_of():
    """Of 3-4-5 triangles to the last bit: both columns of J are 0, the compliance is 0 / 0 of nothing."""
    lengths = {"l1": [2.0], "l2": [3.0], "d": [6.0], "task_y": [3.5]}
    task = dict(table=(1.0, 1.0), poses=3, motor=(1.0, 1.0), stiffness=1.0, tolerances={"q": 1e-3})
    done = fb.sweep(["stiffness", "tip_force", "worst_tip_error", "reach"], lengths, **task)
    assert done["reach"][0] < 0 and not done.errors
    assert np.isnan([done[n][0] for n in ("stiffness", "tip_force", "worst_tip_error")]).all()


def test_a_table_of_four_poses_has_its_corners():
    done = fb.sweep("det_A", {"l1": [0.1]}, table=(0.06, 0.04), poses=2)
    corners = np.array([(x, y) for x in (-0.03, 0.03) for y in (-0.02, 0.02)]) + done.place_at(0)
    pose = fb.igm(done.robot_at(0), corners, (1, -1), unreachable="nan")
    low, high = np.sort(pose.det_A)[[0, -1]]
    expected = np.abs(pose.det_A).min() if low * high > 0 else np.nan
    assert done["det_A"][0] == pytest.approx(expected, rel=1e-12, nan_ok=True)


def test_liu_measures_are_plain_polar_means():
    """Against the mean over polar nodes by the condition number of each Jacobian; area-weighted means are others."""
    r = {"r1": [1.2], "r2": [1.0], "r3": [0.8], "task_y": [1.597]}
    figures = ["global_conditioning_polar", "global_conditioning"]
    done = fb.sweep(figures, r, disc=0.4, poses=(201, 240))
    rho, phi = np.meshgrid(np.linspace(0, 0.4, 201), 2 * np.pi * np.arange(240) / 240)
    points = np.stack([rho * np.cos(phi), 1.597 + rho * np.sin(phi)], axis=-1)
    pose = fb.igm(fb.FiveBar(1.2, 1.0, 1.2, 1.0, 1.6), points, (1, -1))
    inverse = 1 / np.linalg.cond(np.linalg.solve(pose.A, pose.B))
    plain = np.trapezoid(inverse, dx=1 / 200, axis=1).mean()
    weighed = 2 * np.trapezoid(inverse * rho / 0.4, dx=1 / 200, axis=1).mean()
    assert done[figures[0]][0] == pytest.approx(plain, rel=1e-10)
    assert done[figures[1]][0] == pytest.approx(weighed, rel=1e-4)
    assert abs(plain - weighed) > 0.004


def test_the_inscribed_circle_brings_its_own_conditioning():
    robot = fb.FiveBar(1.2, 1.0, 1.2, 1.0, 1.6)
    y, radius = 1.59702341613507074, 0.413807459515147531
    done = fb.sweep("inscribed_conditioning", [robot])
    same = fb.sweep(
        "global_conditioning_polar", [robot], disc=(0, y, radius * (1 - 1e-9)), poses=(101, 180)
    )
    assert done["inscribed_conditioning"][0] == pytest.approx(
        same["global_conditioning_polar"][0], abs=1e-5
    )
    assert 0.3 < done["inscribed_conditioning"][0] < 0.6


def test_liu_published_values_by_a_sweep():
    r = np.array([[float(x) for x in case["r"]] for case in REFERENCE["MIC"]])
    done = fb.sweep("inscribed_circle", dict(zip(("r1", "r2", "r3"), r.T)), workers=1)
    wanted = np.array([float(case["r_MIC"]) for case in REFERENCE["MIC"]])
    np.testing.assert_allclose(done["inscribed_circle"], wanted, rtol=0, atol=1e-12)
    published = np.array([case["published"] for case in REFERENCE["MIC"]])
    off = np.abs(wanted - published) > 5e-5
    assert r[off].tolist() == [[0.7, 1.7, 0.6]]  # the misprint
    r = np.array([[float(x) for x in case["r"]] for case in REFERENCE["areas"]])
    done = fb.sweep("workspace_area", dict(zip(("r1", "r2", "r3"), r.T)))
    wanted = [float(case["theoretical_workspace_area"]) for case in REFERENCE["areas"]]
    np.testing.assert_allclose(done["workspace_area"], wanted, rtol=1e-14)
    # In the whole triangle the largest is the published one.
    atlas = fb.sweep("workspace_area", D.triangle(30))
    assert atlas.design(atlas.best()[0]) == {"r1": 1.5, "r2": 1.5, "r3": 0.0}


def test_the_workspace_is_what_the_aspects_of_a_mode_cover():
    designs = D.sample(
        {
            "l11": (0.05, 0.2),
            "l12": (0.05, 0.2),
            "l21": (0.05, 0.2),
            "l22": (0.05, 0.2),
            "d": (0, 0.3),
        },
        8,
    )
    done = fb.sweep("workspace_area", designs)
    for k in range(8):
        parts = fb.aspects(done.robot_at(k))
        area = sum(part.area for part in parts if part.working == (1, 1))
        assert done["workspace_area"][k] == pytest.approx(area, rel=1e-11)


@pytest.mark.parametrize("share, left", [(1 + 1e-6, 0.0), (1 - 1e-6, 1e-6)])
def test_a_margin_about_as_large_as_the_largest_disc(share, left):
    """Just above its radius no disc is left, and just below it one of the rest."""
    robot = fb.FiveBar()
    parts = [part for part in fb.aspects(robot) if part.working == (1, -1)]
    radius = max(fb.largest_disc(part).radius for part in parts)
    done = fb.sweep(["largest_disc"], [robot], workers=1, margin=share * radius)
    assert done["largest_disc"][0] == pytest.approx(left * radius, rel=1e-6, abs=1e-12)


@pytest.mark.deep
def test_regions_are_the_exact_ones():
    robot = fb.FiveBar(0.12, 0.14, 0.12, 0.14, 0.1)
    done = fb.sweep(
        ["dexterous_area", "largest_disc", "largest_rectangle"],
        [robot],
        workers=1,
        det_A=0.3,
        sin=0.2,
        margin=0.004,
    )
    parts = [part for part in fb.dexterous(robot, det_A=0.3, sin=0.2) if part.working == (1, -1)]
    roomy = [part for part in parts if fb.largest_disc(part).radius > 0.004]
    assert done["dexterous_area"][0] == max(part.area for part in parts)
    assert done["largest_disc"][0] == max(
        fb.largest_disc(part, fb.Constraints(clearance=0.004)).radius for part in roomy
    )
    assert done["largest_rectangle"][0] == max(
        fb.largest_rectangle(part, fb.Constraints(clearance=0.004)).area for part in roomy
    )


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (0.0, -9.81)])
@pytest.mark.parametrize("motor", [(0.6, 1e3), (50.0, 2.0)])
def test_in_the_time_found_a_motor_is_at_its_limit_and_none_beyond(motor, gravity):
    line = fb.line((-0.03, 0.0), (0.03, 0.02), 1.3)
    base = fb.FiveBar(m=0.3, gravity=gravity, fv1=0.02, fv2=0.02)
    designs = {"l1": [0.1, 0.12], "l2": [0.13, 0.14], "d": 0.1, "task_y": 0.15, "zz": 0.002}
    done = fb.sweep(
        ["time", "worst_torque", "worst_speed"], designs, robot=base, motion=line, motor=motor
    )
    for k in range(2):
        s, robot = 1.3 / done["time"][k], done.robot_at(k)
        xi, xi_dot, xi_ddot = line(np.linspace(0, 1.3, SAMPLES))
        pose = fb.igm(robot, xi + done.place_at(k), (1, -1))
        share = []
        for scale in (1.0, s):
            rates = fb.ikm(pose, scale * xi_dot)
            tau = fb.inverse_dynamics(fb.ikm2(rates, scale**2 * xi_ddot))
            share.append((tau, rates.q_dot))
        worst = [np.abs(each).max() for each in share[0]]
        assert (done["worst_torque"][k], done["worst_speed"][k]) == pytest.approx(worst, rel=1e-12)
        tau, q_dot = share[1]
        share = np.abs(tau / motor[0] + q_dot / motor[1]).max()
        assert max(share, np.abs(tau / motor[0]).max()) == pytest.approx(1, rel=1e-9)


def test_the_least_time_of_a_path_is_that_of_time_path():
    points = [(-0.02, 0.0), (0.02, 0.0)]
    base = fb.FiveBar(0.12, 0.15, 0.12, 0.15, 0.1, 0.0005, 0.0005, 0.2)
    done = fb.sweep("path_time", {"task_y": [0.14, 0.9]}, robot=base, path=points, motor=(0.3, 8.0))
    line = fb.path([(x, y + 0.14) for x, y in points])
    timed = fb.time_path(
        base, line, working=(1, -1), constraints=fb.Constraints(motors=fb.Motor(0.3, 8.0))
    )
    assert done["path_time"][0] == pytest.approx(timed.duration, rel=5e-3) and np.isnan(
        done["path_time"][1]
    )
    slower = fb.sweep(
        "time", {"task_y": [0.14]}, robot=base, motion=fb.line(*points, 1.0), motor=(0.3, 8.0)
    )
    assert timed.lower_bound < slower["time"][0]
    with pytest.raises(ValueError, match="path: "):
        fb.sweep("path_time", {"task_y": [0.1]}, path=[(0, 0)], motor=(1, 1))


def test_a_path_of_a_task_is_rounded_as_draw_rounds_it(tmp_path):
    """Rows along a circle: a motion that rests at each of them takes several times as long."""
    angle = np.linspace(0, 2 * np.pi, 121)
    file = tmp_path / "circle.csv"
    rows = [f"{0.02 * np.cos(a)},{0.02 * np.sin(a)}" for a in angle]
    file.write_text("\n".join(["x,y", *rows]), encoding="utf-8")
    base = fb.FiveBar(0.12, 0.15, 0.12, 0.15, 0.1, 0.0005, 0.0005, 0.2)
    task = dict(robot=base, motor=(0.3, 8.0), working=(1, -1))
    done = fb.sweep("path_time", {"task_y": [0.14]}, path=file, **task)
    exact = fb.path([Arc((0.0, 0.14), 0.02, 0.0, 2 * np.pi)])
    timed = fb.time_path(
        base, exact, working=(1, -1), constraints=fb.Constraints(motors=fb.Motor(0.3, 8.0))
    )
    assert done["path_time"][0] == pytest.approx(timed.duration, rel=0.02)


def test_inertias_are_those_of_the_links_at_each_length(tmp_path):
    links = {"11": 0.12, "12": fb.Link(0.08, x=0.05, y=0.002, inertia=3e-4), "22": 0.09}
    loads = dict(payload=0.3, gravity=(0.0, -9.81), rotor=(1e-4, 1e-4), viscous=(2e-3, 1e-3))
    line = fb.line((-0.04, 0.0), (0.04, 0.0), 1.2)
    base = fb.FiveBar.from_links(0.1, 0.15, 0.1, 0.15, 0.07, links, **loads)
    designs = {"l1": [0.06, 0.2], "l2": 0.2, "task_y": 0.15}
    fb.sweep("worst_torque", designs, robot=base, motion=line, out=tmp_path)
    done = D.Sweep.load(tmp_path)
    for k, l1 in enumerate((0.06, 0.2)):
        robot = fb.FiveBar.from_links(l1, 0.2, l1, 0.2, 0.07, links, **loads)
        alone = fb.sweep("worst_torque", {"task_y": 0.15}, robot=robot, motion=line)
        assert done["worst_torque"][k] == pytest.approx(alone["worst_torque"][0], rel=1e-12)
        assert parameters_of(done.robot_at(k)) == pytest.approx(parameters_of(robot), rel=1e-12)
    chosen = fb.design("bars", {"l1": (0.06, 0.2)}, robot=base, effort=0.01).robot
    wanted = fb.FiveBar.from_links(chosen.l11, 0.15, chosen.l11, 0.15, 0.07, links, **loads)
    assert parameters_of(chosen) == pytest.approx(parameters_of(wanted), rel=1e-12)


def test_inertias_that_cannot_follow_the_lengths_are_warned_of():
    task = dict(motion=fb.line((0, 0.1), (0.01, 0.1), 1.0), motor=(1.0, 5.0))
    words = "time: the robot's masses and inertias stay as they are whatever l11, l21 are; "
    with pytest.warns(UserWarning, match=words):
        fb.sweep(["bars", "time"], {"l1": [0.1]}, **task)
    with pytest.warns(UserWarning, match=words):
        fb.design("bars", {"l1": (0.1, 0.11)}, limits={"time": 3.0}, effort=0.01, **task)
    fb.sweep(["bars", "worst_speed"], {"l1": [0.1]}, **task)
    fb.sweep("time", {"l1": [0.1], "zz": 0.002}, **task)
    fb.sweep("time", {"d": [0.1]}, **task)


def test_a_motion_that_cannot_be_done_has_no_figures():
    done = fb.sweep(
        ["time", "worst_torque"],
        {"task_y": [0.1, 5.0]},
        motion=fb.line((0, 0), (0.01, 0), 1.0),
        motor=(1, 1),
    )
    for name in done.figures:
        assert np.isnan(done[name]).tolist() == [False, True]
    assert [words.partition(": ")[0] for k, words in done.errors if k == 1] == [*done.figures]


def test_functions_of_ones_own_and_what_they_raise():
    def odd(robot):
        if robot.l11 > 0.15:
            raise KeyError("too long")
        return robot.l11 / (robot.l12 - 0.1)

    done = fb.sweep(
        {"odd": odd, "text": lambda robot: "long"},
        {"l1": [0.1, 0.2, 0.1, 0.1], "l2": [0.2, 0.2, 0.1, 9e9]},
    )
    assert (
        done["odd"][0] == pytest.approx(1.0)
        and np.isnan(done["odd"][1:]).all()
        and np.isnan(done["text"]).all()
    )
    assert done.best("odd").tolist() == [0]
    notes = dict(enumerate([[text for k, text in done.errors if k == n] for n in range(4)]))
    assert notes[0] == ["text: TypeError: it must give one number, not 'long'"]
    assert notes[1][0] == "odd: KeyError: 'too long'" and notes[2][0].startswith(
        "odd: ZeroDivisionError: "
    )
    assert notes[3] == ["l12 = 9e+09 m is outside 1e-09 to 1e+09 m: choose another unit of length"]


def test_a_biglide_has_figures_of_ones_own_only():
    done = fb.sweep(
        lambda robot: robot.l1 + robot.d, {"l1": [0.3, 0.4], "d": [0.4, 0.9]}, robot=fb.Biglide()
    )
    assert done["<lambda>"][0] == 0.7 and "can never close" in done.errors[0][1]
    with pytest.raises(ValueError, match="det_A is of five-bars; of a biglide"):
        fb.sweep("det_A", {"l1": [0.3]}, robot=fb.Biglide(), table=(0.1, 0.1))
