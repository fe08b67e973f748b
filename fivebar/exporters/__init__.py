"""The robot in others' formats: simulators' files of bodies that move as its base parameters do,
and C99 for a chip.
"""
