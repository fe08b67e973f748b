"""Files that today's NumPy refuses: explained after their traceback, and run by --lenient."""

import builtins
import linecache

import numpy as np
import pytest

from fivebar.amoro.ros_free.explain import explanation
from fivebar.amoro.ros_free.tracebacks import last_place
from fivebar.base import old_numpy
from tests.amoro.test_run import START, run

COLUMN = "import numpy as np\nfrom math import *\nb = np.array([[1.0], [2.0]])\nv, M = np.zeros(2), np.zeros((2, 2))\n"


def explained(folder, line):
    """The lines said after this one fails, and the line that they are about."""
    file = folder / "old.py"
    file.write_text(COLUMN + line + "\n", encoding="utf-8")
    linecache.checkcache(str(file))
    try:
        exec(compile(file.read_text("utf-8"), str(file), "exec"), {})
    except Exception as error:
        frame, number = last_place(error)
        return "\n".join(explanation(error, frame, number)), number
    raise AssertionError(f"{line} works with NumPy {np.__version__}")


@pytest.mark.parametrize(
    "line, words",
    [
        ("M[0, 1] = b[0]", "b[0] is an array of shape (1,)"),
        ("v[0] += b[1]", "write b[1].item()"),
        ("v[0], v[1] = b", "what is computed here is an array"),
        ("x = cos(b[0])", "write b[0].item()"),
        ("x = float(b[1])", "write b[1].item()"),
        ("x = np.array([b[0], 1.0])", "write b[0].item()"),
        ("print('%.3f' % b[0])", "write b[0].item()"),
        ("v[0] = np.sum(b, axis=0)", ".item() after it"),
        ("v[0] = b[0] + v[1]", "write b[0].item()"),
        ("x = atan2(b[1], b[0])", "write b[1].item() and b[0].item()"),
        ("x = atan2(b[1], b[0].item())", "write b[1].item() ("),
        ("x = np.zeros(2, dtype=np.float)", "write float (or run with --lenient"),
        ("x = np.asscalar(b[0])", "write x.item() (or run with --lenient"),
        ("x = np.Inf", "write np.inf ("),
        ("x = float(v)", "what is computed here is an array"),
    ],
)
def test_the_line_and_its_mend(tmp_path, line, words):
    notes, number = explained(tmp_path, line)
    assert words in notes and number == 5


@pytest.mark.parametrize(
    "line", ["v @ np.zeros(3)", "np.no_such", "v[5] = 1.0", "x = int('a')", "v.shape = 3"]
)
def test_other_errors_are_left_alone(tmp_path, line):
    assert explained(tmp_path, line)[0] == ""


@pytest.mark.deep
def test_an_error_that_has_no_text_is_left_alone(tmp_path):
    script = (
        "class Mute(Exception):\n    def __str__(self):\n        raise RuntimeError\nraise Mute()\n"
    )
    done = run(tmp_path, script, code=1)
    assert "Mute: <exception str() failed>" in done.stderr and "made no Robot" in done.stderr


@pytest.mark.deep
def test_a_line_of_the_students_models(tmp_path):
    """The explanation names the student's file, not the script that calls it."""
    (tmp_path / "five_bar_models.py").write_text(
        "from math import *\ndef dgm(q):\n    return cos(q)\n", encoding="utf-8"
    )
    script = "import numpy as np\nfrom five_bar_models import *\ndgm(np.array([0.5]))\n"
    notes = run(tmp_path, script, code=1).stderr
    assert notes.startswith("Traceback") and "TypeError: only 0-dim" in notes
    assert (
        "fivebar run: at five_bar_models.py, line 3: return cos(q)" in notes
        and "mend: write q.item()" in notes
    )
    assert run(tmp_path, script, "--lenient").returncode == 0


def namespace(source):
    """What lenient code leaves."""
    names = {
        old_numpy.HELPER: old_numpy.lenient,
        old_numpy.LOOSEN: old_numpy.loosen,
        "__builtins__": builtins,
        "np": np,
    }
    exec(old_numpy.compiled(source, "old.py"), names)
    return names


def test_lenient_code_counts_one_element_as_a_number():
    left = namespace("""
import math
from math import cos, atan2
b = np.array([[1.0], [2.0]])
v, M, n = np.zeros(2), np.zeros((2, 2)), np.zeros(3, dtype=int)
v[0], v[1] = b
v[1] += b[0]
M[0, 1] = b[1]
M[1] = b[0]
n[int(b[0])] = b[1]
x = cos(b[0]), math.atan2(b[0], b[1]), float(b[1]), int(b[1]), round(b[1])
a = np.array([b[0], 1.0]), np.asarray([[b[0], 0.0], [1, b[1]]]), np.array([b[0], b[1]])
text = "%.1f and %d" % (b[0], b[1]) + " %.2f" % b[1]
""")
    assert left["v"].tolist() == [1.0, 3.0] and left["M"].tolist() == [[0.0, 2.0], [1.0, 1.0]]
    assert left["n"].tolist() == [0, 2, 0] and left["text"] == "1.0 and 2 2.00"
    assert left["x"] == (np.cos(1.0), np.arctan2(1.0, 2.0), 2.0, 2, 2)
    one, two, three = left["a"]
    assert (
        one.tolist() == [1.0, 1.0]
        and two.tolist() == [[1.0, 0.0], [1.0, 2.0]]
        and three.shape == (2, 1)
    )


def test_lenient_code_changes_nothing_else():
    left = namespace("""
b = np.array([1.0])
items, table = [0], {}
items[0], table["b"] = b, b
class Base:
    def __init__(self):
        self.value = b
class Derived(Base):
    def __init__(self):
        super().__init__()
        self.kinds = isinstance(1.0, float), isinstance(b, np.ndarray), type(self).__name__
    def __setitem__(self, key, value):
        self.set = key, value
derived = Derived()
derived[1:2] = b
caller = (lambda: sorted(locals()))()
m = np.arange(6.0).reshape(2, 3)
m[:, 1:] = [[7.0], [8.0]]
percent = 7 % 4
try:
    m[0, 0] = m
except ValueError as error:
    message = str(error)
""")
    assert left["items"][0] is left["table"]["b"] is left["b"] is left["derived"].value
    assert left["derived"].kinds == (True, True, "Derived") and left["derived"].set[1] is left["b"]
    assert (
        left["caller"] == []
        and left["m"].tolist() == [[0, 7, 7], [3, 8, 8]]
        and left["percent"] == 3
    )
    assert left["message"] == "setting an array element with a sequence."


@pytest.mark.deep
def test_lenient_run_of_an_old_file(tmp_path):
    """Columns, elements of one, dropped names; efforts of one element pass without --lenient."""
    models = """import numpy as np
from math import *
def effort(q11, q21):
    K = np.zeros((2, 2), dtype=np.float)
    K[0, 0] = np.array([2e-3])
    K[1, 1] = K[0, 0]
    return -K @ np.array([[q11], [q21]])
"""
    (tmp_path / "five_bar_models.py").write_text(models, encoding="utf-8")
    script = """from five_bar_models import *
robot.apply_efforts(1e-3, 0.0)
for k in range(100):
    tau = effort(left.position, right.position)
    assert tau.shape == (2, 1)
    robot.apply_efforts(tau[0], tau[1])
print(type(left.effort).__name__, left.effort == -2e-3 * before)
""".replace("    tau", "    before = left.position\n    tau")
    done = run(tmp_path, START + script, "--lenient")
    assert done.stdout == "float True\n"
    assert done.stderr.startswith(
        "fivebar run: lenient: arrays of one element pass for numbers, as they did in an older"
    )
    run(tmp_path, START + script, code=1)
    (tmp_path / "five_bar_models.py").write_text(
        models.replace("np.float", "float").replace("np.array([2e-3])", "2e-3"), encoding="utf-8"
    )
    assert run(tmp_path, START + script).stdout == "float True\n"


def test_every_dropped_name_is_dropped_and_has_a_successor():
    for name, today in old_numpy.DROPPED.items():
        assert name not in vars(np)
        assert eval(today, {"np": np}) is not None
