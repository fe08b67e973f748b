"""A replay in parts: figures and words of two runs, states it starts from, rows it copies, what it asks of `simulate`."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.logs import replays
from fivebar.estimation.logs.replays import Replay, _start
from fivebar.simulation.run import Event
from fivebar.singularities.margins import Singularity

ROBOT = fb.FiveBar()
N, STEP = 40, 0.01
T = STEP * np.arange(N)
PATH = fb.line((0.09, 0.068), (0.06, 0.08), T[-1])


def run_of(t=T, working=(-1, -1), turns=(0.0, 0.0), **changes):
    """A run along the line; its torques are those of no motion, 1 and 2 N m more each second."""
    motion = PATH(t)
    acc = fb.ikm(fb.igm(ROBOT, motion[0], working), motion[1])
    columns = {
        "q": acc.pose.q + 2 * np.pi * np.array(turns),
        "q_dot": acc.q_dot,
        "xi": motion[0],
        "tau": np.stack([t, 2 * t], axis=1),
        "energy": fb.energy(acc),
    }
    return fb.Run(robot=ROBOT, t=t, **(columns | changes))


RUN = run_of()


def test_figures_of_a_replay_are_those_of_its_distances():
    xi = RUN.xi + np.linspace(0.0, 1.0, N)[:, None] * (3e-6, 4e-6)
    xi[7] = np.nan
    tau = RUN.tau + np.array([0.5, -0.25])
    tau[9] = np.nan
    simulated = run_of(xi=xi, tau=tau, q=RUN.q + (2 * np.pi, 0.125))
    found = Replay(RUN, simulated, ("a note",))
    far = 5e-6 * np.delete(np.linspace(0.0, 1.0, N), 7)
    rms = np.sqrt((far**2).mean())
    assert found.figures == pytest.approx(
        {"rms_error_m": rms, "max_error_m": 5e-6, "final_error_m": 5e-6}
    )
    assert found.difference[-1] == pytest.approx((3e-6, 4e-6))
    assert found.q_difference == pytest.approx(np.tile((0.0, 0.125), (N, 1)))
    assert found.tau_difference[3] == pytest.approx((0.5, -0.25))
    size = f"apart {1e6 * rms:.4g} um rms, 5 um at most"
    assert repr(found) == f"<Replay: {size}>"
    assert str(found) == f"replay: {size}\ntorques apart 0.5 and 0.25 N m rms\na note"
    assert found.runs == {"measured": RUN, "simulated": simulated}
    without = Replay(RUN, run_of(xi=xi, tau=np.full_like(tau, np.nan)))
    assert "torques apart nan and nan N m rms" in str(without) and without.notes == ()


@pytest.mark.parametrize("working, assembly", [((-1, -1), -1), ((1, 1), -1), ((-1, 1), 1)])
def test_a_replay_starts_at_the_measured_state(working, assembly):
    """In the assembly mode whose point is nearer to the measured one."""
    point = np.array([0.02, 0.1])
    pose = fb.igm(ROBOT, point, working)
    other = fb.dgm(ROBOT, pose.q, -pose.assembly, unreachable="nan")
    assert np.hypot(*(other.xi - point)) > 0.01
    run = SimpleNamespace(
        t=np.array([0.0, 2.5]),
        q=np.array([(0.0, 0.0), pose.q]),
        xi=np.array([(0, 0), point]),
        q_dot=np.array([(0.0, 0.0), (0.3, -0.2)]),
    )
    start = _start(run, ROBOT, 1)
    assert start.pose.xi == pytest.approx(point) and start.pose.assembly == pose.assembly
    assert start.xi_dot == pytest.approx(fb.dkm(pose, (0.3, -0.2)).xi_dot)
    short = replace(ROBOT, l12=0.01, l22=0.01)
    with pytest.raises(fb.UnreachableError, match="at 2.5 s this robot's bars do not close"):
        _start(run, short, 1)


class Simulated:
    """In place of `simulate`: keeps what it was asked, and returns rows at times of its own."""

    def __init__(self, fails=()):
        self.asked, self.fails = [], fails

    def __call__(self, robot, law, reference=None, **options):
        self.asked.append(SimpleNamespace(robot=robot, law=law, reference=reference, **options))
        if len(self.asked) in self.fails:
            raise fb.UnreachableError("out of reach", 0.1)
        t = np.linspace(0.0, options["duration"] + 0.2, 7)
        start = options["start"]
        event = Event(0.01, Singularity.SERIAL, "sin", (-1,) * 3, (1,) * 3)
        return SimpleNamespace(
            t=t,
            q=start.pose.q + np.outer(t, (1.0, 2.0)),
            q_dot=np.outer(t, (3.0, 4.0)),
            xi=start.pose.xi + np.outer(t, (5.0, 6.0)),
            tau=np.outer(np.arange(7), (1.0, -1.0)),
            energy=7.0 * t,
            events=(event,),
        )


def with_gap():
    """Time stops for 1 s after the 20th row."""
    t = T + np.where(np.arange(N) < 20, 0.0, 1.0)
    return replace(RUN, t=t)


def test_rows_of_a_replay_are_those_of_its_simulations(monkeypatch):
    """Interpolated at the run's times; torques are held; whole turns and times are the run's."""
    simulate = Simulated()
    monkeypatch.setattr(replays, "simulate", simulate)
    run = replace(with_gap(), q=RUN.q + (4 * np.pi, -2 * np.pi), torque_limit=(3.0, 4.0))
    found = fb.replay(run)
    assert found.measured is run and found.notes == ()
    assert len(simulate.asked) == 2
    for first, asked in zip((0, 20), simulate.asked):
        rows = slice(first, first + 20)
        t = run.t[rows] - run.t[first]
        assert asked.duration == pytest.approx(0.19) and asked.control_period == pytest.approx(STEP)
        assert asked.start.pose.xi == pytest.approx(run.xi[first])
        assert asked.robot is ROBOT
        own = found.simulated
        assert own.q[rows] == pytest.approx(run.q[first] + np.outer(t, (1.0, 2.0)))
        assert own.q_dot[rows] == pytest.approx(np.outer(t, (3.0, 4.0)))
        assert own.xi[rows] == pytest.approx(run.xi[first] + np.outer(t, (5.0, 6.0)))
        assert own.energy[rows] == pytest.approx(7.0 * t)
        held = np.floor(t / 0.065 + 1e-6)
        assert own.tau[rows] == pytest.approx(np.outer(held, (1.0, -1.0)))
    assert [event.t for event in found.simulated.events] == pytest.approx([0.01, run.t[20] + 0.01])
    assert found.simulated.xi_ref is run.xi and found.simulated.torque_limit == (3.0, 4.0)
    assert found.simulated.t is run.t and found.simulated.robot is ROBOT


def test_what_cannot_be_simulated_is_told_and_the_rest_is(monkeypatch):
    simulate = Simulated(fails=(1,))
    monkeypatch.setattr(replays, "simulate", simulate)
    found = fb.replay(with_gap())
    (note,) = found.notes
    assert note.startswith("from 0 s nothing was simulated: out of reach")
    known = np.isfinite(found.simulated.q).all(axis=1)
    assert np.array_equal(known, np.arange(N) >= 20)
    assert np.isnan(found.simulated.energy[:20]).all() and len(found.simulated.events) == 1
    monkeypatch.setattr(replays, "simulate", Simulated(fails=(1, 2)))
    with pytest.raises(ValueError, match="nothing could be simulated: from 0 s .* out of reach"):
        fb.replay(with_gap())
    gaps = RUN.tau.copy()
    gaps[::3] = np.nan
    with pytest.raises(
        ValueError, match="26 rows, in stretches shorter than 4 rows, .* from 0.01 s"
    ):
        fb.replay(replace(RUN, tau=gaps))
    with pytest.raises(ValueError, match="of a five-bar robot, and robot is a biglide"):
        fb.replay(RUN, robot=fb.Biglide())
