"""A chart whose methods fail in every way, for the tests of the runner; a module, as the runner's process loads it."""

import os
import tempfile
import time

from fivebar.base.errors import SingularityError
from fivebar.study.speed_accuracy.chart import OURS, Attempt, Chart, Failed, Method, Panel


def method(name, call, judge=lambda error: {"error": error}, knobs=(1, 2, 4, 8), **options):
    def prepare(problem, knob):
        return Attempt(lambda: call(knob), judge)

    return Method(name, options.pop("family", "others"), prepare, knobs, **options)


def refuse(knob):
    tempfile.mkdtemp()  # as a compiler's, which a process that is killed leaves
    raise SingularityError("det A = 0", 0.0)


def not_counted(result):
    raise Failed("wrong branch in 23%")


METHODS = (
    method("<ours> & mine", lambda n: 1e-3 / n**2, family=OURS, order=2),
    method("cruder", lambda n: 1e-1 / n, order=1),
    method("astray", lambda n: 50.0),
    method("nan", lambda n: float("nan")),
    method("singular", refuse),
    method("wrong", lambda n: 1.0, not_counted),
    method("hangs", lambda n: time.sleep(30), knobs=(1,)),
    method("crashes", lambda n: os._exit(3), knobs=(1,)),
    method("after the crash", lambda n: 1e-2, knobs=(1,)),
    method(
        "needs more", lambda n: 0.0, knobs=(1,), needs=(lambda: "no C compiler (cc, gcc, clang)",)
    ),
)


def chart():
    return Chart(
        name="toy",
        title="A <toy> & its failures",
        reading="Nothing to be learnt.",
        problems={"p": "the problem"},
        methods=METHODS,
        step=lambda n: 1 / n,
        panels=((Panel("p", "one panel", levels=(1e-2, 1e-4, 1e-9), ceiling=1.0),),),
        limit=1.5,
    )
