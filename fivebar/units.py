"""The unit in which numbers of a given size read well."""

PREFIXES = ((1e-6, 1e9, "n"), (1e-3, 1e6, "µ"), (1.0, 1e3, "m"))  # below so many units, so many of these to one


def readable(largest, unit):
    """Factor and name of the unit in which numbers up to `largest` read well."""
    return next(((scale, prefix + unit) for limit, scale, prefix in PREFIXES if 0 < largest < limit), (1.0, unit))
