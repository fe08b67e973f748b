"""Mirror images of regions against their points, areas and loci in the other working mode."""

import numpy as np
import pytest

import fivebar as fb
from fivebar.singularities.leg_circles import LegCircles
from fivebar.singularities.level_curves import LevelCurves
from fivebar.singularities.locus import Vertex
from fivebar.singularities.mirror import Mirror
from fivebar.singularities.regions import LocusArc
from tests.helpers.curves import TURN, ellipse


@pytest.mark.parametrize(
    "cuts", [(0.5, 2.0), (-2.0, -0.5), (-0.7, 0.7), (0.7, TURN - 0.7), (0, TURN), (1.0, 5.0)]
)
def test_an_arc_of_a_circle_is_mirrored_onto_the_arc_that_is_there(cuts):
    """Its image is from -high to -low, or a turn later: that arc of that circle alone."""
    low, high = cuts
    ends = {0.5: (-2.0, -0.5), -2.0: (0.5, 2.0), 1.0: (TURN - 5.0, TURN - 1.0)}.get(low, cuts)
    (own,) = ellipse(2, 2, 0.3, cuts, circle=(0, 1))
    (image,) = ellipse(2, 2, 0.3, ends, circle=(0, 1))
    others = [
        *ellipse(1, 1, 0.3, ends, circle=(1, 1)),
        *ellipse(2, 2, 0.3, (ends[0], ends[1] - 1e-9), circle=(0, 1)),
        *ellipse(2, 2, 0.3, (ends[0] + 1e-9, ends[1]), circle=(0, 1)),
        *ellipse(2, 2, 0.3, ends),
    ]
    mirror = Mirror([*(arc.locus for arc in others), own.locus, image.locus])
    ((found,),) = mirror.loops(((own,),))
    assert found.locus is own.locus if ends == cuts else found.locus is image.locus
    part = LocusArc(own.locus, low + 0.1 * (high - low), high - 0.3 * (high - low))
    ((found,),) = mirror.loops(((part,),))
    assert found.locus is (own if ends == cuts else image).locus
    assert_mirrored(found, part)
    assert found.start == pytest.approx(ends[0] + 0.3 * (high - low)) and found.end > found.start


def assert_mirrored(found, arc):
    """Run through the other way, each point of its samples conjugate, and on the curve."""
    np.testing.assert_array_equal(found.z, arc.z[::-1].conj())
    np.testing.assert_allclose(found.at(found.s), found.z, rtol=0, atol=4e-15)
    assert (found.s[0], found.s[-1]) == pytest.approx((found.start, found.end), abs=1e-15)
    assert (np.sign(np.diff(found.s)) == np.sign(found.end - found.start)).all()
    own = LocusArc(found.locus, found.start, found.end)
    assert found.moment == pytest.approx(own.moment, rel=1e-12) and found.moment == arc.moment
    np.testing.assert_allclose(
        found.tangent(found.s), -arc.tangent(arc.s)[::-1].conj(), rtol=0, atol=1e-13
    )


def test_a_circle_whose_image_is_missing_and_other_curves_get_an_image_of_their_own():
    (alone,), (curve,) = (
        ellipse(2, 2, 0.3, (0.5, 2.0), circle=(0, 1)),
        ellipse(2, 1, 0.3 + 0.2j, (0.3, 5.0)),
    )
    wrong = ellipse(2, 2, 0.3, (0.5, 2.0 + TURN), circle=(0, 1))[0]
    mirror = Mirror([alone.locus, curve.locus, wrong.locus])
    loop = (alone, curve)
    ((second, first),) = mirror.loops((loop,))
    for found, arc in ((first, alone), (second, curve)):
        assert found.locus not in (alone.locus, curve.locus) and (found.start, found.end) == (
            arc.end,
            arc.start,
        )
        assert_mirrored(found, arc)
        np.testing.assert_array_equal(found.locus.points, arc.locus.points * (1, -1))
        assert mirror.loops(((arc.reversed,),))[0][0].locus is found.locus  # one image of each


def test_images_of_loci_are_loci_of_the_mirrored_working_mode():
    robot = fb.FiveBar(0.12, 0.1, 0.08, 0.15, 0.1)
    circles = LegCircles(robot, 0.2)
    levels = LevelCurves(robot, 0.3, circles)
    for piece in levels.pieces((1, -1)):
        image = Mirror([*circles.pieces]).loops(((LocusArc(piece, *piece.interval),),))[0][0].locus
        assert image.working == ((-1, 1),) and (image.type, image.kind) == (piece.type, piece.kind)
        assert all(isinstance(each, Vertex) for each in image.vertices)
        assert [(v.z.conjugate(), v.circles) for v in image.vertices] == [
            (v.z, v.circles) for v in piece.vertices
        ]
        t = np.linspace(*image.interval, 9)[1:-1]
        pose, own = fb.igm(robot, image.at(t), (-1, 1)), fb.igm(robot, piece.at(t), (1, -1))
        np.testing.assert_allclose(pose.det_A, -own.det_A, rtol=0, atol=1e-13)
        np.testing.assert_allclose(np.abs(pose.det_A), 0.3, rtol=0, atol=1e-10)
