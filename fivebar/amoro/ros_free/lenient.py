"""`fivebar run --lenient`: what NumPy took of files written years ago, the user's modules may do
again.
"""

import importlib.abc
import importlib.machinery
import sys

import numpy as np

from ...base import old_numpy
from .tracebacks import is_users


def install():
    """Rewrite the user's modules when they are imported, and give NumPy its dropped names back."""
    old_numpy.give_names_back(np)
    old_numpy.install()
    sys.meta_path.insert(0, Finder())


class Loader(importlib.machinery.SourceFileLoader):
    def source_to_code(self, data, path, *, _optimize=-1):
        return old_numpy.compiled(data, path)

    def path_stats(self, path):
        raise OSError  # no cached bytecode: it would be that of the source as it stands


class Finder(importlib.abc.MetaPathFinder):
    """The user's own modules, wherever on the path they are."""

    def find_spec(self, name, path=None, target=None):
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is None or not isinstance(spec.loader, importlib.machinery.SourceFileLoader):
            return None
        if not is_users(spec.origin):
            return None
        spec.loader = Loader(name, spec.origin)
        return spec
