"""Programs that return or raise strange things."""

STRANGE = {
    "exception without a text": (
        """
class E(Exception):
    def __str__(self): raise E
def evil(x): raise E
""",
        {"exception"},
        5,
    ),
    "exception whose text lasts": (
        """
class E(Exception):
    def __str__(self):
        while True: pass
def evil(x): raise E
""",
        {"timeout"},
        0.3,
    ),
    "exception of a strange class": (
        """
class M(type):
    def __getattribute__(self, name): raise SystemExit
class E(Exception, metaclass=M):
    pass
def evil(x): raise E("\\x1b[2J" + "<script>" * 10000)
""",
        {"exception"},
        5,
    ),
    "terminal codes": (
        'def evil(x): raise ValueError("\\x1b]0;owned\\x07\\x1b[2J\\r" + "=cmd()")',
        {"exception"},
        5,
    ),
    "destructor that lasts": (
        """
class D:
    def __del__(self):
        while True: pass
def evil(x):
    D()
    return x
""",
        {"timeout"},
        0.3,
    ),
    "a million numbers": ("def evil(x): return list(range(10**6))", {"flood"}, 5),
    "a long string": ('def evil(x): return "9" * 10**7', {"value"}, 5),
    "a long integer": ("def evil(x): return 10 ** 10**5", {"value"}, 5),
    "a list in itself": ("def evil(x):\n    a = []\n    a.append(a)\n    return a", {"flood"}, 5),
    "an endless generator": (
        "import itertools\ndef evil(x): return itertools.count()",
        {"value"},
        5,
    ),
    "an endless list": (
        "class L(list):\n    def __iter__(self):\n        while True: yield 1\ndef evil(x): return L([x])",
        {"value"},
        5,
    ),
    "nan": ('def evil(x): return float("nan")', {"value"}, 5),
    "complex": ("def evil(x): return complex(x, 1e-300)", {"value"}, 5),
    "string": ("def evil(x): return repr(x)", {"value"}, 5),
    "lone surrogates": ('def evil(x): return "\\ud800\\x00"', {"value"}, 5),
    "a class of a strange name": (
        'def evil(x): return type("<b>\\x1b\\n", (), {})()',
        {"value"},
        5,
    ),
    "a large array": ("import numpy\ndef evil(x): return numpy.zeros((300, 300))", {"flood"}, 5),
    "an array of objects": (
        "import numpy\ndef evil(x): return numpy.array([object(), [x], None], dtype=object)",
        {"value"},
        5,
    ),
}
