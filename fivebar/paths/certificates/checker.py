"""python checker.py certificate.json: check what `fivebar.certify` proved, by mpmath's interval
arithmetic alone.

The claim: every five-bar robot of lengths within the tolerances reaches the whole path in the
    working mode; |sin q12|,
|sin q22| and |det A| are above 0 there and at least the margin, and det A has the sign of the
assembly mode. On each part of each piece all three are enclosed at once, by the mean value theorem,
with derivatives by the chain rule.
"""

import hashlib
import json
import sys
from types import SimpleNamespace
from typing import NamedTuple

from mpmath import iv, mpf

LENGTHS = ("l11", "l12", "l21", "l22", "d")
PIECES = {"line": ((2, 2),), "arc": ((2,), (), (), ()), "polynomial": ((None, 2),)}
ENTRIES = {"robot", "tolerances", "tool", "working", "assembly", "margin", "pieces", "parts"}
# Only ends of intervals are compared, as numbers: whether one interval is above another that it
# overlaps, or above NaN, mpmath 1.3 answers with None, and 1.4 with an error.
INTERVALS = SimpleNamespace(
    mpf=iv.mpf,
    sqrt=iv.sqrt,
    cos=iv.cos,
    sin=iv.sin,
    low=lambda interval: mpf(interval.a),
    high=lambda interval: mpf(interval.b),
)


class Number(NamedTuple):
    """An interval that holds a quantity, and those that hold its derivatives."""

    value: object
    slopes: object = ()

    def __add__(self, other):
        if not isinstance(other, Number):
            return Number(self.value + other, self.slopes)
        return Number(self.value + other.value, [a + b for a, b in zip(self.slopes, other.slopes)])

    def __mul__(self, other):
        if not isinstance(other, Number):
            return self.through(self.value * other, other)
        value = other.value
        return Number(
            self.value * value,
            [a * value + self.value * b for a, b in zip(self.slopes, other.slopes)],
        )

    def __sub__(self, other):
        return self + other * -1

    def __truediv__(self, other):
        value = self.value / other.value
        return Number(
            value, [(a - value * b) / other.value for a, b in zip(self.slopes, other.slopes)]
        )

    def through(self, value, slope):
        return Number(value, [a * slope for a in self.slopes])


def point(piece, u, on=INTERVALS):
    """x and y of a piece at its parameter u from 0 to 1; on: an interval arithmetic."""
    ((kind, of),) = piece.items()
    if kind == "line":
        return tuple(u * (on.mpf(last) - first) + first for first, last in zip(*of))
    if kind == "arc":
        (cx, cy), radius, start, stop = of
        angle = u * (on.mpf(stop) - start) + start
        cos = on.cos(angle.value)
        sin = on.sin(angle.value)
        return (angle.through(cos, -sin) * radius + cx, angle.through(sin, cos) * radius + cy)
    if kind == "polynomial":
        x = y = u * 0
        for cx, cy in reversed(of):
            x = x * u + cx
            y = y * u + cy
        return x, y
    raise ValueError(f"no piece is a {kind!r}")


def reach(base, l1, l2, x, y):
    """Of a leg its two bars, the way from its base, its square, and by how much that is within both
    limits.
    """
    rx = x - base
    r2 = rx * rx + y * y
    return (l1, l2, rx, y, r2, (l1 + l2) * (l1 + l2) - r2, r2 - (l1 - l2) * (l1 - l2))


def legs(x, y, lengths):
    """`reach` of both legs."""
    l11, l12, l21, l22, d = lengths
    return [reach(d * -0.5, l11, l12, x, y), reach(d * 0.5, l21, l22, x, y)]


def distal(leg, mode, on=INTERVALS):
    """The distal bar as a vector, and l1^2 l2^2 sin^2 q_i2 times 4; None out of reach."""
    l1, l2, rx, ry, r2, outer, inner = leg
    if not all(on.low(number.value) > 0 for number in (outer, inner, r2)):
        return None
    product = outer * inner
    root = on.sqrt(product.value)
    along = (r2 - l1 * l1 + l2 * l2) / (r2 * 2)
    across = product.through(root, 1 / (root * 2)) / (r2 * 2) * mode
    return (along * rx + across * ry, along * ry - across * rx, product)


def margins(reached, working, on=INTERVALS):
    """sin^2 q12, sin^2 q22 and det A, of what `legs` gives; None where a leg may be out of
    reach.
    """
    sines = []
    u2 = []
    for mode, leg in zip(working, reached):
        if (bar := distal(leg, mode, on)) is None:
            return None
        l1, l2 = leg[:2]
        sines.append(bar[2] / (l1 * l1 * l2 * l2 * 4))
        u2 += [bar[0] / l2, bar[1] / l2]
    return *sines, u2[0] * u2[3] - u2[1] * u2[2]


def joint(x, y, lengths, tool, working, on=INTERVALS):
    """x and y of the joint of the distal bars, of the tool's x and y; None where the leg may not
    lead the tool there in its mode. tool: {leg, along, across}, as `fivebar.Tool` has them.

    The tool T closes a dyad of l1 and r = |l2 + along + i across| on the base, and from its elbow E
    T - C = (along + i across) / (l2 + along + i across) (T - E).
    """
    k = int(tool["leg"]) - 1
    l1, l2 = lengths[2 * k : 2 * k + 2]
    along = on.mpf(tool["along"])
    across = on.mpf(tool["across"])
    real = l2 + along
    r2 = real * real + across * across
    if on.low(real.value) > 0:
        mode = working[k]
    elif on.high(real.value) < 0:
        mode = -working[k]
    else:
        return None
    root = on.sqrt(r2.value)
    leg = reach(lengths[4] * (k - 0.5), l1, r2.through(root, 1 / (root * 2)), x, y)
    bar = distal(leg, mode, on)
    if bar is None:
        return None
    ex, ey, _ = bar
    # (C - E) / l2
    fx = (real * ex + ey * across) / r2
    fy = (real * ey - ex * across) / r2
    # E x (C - E): of sin q_i2, which the mode gives a sign.
    bend = ((leg[2] - ex) * fy - (leg[3] - ey) * fx) * -working[k]
    if not on.low(bend.value) > 0:
        return None
    return (x - fx * along + fy * across, y - fy * along - fx * across)


def proved(certificate, piece, first, last, on=INTERVALS):
    """Return whether the claim holds on a part of a piece."""
    whole = [on.mpf((first, last))]
    middle = [on.mpf((first + last) / 2)]
    free = [0]
    for k, name in enumerate(LENGTHS, 1):
        length = on.mpf(certificate["robot"].get(name, 0))
        tolerance = on.mpf(certificate["tolerances"].get(name, 0))
        whole.append(on.mpf((length - tolerance, length + tolerance)))
        middle.append(length)
        free += [k] * (on.low(tolerance) > 0)
    if not all(on.low(bar) > 0 for bar in whole[1:-1]):
        return False

    def centred(over, at):  # the mean value theorem
        change = sum(
            (slope * (whole[k] - middle[k]) for slope, k in zip(over.slopes, free)), on.mpf(0)
        )
        return Number(at.value + change, over.slopes)

    both = []
    for values in (whole, middle):
        numbers = []
        for k, value in enumerate(values):
            numbers.append(Number(value, [on.mpf(k == j) for j in free]))
        place = point(piece, numbers[0], on)
        if tool := certificate.get("tool"):
            place = joint(*place, numbers[1:], tool, certificate["working"], on)
        if place is None:
            return False
        both.append(list(legs(*place, numbers[1:])))
    both[0] = [list(map(centred, *leg)) for leg in zip(*both)]
    both = [margins(each, certificate["working"], on) for each in both]
    if None in both:
        return False
    least = on.mpf(certificate["margin"])
    wanted = zip(*both, (least * least, least * least, least), (1, 1, -certificate["assembly"]))
    for over, at, bound, sign in wanted:
        value = centred(over, at).value * sign
        if not (on.low(value) > 0 and on.low(value - bound) >= 0):
            return False
    return True


def digest(certificate):
    claim = {key: value for key, value in certificate.items() if key != "sha256"}
    content = json.dumps(claim, sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()


def has_shape(value, *sizes):
    """Return whether a value is finite numbers in nested lists of these sizes; None: of any."""
    if not sizes:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and abs(value) < 1e300
    if not isinstance(value, list) or sizes[0] not in (None, len(value)):
        return False
    return all(has_shape(each, *sizes[1:]) for each in value)


def is_piece(piece):
    """Return whether a value is a line, an arc or a polynomial."""
    if not isinstance(piece, dict) or len(piece) != 1:
        return False
    ((kind, of),) = piece.items()
    shapes = PIECES.get(kind)
    if shapes and len(shapes) == 1:
        return has_shape(of, *shapes[0])
    if not (shapes and isinstance(of, list) and len(of) == len(shapes)):
        return False
    return all(has_shape(each, *shape) for each, shape in zip(of, shapes))


def fault(certificate):
    """Return what is wrong with the form of a certificate; None where nothing is."""
    if not isinstance(certificate, dict):
        return "it is no JSON object"
    if unknown := sorted(set(certificate) - ENTRIES - {"sha256"}):
        return f"unknown: {', '.join(unknown)[:60]}"
    for name in ("robot", "tolerances", "tool")[: 2 + ("tool" in certificate)]:
        given = certificate.get(name)
        if not isinstance(given, dict) or not all(map(has_shape, given.values())):
            return f"{name} must be an object of finite numbers"
    robot = certificate["robot"]
    tolerances = certificate["tolerances"]
    if not set(robot) == set(LENGTHS) >= set(tolerances):
        return f"robot must have {', '.join(LENGTHS)}, and tolerances none but these"
    if not has_shape(certificate.get("margin")):
        return "margin must be a finite number"
    if min(*robot.values(), *tolerances.values(), certificate["margin"]) < 0:
        return "a length, a tolerance or the margin is below 0"
    modes = certificate.get("working")
    if not (has_shape(modes, 2) and {*modes} <= {-1, 1}):
        return "working must be two modes of -1 or 1"
    if certificate.get("assembly") not in (-1, 1):
        return "assembly must be -1 or 1"
    if "tool" in certificate:
        tool = certificate["tool"]
        if set(tool) != {"leg", "along", "across"} or tool["leg"] not in (1, 2):
            return "tool must have leg, 1 or 2, along and across"
    pieces = certificate.get("pieces")
    parts = certificate.get("parts")
    if not (isinstance(pieces, list) and pieces):
        return "it has no pieces"
    for number, piece in enumerate(pieces, 1):
        if not is_piece(piece):
            return f"piece {number} is no line, arc or polynomial of finite numbers"
    if not has_shape(parts, len(pieces), None):
        return "parts must be a list of numbers for each piece"
    return None


def refusal(certificate, shown=iter):
    """Why a certificate does not prove its claim; None where it does. shown: a progress bar around
    the pieces.
    """
    iv.prec = 80
    if wrong := fault(certificate):
        return f"it is no certificate: {wrong}"
    if certificate.get("sha256") != digest(certificate):
        return "it is not as it was written (sha256)"
    gap = 1e-12 * sum(certificate["robot"].values())
    end = None
    pairs = list(zip(certificate["pieces"], certificate["parts"]))
    for number, (piece, parts) in enumerate(shown(pairs), 1):
        start = [xy.value for xy in point(piece, Number(iv.mpf(0)))]
        joined = end is None or all(INTERVALS.high(abs(a - b)) <= gap for a, b in zip(end, start))
        if not (joined and parts[:1] == [0] and parts[-1:] == [1]):
            return (
                f"piece {number} does not begin where the one before ends, or its parts are not"
                " from 0 to 1"
            )
        end = [xy.value for xy in point(piece, Number(iv.mpf(1)))]
        for first, last in zip(parts, parts[1:]):
            if not (first < last and proved(certificate, piece, first, last)):
                return f"piece {number}, from {first} to {last} of it: not proved"
    return None


def check(file, shown=iter):
    """Return why a file does not prove its claim; None where it does."""
    try:
        with open(file, encoding="utf-8") as opened:
            certificate = json.load(opened)
    except OSError as error:
        return f"it cannot be read: {error.strerror}"
    except (ValueError, RecursionError) as error:
        return f"it is no certificate: it is no JSON in UTF-8 ({error})"
    return refusal(certificate, shown)


if __name__ == "__main__":
    sys.exit(check(sys.argv[1]) or print("proved"))
