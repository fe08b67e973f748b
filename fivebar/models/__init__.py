"""Robots and their models: geometry, kinematics, dynamics, and these compiled."""
