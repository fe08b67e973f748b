"""For `pytest labs/lab1_geometry --submission my.py`."""

pytest_plugins = ["fivebar.grading.plugin"]
