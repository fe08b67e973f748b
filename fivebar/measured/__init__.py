"""What was measured: logs, calibration, identification."""
