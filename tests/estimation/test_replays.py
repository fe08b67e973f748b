"""A run beside its simulation: the same torques, the same reference, another robot, gaps."""

from dataclasses import replace

import numpy as np
import pytest

import fivebar as fb

ROBOT = fb.FiveBar()
RUN = fb.simulate(
    ROBOT, fb.ComputedTorque(ROBOT, 400.0, 40.0), fb.line((0.09, 0.068), (0.0, 0.1), 1.0), step=2e-3
)
COLUMNS = {"t": RUN.t, "q": RUN.q, "tau": RUN.tau}


def test_a_replay_of_the_torques_is_the_run_and_of_another_robot_is_not(tmp_path):
    same = fb.replay(RUN)
    assert same.figures["max_error_m"] < 1e-9 and np.nanmax(np.abs(same.tau_difference)) < 1e-15
    other = fb.replay(RUN, replace(ROBOT, m=0.6), restart=0.25)
    assert (
        1e-6
        < other.figures["max_error_m"]
        < fb.replay(RUN, replace(ROBOT, m=0.6)).figures["max_error_m"]
    )
    measured = fb.from_log(COLUMNS)
    held = fb.replay(measured)
    assert held.figures["max_error_m"] < 2e-4  # rates by differentiation
    held.plot(tmp_path / "a.png"), held.page(tmp_path / "a.html")
    held.scene().save(tmp_path / "b.html")
    assert all((tmp_path / name).stat().st_size > 10_000 for name in ("a.png", "a.html", "b.html"))
    assert "\n" not in repr(held) and "torques apart" in str(held)


HOLDS = "each torque is taken as held to the next row, which comes nearer to the run"


def test_torques_of_a_simulated_run_are_held_after_a_round_trip(tmp_path):
    """Its file says so; of other logs the better is chosen, and said if it is not the usual one."""
    RUN.to_csv(tmp_path / "run.csv")
    run = fb.from_log(tmp_path / "run.csv")
    run.to_csv(tmp_path / "again.csv")
    for own in (run, fb.from_log(tmp_path / "again.csv"), fb.Run.from_csv(tmp_path / "again.csv")):
        found = fb.replay(own)
        assert own.measured.held and found.notes == ()
        assert found.figures["max_error_m"] < 1e-12
    log = fb.from_log({**COLUMNS, "q_dot": RUN.q_dot})
    found = fb.replay(log)
    assert not log.measured.held and found.notes == (HOLDS,)
    assert found.figures["max_error_m"] < 1e-12
    log.to_csv(tmp_path / "log.csv")
    assert not fb.from_log(tmp_path / "log.csv").measured.held
    means = RUN.tau.copy()
    means[1:] = (RUN.tau[1:] + RUN.tau[:-1]) / 2
    smooth = fb.replay(fb.from_log({**COLUMNS, "tau": means}))
    assert smooth.notes == () and smooth.figures["max_error_m"] < 1e-3


def test_what_is_no_run_and_what_has_no_torques_is_refused():
    with pytest.raises(TypeError, match="a Run, as fb.from_log and fb.Run.from_csv read one, not"):
        fb.replay(fb.line((0.09, 0.068), (0.0, 0.1), 1.0))
    with pytest.raises(ValueError, match="has no torques"):
        fb.replay(fb.from_log(RUN.t, *RUN.q.T))


def test_gaps_are_replayed_from_what_was_measured_after_them():
    keep = np.r_[0:200, 240 : len(RUN.t)]
    run = fb.from_log(RUN.t[keep], *RUN.q[keep].T, *RUN.tau[keep].T)
    found = fb.replay(run)
    apart = np.hypot(*found.difference.T)
    assert np.isnan(apart).sum() == 1 and np.nanmax(apart) < 5e-4
    q = (run.q + found.q_difference)[np.isfinite(apart)]
    assert np.abs(fb.dgm(ROBOT, q).xi - found.simulated.xi[np.isfinite(apart)]).max() < 1e-12


@pytest.mark.parametrize("restart", [0.05, 0.07, 0.11, 0.5])
def test_parts_of_a_replay_leave_no_row_out(restart):
    """What a part leaves over is simulated with it; what lies between two gaps is named."""
    found = fb.replay(RUN, restart=restart)
    assert found.notes == () and np.isfinite(found.simulated.q).all()
    tau = RUN.tau.copy()
    tau[[20, 23]] = np.nan
    found = fb.replay(replace(RUN, tau=tau), restart=restart)
    missing = np.flatnonzero(np.isnan(found.simulated.q[:, 0]))
    assert missing.tolist() == [20, 21, 22, 23]
    (note,) = found.notes
    assert note == (
        "2 rows, in stretches shorter than 4 rows, were not simulated, the first from"
        f" {RUN.t[21]:.6g} s"
    )
