"""The lab that labs/README.md shows, written to a folder, and answers to it: the grader's tests use it."""

import re

from tests.helpers import LABS

README = LABS / "README.md"
CONSTANTS = (
    "l11 = 0.09\nl12 = 0.09\nl21 = 0.09\nl22 = 0.09\nd = 0.118\nzz1 = 0.002\nzz2 = 0.002\nm = 0.5\n"
)
RIGHT = f"from math import cos, sin\n{CONSTANTS}def elbow(q11):\n    return -d / 2 + l11 * cos(q11), l11 * sin(q11)\n"
SHIFTED = RIGHT.replace("-d / 2 + ", "")
UNTOUCHED = f'{CONSTANTS}def elbow(q11):\n    raise NotImplementedError("task 1: the elbow")\n'
HALF = RIGHT.replace("return", "if q11 > 0:\n        raise ValueError('no')\n    return")
HANGS = "from time import sleep\n" + RIGHT.replace(
    "return", "while True:\n        sleep(1)\n    return"
)
CRASHES = f"import no_such_package\n{RIGHT}"


def write_lab(folder):
    """The README's lab in folder/elbow; gives `folder`."""
    parts = re.findall(
        r"`mylabs/elbow/(\w+\.py)`.*?```python\n(.*?)```",
        README.read_text(encoding="utf-8"),
        re.DOTALL,
    )
    assert [name for name, _ in parts] == ["exercises.py", "test_lab.py"]
    (folder / "elbow").mkdir(parents=True)
    for name, code in parts:
        (folder / "elbow" / name).write_text(code, encoding="utf-8")
    return folder


def written(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path
