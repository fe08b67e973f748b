"""Read drawings: G-code, SVG, DXF-like point tables; the result is a Path."""
