"""Methods held against each other: where they lose or fail (`pitfalls`), and speed against accuracy
(`speed_accuracy`).

Nothing here is loaded by `import fivebar`, and nothing of the package outside `study` and the
command line needs it.
"""
