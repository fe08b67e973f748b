"""A robot for each student and hidden inputs for each grading, both drawn from the course's secret."""

import ast
import hmac
import re
import unicodedata
from dataclasses import asdict, fields, replace

import numpy as np

from ..errors import UsageError
from ..robots import KINDS, Biglide, FiveBar

PUBLIC_SEED = "public"
CONSTANTS = tuple(dict.fromkeys(field.name for kind in KINDS for field in fields(kind)))


def _drawn(secret, *words):
    text = "\0".join(unicodedata.normalize("NFC", word).strip().casefold() for word in words)
    return hmac.digest(secret, text.encode("utf-8", "surrogatepass"), "sha256")


def hidden_seed(secret, lab):
    """Seed of a lab's hidden inputs, the same for the whole course."""
    return _drawn(secret, "inputs", lab).hex()[:16]


def robot_of(secret, student, handout):
    """The student's robot, from HMAC-SHA256(secret, id): both legs alike, lengths in whole mm near the handout's.

    Case and surrounding blanks of the id do not count. Five-bar: l1, l2 in 82..98 mm, d in 108..128 mm; biglide:
    bars in 262..302 mm, d in 380..420 mm: always assemblable.
    """
    draw = np.random.default_rng(int.from_bytes(_drawn(secret, "robot", student)))
    if isinstance(handout, Biglide):
        bar, d = draw.integers((262, 380), (302, 420), endpoint=True).tolist()
        mf1, mf2, m = draw.integers((80, 80, 250), (120, 120, 350), endpoint=True).tolist()
        return Biglide(bar / 1000, bar / 1000, d / 1000, mf1 / 100, mf2 / 100, m / 100)
    l1, l2 = draw.integers(82, 98, 2, endpoint=True).tolist()
    d, m = int(draw.integers(108, 128, endpoint=True)), int(draw.integers(40, 60, endpoint=True))
    zz = draw.integers(16, 24, 2, endpoint=True).tolist()
    bars = (l1 / 1000, l2 / 1000) * 2
    return FiveBar(*bars, d / 1000, zz[0] / 10000, zz[1] / 10000, m / 100)


def with_constants(source, robot):
    """A student.py's source with the robot's numbers in its lines `l11 = ...`."""
    for name, value in asdict(robot).items():
        source, found = re.subn(rf"(?m)^({name}\s*=\s*)[^\s#]+", rf"\g<1>{value!r}", source, count=1)
        if not found and name in lengths(robot):
            raise UsageError(f"the lab's student.py has no line `{name} = ...` to put a student's own robot in")
    return source


def constants_in(source):
    """The robot's constants that a file assigns at its top level as plain numbers, name -> value."""
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    found = {}
    for node in body:
        if (
            isinstance(node, ast.Assign)
            and isinstance(node.value, ast.Constant)
            and type(node.value.value) in (int, float)
        ):
            found |= {t.id: node.value.value for t in node.targets if isinstance(t, ast.Name) and t.id in CONSTANTS}
    return found


def lengths(robot):
    """The robot's lengths, name -> m."""
    return {name: value for name, value in asdict(robot).items() if name[0] in "ld"}


def robot_from(constants, handout):
    """The handout's robot with those of the constants that it has, or as it is where no robot can have them."""
    try:
        return replace(handout, **{name: value for name, value in constants.items() if hasattr(handout, name)})
    except (ValueError, OverflowError):
        return handout
