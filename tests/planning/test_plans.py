"""What a plan is beside a motion: a reference, a file, a picture, a page."""

from base64 import b64decode

import numpy as np
import pytest

import fivebar as fb
from fivebar.models.dynamics import bar_force_dynamics
from fivebar.planning import plans
from fivebar.planning.plan import plan
from fivebar.planning.problem import PlanError
from fivebar.visualization.pages.runs import runs_content, sampled

from ..conftest import UNEQUAL
from .conftest import DEGREES, HOME, ROBOT, TASK_1, TASK_2, fine


def test_plan_is_a_reference(crossing):
    for t in (-1.0, 5.0, np.array([-2.0, 9.0])):
        xi, xi_dot, xi_ddot = crossing(t)
        np.testing.assert_allclose(
            xi[..., :], np.where(np.asarray(t)[..., None] < 0, HOME, TASK_2), atol=1e-9
        )
        assert not xi_dot.any() and not xi_ddot.any() and not crossing.torques(t).any()
    assert [part.shape for part in crossing(0.3)] == [(2,)] * 3 and crossing.torques(0.3).shape == (
        2,
    )
    assert [part.shape for part in crossing(np.zeros((3, 4)))] == [(3, 4, 2)] * 3
    assert (crossing.start, crossing.duration) == (0.0, 4.0)
    assert len(crossing.nodes) == 3 * len(crossing.defects) and (np.diff(crossing.nodes) > 0).all()
    for end, within in ((0.0, 1e-9), (4.0, 4.0 - 1e-9)):  # it is the motion at its ends, too
        assert crossing(end)[2] == pytest.approx(crossing(within)[2], rel=1e-5)
        assert crossing.torques(end) == pytest.approx(crossing.torques(within), rel=1e-5)
        assert np.abs(crossing.torques(end)).min() > 1e-6
    push, _ = bar_force_dynamics(
        crossing.accelerations(crossing.nodes), crossing.bar_forces(crossing.nodes).T
    )
    assert np.abs(push).max() <= 1e-8


@pytest.mark.parametrize(
    "options",
    [
        *DEGREES,
        dict(
            constraints=fb.Constraints(
                torque=(0.02, 0.03), region=((-0.1, -0.1), (0.1, -0.1), (0.1, 0.2), (-0.1, 0.2))
            )
        ),
    ],
)
def test_csv_round_trip(options, tmp_path):
    written = plan(UNEQUAL, (0.05, 0.15), (-0.05, 0.1), 2.0, **options)
    written.to_csv(tmp_path / "plan.csv")
    read = plans.Plan.from_csv(tmp_path / "plan.csv")
    t = fine(written)
    for a, b in zip((*written(t), written.torques(t)), (*read(t), read.torques(t))):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * np.abs(a).max() + 1e-15)
    assert (
        read.problem.constraints == written.problem.constraints
        and read.problem.stops == written.problem.stops
    )
    assert (read.objective, read.status, read.meshes) == (
        written.objective,
        written.status,
        written.meshes,
    )
    assert read.violations == pytest.approx(written.violations, abs=1e-12)
    from_table = fb.from_csv(tmp_path / "plan.csv")  # it is a path like any other, too
    np.testing.assert_allclose(from_table(1.0)[0], written(1.0)[0], atol=1e-6)
    lines = (tmp_path / "plan.csv").read_text("utf-8").splitlines(keepends=True)
    rows = np.array([line.split(",") for line in lines[2:]], dtype=float)
    assert (
        rows[0, 0] == 0.0 and rows[-1, 0] == written.duration
    )  # the ends, where Legendre and Gauss have no node
    for row in (rows[0], rows[-1]):
        np.testing.assert_allclose(
            row[1:9], np.concatenate([*written(row[0]), written.torques(row[0])]), atol=1e-12
        )
    for name, text, words in (
        ("a", lines[1:], "line 1: not a file"),
        ("b", lines[:-1], "rows, its first line"),
        ("c", lines[:-2], "the times are not those|rows, its first line"),
    ):
        (tmp_path / name).write_text("".join(text), encoding="utf-8")
        with pytest.raises(ValueError, match=words):
            plans.Plan.from_csv(tmp_path / name)


def test_picture(crossing, fastest, tmp_path):
    figure = crossing.plot(tmp_path / "plan.png")
    assert len(figure.axes) == 3 and (tmp_path / "plan.png").stat().st_size > 10_000
    path, torques, sines = fastest.plot().axes
    labels = [text.get_text() for text in torques.get_legend().get_texts()]
    assert any("limit, reached 100 %" in label for label in labels)
    assert "Type 2" in [text.get_text() for text in path.get_legend().get_texts()]


def test_page_and_animation_show_themselves(crossing, fastest, tmp_path):
    shown = crossing.page(tmp_path / "plan.html")
    assert (tmp_path / "plan.html").read_text(
        "utf-8"
    ) == shown.html and "<iframe" in shown._repr_html_()
    content = runs_content({"": sampled(crossing)})
    assert [panel["title"] for panel in content["panels"]][:2] == ["end-effector", "motor torques"]
    (subject,), t = content["subjects"], np.linspace(0.0, crossing.duration, 2001)
    ((when, what),) = subject["marks"]
    assert what == "Type 2" and crossing.accelerations(when).rates.pose.det_A == pytest.approx(
        0, abs=1e-6
    )
    for key, values in (("tau left", crossing.torques(t)[:, 0]), ("xi y", crossing(t)[0][:, 1])):
        np.testing.assert_array_equal(
            np.frombuffer(b64decode(subject["columns"][key]["f8"])), values
        )
    assert runs_content({"": sampled(fastest)})["panels"][1]["limits"] != []
    (notice,) = crossing.animate(tmp_path / "plan.html").machines[0].events
    assert notice.t == pytest.approx(when, abs=1e-3) and notice.text.startswith("Type 2")
    assert "<iframe" in crossing.animate()._repr_html_() and repr(crossing.animate()).startswith(
        "Scene('five-bar robot,"
    )


def test_nothing_is_printed(capfd):
    plan(ROBOT, HOME, TASK_1, 2.0)
    with pytest.raises(PlanError):
        plan(ROBOT, HOME, TASK_1, 2.0, constraints=fb.Constraints(torque=1e-4))
    assert capfd.readouterr() == ("", "")
