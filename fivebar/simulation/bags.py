"""Bags of ROS 2 (sqlite3 and MCAP): write a run as topics, read joint states and references.

They need the package rosbags, which needs no ROS.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from numpy import ndarray

from ..base.columns import Columns
from ..base.tables import FilePath
from ..models.geometry import dgm
from ..models.robots import Robot

if TYPE_CHECKING:
    from .run import Run

JOINTS = "left_motor", "right_motor"
STATES = "/joint_states"
WORDS = {"position": "q#", "velocity": "q#_dot", "effort": "tau#"}  # of JointState
PLACES = {"Pose", "PoseStamped", "Point", "PointStamped"}
REFERENCES = "ref", "desired", "goal", "target", "command", "cmd"  # in names of topics
NANO = 1_000_000_000
TYPES = {
    STATES: "sensor_msgs/msg/JointState",
    "/end_effector": "geometry_msgs/msg/PoseStamped",
    "/end_effector_reference": "geometry_msgs/msg/PoseStamped",
}


def _rosbags():
    try:
        from rosbags import highlevel, rosbag2, typesys
    except ImportError:
        raise ImportError("bags need one more package: pip install rosbags") from None
    return highlevel, rosbag2, typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)


def is_bag(source: object) -> TypeGuard[FilePath]:
    """Return whether a path is a bag: its folder, or one of its files."""
    if not isinstance(source, (str, Path)):
        return False
    return Path(source).is_dir() or Path(source).suffix in (".mcap", ".db3")


def read_bag(
    path: FilePath,
    robot: Robot,
    topic: str | None = None,
    joints: Sequence[str] = JOINTS,
    assembly: int = -1,
) -> Columns:
    """Return the columns of the log in a bag; times begin at the earliest joint state.

    Parameters
    ----------
    path : path
        The bag: a folder, or an MCAP file.
    robot : FiveBar or Biglide
        It gives the points of references of joints (JointTrajectory).
    topic : str, optional
        Of sensor_msgs/JointState; by default /joint_states, or the only one.
    joints : pair of str
        The left and the right joint in these messages, in whatever order they are there.
    assembly : int
        Assembly mode of references of joints.

    Raises
    ------
    ValueError
        The bag has no such topic or joints: the message names those that it has.
    ImportError
        The package rosbags is not installed.
    """
    if len(joints) != 2 or joints[0] == joints[1]:
        raise ValueError(f"joints must be the names of the left and the right one, not {joints!r}")
    highlevel, rosbag2, types = _rosbags()
    name = str(path)
    place = Path(path).parent if Path(path).suffix == ".db3" else Path(path)
    messages: dict[str, list] = {}
    kinds = {}
    try:
        with highlevel.AnyReader([place], default_typestore=types) as reader:
            for connection in reader.connections:
                kinds[connection.topic] = connection.msgtype.rpartition("/")[2]
            read = PLACES | {"JointState", "JointTrajectory"}
            used = [own for own in reader.connections if kinds[own.topic] in read]
            for connection, logged, raw in reader.messages(used) if used else ():
                message = reader.deserialize(raw, connection.msgtype)
                messages.setdefault(connection.topic, []).append((logged, message))
    except (highlevel.AnyReaderError, rosbag2.ReaderError, OSError) as error:
        raise ValueError(f"{name} is no bag that can be read: {error}") from None
    topic = _topic_of_states(topic, kinds, messages, name)
    logged, stamps, states = _states(messages.pop(topic), joints, f"{name}: {topic}")
    notes = []
    if not np.isfinite(states[0]).all(axis=0).any():
        logged, stamps, states = _together(logged, stamps, states)
        notes.append(
            f"{topic} has one joint in a message: {joints[1]} was put at {joints[0]}'s times"
        )
    # Messages without a header have the recorder's time, whose clock may be another.
    late = int(np.median(stamps - logged))
    values = {"t": (stamps - stamps.min()) / NANO}
    for (word, heading), pair in zip(WORDS.items(), states):
        missing = [joint for joint, own in zip(joints, pair) if np.isnan(own).all()]
        if missing:
            notes.append(f"{topic} has no {word} of {' and '.join(missing)}")
        else:
            values |= {heading.replace("#", digit): own for digit, own in zip("12", pair)}
    for other, own in messages.items():
        t, points = _points(own, kinds[other], joints, late, robot, assembly)
        is_reference = any(word in other.lower() for word in REFERENCES)
        end = "_ref" if is_reference or kinds[other] == "JointTrajectory" else ""
        if kinds[other] == "JointState" or f"x{end}" in values or not len(t):
            notes.append(f"topic {other} is not used")
            continue
        held = np.searchsorted(t, stamps, side="right") - 1
        known = np.where(held >= 0, points[np.maximum(held, 0)].T, np.nan)
        values |= {f"x{end}": known[0], f"y{end}": known[1]}
    rows = np.arange(1, len(stamps) + 1)
    return Columns(
        name, values, rows, tuple(notes), dict.fromkeys(values, ""), f"message of {topic}"
    )


def _topic_of_states(topic, kinds, messages, name):
    there = [own for own in messages if kinds[own] == "JointState"]
    if topic is None:
        topic = there[0] if len(there) == 1 else STATES
    if topic not in there:
        raise ValueError(
            f"{name}: no messages sensor_msgs/JointState in {topic}; it has them in"
            f" {', '.join(there) or 'no topic'}, and the topics {', '.join(kinds)}"
        )
    return topic


def _stamp(message):
    header = getattr(message, "header", None)
    return header.stamp.sec * NANO + header.stamp.nanosec if header else 0


def _numbers(names, numbers, joints):
    """Return the numbers of the joints, nan where a message has none."""
    known = dict(zip(names, numbers))
    return [float(known.get(joint, np.nan)) for joint in joints]


def _states(messages, joints, where):
    """Return times of recording and of the messages (n,), ns, and all numbers (3, 2, n)."""
    there = {joint for _, message in messages for joint in message.name}
    if not set(joints) <= there:
        raise ValueError(
            f"{where} has no joints {' and '.join(joints)}, but {', '.join(sorted(there))}: name"
            ' the left and the right one, as joints=("LEFT", "RIGHT") or --columns q1=LEFT q2=RIGHT'
        )
    logged = np.array([own for own, _ in messages])
    stamps = np.array([_stamp(message) for _, message in messages])
    rows = []
    for _, message in messages:
        rows.append([_numbers(message.name, getattr(message, word), joints) for word in WORDS])
    return logged, np.where(stamps > 0, stamps, logged), np.moveaxis(rows, 0, 2)


def _together(logged, stamps, states):
    """Return times and numbers of both joints where each message has one: at the left one's times.

    The right one's numbers are interpolated, nan where it was not yet or no longer there.
    """
    left, right = (np.flatnonzero(there) for there in np.isfinite(states[0]))
    right = right[np.argsort(stamps[right], kind="stable")]
    t = stamps[left] - stamps[0]
    known = stamps[right] - stamps[0]
    merged = states[:, :, left]
    for k, numbers in enumerate(states[:, 1, right]):
        merged[k, 1] = np.interp(t, known, numbers, np.nan, np.nan)
    return logged[left], stamps[left], merged


def _points(messages, kind, joints, late, robot, assembly):
    """Return times (n,), ns, and points (n, 2) of the messages of a topic."""
    times = []
    points = []
    for logged, message in messages:
        t = _stamp(message) or logged + late
        if kind == "JointTrajectory":
            for point in message.points:
                after = point.time_from_start
                times.append(t + after.sec * NANO + after.nanosec)
                points.append(_numbers(message.joint_names, point.positions, joints))
        elif kind in PLACES:
            place: Any = message
            for part in ("pose", "position", "point"):
                place = getattr(place, part, place)
            times.append(t)
            points.append((place.x, place.y))
    found: ndarray = np.array(points).reshape(-1, 2)
    if kind == "JointTrajectory" and len(found):
        closed = np.isfinite(found).all(axis=1)
        pose = dgm(robot, np.where(closed[:, None], found, 0.0), assembly, unreachable="nan")
        found = np.where(closed[:, None], pose.xi, np.nan)
    order = np.argsort(times, kind="stable")
    return np.array(times)[order], found[order]


def write_bag(run: Run, folder: FilePath) -> None:
    """Write the joints, the end-effector and its reference as topics of a bag, MCAP."""
    _, rosbag2, types = _rosbags()
    if Path(folder).exists():
        raise FileExistsError(f"{folder} is there already: a bag needs a new folder")
    own = types.types
    rows = np.column_stack([run.q, run.q_dot, run.tau])
    points: dict[str, Any] = {"/end_effector": run.xi, "/end_effector_reference": run.xi_ref}
    upright = own["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    storage = rosbag2.StoragePlugin.MCAP
    with rosbag2.Writer(Path(folder), version=9, storage_plugin=storage) as writer:
        topics = [topic for topic in TYPES if points.get(topic, rows) is not None]
        connections = {}
        for topic in topics:
            connections[topic] = writer.add_connection(topic, TYPES[topic], typestore=types)
        for k, t in enumerate(np.round(run.t * NANO).astype(int).tolist()):
            stamp = own["builtin_interfaces/msg/Time"](*divmod(t, NANO))
            header = own["std_msgs/msg/Header"](stamp, "base")
            for topic in topics:
                if topic == STATES:
                    message = own[TYPES[topic]](header, list(JOINTS), *np.split(rows[k], 3))
                else:
                    place = own["geometry_msgs/msg/Point"](*points[topic][k].tolist(), 0.0)
                    pose = own["geometry_msgs/msg/Pose"](place, upright)
                    message = own[TYPES[topic]](header, pose)
                raw = types.serialize_cdr(message, TYPES[topic])
                writer.write(connections[topic], t, raw)
