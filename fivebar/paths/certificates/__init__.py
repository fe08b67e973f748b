"""Certificates of a timed path, and the checker that needs nothing of the rest."""
