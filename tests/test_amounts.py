"""What would take too much time or memory is refused at once, and what is large but possible is not held twice over."""

import resource
import subprocess
import sys
import time

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
LOADED = (
    fb.simulate,
    fb.simulate_many,
    fb.Tracker,
    fb.singularity_map,
)  # now, as it is not what is measured
LINE = fb.line((0.09, 0.068), (0.0, 0.1), 1.0)
CONTROLLER = fb.ComputedTorque(ROBOT, 100, 20)
FOUR_BAR = fb.linkages.FourBar(0.2, 0.06, 0.16, 0.14)


@pytest.mark.parametrize(
    "call, words",
    [
        (
            lambda: fb.simulate(ROBOT, CONTROLLER, LINE, step=1e-9),
            r"1e\+09 steps of 1e-09 s: at most 1e\+07.* 400 GB",
        ),
        (lambda: fb.Tracker(ROBOT, 10**20), "horizon must be at most 500"),
        (lambda: fb.Tracker(ROBOT, delay=10**9), "delay must be at most 1000"),
        (lambda: fb.linkages.study(FOUR_BAR, turns=1e6), r"are more than 10\^6 poses"),
        (
            lambda: fb.linkages.coupler_curves(FOUR_BAR, samples=10**12),
            "samples must be at most 1000000",
        ),
        (
            lambda: fb.simulate_many(
                [ROBOT] * 100, CONTROLLER, LINE, step=1e-6, control_period=1e-3
            ),
            r"100 runs of 1000000 steps are 1e\+08 rows .*: at most 3e\+07.* 18 GB",
        ),
        (
            lambda: fb.simulate_many([ROBOT], CONTROLLER, LINE, step=1e-6, control_period=1.0),
            r"control_period = 1 s is 1e\+06 steps: at most 100000",
        ),
        (lambda: fb.singularity_map(ROBOT, shape=(10**6, 10**6)), "map of 1000000 x 1000000 nodes"),
    ],
)
def test_what_is_too_large_is_refused_at_once(call, words):
    began = time.process_time()
    with pytest.raises(ValueError, match=words):
        call()
    assert time.process_time() - began < 0.5


def test_a_control_period_beyond_the_end_is_one_period():
    long, whole = (
        fb.simulate(ROBOT, CONTROLLER, LINE, control_period=period) for period in (1e6, 1.0)
    )
    assert np.array_equal(long.q, whole.q) and len(long.control.t) == 1
    many, _ = fb.simulate_many(
        [ROBOT, ROBOT], CONTROLLER, LINE, control_period=1e6, integrator=fb.Integrator(chart="task")
    )
    assert len(many.t) == len(long.t)


@pytest.mark.every(2)
@pytest.mark.parametrize("method", ["None", "'rk4'"])
def test_a_period_of_many_steps_takes_the_memory_of_its_rows(method):
    """A hundred thousand rows of one period: less than 1 kB a row, where compiling the period took 7 kB a step."""
    code = f"""import fivebar as fb, resource
robot, line = fb.FiveBar(), fb.line((0.09, 0.068), (0.0, 0.1), 0.1)
control = fb.ComputedTorque(robot, 100, 20)
fb.simulate(robot, control, line, control_period=0.01, step=1e-5, integrator=fb.Integrator({method}))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
run = fb.simulate(robot, control, line, control_period=0.1, step=1e-6, integrator=fb.Integrator({method}))
print(len(run.t), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    rows, kilobytes = map(int, done.stdout.split())
    assert rows == 100_001 and kilobytes < 1.0 * rows
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # the unit of both is kB here
