"""What was measured on a robot as built: calibration, identification, logs, accuracy."""
