"""What one student's checks came to, for people: the door is `text.report_text`, on a terminal;
`page` makes the same a page, `outputs` JSON, CSV and Gradescope's form.
`tries` counts the wrong tries at home, before a line is shown.
"""
