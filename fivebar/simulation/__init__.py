"""Closed loops in time: one run, many, and how runs compare."""
