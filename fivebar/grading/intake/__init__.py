"""What is handed in, as it comes: files, folders, zips. The door for one file is `program.Job`,
which opens it in a process of its own; that for a class is `cohort_folder.entries_of`.
Each student's robot is drawn in `students_robots`.
"""
