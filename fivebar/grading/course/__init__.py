"""Many students: found, graded in turn, summed up."""
