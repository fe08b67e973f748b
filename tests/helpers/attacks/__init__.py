"""Hostile programs: name -> (source that defines `evil(x)`, the kinds its reply may have, seconds it is given).

The right answer to evil(x) is a secret number times x, which stands in the environment, the memory and a file of the
grader. GRADER, FOLDER, SECRETS, PACKAGE and MARK are replaced by the grader's process id, a folder all may write to,
the file in it with the secret, a file of the package, and a word for the names of files to leave behind.
"""

from .claiming import CLAIMING
from .ending import ENDINGS
from .filling import FILLING
from .reading import READING
from .spreading import SPREADING
from .strange import STRANGE

SELF_HARM = {
    "patched builtins",
    "patched json",
    "traced",
    "late alarm",
}  # his own later answers may be lost

ATTACKS = READING | CLAIMING | ENDINGS | STRANGE | SPREADING | FILLING
