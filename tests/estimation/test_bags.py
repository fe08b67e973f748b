"""Bags of ROS 2, written here by rosbags: joints in any order, references, what is missing."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.cli import main
from tests.amoro.test_run import START

rosbags = pytest.importorskip("rosbags")
from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

TYPES = get_typestore(Stores.ROS2_JAZZY)
ROBOT = fb.FiveBar()
STORAGES = StoragePlugin.SQLITE3, StoragePlugin.MCAP
EPOCH = 1_700_000_000 * 10**9
T = 0.01 * np.arange(20)
Q = np.stack([0.3 * np.sin(T), 0.2 * np.cos(T)], axis=1)
NAMES = {"left_motor": 0, "elbow": None, "right_motor": 1}


def message(kind, *parts):
    return TYPES.types[kind](*parts)


def header(t):
    stamp = message("builtin_interfaces/msg/Time", *divmod(t, 10**9))
    return message("std_msgs/msg/Header", stamp, "")


def states(effort=True, names=NAMES, stamped=True):
    """(time of recording, message) of joint states; the names take turns, as ROS promises no order."""
    kind = "sensor_msgs/msg/JointState"
    for k, (t, q) in enumerate(zip(T, Q)):
        stamp = EPOCH + round(t * 1e9)
        order = list(names)[:: (-1) ** k]
        position = np.array([9.0 if names[name] is None else q[names[name]] for name in order])
        own = [order, position, 2 * position, 3 * position if effort else np.zeros(0)]
        yield stamp + 5 * 10**9, kind, message(kind, header(stamp if stamped else 0), *own)


def trajectory():
    """A reference of the joints: each point is Q a second later."""
    kind = "trajectory_msgs/msg/JointTrajectory"
    points = []
    for t, q in zip(T, Q):
        after = message("builtin_interfaces/msg/Duration", 0, round(t * 1e9))
        numbers = (q[::-1].copy(), np.zeros(2), np.zeros(2), np.zeros(2), after)
        points.append(message("trajectory_msgs/msg/JointTrajectoryPoint", *numbers))
    own = message(kind, header(EPOCH), ["right_motor", "left_motor"], points)
    return [(EPOCH, kind, own)]


def poses(x=0.0, earlier=0):
    """Poses x m beside, without a header: of the recorder's time, 5 s behind, but for some ns."""
    kind = "geometry_msgs/msg/Pose"
    upright = message("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    for t, xi in zip(T, fb.dgm(ROBOT, Q).xi):
        place = message("geometry_msgs/msg/Point", xi[0] + x, xi[1], 0.0)
        yield EPOCH + 5 * 10**9 + round(t * 1e9) - earlier, kind, message(kind, place, upright)


def bag(path, topics, storage=StoragePlugin.MCAP):
    with Writer(path, version=9, storage_plugin=storage) as writer:
        for topic, messages in topics.items():
            connection = None
            for t, kind, own in messages:
                connection = connection or writer.add_connection(topic, kind, typestore=TYPES)
                writer.write(connection, t, TYPES.serialize_cdr(own, kind))
    return path


@pytest.mark.parametrize("storage", STORAGES)
def test_joint_states_in_any_order_of_names(tmp_path, storage):
    path = bag(tmp_path / "bag", {"/joint_states": states()}, storage)
    run = fb.from_bag(path)
    np.testing.assert_allclose(run.t, T, atol=1e-9)
    np.testing.assert_allclose(run.q, Q, atol=1e-15)
    np.testing.assert_allclose(run.tau, 3 * Q, atol=1e-15)
    np.testing.assert_allclose(run.q_dot, 2 * Q, atol=1e-15)
    again = fb.from_log(str(path), columns={"q1": "right_motor", "q2": "left_motor"})
    np.testing.assert_allclose(again.q, Q[:, ::-1], atol=1e-15)


def test_missing_efforts_and_headers_are_named(tmp_path):
    path = bag(tmp_path / "bag", {"/joint_states": states(effort=False, stamped=False)})
    run = fb.from_bag(path)
    assert "/joint_states has no effort of left_motor and right_motor" in run.measured.notes
    with pytest.raises(ValueError, match="no torques .*has no effort of left_motor and right_m"):
        fb.identify(fb.FiveBar(), str(path))
    assert np.isnan(run.tau).all()
    np.testing.assert_allclose(run.t, T, atol=1e-9)
    with pytest.raises(ValueError, match="the log has no torques"):
        fb.identify(ROBOT, str(path))


def test_a_message_for_each_joint_is_put_together(tmp_path):
    """The driver of the right motor reports 3 ms later."""
    own = list(states(names={"left_motor": 0}))
    for t, kind, each in states(names={"right_motor": 1}):
        each.header.stamp.nanosec += 3_000_000
        own.append((t + 3_000_000, kind, each))
    run = fb.from_bag(bag(tmp_path / "bag", {"/joint_states": sorted(own, key=lambda one: one[0])}))
    np.testing.assert_allclose(run.t, T[1:], atol=1e-9)  # the first has no right joint yet
    np.testing.assert_allclose(run.q[:, 0], Q[1:, 0], atol=1e-15)
    expected = np.interp(T[1:], T + 0.003, Q[:, 1])
    np.testing.assert_allclose(run.q[:, 1], expected, atol=1e-9)
    assert any("has one joint in a message" in note for note in run.measured.notes)


def test_references_of_joints_and_of_points(tmp_path):
    topics = {"/joint_states": states(), "/plan": trajectory(), "/pose": poses()}
    run = fb.from_bag(bag(tmp_path / "bag", topics))
    np.testing.assert_allclose(run.xi_ref, fb.dgm(ROBOT, Q).xi, atol=1e-15)
    np.testing.assert_allclose(run.xi, fb.dgm(ROBOT, Q).xi, atol=1e-15)
    # A topic that is not used does not hide the one after it.
    topics = {"/joint_states": states(), "/goal": poses(0.0, 3), "/pose_goal": poses(0.1, 2)}
    topics |= {"/tip": poses(0.2, 1)}
    run = fb.from_bag(bag(tmp_path / "second", topics))
    np.testing.assert_allclose(run.xi_ref, fb.dgm(ROBOT, Q).xi, atol=1e-15)
    np.testing.assert_allclose(run.xi[1:], fb.dgm(ROBOT, Q[1:]).xi + (0.2, 0.0), atol=1e-15)
    assert "topic /pose_goal is not used" in run.measured.notes


def test_messages_are_in_the_order_of_their_stamps(tmp_path):
    """A recorder receives them with a jitter of 3 periods."""
    jitter = np.random.default_rng(3).integers(0, 30_000_000, len(T)).tolist()
    received = [(t + late, kind, own) for (t, kind, own), late in zip(states(), jitter)]
    received.sort(key=lambda one: one[0])
    run = fb.from_bag(bag(tmp_path / "bag", {"/joint_states": received}))
    np.testing.assert_allclose(run.t, T, atol=1e-9)
    np.testing.assert_allclose(run.q, Q, atol=1e-15)
    (note,) = run.measured.notes
    assert "rows were not in the order of time" in note


@pytest.mark.parametrize(
    "topics, options, words",
    [
        ({"/s": states}, {"joints": ("a", "b")}, "/s has no joints a and b, but elbow, left_motor"),
        ({"/s": states}, {"joints": ("left_motor", "left_motor")}, "the left and the right one"),
        ({"/s": states}, {"topic": "/t"}, "no messages sensor_msgs/JointState in /t; .* in /s"),
        ({"/s": states, "/t": states}, {}, "in /joint_states; it has them in /s, /t"),
        ({"/pose": poses}, {}, "in /joint_states; it has them in no topic, and the topics /pose"),
    ],
)
def test_what_a_bag_lacks_is_named(tmp_path, topics, options, words):
    path = bag(tmp_path / "bag", {topic: messages() for topic, messages in topics.items()})
    with pytest.raises(ValueError, match=words):
        fb.from_bag(path, **options)


def test_a_folder_that_is_no_bag_is_called_so(tmp_path):
    with pytest.raises(ValueError, match="is no bag that can be read"):
        fb.from_bag(tmp_path)


def test_a_bag_is_written_to_a_new_folder(tmp_path):
    run = fb.from_log(np.arange(4) * 0.01, np.zeros(4), np.ones(4))
    run.to_bag(tmp_path / "bag")
    with pytest.raises(FileExistsError, match="bag is there already: a bag needs a new folder"):
        run.to_bag(tmp_path / "bag")


def test_a_run_comes_back_from_its_bag_and_is_identified(tmp_path, capsys):
    circle = fb.circle((0.06, 0.09), 0.02, 0.5)
    run = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), circle, step=2e-3)
    run.to_bag(tmp_path / "bag")
    back = fb.from_bag(tmp_path / "bag")
    np.testing.assert_allclose(back.t, run.t, atol=1e-9)
    for name in ("q", "q_dot", "tau", "xi", "xi_ref"):
        np.testing.assert_allclose(getattr(back, name), getattr(run, name), atol=1e-14)
    unknown = ["--unknown", "zz1", "zz2", "m"]
    assert main(["identify", str(tmp_path / "bag"), *unknown]) == 0
    assert "m " in capsys.readouterr().out


def test_the_lab_leaves_a_bag(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(START + "for _ in range(5):\n    robot.apply_efforts(0.01, 0.0)\n")
    with pytest.raises(SystemExit) as ended:
        main(["run", "--bag", str(tmp_path / "bag"), str(script)])
    assert ended.value.code == 0
    assert len(fb.from_bag(tmp_path / "bag").t) > 40
