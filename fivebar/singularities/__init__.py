"""Where a robot is singular: margins, exact loci, maps, regions free of them, paths against
them.
"""
