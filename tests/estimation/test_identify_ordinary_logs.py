"""Logs as drives write them: counts that stay for many rows, torques at the rows' times, wrong rows."""

import re

import numpy as np
import pytest

import fivebar as fb
from fivebar.estimation.logs.derivatives import spectrum
from fivebar.estimation.logs.logs import off_their_neighbours
from tests.helpers.synthetic_logs import torques_of

OWN = {
    "zz1": 4e-4,
    "zz2": 5e-4,
    "m": 0.3,
    "mx11": 3e-3,
    "mx21": 2e-3,
    "fv1": 1e-3,
    "fs1": 2e-3,
    "fv2": 2e-3,
    "fs2": 1e-3,
}
ROBOT = fb.FiveBar(**OWN, gravity=(0.0, -9.81))
KNOWN = fb.FiveBar(gravity=(0.0, -9.81))
SIZES = np.array([[0.2, 0.1, 0.05], [0.22, 0.08, 0.06]])
PHASES = np.array([[0.3, 1.0, 2.0], [1.9, 0.2, 0.7]])


def motion(t, period):
    """q, q', q'' of three waves for each joint."""
    omega = 2 * np.pi / period * np.arange(1, 4)
    angle = omega * np.asarray(t)[:, None, None] + PHASES
    q = (1.45, 1.75) + (SIZES * np.sin(angle)).sum(axis=2)
    q_dot = (SIZES * omega * np.cos(angle)).sum(axis=2)
    return q, q_dot, -(SIZES * omega**2 * np.sin(angle)).sum(axis=2)


def log_of(rate, duration, period, seed, encoder=0.0, counts=None):
    t = np.arange(0, duration, 1 / rate)
    rng = np.random.default_rng(seed)
    moved = motion(t, period)
    q = moved[0] + encoder * rng.normal(size=(len(t), 2))
    tau = torques_of(ROBOT, *moved) + 2e-3 * rng.normal(size=q.shape)
    if counts:
        count = 2 * np.pi / counts
        q = count * np.round(q / count)
    return {"t": t, "q": q, "tau": tau}


def errors(found):
    """In standard deviations."""
    return np.array(
        [(value - OWN.get(name, 0.0)) / found.sd[name] for name, value in found.values.items()]
    )


@pytest.mark.parametrize("counts", [2000, 8192])
@pytest.mark.parametrize("rate", [200, 1000, 5000])
def test_the_band_of_a_motion_is_found_under_counts_that_stay_for_many_rows(rate, counts):
    """Its waves are up to 0.3 Hz; in the band, noise is no less than if each count had its own rounding."""
    q = log_of(rate, 20.0, 10.0, 0, counts=counts)["q"]
    found = spectrum([q], 1 / rate)
    assert found.fast == 0.0 and found.cutoff < max(2.0, 17 / 4096 * rate)
    assert min(found.noise) > 0.5 * 2 * np.pi / counts / np.sqrt(12)


@pytest.mark.parametrize("rate, counts", [(1000, 2000), (500, 2000), (100, 8192)])
def test_logs_of_slow_encoders_are_fitted_at_any_rate(rate, counts):
    found = fb.identify(KNOWN, log_of(rate, 30.0, 5.0, 0, counts=counts), unknown=list(OWN))
    assert abs(found.values["m"] - 0.3) < 4 * found.sd["m"] < 0.02
    assert not found.notes or "noise of the encoders" in found.notes[0]


@pytest.mark.parametrize("rate, period", [(40, 5.0), (100, 5.0)])
def test_torques_at_the_times_of_their_rows_are_not_taken_as_held(rate, period):
    """The mean of two rows is smoother than one, which is no sign of a held torque."""
    z = []
    for seed in range(1, 5):
        found = fb.identify(KNOWN, log_of(rate, 60.0, period / (1 + 0.02 * seed), seed, 1e-4))
        assert not any("held" in note or "does not have" in note for note in found.notes)
        z += errors(found).tolist()
    assert np.abs(z).max() < 4.0


def test_a_held_torque_is_known_by_being_half_a_row_early():
    log = log_of(40, 60.0, 8.0, 0)
    middles = motion(log["t"] + 1 / 80, 8.0)
    noise = 2e-3 * np.random.default_rng(1).normal(size=log["q"].shape)
    log["tau"] = torques_of(ROBOT, *middles) + noise
    found = fb.identify(KNOWN, log, unknown=list(OWN))
    assert "each torque is taken as held to the next row, which fits the motion better" in (
        found.notes
    )
    assert np.abs(errors(found)).max() < 4.0
    assert not any("misses" in note or "late" in note for note in found.notes)


@pytest.mark.parametrize(
    "rows, off",
    [([3000], 1.0), ([3000], 0.01), ([1000, 3000, 3001], 0.5), ([3000, 3001, 3002], 4.0)],
)
def test_rows_of_wrong_positions_are_left_out_and_named(rows, off):
    log = log_of(100, 60.0, 5.0, 0, 1e-5)
    whole = fb.identify(KNOWN, log, unknown=list(OWN))
    log["q"][rows, 1] += off
    found = fb.identify(KNOWN, log, unknown=list(OWN))
    note = f"{len(rows)} rows with positions far off their neighbours (first "
    assert any(
        each.startswith(note)
        and f"{log['q'][rows[0], 1]:.4g}" in each
        and f"row {rows[0] + 1}" in each
        for each in found.notes
    )
    assert np.abs(errors(found)).max() < 3.5
    assert found.sd["m"] < 1.2 * whole.sd["m"]


def test_no_row_of_a_motion_is_off_its_neighbours():
    rng = np.random.default_rng(0)
    t = np.arange(0, 20, 0.01)
    wave = np.stack([np.sin(2 * np.pi * 8 * t), np.sign(np.sin(t)) * 0.1], axis=1)  # 12 rows a wave
    move = np.clip(t - 10, 0, 0.05)[:, None] * [1.0, -2.0]  # of few rows
    cut = 0.2 * (t > 5)[:, None] * [1.0, 1.0]
    for q in (wave, move, cut, rng.normal(size=(2000, 2)), np.round(move / 0.01), 0 * wave):
        assert not off_their_neighbours(q).any()


def test_masses_that_come_out_below_0_by_noise_are_said_to_be_unsure():
    log = log_of(20, 60.0, 8.0 / 1.04, 0, 1e-5)
    with pytest.raises(ValueError, match="does not tell zz. = -.* ± .* from what no robot has"):
        fb.identify(KNOWN, log)


@pytest.mark.parametrize("rows", [6, -12])
def test_the_delay_of_torques_is_told_as_it_is(rows):
    """A model without the parameters that seem to be 0 then took a half of 6 ms for itself."""
    heavy = {"11": 0.2, "12": 0.08, "21": 0.2, "22": 0.08}
    robot = fb.FiveBar.from_links(
        0.09,
        0.09,
        0.09,
        0.09,
        0.118,
        heavy,
        payload=0.1,
        gravity=(0.0, -9.81),
        coulomb=(8e-3, 5e-3),
    )
    log = log_of(1000, 20.0, 2.0, 0, 1e-5)
    moved = motion(log["t"] - rows * 1e-3, 2.0)
    noise = 1e-3 * np.random.default_rng(3).normal(size=log["q"].shape)
    log["tau"] = torques_of(robot, *moved) + noise
    notes = "; ".join(fb.identify(fb.FiveBar(gravity=(0.0, -9.81)), log).notes)
    late, sd, word = re.search(r"come (\S+) ± (\S+) ms too (late|early)", notes).groups()
    assert word == ("late" if rows > 0 else "early")
    assert abs(float(late) - abs(rows)) < 3 * float(sd) < 0.3 * abs(rows)
