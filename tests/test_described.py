"""What results say of themselves: one line each, with numbers for one pose and shapes for batches."""

import html
from base64 import b64decode

import casadi
import numpy as np
import pytest

import fivebar as fb
from fivebar import linkages, view
from fivebar.singularities.margins import Singularity
from fivebar.singularities.passages import Passage, Route

ROBOT, SERIAL = fb.FiveBar(), Singularity.SERIAL
POSE = fb.igm(ROBOT, (0.05, 0.09))
RATES = fb.ikm(POSE, (0.1, 0.0))
LINE = fb.line((0.05, 0.09), (0.0, 0.1), 1.0)
RUN = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), LINE)


def symbols():
    return fb.igm(ROBOT, casadi.SX.sym("xi", 2))


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (
            lambda: POSE,
            "<Pose: xi = (0.05, 0.09) m, q = (0.022595, 0.626149) rad, working (-1, -1), assembly -1",
        ),
        (lambda: fb.igm(ROBOT, np.full((4, 2), 0.09)), "<Pose: xi (4, 2), five-bar robot>"),
        (lambda: fb.igm(ROBOT, (1.0, 1.0), unreachable="nan"), "q = (nan, nan) rad"),
        (symbols, "<Pose: xi of symbols, five-bar robot>"),
        (lambda: fb.dgm(fb.Biglide(), (0.0, 0.1)), "q = (0, 0.1) m"),
        (lambda: RATES, "<Rates: xi' = (0.1, 0) m/s, q' = "),
        (lambda: fb.dkm2(RATES, (1.0, -2.0)), "q'' = (1, -2) rad/s²"),
        (
            lambda: fb.singularity_margins(POSE),
            "<Margins: sin q12, sin q22, det A = (0.972382, 0.868893, 0.977223), <Pose: xi = ",
        ),
        (lambda: RUN, "<Run: five-bar robot, 1 s in 1001 rows, error at most "),
        (lambda: view.scene(ROBOT, RUN), ", 1 s)"),
        (lambda: fb.line((0.09, 0.068), (0, 0.1), 2.0), "from = (0.09, 0.068) m, to = (0, 0.1) m>"),
        (
            lambda: fb.plan(ROBOT, (0.05, 0.09), (0.0, 0.1), 1.0),
            "five-bar robot, 1 s, working (-1, -1), effort ",
        ),
        (lambda: fb.plan(ROBOT, POSE, fb.igm(ROBOT, (0.0, 0.1)), 1.0), "free of modes"),
        (
            lambda: fb.time_path(
                ROBOT, fb.path([(0.05, 0.09), (0, 0.1)]), constraints=fb.Constraints(torque=0.1)
            ),
            "s, proved: no less than",
        ),
        (
            lambda: fb.singularity_map(fb.Biglide(), "serial_right", "joint", shape=(20, 30)),
            "<Map: sin phi2, signed, 0 at Type 1 of the right leg, joint space, 20 x 30 nodes, 2 modes, biglide robot>",
        ),
        (
            lambda: fb.check_path(ROBOT, fb.line((0.09, 0.068), (0.05, 0.0), 2.0)),
            "<PathCheck: meets Type 2 at 1.58636 s, torque diverges, least margin 0 at 1.58636 s>",
        ),
        (
            lambda: fb.check_path(ROBOT, fb.line((0.09, 0.068), (0.5, 0.0), 2.0)),
            "<PathCheck: leaves the workspace at 0.367249 s, least margin 0 at 0.367249 s>",
        ),
        (
            lambda: fb.check_path(ROBOT, LINE, constraints=fb.Constraints(det_A=0.99)),
            "<PathCheck: free of singularities, breaks |det A| >= 0.99 from 0 s, least margin 0.869 at 0 s>",
        ),
        (
            lambda: fb.check_path(ROBOT, fb.line((0.121, 0.0), (-0.2, 0.01), 2.0)),
            "<PathCheck: leaves the workspace at 1.28542 s, touches Type 1 at 0 s, least margin 0 at 0 s>",
        ),
        (
            lambda: fb.check_path(fb.Biglide(), fb.line((0.05, 0.1), (-0.05, 0.5), 2.0), (-1, 1)),
            "<PathCheck: meets Type 2 at 1 s, finite torque, least margin 0 at 1 s>",
        ),
        (
            lambda: fb.Constraints(
                joints=(None, (-1, 2.5)),
                half_planes=[(0, 2, 0.02)],
                region=[(0, 0), (1, 0), (0, 1)],
                det_A=0.25,
            ),
            "<Constraints: joints (None, (-1.0, 2.5)), half_planes ((0.0, 1.0, 0.01),), region ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), det_A 0.25>",
        ),
        (
            lambda: fb.Constraints(
                joints=((0, 1), None), sin=0.125, collisions=fb.LinkCollisions(0.01)
            ),
            "<Constraints: joints ((0.0, 1.0), None), sin 0.125, collisions LinkCollisions(widths=",
        ),
        (
            lambda: Route(
                (1, 2, 3),
                (Passage((1, 2), SERIAL, 1, POSE.xi, True), Passage((2, 3), SERIAL, 0, POSE.xi)),
            ),
            "<Route: aspect 1, right leg folded -> 2, left leg -> 3>",
        ),
        (
            lambda: fb.routes(ROBOT, POSE, fb.igm(ROBOT, (0.0, 0.1), (-1, 1)))[0],
            "<Route: aspect 9, right leg -> 8, Type 2 -> 6>",
        ),
        (lambda: fb.aspects(ROBOT)[0], "Aspect(number=1, working=(1, 1), assembly=-1"),
        (
            lambda: linkages.study(linkages.FourBar(0.2, 0.06, 0.16, 0.14)),
            "<Study: FourBar, 1 s in ",
        ),
    ],
)
def test_an_object_says_in_one_line_what_it_is(made, words):
    notes = repr(made())
    assert words in notes and "\n" not in notes and len(notes) < 250


@pytest.mark.deep
def test_a_notebook_shows_the_picture():
    for made in (RUN, fb.plan(ROBOT, (0.05, 0.09), (0.0, 0.1), 1.0)):
        shown = made._repr_html_()
        picture = b64decode(shown.partition("base64,")[2].partition('"')[0])
        assert (
            picture.startswith(b"\x89PNG")
            and len(shown) < 200_000
            and html.escape(repr(made)) in shown
        )
