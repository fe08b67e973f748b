"""Pictures with Matplotlib, made with its figure objects: no global state, no window."""
