"""Odd calls of every public function: an answer or a documented error, never anything else.

Eighty calls each; with FIVEBAR_NIGHTLY=1 ten thousand, of slow functions as many as NIGHT seconds allow.
"""

import os
import resource
import zlib
from pathlib import Path

import numpy as np
import pytest

import fivebar as fb
from fivebar.amoro.models import models
from tests.helpers.odd_calls import odd_calls
from tests.helpers.odd_cases import CASES, parameters_missed, public_names

NIGHTLY = bool(os.environ.get("FIVEBAR_NIGHTLY"))
CALLS, SECONDS, NIGHT = (10_000, 60.0, 60.0) if NIGHTLY else (80, 3.0, 60.0)
# Of these a few calls take more than half a second.
SLOW = (
    "place",
    "exciting_trajectory",
    "calibrate",
    "aspect",
    "largest_rectangle",
    "identify",
    "dexterous",
    "largest_disc",
    "measurement_poses",
    "design",
    "plan",
)
NAMES = [pytest.param(name, marks=pytest.mark.deep) if name in SLOW else name for name in CASES]
MEMORY = 4 * 2**30  # bytes that a call may take


@pytest.fixture
def little_memory(monkeypatch, tmp_path):
    """MEMORY beside what tests before have loaded, and a folder of its own for files whose names were strange."""
    monkeypatch.chdir(tmp_path)
    before = resource.getrlimit(resource.RLIMIT_AS)
    taken = (
        int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
        * resource.getpagesize()
    )
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


def test_every_public_function_and_parameter_is_called_oddly():
    assert set(CASES) == public_names()
    assert parameters_missed() == []


@pytest.mark.parametrize("name", NAMES)
def test_odd_calls(name, little_memory, record_property):
    report = odd_calls(
        CASES[name], CALLS, np.random.default_rng(zlib.crc32(name.encode())), SECONDS
    )
    record_property("calls", report.calls)
    assert report.calls > 5  # of as many as the seconds allow
    assert not report.wrong, "\n".join(f"{given} -> {what}" for given, what in report.wrong[:10])


ROBOT = fb.FiveBar()
LAB = models(ROBOT)


@pytest.mark.parametrize(
    "call, error, words",
    [
        (
            lambda: fb.FeedForward(ROBOT, 1.0, 1.0, ahead=np.nan),
            ValueError,
            "ahead must be finite and >= 0, not nan",
        ),
        (
            lambda: LAB.dkm(0.2, np.nan, -0.1, 0.3, 0.1, 0.2),
            ValueError,
            "q12 must be finite, not nan",
        ),
        (
            lambda: LAB.dynamic_model(0.2, 1.0, -0.1, 0.3, 0.1, np.inf, 0, 0),
            ValueError,
            "q12D must be finite, not inf",
        ),
        (
            lambda: fb.linkages.move(fb.linkages.FourBar(4, 2, 3, 4), 1.0, 1e200),
            ValueError,
            "q_dot must be below 1e",
        ),
        (
            lambda: fb.ikm(fb.dgm(ROBOT, (0.2, -0.1)), (1e200, 0.0)),
            ValueError,
            r"xi_dot must be below 1e\+60",
        ),
        (
            lambda: fb.dgm(5, (0.2, -0.1)),
            TypeError,
            r"robot must be a robot, as FiveBar\(\) or Biglide\(\), not 5",
        ),
        (
            lambda: fb.dkm(ROBOT, (1.0, 0.0)),
            TypeError,
            "pose must be a Pose, as dgm and igm give, not FiveBar",
        ),
        (
            lambda: fb.dynamic_model(fb.dgm(ROBOT, (0, 0))),
            TypeError,
            "rates must be Rates, as dkm and ikm give",
        ),
        (lambda: fb.igm(ROBOT, ("0.09", "0.068")), ValueError, "xi must be real numbers"),
        (
            lambda: fb.dgm(ROBOT, (0.2, -0.1), assembly="1"),
            ValueError,
            "assembly must be real numbers, not '1'",
        ),
        (lambda: fb.linkages.FiveBarLinkage("x"), TypeError, "robot must be a FiveBar, not 'x'"),
        (
            lambda: fb.linkages.FourBar(0.2, 0.06, 0.16, "a"),
            ValueError,
            "rocker must be a number, not 'a'",
        ),
        (lambda: fb.FiveBar(l11="0.1"), ValueError, "l11 must be a number, not '0.1'"),
        (lambda: fb.simulate("robot", duration=1.0), ValueError, "no robot 'robot': the known"),
        (lambda: fb.largest_disc(ROBOT), TypeError, "aspect must be an Aspect, not FiveBar"),
    ],
)
def test_what_the_report_named(call, error, words):
    with pytest.raises(error, match=words):
        call()


def test_casadi_numbers_are_no_lengths_of_linkages_and_no_modes():
    import casadi

    with pytest.raises(ValueError, match="crank must be a number"):
        fb.linkages.FourBar(0.2, casadi.SX.sym("l"), 0.16, 0.14)
    with pytest.raises(ValueError, match="working must be real numbers"):
        fb.igm(ROBOT, (0.09, 0.068), working=casadi.SX.sym("w", 2))
    assert fb.FiveBar(l11=casadi.DM(0.09)) == ROBOT  # CasADi's numbers are numbers
    symbol = casadi.SX.sym("l")
    assert fb.FiveBar(l11=symbol).l11 is symbol
