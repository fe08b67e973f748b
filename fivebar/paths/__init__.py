"""Given paths: read, blended, placed, timed and certified."""
