"""What is handed in, as it comes: files, folders, zips; which of them is the program, and what else
there was.
"""
