"""Scenes without a browser: what is computed, what is refused, and what is written."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar import linkages
from fivebar.study.pitfalls import crossing
from fivebar.visualization import view
from fivebar.visualization.loci import crossings
from fivebar.visualization.view import shows, sources
from fivebar.visualization.view.frames import MOST, choose
from fivebar.visualization.view.layers import Arrows, LineLayer, TurningArrows
from fivebar.visualization.view.solids import dash_pieces

from .conftest import ROBOT, long_run


def layers(scene, kind=object):
    return [
        layer for machine in scene.machines for layer in machine.layers if isinstance(layer, kind)
    ]


def test_a_scene_computes_only_what_it_draws(run, monkeypatch):
    called = []

    def counted(module, name):
        own = getattr(module, name)
        monkeypatch.setattr(
            module, name, lambda *given, **options: called.append(name) or own(*given, **options)
        )

    for name in (
        "dkm",
        "ikm",
        "ikm2",
        "forward_dynamics",
        "bar_forces",
        "inverse_dynamics",
        "igm",
        "measured_pose",
    ):
        counted(sources, name)
    counted(shows, "singularity_loci")
    plan = fb.line((0.09, 0.068), (0.0, 0.1), 1.0)
    for motion, show, expected in [
        (run, ["trace", "reference", "elbow-circles"], []),
        (run, ["velocity"], ["dkm", "measured_pose"]),
        (run, ["acceleration"], ["dkm", "forward_dynamics", "measured_pose"]),
        (run, ["bar-forces"], ["bar_forces", "dkm", "measured_pose"]),
        (run, ["torques"], []),
        (run, ["loci"], ["measured_pose", "singularity_loci"]),
        (plan, ["trace", "velocity", "acceleration"], ["igm"]),
        (plan, ["torques"], ["igm", "ikm", "ikm2", "inverse_dynamics"]),
    ]:
        called.clear()
        view.scene(ROBOT, motion, show)
        assert sorted(set(called)) == expected, show


def test_vectors_of_a_run_are_those_of_its_own_differences():
    run = fb.simulate(ROBOT, lambda t, q, q_dot, reference: (0.002, -0.0016), None, duration=0.5)
    scene = view.scene(ROBOT, run, ["velocity", "acceleration", "bar-forces"])
    velocity, acceleration, left, right = layers(scene, Arrows)
    index, step, xi = scene.machines[0].frames.index[1:-1], run.t[1], run.xi
    np.testing.assert_allclose(
        velocity.vectors[1:-1], (xi[index + 1] - xi[index - 1]) / (2 * step), atol=1e-6
    )
    second = (xi[index + 1] - 2 * xi[index] + xi[index - 1]) / step**2
    np.testing.assert_allclose(acceleration.vectors[1:-1], second, atol=1e-5)
    np.testing.assert_allclose(
        left.vectors + right.vectors, ROBOT.m * acceleration.vectors, atol=1e-12
    )
    index = scene.machines[0].frames.index
    for forces, elbow in zip(
        (left.vectors, right.vectors), np.moveaxis(run.points[index][:, [1, 3]], 1, 0)
    ):
        bar = xi[index] - elbow
        np.testing.assert_allclose(
            bar[:, 0] * forces[:, 1] - bar[:, 1] * forces[:, 0], 0, atol=1e-12
        )
    assert (
        left.largest == right.largest == np.linalg.norm([left.vectors, right.vectors], axis=2).max()
    )


def test_bar_forces_are_finite_across_a_singularity(crossing_run):
    forces = np.stack(
        [layer.vectors for layer in layers(view.scene(ROBOT, crossing_run, "bar-forces"), Arrows)]
    )
    assert np.isfinite(forces).all() and np.abs(forces).max() < 0.1


def test_bar_forces_without_inertia_of_the_drives_move_the_end_effector():
    robot = fb.FiveBar(zz1=0.0, zz2=0.0)
    scene = view.scene(robot, fb.circle((0.0, 0.12), 0.03, 1.0), ["acceleration", "bar-forces"])
    acceleration, left, right = (layer.vectors for layer in layers(scene, Arrows))
    np.testing.assert_allclose(left + right, robot.m * acceleration, atol=1e-13)


def test_torques_turn_as_the_motors_do(run):
    scene = view.scene(ROBOT, run, "torques")
    tau = run.tau[scene.machines[0].frames.index]
    for leg, layer in enumerate(layers(scene, TurningArrows)):
        np.testing.assert_allclose(
            layer.sweeps(), np.radians(300) * tau[:, leg] / np.abs(tau).max()
        )


def test_loci_are_singular_and_change_with_the_working_modes(crossing_run):
    free = fb.simulate(
        ROBOT,
        None,
        None,
        duration=0.7,
        start=fb.ikm(fb.igm(ROBOT, (0.01, 0.12), (1, -1)), (0.02, -0.3)),
    )
    assert len({event.after[:2] for event in free.events}) > 1
    scene = view.scene(ROBOT, free, "loci")
    lines = layers(scene, LineLayer)
    assert all(line.good is not None for line in lines)
    shown = np.stack([line.good for line in lines if line.dash is None])
    assert (shown.sum(axis=0) == 1).all(), "one mode's loci at a time"
    for line in layers(view.scene(ROBOT, crossing_run, "loci"), LineLayer):
        points = np.concatenate([path for path in line.paths if np.ptp(path, axis=0).max() > 0.01])
        pose = fb.igm(ROBOT, points * (1 - 1e-9), (-1, -1), unreachable="nan")
        margins = np.nanmin(np.abs([*pose.sines, pose.det_A]), axis=0)
        assert np.nanmax(margins) < 1e-3


def test_plans_and_references_have_events_and_gaps():
    straight = view.scene(ROBOT, crossing.straight()).machines[0]
    assert [event.t for event in straight.events] == pytest.approx([3.172591], abs=2e-4)
    assert "Type 2 singularity (det A = 0)" in straight.events[0].text
    out = view.scene(ROBOT, fb.line((0.0, 0.1), (0.0, 0.3), 2.0))
    ((low, high),) = out.machines[0].frames.gaps
    edge = np.sqrt(0.18**2 - 0.059**2)
    assert (
        fb.line((0.0, 0.1), (0.0, 0.3), 2.0)(low)[0][1] == pytest.approx(edge, abs=5e-3)
        and high == 2.0
    )
    assert "out of reach" in out.notes[0]


def test_plans_show_their_own_torques_and_forces():
    plan = fb.plan(ROBOT, (0.09, 0.068), (0.05, 0.0), 1.5)
    scene = view.scene(
        ROBOT, plan, ["trace", "loci", "velocity", "acceleration", "torques", "bar-forces"]
    )
    (machine,), t = scene.machines, scene.machines[0].frames.t
    xi, xi_dot, xi_ddot = plan(t)
    np.testing.assert_array_equal(machine.body.points[:, machine.body.traced], xi)
    velocity, acceleration, *forces = layers(scene, Arrows)
    np.testing.assert_array_equal([velocity.vectors, acceleration.vectors], [xi_dot, xi_ddot])
    np.testing.assert_array_equal(
        [layer.values for layer in layers(scene, TurningArrows)], plan.torques(t).T
    )
    u = plan.accelerations(t).rates.pose.A
    for leg, layer in enumerate(forces):
        expected = plan.bar_forces(t)[:, leg, None] * u[:, leg]
        np.testing.assert_allclose(layer.vectors, expected, atol=1e-3 * layer.largest)
    assert [event.text.split(" at ")[0] for event in machine.events] == [
        "Type 2 singularity (det A = 0)"
    ]


def test_a_million_samples_are_thinned_with_a_note(tmp_path):
    t = np.arange(1_000_000) * 1e-3
    frames = choose(t, np.zeros(len(t)))
    assert len(frames.index) == MOST and frames.index[[0, -1]].tolist() == [0, 999_999]
    assert "3600 of 1000000 samples" in frames.notes[0]
    assert choose(t[:10_001], t[:10_001]).notes == ()
    q = np.stack([0.3 * np.sin(t / 50), 0.2 * np.sin(t / 70)], axis=1)
    run = long_run(t, q)
    path = tmp_path / "long.html"
    view.scene(ROBOT, run, ["trace", "velocity", "torques"]).save(path)
    assert path.stat().st_size < 2_000_000 and "3600 of 1000000 samples" in path.read_text("utf-8")


def test_samples_that_are_not_numbers_are_a_gap():
    t = np.linspace(0, 2, 201)
    q = np.stack([np.sin(t), np.cos(t)], axis=1) * 0.2
    q[50:60] = np.nan
    q[100, 1] = np.inf
    scene = view.scene(ROBOT, long_run(t, q))
    frames = scene.machines[0].frames
    np.testing.assert_allclose(frames.gaps, [(0.495, 0.595), (0.995, 1.005)])
    assert not set(frames.index) & {*range(50, 60), 100} and {49, 60, 99, 101} <= set(frames.index)
    times, shown = frames.switches
    assert times.tolist() == pytest.approx([0, 0.495, 0.595, 0.995, 1.005]) and shown.tolist() == [
        1,
        0,
        1,
        0,
        1,
    ]
    assert scene.notes[0].startswith("11 of 201 samples are not numbers")
    (trace,) = layers(scene, LineLayer)
    assert len(trace.paths) == 3 and all(np.isfinite(path).all() for path in trace.paths)


def test_only_what_is_not_known_is_left_out(run, tmp_path):
    """The mechanism goes on where only its rates, torques or reference are not numbers."""
    tau, q_dot, xi_ref = run.tau.copy(), run.q_dot.copy(), run.xi_ref.copy()
    tau[100:200], q_dot[250:300], xi_ref[300:350], xi_ref[400:] = np.nan, np.nan, np.nan, (1, 1)
    scene = view.scene(ROBOT, replace(run, tau=tau, q_dot=q_dot, xi_ref=xi_ref), view.SHOWS)
    index, whole = scene.machines[0].frames.index, view.scene(ROBOT, run, view.SHOWS)
    assert scene.notes == ()
    lost = {"tau": (index >= 100) & (index < 200), "q_dot": (index >= 250) & (index < 300)}
    lost["xi_ref"] = (index >= 300) & (index < 350) | (index >= 400)
    for layer, full in zip(layers(scene), layers(whole)):
        if isinstance(layer, (Arrows, TurningArrows)):
            name = {Arrows: "vectors", TurningArrows: "values"}[type(layer)]
            values, expected = (getattr(x, name).reshape(len(index), -1) for x in (layer, full))
            missing = {"velocity": lost["q_dot"]}.get(layer.name, lost["tau"])
            if layer.name in ("acceleration", "bar-forces"):
                missing = lost["tau"] | lost["q_dot"]
            np.testing.assert_allclose(values[~missing], expected[~missing], atol=1e-12)
            assert np.isnan(values[missing]).all(), layer.name
    (reference,) = (layer for layer in layers(scene, LineLayer) if layer.name == "reference")
    assert len(reference.paths) == 2
    nothing = replace(run, tau=tau * np.nan, q_dot=q_dot * np.nan, xi_ref=xi_ref * np.nan)
    scene = view.scene(ROBOT, nothing, view.SHOWS)
    assert "NaN" not in scene.html.split("<script", 4)[3] and scene.png


def test_dashes_begin_and_end_a_path():
    path = np.array([(0, 0), (1, 0), (1, 1.0)])
    pieces = dash_pieces(path, 0.2, 0.1)
    np.testing.assert_allclose([pieces[0][0], pieces[-1][-1]], path[[0, -1]], atol=1e-15)
    lengths = [np.hypot(*np.diff(piece, axis=0).T).sum() for piece in pieces]
    np.testing.assert_allclose(lengths, lengths[0])
    assert lengths[0] == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize("held", ["guide", "crank", "rod", "slider"])
def test_linkages_slide_where_they_do(held):
    study = linkages.study(
        linkages.SliderCrank(0.1, 0.3, held=held), drive="swing" if held == "slider" else "turn"
    )
    machine = view.scene(study.linkage, study, ["trace", "velocity"]).machines[0]
    assert len(machine.body.rails) == 1 and len(machine.body.blocks) == (held != "slider")
    for i, j, _ in machine.body.blocks:  # the block lies on the line of its guide
        (g, h), middle = (
            machine.body.rails[0],
            (machine.body.points[:, i] + machine.body.points[:, j]) / 2,
        )
        span, to = (
            machine.body.points[:, h] - machine.body.points[:, g],
            middle - machine.body.points[:, g],
        )
        np.testing.assert_allclose(span[:, 0] * to[:, 1] - span[:, 1] * to[:, 0], 0, atol=1e-12)


def test_lines_without_ends_are_drawn_where_the_biglide_is():
    reference = fb.line((0.0, 5.2), (0.06, 5.25), 2.0)
    scene = view.scene(fb.Biglide(), reference, "loci")
    for line in layers(scene, LineLayer):
        assert [sorted(path[:, 1]) for path in line.paths] == [
            pytest.approx([4.86, 5.39], abs=0.01)
        ] * len(line.paths)
        assert all(
            abs(path[0, 0]) == pytest.approx(0.0828427) and np.ptp(path[:, 0]) == 0
            for path in line.paths
        )
    assert scene.window[1][1] - scene.window[0][1] < 0.7


def test_crossings_are_found_once_also_on_a_sample():
    t, one = np.array([0.0, 1.0, 3.0, 4.0, 5.0, 6.0]), np.ones(6)
    for sines, expected in [
        ((3, 1, -1, -2, -2, -2), [2.0]),
        ((2, 0, -1, -2, -2, -2), [1.0]),
        ((-2, -1, 0, 1, 2, 2), [3.0]),
        ((1, np.nan, -1, -1, 1, 1), [4.5]),
        ((0, 1, 2, 1, 1, 1), []),
    ]:
        pose = SimpleNamespace(sines=(one, np.array(sines, dtype=float)), det_A=one)
        found = list(crossings(t, pose))
        assert [(when, kind, margin) for when, kind, margin, *_ in found] == [
            (when, 1, 1) for when in expected
        ]


def test_biglide_has_driven_feet_on_rails():
    robot = fb.Biglide()
    reference = fb.line((0.0, 0.2), (0.05, 0.15), 0.5)
    run = fb.simulate(robot, fb.PD(robot, 200.0, 30.0), reference)
    scene = view.scene(robot, run, ["trace", "torques", "velocity", "loci"])
    (machine,), index = scene.machines, scene.machines[0].frames.index
    assert (
        scene.title == "biglide robot, all bars 282.8 mm, base 400 mm"
        and len(set(machine.body.colours)) == 2
    )
    for leg, ((foot, tip), block, rail) in enumerate(
        zip(machine.body.bars, machine.body.blocks, machine.body.rails)
    ):
        np.testing.assert_allclose(machine.body.points[:, foot, 0], (-0.2, 0.2)[leg])
        np.testing.assert_allclose(machine.body.points[:, foot, 1], run.q[index, leg])
        np.testing.assert_array_equal(machine.body.points[:, tip], run.xi[index])
        np.testing.assert_allclose(
            machine.body.points[:, block[:2]].mean(axis=1), machine.body.points[:, foot]
        )
        low, high = machine.body.points[0, rail, 1]
        assert (
            low < run.q[:, leg].min()
            and run.q[:, leg].max() < high
            and block[2] == foot in machine.body.actuated
        )
    forces = [layer for layer in layers(scene, Arrows) if layer.name == "forces"]
    np.testing.assert_array_equal([layer.vectors[:, 1] for layer in forces], run.tau[index].T)
    assert "F\\u2081, F\\u2082: motor forces (longest" in scene.html and scene.png
    with pytest.raises(ValueError, match="are for cranks"):
        view.scene(robot, run, "elbow-circles")


# sRGB as people without one kind of cone see it: Machado, Oliveira and Fernandes 2009, severity 1, on linear values.
MACHADO = {
    "all cones": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def lab(colour, seen):
    """CIE L*a*b* of a colour as it is seen."""
    rgb = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(seen @ linear, 0, 1) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("cones", MACHADO)
def test_colours_of_a_scene_are_told_apart_by_the_colour_blind(run, cones):
    (machine,) = view.scene(ROBOT, run, view.SHOWS).machines
    lines = {
        layer.colour
        for layer in machine.layers
        if isinstance(layer, (LineLayer, Arrows, TurningArrows))
    }
    names = sorted(lines | set(machine.body.colours))
    seen = np.stack([lab(name, np.array(MACHADO[cones])) for name in names])
    apart = np.linalg.norm(seen[:, None] - seen, axis=2) + 100 * np.eye(len(names))
    assert len(names) >= 11 and apart.min() > 12, [
        names[k] for k in np.unravel_index(apart.argmin(), apart.shape)
    ]
