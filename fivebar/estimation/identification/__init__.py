"""Identification of the dynamic parameters: regressor, base parameters, confidence."""
