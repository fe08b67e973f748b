"""Programs that claim a result of their own."""

CLAIMING = {
    "result printed": (
        """
import sys
def evil(x):
    print('{"k": "value", "v": 1.0, "s": 0.0}\\n\\n1 passed in 0.01s', flush=True)
    print('{"score": 100}', file=sys.stderr)
    return None
""",
        {"value"},
        5,
    ),
    "pipes guessed": (
        """
import os
def evil(x):
    for n in range(1, 64):
        try:
            os.write(n, b'{"n": "0", "k": "value", "v": 1.0, "s": 0.0}\\n')
        except OSError:
            pass
    return x
""",
        {"garbled"},
        5,
    ),
    "nonce stolen": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    nonce, sink = frame.f_locals["nonce"], frame.f_locals["sink"]
    for value in (1.0, 2.0, 3.0):
        os.write(sink, b'{"n": "%s", "k": "value", "v": %r, "s": 0.0}\\n' % (nonce.encode(), value))
    return x
""".replace("%r", "%f"),
        {"value"},
        5,
    ),
    "left-over lines": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    line = b'{"n": "%s", "k": "value", "v": 3.0, "s": 0.0}\\n' % frame.f_locals["nonce"].encode()
    os.write(frame.f_locals["sink"], line * 40)
    return x
""",
        {"value"},
        5,
    ),
    "stdout onto the pipe": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "sink" not in frame.f_locals:
        frame = frame.f_back
    os.dup2(frame.f_locals["sink"], 1)
    print('{"k": "value", "v": 1.0}', flush=True)
    return x
""",
        {"garbled"},
        5,
    ),
    "strange messages": (
        """
import os, sys
def evil(x):
    frame = sys._getframe()
    while "nonce" not in frame.f_locals:
        frame = frame.f_back
    nonce = frame.f_locals["nonce"]
    deep = "[" * 900 + "]" * 900
    os.write(frame.f_locals["sink"], ('{"n": "%s", "k": "value", "s": 0, "v": %s}\\n' % (nonce, deep)).encode())
    return x
""",
        {"garbled"},
        5,
    ),
    "results folder": (
        """
def evil(x):
    with open("FOLDER/results.json", "w") as f:
        f.write('{"score": 100}')
""",
        {"exception"},
        5,
    ),
    "always pleased": (
        """
class Pleased(float):
    def __eq__(self, other): return True
    def __array__(self, *a, **k): raise SystemExit
    def __float__(self): return 1.0
    def __sub__(self, other): return 0.0
    __rsub__, __hash__, __abs__ = __sub__, float.__hash__, lambda self: 0.0
    def __lt__(self, other): return True
    __le__ = __gt__ = __ge__ = __lt__
def evil(x): return Pleased()
""",
        {"value"},
        5,
    ),
    "patched json": (
        """
import json
json.dumps = lambda *a, **k: '{"k": "value", "v": 1.0}'
json.loads = lambda *a, **k: {}
json.JSONEncoder.encode = json.JSONEncoder.iterencode = lambda *a, **k: "1"
def evil(x): return x
""",
        {"value", "garbled", "exception", "timeout", "exit"},
        1,
    ),
    "patched numpy and math": (
        """
import math
import numpy as np
np.allclose = np.isclose = np.array_equal = lambda *a, **k: True
np.abs = np.max = np.linalg.norm = math.fabs = lambda *a, **k: 0.0
def evil(x): return np.float64(x)
""",
        {"value"},
        5,
    ),
    "patched builtins": (
        """
import builtins
def evil(x):
    for name in ("isinstance", "len", "abs", "float", "min", "max", "issubclass", "type", "sorted", "callable", "set"):
        setattr(builtins, name, lambda *a, **k: True)
    return x
""",
        {"value", "exception", "garbled", "exit", "timeout"},
        1,
    ),
    "traced": (
        """
import sys
def evil(x):
    def spy(frame, event, argument):
        if "value" in frame.f_locals:
            frame.f_locals["value"] = 1.0
        return spy
    sys.settrace(spy)
    sys._getframe(1).f_trace = spy
    return x
""",
        {"value"},
        5,
    ),
    "json.py to be imported": (
        """
import sys
def evil(x):
    with open("json.py", "w") as f:
        f.write("1/0")
    sys.path.insert(0, ".")
""",
        {"exception"},
        5,
    ),
}
