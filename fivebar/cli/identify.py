"""`fivebar identify`: masses and friction of a robot, from logs of its motion and torques."""

from __future__ import annotations

from dataclasses import replace

from ..base.errors import UsageError
from .options import TABLE, add_command, option_of, print_json, used_options, write_files
from .robot_options import add_robot_options, chosen_machine

GAUGES = {
    "counts_per_turn": (
        "of an encoder, where q is in counts; negative where it counts the other way"
    ),
    "gear_ratio": "turns of the motor for one of the joint",
    "offset": "of the joint beyond the encoder's zero, rad",
    "torque_constant": "of the motor for a unit of tau, N m",
}
NEAR_1 = 0.01  # within which a ratio is that of an encoder that is a little off
OPTIONS = TABLE | {
    "LOG.csv ...": "columns t, q1, q2, tau1, tau2, perhaps q1_dot, ...",
    "--validate LOG.csv": "a second run, whose torques are only predicted",
    "--out DIR": "write robot.toml, identification.json and torques.png there",
    "--unknown NAME ...": "identify only these (default: all)",
    "--assembly -1|1": (-1, "of the logs, throughout"),
    "--cutoff HZ": "of the filters (default: where the motion ends in noise)",
    "--units UNIT ...": "of columns without one, as q1=deg",
}


def add_parsers(commands):
    """Add `identify` to the program's commands."""
    gauges = {}
    for name, words in GAUGES.items():
        value = "RAD" if name == "offset" else "NUMBER"
        gauges[f"{option_of(name)} {value} ..."] = words
    logged = gauges, "what was logged", "one number for both motors, or two"
    add_robot_options(add_command(commands, "identify", _identify, (OPTIONS,), logged))


def _identify(arguments):
    from ..estimation.identification.identify import identify

    machine = chosen_machine(arguments)
    names = "validate unknown assembly cutoff units columns".split()
    options = used_options(arguments, *names) | _gauges(arguments, machine)
    result = identify(machine.robot, arguments.log, **options)
    files = []
    if arguments.out:
        identified = replace(machine, robot=result.robot)
        files = write_files(
            arguments.out,
            {
                "robot.toml": lambda path: identified.save(
                    path, result.sd, ("identified; SI units",)
                ),
                "identification.json": result.to_json,
                "torques.png": result.plot,
            },
        )
    if arguments.json:
        print_json({**result.table, "files": files})
    else:
        print(result, *files, sep="\n")


def _gauges(arguments, machine):
    options = {"offset": machine.offset}
    for name, numbers in used_options(arguments, *GAUGES).items():
        if len(numbers) > 2:
            raise UsageError(f"{option_of(name)} takes one number or two, not {len(numbers)}")
        options[name] = numbers[0] if len(numbers) == 1 else tuple(numbers)
    scaled = max(abs(ratio - 1) for ratio in machine.ratio) > NEAR_1
    if scaled and not {"counts_per_turn", "gear_ratio"} & set(options):
        raise UsageError(
            f"the drives of {arguments.robot} have ratios of {machine.ratio[0]:.6g} and"
            f" {machine.ratio[1]:.6g}: name --counts-per-turn or --gear-ratio of what was logged"
        )
    return options
