"""The worker process: confines itself, runs the student's file, answers calls over two pipes in
JSON lines.

`python -I -S -B -u CELL SETTINGS`, where SETTINGS is a JSON object. It never holds an expected
answer: whatever the student's program does to this process, a line that leaves it is only a claim
    about one row of one ask.
"""

from __future__ import annotations

import builtins
import contextlib
import io
import json
import os
import signal
import sys
import types
from collections.abc import Callable

from answers import call, end_call, plain
from changes import Trials
from confine import confine
from loading import FILE, OwnImports, Siblings, load, methods, outline, own_values
from reading import deep, statements
from scopes import REWRITES
from stand_in import StandIn

MOST_LINE = 1_000_000  # bytes of a message
SPARE = b'{"n": "%s", "k": "memory", "t": ""}\n'  # of no new objects but one


class Gate:
    """Refuses all imports but the standard library's and those of the named packages."""

    def __init__(self, packages: list[str]):
        self.known = sys.stdlib_module_names | set(packages)
        self.words = " and ".join((", ".join(packages[:-1]), packages[-1]))

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        top = name.partition(".")[0]
        if top not in self.known and not top.startswith("_sysconfigdata"):
            raise ModuleNotFoundError(
                f"{top} is not available here: a submission may import the standard library,"
                f" {self.words}",
                name=name,
            )


def as_with_old_numpy(source: str) -> Callable:
    """Return how `fivebar.base.old_numpy`, given as text, rewrites a statement."""
    known: dict = {}
    exec(source, known)
    known["install"]()

    def rewrite(tree):
        if "numpy" in sys.modules:
            known["give_names_back"](sys.modules["numpy"])
        return known["rewritten"](tree)

    return rewrite


def main() -> None:
    settings = json.loads(sys.argv[1])
    read, write, close = os.read, os.write, os._exit
    loads, dumps = json.loads, json.dumps
    source, sink = settings["read"], settings["write"]
    buffer = bytearray()

    def send(message):
        line = dumps(message).encode() + b"\n"
        if len(line) > MOST_LINE:
            line = (
                dumps(
                    {"n": message["n"], "k": "flood", "t": f"an answer of {len(line)} bytes"}
                ).encode()
                + b"\n"
            )
        while line:
            line = line[write(sink, line) :]

    def receive():
        while b"\n" not in buffer:
            piece = read(source, 1 << 16)
            if not piece:
                close(0)
            buffer.extend(piece)
        line, _, rest = bytes(buffer).partition(b"\n")
        buffer[:] = rest
        return loads(line)

    try:
        report = confine(settings)
    except OSError as error:
        send({"n": settings["n"], "k": "refused", "t": str(error)})
        return
    sys.argv[:] = ["student"]
    for name in ("exit", "quit"):  # which Python has outside of this cell
        setattr(builtins, name, sys.exit)
    sys.meta_path.insert(0, Gate(settings["packages"]))
    send({"n": settings["n"], "k": "ready", **report})

    request = receive()
    nonce = request["n"]
    own_imports = OwnImports(request["modules"])
    old = as_with_old_numpy(request["old_numpy"]) if request["old_numpy"] else lambda tree: tree

    def rewrite(tree):
        return old(own_imports.visit(tree))

    file = request["source"], request["notebook"], set(request["skip"])
    REWRITES.append(rewrite)
    siblings = Siblings(request["modules"], rewrite)
    sys.meta_path.insert(0, siblings)
    sources = [*((source, f"<{name}.py>") for name, source in siblings.sources.items())]
    functions = outline([*sources, (request["source"], FILE)])
    module, trouble, numbers = load(
        *file,
        lambda index, line: send({"n": nonce, "k": "at", "i": index, "l": line}),
        rewrite=rewrite,
    )
    trouble, numbers = trouble or siblings.trouble, siblings.numbers | numbers
    if not any(isinstance(value, types.FunctionType) for value in own_values(module)):
        numbers = methods(module) | numbers
    names = [
        name for name, value in vars(module).items() if callable(value) and not name.startswith("_")
    ]
    loaded = {"names": names, "trouble": trouble, "numbers": numbers, "outline": functions}
    send({"n": nonce, "k": "loaded", **loaded})

    signal.signal(signal.SIGALRM, end_call)
    with deep():
        trials = Trials(statements(request["source"], FILE)[0])
    last: tuple = ({}, module)

    while True:
        request = receive()
        nonce, constants = request["n"], request["constants"]
        asked, absent = module, sorted(set(constants) - set(numbers))
        if constants and not absent and request["tried"] and constants == last[0]:
            asked = last[1]  # what is changed is put into it anew
        elif constants and not absent:
            with contextlib.redirect_stdout(io.StringIO()):  # what it prints is known
                siblings.forget(constants)
                asked = load(*file, lambda index, line: None, constants, rewrite)[0]
            last = constants, asked
        name = request["function"]
        if not absent and not callable(vars(asked).get(name)):
            methods(asked, constants)
        function = vars(asked).get(name)
        if absent or not callable(function):
            send({"n": nonce, "k": "missing", "absent": absent})
            continue
        for name in request["given"]:

            def ask(row, name=name, nonce=nonce):
                send({"n": nonce, "k": "asks", "f": name, "row": plain(row)})
                return receive()

            for space in (
                asked,
                *(sys.modules[own] for own in siblings.sources if own in sys.modules),
            ):
                own = vars(space).get(name)
                if isinstance(own, StandIn):
                    own.ask = ask
                elif callable(own):
                    vars(space)[name] = StandIn(own, ask, request["form"])
        tried, told, named = request["tried"], {}, vars(asked)
        changed = tried and trials.of(tried)
        if tried:
            if changed.install(named, request["given"]):
                methods(asked, constants, anew=True)
            told = changed.told(tried["numbers"])
        send({"n": nonce, "k": "asked", **told})
        for place, row in enumerate(request["rows"]):
            if tried:
                changed.switch(named, tried["numbers"][place])
            answer = call(named[request["function"]], row, FILE, request["limit"])
            answer["n"] = nonce
            if tried:
                answer |= changed.seen(named)
            try:
                send(answer)
            except MemoryError:
                del answer
                write(sink, SPARE % nonce.encode())


main()
