"""Many students: found, graded in turn, summed up. The door is `course.Course`; `cohort` grades one
lab's hand-ins, each result on disk before the next, and `marks` and `gradebook` hold the marks.
What students have in common is in `copies`.
"""
