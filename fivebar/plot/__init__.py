"""Pictures with Matplotlib, made with its figure objects: no global state, no window."""


def __getattr__(name):
    if name == "singularity_map":
        from .maps import singularity_map

        return singularity_map
    raise AttributeError(f"module 'fivebar.plot' has no attribute {name!r}")
