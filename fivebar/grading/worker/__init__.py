"""A student's program in a process of its own, never trusted: the door is `student.Student`.
`sandbox` starts and confines the process, `wire` reads what comes out of it, as mere claims;
`cell` is the folder of what runs inside, of the standard library alone.
"""
