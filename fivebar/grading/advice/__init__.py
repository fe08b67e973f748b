"""What is wrong in a program, and what it is called. The door is `advice.Advice`: it tells, when
all checks are done, the changes that `search` tried and found right, in the words of `names`.
The quantities that it names are the steps of `grading.derivation`.
"""
