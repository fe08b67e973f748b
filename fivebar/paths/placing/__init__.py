"""Place a drawing in the workspace: the largest size, the largest clearance."""
