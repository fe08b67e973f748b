"""Time-optimal timing of a path with a proven lower bound."""
