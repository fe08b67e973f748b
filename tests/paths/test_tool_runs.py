"""What follows a tool's path: simulated runs, plans, proofs, set-points, pictures and commands."""

import json

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from fivebar.paths.setpoints import setpoints
from fivebar.visualization.skeleton import run_body

ROBOT = fb.FiveBar(0.1, 0.13, 0.1, 0.13, 0.08, zz1=0.002, zz2=0.002, m=0.3)
LINE = fb.line((-0.03, 0.14), (0.04, 0.15), 0.5)


def tools(count):
    rng = np.random.default_rng(30)
    for _ in range(count):
        yield fb.Tool(int(rng.integers(1, 3)), *rng.uniform(-0.03, 0.03, 2))


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "robot.toml"
    fb.Machine(ROBOT, tool=fb.Tool(1, 0.03, 0.02)).save(path)
    return str(path)


@pytest.fixture(scope="module")
def run():
    led = fb.Tool(1, 0.03, 0.02).path(ROBOT, LINE)
    return fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), led, control_period=0.002)


def test_a_trajectory_is_led_with_its_derivatives():
    for tool in tools(20):
        led = tool.path(ROBOT, LINE)
        assert led.drawn is LINE and led.tool == (tool.leg, tool.along, tool.across)
        t = np.linspace(0.0, 0.5, 201)
        xi, xi_dot, xi_ddot = led(t)
        pose = fb.igm(ROBOT, xi)
        np.testing.assert_allclose(tool.point(pose), LINE(t)[0], atol=1e-14)
        rates = fb.ikm(pose, xi_dot)
        tip_dot = np.einsum("nij,nj->ni", tool.jacobian(pose), rates.q_dot)
        np.testing.assert_allclose(tip_dot, LINE(t)[1], atol=1e-12)
        h = 1e-5
        change = (led(t[1:-1] + h)[1] - led(t[1:-1] - h)[1]) / (2 * h)
        np.testing.assert_allclose(xi_ddot[1:-1], change, atol=1e-6)
        assert [each.shape for each in led(0.1)] == [(2,)] * 3
        assert not np.any(led(0.6)[1:])


def test_a_trajectory_out_of_the_tools_reach_is_refused():
    with pytest.raises(fb.UnreachableError, match=r"at t = 0\.\d+ s the tool does not reach"):
        fb.Tool(1, 0.03).path(ROBOT, fb.line((0.0, 0.15), (0.0, 0.3), 1.0))


def test_the_error_of_a_run_is_that_of_the_tool(run, tmp_path):
    assert 1e-7 < np.abs(run.error).max() < 1e-4
    np.testing.assert_allclose(run.drawn_ref, LINE(run.t)[0], atol=1e-13)
    leg = run_body(run)
    arm = np.linalg.norm(leg.points[:, 5] - leg.points[:, 1], axis=1)
    np.testing.assert_allclose(arm, np.hypot(0.16, 0.02), rtol=1e-9)  # rigid on the left distal bar
    np.testing.assert_allclose(leg.points[:, 5], run.drawn, atol=1e-15)
    run.to_csv(tmp_path / "run.csv")
    again = fb.Run.from_csv(tmp_path / "run.csv")
    assert again.tool == run.tool
    np.testing.assert_array_equal(again.error, run.error)
    rows = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True, skip_header=1)
    np.testing.assert_allclose(rows["x_tip"], run.drawn[:, 0])
    np.testing.assert_allclose(rows["y_tip_ref"], LINE(run.t)[0][:, 1], atol=1e-13)


def test_pictures_and_pages_show_the_tool(run):
    axes = run.plot().axes
    assert "error of the tool" in axes[1].get_title()
    lines = {line.get_label(): line for line in axes[0].lines}
    np.testing.assert_allclose(lines["tool"].get_xydata(), 1e3 * run.drawn)
    scene = run.scene()
    np.testing.assert_allclose(scene.machines[0].body.points[-1, 5], run.drawn[-1], atol=1e-12)
    with pytest.raises(ValueError, match="no 'velocity' to show"):
        run.scene(show="velocity")  # it would be that of joint C
    motion = fb.time_path(
        ROBOT,
        fb.Tool(2, 0.01, -0.02).path(ROBOT, fb.path([(0.0, 0.15), (0.03, 0.16)])),
        constraints=fb.Constraints(acceleration=0.5),
    )
    assert motion.tool == (2, 0.01, -0.02)
    ends = np.concatenate([each.get_segments() for each in motion.plot().axes[0].collections])
    assert np.abs(ends[0][0] - (0.0, 150.0)).max() < 0.1
    x, y = setpoints(ROBOT, motion).xi[-1]
    assert (x, y) == pytest.approx((0.03, 0.16))


def test_many_runs_keep_the_tool_and_a_summary_refuses_it():
    led = fb.Tool(1, 0.03).path(ROBOT, LINE)
    controller = fb.ComputedTorque(ROBOT, 100, 20)
    runs = fb.simulate_many([ROBOT, ROBOT], controller, led)
    np.testing.assert_allclose(runs[0].drawn_ref, LINE(runs[0].t)[0], atol=1e-13)
    with pytest.raises(ValueError, match="not those of the reference's tool"):
        fb.simulate_many([ROBOT, ROBOT], controller, led, summary=fb.Summary())


@pytest.mark.deep
def test_track_plan_and_certify_lead_the_tool(file, tmp_path, capsys):
    ends = ["--from", "-0.03", "0.14", "--to", "0.04", "0.15", "--duration", "0.5"]
    robot = ["--robot", file]
    assert main(["track", *ends, *robot, "--json", "--page", str(tmp_path / "page.html")]) == 0
    assert json.loads(capsys.readouterr().out)["max_error_m"] < 5e-4
    folder = tmp_path / "plan"
    assert main(["plan", *ends, "--via", "0", "0.16", *robot, "--out", str(folder)]) == 0
    rows = np.genfromtxt(folder / "setpoints.csv", delimiter=",", names=True, skip_header=1)
    assert rows["x"][[0, -1]] == pytest.approx((-0.03, 0.04), abs=1e-6)
    assert np.hypot(rows["x"], rows["y"] - 0.16).min() < 1e-3
    (tmp_path / "path.csv").write_text("x,y\n-0.03,0.14\n0.04,0.15\n", encoding="utf-8")
    proof = str(tmp_path / "proof.json")
    words = ["certify", str(tmp_path / "path.csv"), "--units", "m", *robot]
    assert main([*words, "--tolerance", "1e-4", "--out", proof]) == 0
    assert main(["certify", "--check", proof]) == 0
    assert "a tool on leg 1, 0.03 m along its bar" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, said",
    [
        ("--workspace 0 1 0 1", "--workspace is of joint C"),
        ("--acceleration-limit 1", "--acceleration-limit is of joint C"),
        ("--from-working -1 -1", "give --from-working and --to-working both"),
        ("--from-working 1 -1 --to-working -1 -1 --via 0 0.15", "--via with --working only"),
    ],
)
def test_a_plan_of_the_tool_refuses_what_is_of_the_joint(file, words, said, capsys):
    ends = ["--from", "-0.03", "0.14", "--to", "0.04", "0.15"]
    assert main(["plan", *ends, *words.split(), "--robot", file]) == 2
    assert said in capsys.readouterr().err


def test_a_drawing_is_shown_in_the_measuring_frame():
    frame = fb.Placement((0.1, -0.05), np.pi / 2, 2.0)
    stroke = np.array([(0.0, 0.14), (0.02, 0.15)])
    figure = fb.plot.drawing(ROBOT, (-1, -1), [stroke], [], [], frame=frame)
    lines = {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}
    np.testing.assert_allclose(lines["pen at the start"], [1e3 * frame(stroke[0])])
    np.testing.assert_allclose(figure.axes[1].lines[0].get_xydata()[:2], 1e3 * frame(stroke))
