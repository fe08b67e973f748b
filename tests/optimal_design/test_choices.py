"""Choices of a design by their names, and what is kept on disk: each number that does not go is refused by its name."""

import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.base import shards
from fivebar.models.motors import MOTORS, Motor
from fivebar.optimal_design.closed_forms import _lens
from fivebar.optimal_design.evolution import evolve, refine, thinned
from fivebar.optimal_design.optimum import DesignProblem
from fivebar.optimal_design.results import plain_parameters, robot_of_plain
from fivebar.optimal_design.task import task_of

LENGTHS = {"l1": (0.05, 0.3), "d": (0.0, 0.2)}


@pytest.mark.parametrize("motor", [Motor(2.0, 5.0), (2.0, 5.0), [2, 5]])
def test_a_motor_is_taken_as_it_is_given(motor):
    assert task_of({"motor": motor}).motor == Motor(2.0, 5.0)


def test_a_motor_is_taken_by_its_name():
    name = next(iter(MOTORS))
    assert task_of({"motor": name}).motor == MOTORS[name]


@pytest.mark.parametrize(
    "choice,words",
    [
        ({"motor": (0.0, 5.0)}, "motor: Motor: stall_torque must be"),
        ({"motor": (2.0, -5.0)}, "motor: Motor: no_load_speed must be"),
        ({"motor": (1, 2, 3)}, "motor must be"),
        ({"table": (0, 1, 2, 2)}, r"table = \(x_min, x_max, y_min, y_max\) must rise"),
        ({"table": (1, 1, 0, 2)}, r"table = .* must rise"),
        ({"table": (0, 1, 0, np.nan)}, "table must be"),
        ({"disc": 0.0}, "disc must be"),
        ({"table": (1, 1), "poses": 1}, "poses must be"),
        ({"table": (1, 1), "poses": (3, 10**5)}, "poses must be"),
    ],
)
def test_choices_that_do_not_go(choice, words):
    with pytest.raises((ValueError, TypeError), match=f"^{words}"):
        task_of(choice)


@pytest.mark.parametrize("effort", [0.0, 1e-3, 101.0, np.inf, None, "much"])
def test_an_effort_beyond_its_range(effort):
    with pytest.raises((ValueError, TypeError), match="^effort must be"):
        fb.design("workspace_area", LENGTHS, effort=effort)


def test_a_table_out_of_reach_counts_by_how_far_it_is():
    task = task_of({"table": (0.2, 0.1), "poses": 5})
    bounds = {"l1": (0.01, 0.3), "l2": (0.01, 0.3), "d": 0.1}
    problem = DesignProblem("bars", bounds, {}, fb.FiveBar(), None, task, None)
    for leg in (0.06, 0.08, 0.1):
        _, violation = problem(np.array([[leg / 2, leg / 2, 0.1]]))
        farthest = np.hypot(0.1 + 0.05, 0.05)  # a corner from the other base joint
        assert violation[0] == pytest.approx(10 + (farthest - leg) / 0.2, rel=1e-12)


def test_a_search_that_does_not_settle_ends_by_its_effort():
    """Of what is noise no generation is the last by itself."""

    def calls_with(effort):
        seen = []
        noise = np.random.default_rng(0)
        goal = {lambda robot: seen.append(robot) or noise.uniform(): "min"}
        fb.design(goal, {"l1": (0.1, 0.2)}, effort=effort)
        return len(seen)

    assert calls_with(0.02) - calls_with(0.01) == 3 * 20  # three generations of twenty


@pytest.mark.parametrize(
    "limit,words",
    [
        (("a", None), "limits: bars's low must be"),
        ((None, "b"), "limits: bars's high must be"),
        ((2.0, 1.0), r"limits: bars = \(2, 1\) is the wrong way round"),
        ((None, None), "limits: bars has neither"),
        ((1, 2, 3), r"limits: bars must have \(low, high\) or a number"),
    ],
)
def test_limits_that_do_not_go(limit, words):
    with pytest.raises((ValueError, TypeError), match=f"^{words}"):
        fb.design("workspace_area", LENGTHS, limits={"bars": limit})


def test_designs_say_what_they_are():
    assert (
        repr(fb.optimal_design.grid({"l1": [0.1, 0.2], "d": [0.0, 0.1, 0.2]}))
        == "<Designs: l1, d, 6 rows>"
    )


@pytest.mark.parametrize("robot", [fb.FiveBar(l12=0.11), fb.Biglide()])
def test_a_design_comes_back_from_its_file(robot, tmp_path):
    name = next(iter(robot.parameters))
    value = getattr(robot, name)
    found = fb.design(lambda one: getattr(one, name), {name: value}, robot=robot)
    found.save(tmp_path / "one.json")
    again = fb.optimal_design.Design.load(tmp_path / "one.json")
    assert again.as_json() == found.as_json() and again.robot == robot


@pytest.mark.parametrize(
    "robot", [fb.FiveBar(gravity=(0.0, -9.81), l11=0.1), fb.Biglide(0.1, 0.2, 0.1)]
)
def test_a_robot_comes_back_from_plain_numbers(robot):
    plain = json.loads(json.dumps(plain_parameters(robot)))
    assert robot_of_plain(plain) == robot
    assert all(not isinstance(value, list) for value in robot_of_plain(plain).parameters.values())


def test_a_step_gives_no_negative_zero_and_bounds_are_met():
    """What is a billionth of the range from a bound is put on it; the rest to multiples of the step."""
    found = fb.design("workspace_area", {"l1": (0.05, 0.3), "d": (0.0, 0.2)}, step=0.01)
    values = np.array(list(found.parameters.values()))
    assert not np.signbit(values).any()
    assert values == pytest.approx(np.round(values, 2), abs=1e-12)


@pytest.mark.parametrize(
    "r1,r2,d", [(1.0, 0.6, 0.9), (0.5, 0.5, 0.3), (1.0, 0.2, 1.1), (1, 0.3, 0.5), (1, 1, 2.5)]
)
def test_what_two_discs_have_in_common(r1, r2, d):
    """By the widths of both across x, of one pair and of several at once, one of them touching nothing."""
    x = -1.2 + 3.4 * (np.arange(10**5) + 0.5) / 10**5
    halves = [np.sqrt(np.maximum(r * r - (x - at) ** 2, 0)) for r, at in ((r1, 0.0), (r2, d))]
    common = 3.4 * np.mean(2 * np.minimum(*halves))
    assert float(_lens(r1, r2, np.float64(d))) == pytest.approx(common, abs=1e-6)
    both = _lens(np.array([r1, r1]), np.array([r2, 0.0]), np.array([d, 0.0]))
    assert both == pytest.approx([common, 0.0], abs=1e-6)


@pytest.fixture
def kept(tmp_path):
    fb.sweep(
        "bars", {"l1": [0.1, 0.2, 0.3], "d": [0.1, 0.1, 0.1]}, out=tmp_path / "swept", workers=1
    )
    return tmp_path / "swept"


@pytest.mark.parametrize(
    "change,words",
    [
        ({"what": "a cake"}, "it is of 'a cake'"),
        ({"robot": []}, "its robot, choices and designs are no tables"),
        ({"done": {"chunks": -1, "designs": 3}}, "chunks must be a whole number"),
        ({"done": {"chunks": 1, "designs": "all"}}, "designs must be a whole number"),
        ({"done": {"chunks": 1}}, "designs"),
        ({"variables": "l1"}, "variables must be"),
        ({"figures": [{"name": 3}]}, "figures"),
    ],
)
def test_a_manifest_that_was_changed_is_refused(kept, change, words):
    file = kept / "manifest.json"
    file.write_text(json.dumps(json.loads(file.read_text("utf-8")) | change), "utf-8")
    with pytest.raises(ValueError, match=f"is not what a sweep left there .*{words}"):
        shards.read_manifest(kept, "sweep")


@pytest.mark.parametrize(
    "change,words",
    [
        ({"error_at": np.zeros(2, dtype=int)}, "its errors are not one a row"),
        ({"error_at": np.zeros(0)}, "its errors are not one a row"),
        ({"values": np.zeros((2, 1))}, "values of shape"),
        ({"values": np.zeros((3, 1), dtype=int)}, "values of shape"),
        ({"designs": np.zeros(3)}, "designs of shape"),
        ({"error_text": np.frombuffer(b"[1]", dtype=np.uint8)}, "errors"),
    ],
)
def test_a_chunk_that_was_changed_is_refused(kept, change, words):
    file = shards.shard(kept, 0)
    with np.load(file) as known:
        arrays = {name: known[name] for name in known} | change
    np.savez(file, **arrays)
    with pytest.raises(ValueError, match=f"is no chunk of a sweep, or not whole .*{words}"):
        shards.read_chunk(file, "sweep")


def test_a_thinned_front_has_its_ends_and_even_gaps_wherever_it_lies():
    """Shifted and scaled it is the same choice."""
    s = np.sort(np.random.default_rng(0).uniform(0, 1, 300))
    front = np.stack([s, 1 - s], axis=1)
    chosen = thinned(front, np.arange(300), 11)
    assert {0, 299} <= set(chosen) and len(set(chosen)) == 11
    assert sorted(chosen) == sorted(thinned(front * (3, 50) + (-7, 1000), np.arange(300), 11))
    assert np.diff(np.sort(s[chosen])).max() < 0.2


def test_a_group_starts_about_its_own_points():
    """Without one generation each point is as good as it was, and its neighbours are near it."""
    low, high = np.zeros(3), np.ones(3)
    x = np.random.default_rng(1).uniform(0.4, 0.6, (30, 3))
    seen = []

    def evaluate(rows):
        seen.append(rows)
        return rows[:, :2].copy(), np.zeros(len(rows))

    f = x[:, :2].copy()
    refine(evaluate, low, high, x, f, [0, 5, 9], 8, 0, np.random.default_rng(2))
    first = seen[0]
    assert len(first) == 24 and (first > 0.3).all() and (first < 0.7).all()
    assert np.abs(first.reshape(3, 8, 3)[:, 0] - x[[0, 5, 9]]).max() == 0


def bent(x):
    """Two goals whose front is x_1 = 0: the first is least at x_0 = 0, the second at x_0 = 1."""
    waste = x[:, 1] ** 2
    return np.stack([x[:, 0] ** 2 + waste, (1 - x[:, 0]) ** 2 + waste], axis=1)


@pytest.mark.parametrize("units", [(1.0, 1024.0), (2.0**-20, 1.0), (8.0, 8.0)])
def test_a_search_does_not_depend_on_the_units_of_its_goals(units):
    low, high = np.array([0.0, -1.0]), np.ones(2)

    def searched(units):
        def evaluate(x):
            return bent(x) * units, np.zeros(len(x))

        rng = np.random.default_rng(4)
        x, f, _ = evolve(evaluate, low, high, 30, 5, rng)
        chosen = thinned(f, np.arange(len(f)), 7)
        return [x, refine(evaluate, low, high, x, f, chosen, 8, 4, rng)[0]]

    for one, other in zip(searched(np.ones(2)), searched(np.array(units))):
        assert (one == other).all()


def test_refined_points_come_to_the_front_and_its_ends_to_the_best():
    """Each keeps its place along the front, is no worse than before, and stays within the bounds."""
    low, high = np.array([0.0, -1.0]), np.ones(2)
    x = np.random.default_rng(1).uniform((0, -0.2), (1, 0.2), (60, 2))
    f = bent(x)
    chosen = [int(f[:, 0].argmin()), 5, 9, 17, int(f[:, 1].argmin())]
    seen, ends = [], []

    def evaluate(rows):
        seen.append(rows.copy())
        return bent(rows), np.zeros(len(rows))

    found, g, violation = refine(
        evaluate, low, high, x, f, chosen, 12, 40, np.random.default_rng(2), lambda: ends.append(1)
    )
    assert len(ends) == 40 and len(seen) == 41 and not violation.any()
    everything = np.concatenate(seen)
    assert (everything >= low).all() and (everything <= high).all()
    assert (g == bent(found)).all()
    assert np.abs(found[:, 1]).max() < 0.01
    assert found[0, 0] < 1e-3 and found[-1, 0] > 1 - 1e-3
    # Both goals gain by equal shares: the difference of both, over the range, stays.
    span = np.ptp(f[chosen], axis=0)
    gained = (f[chosen] - g)[1:-1] / span
    assert (gained > -1e-9).all()
    assert gained[:, 0] == pytest.approx(gained[:, 1], abs=0.02)


def test_refined_points_keep_limits_first():
    """The optimum beyond a limit is not taken; what violated it comes inside."""
    low, high = np.zeros(2), np.ones(2)
    x = np.random.default_rng(1).uniform(0.0, 0.3, (40, 2))

    def evaluate(rows):
        return bent(rows), np.maximum(0.2 - rows[:, 0], 0)

    f = bent(x)
    chosen = [0, 1, 2, 3]
    found, _, violation = refine(
        evaluate, low, high, x, f, chosen, 10, 30, np.random.default_rng(3)
    )
    assert not violation.any() and (found[:, 0] >= 0.2).all()
    assert found[:, 0].min() < 0.22
