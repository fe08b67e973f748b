"""Write the guide's page of what is used of a robot's file: `python -m tests.helpers.robot_uses_page`."""

from fivebar.base.robot_uses import uses

from . import ROOT

PAGE = ROOT / "fivebar" / "guide" / "robot_files.md"
MARKS = {"used": "●", "kept": "○", "left_out": "", "refused": "×"}
MACHINE = "readings", "frame", "tool", "measured"
LIMITS = "motors", "joint_speed", "joint_acceleration", "speed", "acceleration", "jerk"
LIMITS += "joints", "half_planes", "region", "det_A", "sin", "clearance", "collisions"
HEAD = """# What is used of a robot's file

Each command and each function that takes a robot takes a name out of `fb.ROBOTS`, the path of a
[robot file](models.md#robot-files), an `fb.FiveBar`, an `fb.Biglide` or an `fb.Machine`:

```python
import fivebar as fb

data = fb.singularity_map("motkin")
machine = fb.load_machine("plotclock")
stroke = fb.path([(0.03, 0.02), (0.04, 0.02)])               # of the pen, in the frame of the board
limits = fb.Constraints(speed=0.05, acceleration=0.5)
motion = fb.time_path(machine, stroke, constraints=limits, working=(1, -1))
```

Where a file has a `[frame]`, the points of a command are in it, and the output says so; `--frame robot` asks for the
robot's own frame. `time_path`, `check_path` and `certify` take the path of the tool in the measuring frame of a Machine;
what they return is of joint C in the robot's own frame. Constraints of a Machine hold where the call names no others.

Files that keep the robot's own frame, as `run.csv`, are named as such in the output. The first line of `plan.csv`,
`run.csv` and `setpoints.csv` says whether their points are of joint C or of the tool, and in which frame: read again as
a path they are taken so, and refused for a robot that has no such tool or frame.

What has no meaning for a command or function is left out, and a line or a warning says so where it could change the
answer. A constraint that is written
for the call, and cannot be kept there, is an error. The tables are those that the program asks, and `--help` prints.
● used, ○ kept in the robot file that is written, × refused; an empty place is left out.

"""


def table(title: str, users: list, rows: tuple) -> str:
    """Return a table of Markdown: what each of these uses of these rows, alike ones in a line."""
    words, found = uses()
    lines = [f"| {title} | " + " | ".join(words[row] for row in rows) + " |"]
    lines.append("|---" * (len(rows) + 1) + "|")
    alike: dict[tuple, list] = {}
    for user in users:
        marks = (
            next(MARKS[name] for name in MARKS if row in getattr(found[user], name)) for row in rows
        )
        alike.setdefault(tuple(marks), []).append(user)
    for cells, of_these in alike.items():
        if any(cells):
            lines.append(f"| {names(of_these)} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n\n"


def names(users: list) -> str:
    return ", ".join(dict.fromkeys(f"`{user.removeprefix('fb.')}`" for user in users))


def page() -> str:
    """Return the whole page."""
    found = uses()[1]
    parts = [HEAD]
    for title, is_function in (("command", False), ("function", True)):
        users = sorted((u for u in found if u.startswith("fb.") == is_function), key=str.lower)
        parts.append(table(title, users, ("biglide", "masses", "gravity", "friction", *MACHINE)))
        parts.append(
            f"Of `[constraints]`; `torque` is as `motors`:\n\n{table(title, users, LIMITS)}"
        )
    parts.append("Why something is left out or refused:\n\n")
    reasons: dict[str, list] = {}
    for user, use in found.items():
        for reason in {**use.left_out, **use.refused}.values():
            reasons.setdefault(reason, []).append(user)
    parts += [f"- {names(users)}: {reason}.\n" for reason, users in reasons.items()]
    return "".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
