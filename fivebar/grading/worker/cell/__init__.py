"""The inside of the worker process: run as a program by its folder, with the standard library
only.
"""
