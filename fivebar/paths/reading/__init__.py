"""Read drawings: G-code, SVG, tables of points; the result is a Path."""
