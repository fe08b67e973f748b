"""Pictures with Matplotlib, made with its figure objects: no global state, no window."""

from importlib import import_module

_LATER = {"pose": "pose_panels", "singularity_map": "maps"}


def __getattr__(name):
    if name not in _LATER:
        raise AttributeError(f"module 'fivebar.plot' has no attribute {name!r}")
    return getattr(import_module(f".{_LATER[name]}", __name__), name)
