"""What the AMORO lab's five_bar_models.py is asked: its own oscillation, poses everywhere, and where none exists."""

from fivebar.grading.ten_models import checks

globals().update(checks())
