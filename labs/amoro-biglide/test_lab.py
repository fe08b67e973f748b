"""What the AMORO lab's biglide_models.py is asked: its own oscillation, poses everywhere, and where none exists."""

from fivebar.grading.ten_models import checks

globals().update(checks())
