"""Constraints on a motion, and the regions and paths that satisfy them."""
