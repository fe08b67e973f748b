"""Stand-in for the two functions of `rclpy` that the lab's scripts call."""

__all__ = ["init", "shutdown"]

_initialised = False


def init(args=None):
    """Must come before Robot(...), once."""
    global _initialised
    if _initialised:
        raise RuntimeError("rclpy.init was called twice")
    _initialised = True


def shutdown():
    """The end of ROS; init may follow."""
    global _initialised
    _initialised = False


def must_be_initialised(what):
    if not _initialised:
        raise RuntimeError(f"{what} before rclpy.init(args=args): in ROS no node can be made then")
