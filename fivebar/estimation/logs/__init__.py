"""Logs of a bench: reading, filtering, differentiation, replay."""
