"""Reference motions: simple ones, and planned ones by optimal control."""
