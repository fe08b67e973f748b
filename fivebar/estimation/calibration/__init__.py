"""Geometric calibration: lengths, offsets and the frame of the measuring device."""
