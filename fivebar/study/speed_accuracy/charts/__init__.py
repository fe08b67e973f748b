"""The charts, what they measure on (exact, motions) and what they share."""
