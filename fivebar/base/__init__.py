"""Base: array backends, argument checks, tables, files, progress and errors; knows no robot."""
