"""The lab's module names inside the child process, and a clear refusal of ROS's others, and of
Qt's.
"""

import importlib.abc
import importlib.machinery
import re
import sys
from types import ModuleType

from . import parallel_robot, plot_tools, rclpy

OFFERED = {
    "lab_amoro.parallel_robot": parallel_robot,
    "lab_amoro.plot_tools": plot_tools,
    "rclpy": rclpy,
}
ABSENT = re.compile(
    r"\w+_(msgs|srvs|interfaces)|rospy|roslib|ament_\w+|launch(_\w+)?|tf2?(_\w+)?|rosidl\w*"
    r"|gazebo_ros\w*"
    r"|controller_manager|PyQt\d|PySide\d|pyqtgraph"
)


def install():
    """Put the stand-ins in place, before a real one that may be on the path, and the refusals after
    everything.
    """
    package = sys.modules["lab_amoro"] = _package("lab_amoro", {})
    for name, module in OFFERED.items():
        stand_in = sys.modules[name] = _package(
            name, {each: getattr(module, each) for each in module.__all__}
        )
        if name.startswith("lab_amoro."):
            setattr(package, name.removeprefix("lab_amoro."), stand_in)
    sys.modules["lab_amoro.parallel_robot"].rclpy = sys.modules["rclpy"]
    sys.meta_path.append(Refusals())


def _package(name, offered):
    """Return a module of these names; a package, so that what else is imported from it is asked of
    the finder below.
    """
    module = ModuleType(name)
    vars(module).update(offered, __all__=list(offered), __path__=[])

    def refuse(attribute):
        raise AttributeError(f"fivebar run has no {name}.{attribute}")

    module.__getattr__ = refuse
    return module


class Refusals(importlib.abc.MetaPathFinder):
    """Asked last, when nobody else has the module."""

    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top in ("lab_amoro", "rclpy") or ABSENT.fullmatch(top):
            raise ModuleNotFoundError(
                f"fivebar run has no {name!r}: it runs the lab's scripts without ROS and Qt"
            )
        return None


class KeepBackend(importlib.abc.MetaPathFinder):
    """Lets a script's `matplotlib.use("TkAgg")` go without effect: windows are files here."""

    def find_spec(self, name, path=None, target=None):
        if name != "matplotlib":
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None:
            execute = spec.loader.exec_module

            def exec_module(module):
                execute(module)
                module.use = lambda backend, *, force=True: None

            spec.loader.exec_module = exec_module
        return spec
