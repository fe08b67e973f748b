"""A student's program in a process of its own: started, confined, asked, never trusted."""
