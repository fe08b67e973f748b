"""Controllers: callables (t, q, q_dot, reference) -> tau."""
