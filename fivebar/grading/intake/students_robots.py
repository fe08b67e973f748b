"""A robot for each student and hidden inputs for each grading, both drawn from the course's
secret.
"""

from __future__ import annotations

import hmac
import re
import unicodedata

import numpy as np

from ...base.errors import UsageError
from ...models.robots import Biglide, FiveBar, Robot
from ..robots import has_models, parameters_of, with_numbers

PUBLIC_SEED = "public"


def id_key(student: str) -> str:
    """Return what of an id counts: neither case nor surrounding blanks, nor how an accent
    is coded.
    """
    return name_key(student).casefold()


def name_key(student: str) -> str:
    """Return what tells a student's hand-ins from others': case counts, where two ids differ by
    nothing else.
    """
    return unicodedata.normalize("NFC", student).strip()


def _drawn(secret, *words):
    text = "\0".join(map(id_key, words))
    message = text.encode("utf-8", "surrogatepass")
    return hmac.digest(secret, message, "sha256")


def _generator(secret, *words):
    seed = int.from_bytes(_drawn(secret, *words))
    return np.random.default_rng(seed)


def hidden_seed(secret: bytes, lab: str) -> str:
    """Return the seed of a lab's hidden inputs, the same for the whole course."""
    digits = _drawn(secret, "inputs", lab).hex()
    return digits[:16]


def draw_for(secret: bytes, student: str, lab: str) -> np.random.Generator:
    """Return what the files of a lab are drawn with that a student gets."""
    return _generator(secret, "files", lab, student)


def robot_of(secret: bytes, student: str) -> FiveBar:
    """Return the student's five-bar, from HMAC-SHA256(secret, id): both legs alike, lengths in
    whole mm near the default's.

    Case and surrounding blanks of the id do not count. l1, l2 in 82..98 mm, d in 108..128 mm:
    always assemblable.
    """
    draw = _generator(secret, "robot", student)
    l1, l2 = draw.integers(82, 98, 2, endpoint=True).tolist()
    d = int(draw.integers(108, 128, endpoint=True))
    m = int(draw.integers(40, 60, endpoint=True))
    zz1, zz2 = draw.integers(16, 24, 2, endpoint=True).tolist()
    bars = (l1 / 1000, l2 / 1000) * 2
    inertias = (zz1 / 10000, zz2 / 10000)
    return FiveBar(*bars, d / 1000, *inertias, m / 100)


def biglide_of(secret: bytes, student: str) -> Biglide:
    """Return the student's biglide likewise: bars alike in 262..302 mm, d in 380..420 mm."""
    draw = _generator(secret, "biglide", student)
    lengths = draw.integers((262, 380), (302, 420), endpoint=True)
    masses = draw.integers((80, 80, 250), (120, 120, 350), endpoint=True)
    bar, d = (length / 1000 for length in lengths.tolist())
    mf1, mf2, m = (mass / 100 for mass in masses.tolist())
    return Biglide(bar, bar, d, mf1, mf2, m)


def with_constants(source: str, robot: Robot) -> str:
    """Return a student.py's source with the robot's numbers in its lines `l11 = ...`."""
    for name, value in parameters_of(robot).items():
        line = rf"(?m)^({name}\s*=\s*)[^\s#]+"
        with_value = rf"\g<1>{value!r}"
        source, found = re.subn(line, with_value, source, count=1)
        if not found and name in lengths(robot):
            raise UsageError(
                f"the lab's student.py has no line `{name} = ...` to put a student's own robot in"
            )
    return source


def robot_for(student: str, secret: bytes | None, standard: Robot) -> Robot:
    """Return a student's robot: his own where the course has a secret and the package can draw
    such a robot, else the lab's standard one.
    """
    if secret is None or not has_models(standard):
        return standard
    draw = biglide_of if isinstance(standard, Biglide) else robot_of
    return with_numbers(standard, parameters_of(draw(secret, student)))


def lengths(robot: Robot) -> dict[str, float]:
    """Return a robot's lengths by name, m."""
    found = {}
    for name, value in parameters_of(robot).items():
        if name.startswith(("l", "d")):
            found[name] = value
    return found


def robot_from(standard: Robot, constants: dict[str, float]) -> Robot:
    """Return the standard robot with those of its numbers that are among the constants, or as it is
    where that is no robot.
    """
    changes = {}
    for name in parameters_of(standard):
        if name in constants:
            changes[name] = constants[name]
    try:
        return with_numbers(standard, changes)
    except (ValueError, OverflowError):
        return standard
