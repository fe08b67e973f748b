"""The lab's `lab_amoro.parallel_robot` in our words: a Robot whose steps are the simulation's."""

from . import rclpy
from . import world as place

__all__ = ["EndEffector", "Joint", "Robot", "rclpy", "start_robot"]

# Effort of the oscillation, N m or N, and the joint coordinates at which it turns, rad or m.
OSCILLATION = {"five_bar": (0.0002, 0.05), "biglide": (0.01, 0.01)}


class Joint:
    """position, velocity, acceleration, effort: rad or m, s, N m or N."""

    def __init__(self):
        self.position = self.velocity = self.acceleration = self.effort = 0.0


class EndEffector:
    """position_x, position_y, velocity_x, ..., acceleration_y: m, s."""

    def __init__(self):
        self.position_x = self.position_y = self.velocity_x = self.velocity_y = 0.0
        self.acceleration_x = self.acceleration_y = 0.0


class Robot:
    """The lab's robot, "five_bar" or "biglide"."""

    def __init__(self, robot_type):
        rclpy.must_be_initialised(f"Robot({robot_type!r})")
        self._world = place.world
        self._world.make(robot_type)
        self._oscillates = False
        self._effort, self._limit = OSCILLATION[robot_type]
        self._efforts = [self._effort, -self._effort]
        self._joints = [Joint() for _ in range(4)]
        self.active_left_joint, self.active_right_joint = self._joints[:2]
        self.passive_left_joint, self.passive_right_joint = self._joints[2:]
        self.end_effector = EndEffector()
        self._read()

    def _read(self):
        state = self._world.state
        columns = (
            [*state.q.tolist(), *state.passive.tolist()],
            [*state.q_dot.tolist(), *state.passive_dot.tolist()],
            [*state.q_ddot.tolist(), *state.passive_ddot.tolist()],
        )
        for joint, *values in zip(self._joints, *columns):
            joint.position, joint.velocity, joint.acceleration = values
        end = self.end_effector
        end.position_x, end.position_y = state.xi.tolist()
        end.velocity_x, end.velocity_y = state.xi_dot.tolist()
        end.acceleration_x, end.acceleration_y = state.xi_ddot.tolist()

    def apply_efforts(self, left_joint, right_joint):
        """Hold the two efforts for 10 ms of simulated time."""
        efforts = self._world.step((left_joint, right_joint))
        if efforts is not None:
            self.active_left_joint.effort, self.active_right_joint.effort = efforts
            self._read()

    def data_updated(self):
        """Return whether the state is new since the last call."""
        return self._world.updated()

    def get_time(self):
        """Simulated time, s."""
        return self._world.time

    def start_oscillate(self):
        """Begin the oscillation, with a step without effort."""
        self._oscillates = True
        self.apply_efforts(0.0, 0.0)

    def continue_oscillations(self):
        """One step of the oscillation: each effort turns when its joint has passed a limit."""
        if not self._oscillates:
            return
        for k, joint in enumerate((self.active_left_joint, self.active_right_joint)):
            if self._efforts[k] * joint.position > 0 and abs(joint.position) > self._limit:
                self._efforts[k] = -self._efforts[k]
        self.apply_efforts(*self._efforts)

    def stop_oscillate(self):
        """End the oscillation and reset the simulation."""
        self._oscillates = False
        self.reset_simulation()

    def reset_simulation(self):
        """Back to the home position, at rest, at time 0."""
        self._world.reset()
        self.active_left_joint.effort = self.active_right_joint.effort = 0.0
        self._read()

    def __getattr__(self, name):
        raise AttributeError(f"Robot has no {name!r} in fivebar run")


def start_robot(robot):
    """Begin to receive the robot's states."""
    if not isinstance(robot, Robot):
        raise TypeError(f"start_robot needs a Robot, not {robot!r}")
    robot._world.started = True
