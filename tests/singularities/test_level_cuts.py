"""Cuts of a curve of one det A: which of them are one, and what vertices they share."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.five_bar_loci import CouplerCurve
from tests.singularities.test_level_curves import ROBOTS, curves, made_around


def test_two_cuts_are_one_where_they_touch_or_pass_a_corner():
    levels = curves(ROBOTS["unequal"], 0.3, 0.2)
    size, near = levels.circles.scale, 1e-12

    def one(apart, places, circles=((0, 1), (1, 1)), first=0.3):
        found = [(first, circles[0]), (first + apart, circles[1])]
        forth, back = (
            levels._one(found, [0.1j, 0.1j + places * size], k, m, 4.0) for k, m in ((0, 1), (1, 0))
        )
        assert forth == back
        return forth

    for apart, same in (
        (0, True),
        (3e-7, True),
        (5e-7, False),
        (2.0, False),
        (4 - 3e-7, True),
        (4 - 5e-7, False),
    ):
        assert (
            one(apart, 0.3, ((1, 1), (1, 1))) == same
        )  # a circle that is touched, over the curve's end too
    for apart, same in (
        (0, True),
        (3e-3, True),
        (5e-3, False),
        (2.0, False),
        (4 - 3e-3, True),
        (4 - 5e-3, False),
    ):
        assert one(apart, 0.9 * near) == same and not one(apart, 1.5 * near)


def test_a_vertex_is_shared_by_what_ends_within_a_millionth_of_the_size():
    for factor in (1.0, 100.0):
        levels = curves(
            fb.FiveBar(*(factor * each for each in (0.12, 0.1, 0.08, 0.15, 0.1))), 0.3, 0.2
        )
        near = 1e-6 * levels.circles.scale
        corner = next(v for v in levels.corners if len(v.circles) == 2)
        node = levels._vertex("folded +", 0.1j, set())
        assert (node.z, node.circles) == (0.1j, ()) and levels.nodes == {"folded +": [node]}
        for by in (0.9, -0.9j):
            assert levels._vertex("folded +", node.z + by * near, set()) is node
            assert levels._vertex("any", corner.z + by * near, set(corner.circles)) is corner
            assert (
                levels._vertex("any", corner.z + by / 0.9 * 1.1 * near, set(corner.circles))
                is not corner
            )
        assert (
            levels._vertex("folded +", node.z + 1.1 * near, set()) is not node
            and len(levels.nodes["folded +"]) == 2
        )
        assert levels._vertex("folded -", node.z, set()) is not node
        lone = levels._vertex("folded +", corner.z, {(0, 1)})
        assert lone.circles == ((0, 1),) and lone.z == corner.z and lone not in levels.corners


@pytest.mark.parametrize("more", [None, (), (1.0,), (1.0, 2.0)])
def test_a_corner_where_the_curves_parameter_begins_is_one_cut(more):
    sin = 0.3
    robot, z = made_around(np.arcsin(sin), 0.0, 0.9 + np.arcsin(sin), 0.9, (0.21, 0.17, 0.19, 0.23))
    levels = curves(robot, np.sin(0.9), sin)
    kind, chain = min(
        (each for each in levels.chains if each[0] == "folded +"),
        key=lambda each: abs(_nearest(each[1], z)[0]),
    )
    _, begin = _nearest(chain, z)
    motion = chain.motion
    found = [[1e-13, *(more or ())], [], [motion.period - 1e-13] * (more is not None), []]

    class Shifted:
        period, flat = motion.period, ()
        meets = staticmethod(lambda ways: found)

        def __call__(self, t):
            return motion(t + begin)

    t, vertices = levels._cuts(kind, CouplerCurve(robot, Shifted(), chain.bars), (1, 1))
    assert t == [1e-13, *(more or ())] and len(vertices) == len(t)
    assert set(vertices[0].circles) == ({(0, 1)} if more is None else {(0, 1), (1, 1)})
    assert (vertices[0] in levels.corners) == (more is not None)
    assert all(v.circles == ((0, 1),) for v in vertices[1:])


def _nearest(chain, z):
    """How near the chain comes to z, and where."""
    t = np.linspace(0, chain.motion.period, 2001)
    k = np.abs(chain.task(t)[0] - z).argmin()
    t = t[k]
    for _ in range(6):
        at, slope = chain.task(np.array([t]))
        t += ((z - at[0]) / slope[0]).real
    return abs(chain.task(np.array([t]))[0][0] - z), t
