"""`fivebar export`: the robot as a file of a simulator, or as C for a chip."""

from __future__ import annotations

import sys

from ..base.errors import SingularityError
from .options import WORKING, add_command, usage_errors, used_options
from .robot_options import add_robot_options, chosen_machine

OPTIONS = {
    "--out OUT": "(default: stdout)",
    "--name NAME": "of the model; in C what all names begin with (default: fivebar or biglide)",
    "--start Q1 Q2": "the pose that is shown",
    "--assembly -1|1": (-1, "of that pose"),
    "--step S": "the simulator's (default: 0.001)",
    "--closure constraint|joint": "of SDF: for Drake (default) or for Gazebo",
    "--functions NAME ...": "of C (default: all); a wrong name lists them",
    WORKING: "of RepRapFirmware: working modes (default: -1 -1)",
    "--homing-deg DEG DEG": "of RepRapFirmware: angles of the proximal bars at their switches",
    "--steps-per-turn NUMBER": "of RepRapFirmware: of a motor, with microsteps, for M92",
    "--plugin NAME": "of ros2_control: the hardware's (default: a mock)",
}


def add_parsers(commands):
    """Add `export` to the program's commands."""
    parser = add_command(commands, "export", _export, (OPTIONS,))
    formats = "mjcf", "urdf", "sdf", "c", "reprapfirmware", "ros2_control"
    words = "c is one header: models and a controller; reprapfirmware the lines M669 and M92"
    parser.add_argument("--format", "--to", choices=formats, required=True, help=words)
    add_robot_options(parser)


def _export(arguments):
    from ..exporters.export import export
    from ..models.geometry import dgm

    machine = chosen_machine(arguments, f"export {arguments.format}")
    names = "start step closure functions plugin working homing_deg steps_per_turn".split()
    options = used_options(arguments, *names)
    with usage_errors(ValueError, SingularityError):
        if arguments.start:
            options["start"] = dgm(machine.robot, arguments.start, arguments.assembly)
        text = export(machine, arguments.format, arguments.out, name=arguments.name, **options)
    sys.stdout.write(f"{arguments.out}\n" if arguments.out else text)
