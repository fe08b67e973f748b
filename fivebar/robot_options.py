"""The robot on the command line: a named set, a TOML file, single values."""

from dataclasses import fields, replace

from .errors import UsageError
from .robots import ROBOTS, FiveBar


def add_robot_options(parser):
    group = parser.add_argument_group(
        "robot", "lengths in m, inertias in kg m^2, mass in kg; single values go over the set's"
    )
    group.add_argument(
        "--robot", default="amoro", metavar="NAME|FILE.toml", help=f"one of {', '.join(ROBOTS)}, or a TOML file"
    )
    for field in fields(FiveBar):
        group.add_argument(f"--{field.name}", type=float)


def chosen_robot(arguments):
    given = {f.name: getattr(arguments, f.name) for f in fields(FiveBar) if getattr(arguments, f.name) is not None}
    try:
        robot = ROBOTS[arguments.robot].robot if arguments.robot in ROBOTS else _robot_from_toml(arguments.robot)
        return replace(robot, **given)
    except ValueError as error:
        raise UsageError(error) from None


def _robot_from_toml(path):
    import tomllib

    if not path.endswith(".toml"):
        raise UsageError(
            f"no robot {path!r}: the known ones are {', '.join(ROBOTS)}; or name a file that ends in .toml"
        )
    try:
        with open(path, "rb") as file:
            table = tomllib.load(file)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path}: {error}") from None
    known = [field.name for field in fields(FiveBar)]
    if unknown := sorted(set(table) - set(known)):
        raise UsageError(f"{path}: no parameter {', '.join(unknown)}; the known ones are {', '.join(known)}")
    return FiveBar(**table)
