"""The picture of a run says the errors that the run has."""

import numpy as np

import fivebar as fb


def test_rms_and_maximum_of_the_error_are_printed():
    robot = fb.FiveBar()
    run = fb.simulate(robot, fb.PD(robot, 0.4, 0.08), fb.line((0.09, 0.068), (0.0, 0.1), 2.0))
    size = np.hypot(*run.error.T)
    path, errors, torques = run.plot().axes
    notes = [text.get_text() for text in errors.get_legend().get_texts()]
    rms, largest = np.sqrt(np.mean(size**2)), size.max()
    assert 1.05 * np.mean(size) < rms < 0.95 * largest and 1e-3 < largest < 1e-1
    assert f"RMS {1e3 * rms:.3g} mm" in notes and f"maximum {1e3 * largest:.3g} mm" in notes
    (line,) = (each for each in errors.lines if each.get_label().startswith("RMS"))
    assert np.allclose(line.get_ydata(), 1e3 * rms)
