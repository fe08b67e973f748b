"""What a function answers, and whether that is right. The door is `ask.Ask`, the fixture of the
labs' checks: it asks a student's program and gives the answers to `judge.judge`.
What follows rightly from a wrong function is asked again in `with_right_ones`.
"""
