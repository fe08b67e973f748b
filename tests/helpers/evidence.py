"""Which part of the grader says what of wrong files, and how often it is true:
`python -m tests.helpers.evidence --jobs 2 evidence.jsonl` grades all corpora, `--table` counts.

A part is a slip of the catalogue, a model of a lab's exercises.py, a relation, a kind of change, or
a way to find a formula. What is told is true where the corpus says so, or where the change that is
told stands in the wrong function and makes it right on other rows of another robot.
"""

import argparse
import json
import random
import re
import resource
import tempfile
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from fivebar.grading.advice import formulas, search
from fivebar.grading.judging import judge
from fivebar.grading.labs import find_lab
from tests.helpers.hand_ins import FOLDER, HandIn, graded, hand_ins
from tests.helpers.hand_ins import mends as is_mended
from tests.helpers.lab_session import SOLUTIONS, mistakes
from tests.helpers.mutants import mutants

FILES = "cases others fresh/first fresh/second fresh/third fresh/fourth fresh/fifth fresh/sixth fresh/seventh fresh/eighth".split()
MUTATED = (
    "amoro scalars",
    "amoro helpers",
    "amoro fresh/amoro_closure",
    "amoro-biglide biglide_loops",
    "lab4 fresh/lab4",
    "lab5 fresh/lab5",
    "lab6 fresh/lab6",
    "lab8 fresh/lab8",
)
EACH = 12  # mutants
ORIGINS: dict = {}  # name or formula -> the part that found it
SIDE = re.compile(r", in the (left|right) leg$")
FORMULAS = [name for name in vars(formulas) if re.fullmatch("_(of|with|an|sums|by).*", name)]


def cases(name):
    """Yield the wrong files of a corpus as HandIn; what a mistake of a lab is called is its truth."""
    if name.startswith("lab"):
        for function, title, source in mistakes(name):
            truth = "|".join(map(re.escape, title.split(" | ")))
            base = f"../solutions/{name}"
            yield HandIn(name, base, "utf-8", title, source, {function: truth})
    elif name.startswith("mutants "):
        lab, base = name.split()[1:]
        source = (FOLDER / f"{base}.py").read_text("utf-8")
        for number, mutant in enumerate(mutants(source, EACH, 7)):
            truths = dict.fromkeys(find_lab(lab).exercises(), "(?!)")
            yield HandIn(lab, base, "utf-8", f"mutant {number}", mutant, truths)
    else:
        yield from hand_ins(f"{name}.txt")


def traced(origins):
    """Let what is found be remembered with the part that found it: name or formula -> part."""
    plain = judge.diagnose

    def diagnose(answers):
        found = plain(answers)
        if found is not None and found.model is not None:
            origins.setdefault(found.name, "catalogue: " + SIDE.sub("", found.name))
        return found

    judge.diagnose = diagnose
    for name in FORMULAS:
        setattr(formulas, name, _traced_formula(getattr(formulas, name), name, origins))
    search._Search._sure = _traced_search(search._Search._sure, origins)


def _traced_formula(plain, name, origins):
    def found(*row):
        for each in plain(*row):
            if isinstance(each, tuple) and isinstance(each[-1], str):
                origins["formula", each[-1]] = name
            yield each

    return found if name not in ("_of_kin",) else plain


def _traced_search(plain, origins):
    def sure(self, tried, numbers):
        found = plain(self, tried, numbers)
        if found is not None:
            ways = [f"wave {tried.wave}"]
            if tried.wave is None:
                written = tried.made[-1][2]
                ways = [origins.get(("formula", one[2]), "named") for one in written]
            for change in found.changes:
                origins[change.old, change.new] = f"{change.kind} ({' and '.join(ways)})"
        return found

    return sure


def told(name, number):
    """Return what is told of the wrong functions of one file, as rows for JSON."""
    case = [*cases(name)][number]
    if not ORIGINS:
        traced(ORIGINS)
    ORIGINS.clear()
    ORIGINS["traced"] = ""
    origins = ORIGINS
    before = _cpu()
    with tempfile.TemporaryDirectory() as folder:
        report = graded(case, folder)
    cpu = _cpu() - before
    rows = []
    for check in report.checks:
        if check.share == 1 and not check.remarks:
            continue
        truth = case.truths.get(check.function)
        text = f"{check.misconception} {check.spot} {check.text} {' '.join(check.remarks)}"
        is_true = truth is not None and re.search(truth, text, re.DOTALL) is not None
        is_true = is_true or truth is not None and is_mended(case, check)
        part = origins.get(check.misconception, "") or _part_of(check, origins)
        rows.append(
            {"corpus": name, "title": case.title, "base": case.base, "function": check.function,
             "wrong": truth is not None, "lost": check.max_points - check.points, "cpu": cpu,
             "misconception": check.misconception, "spot": check.spot, "text": check.text,
             "remarks": check.remarks, "true": is_true, "part": part}
        )  # fmt: skip
    return rows


def _part_of(check, origins):
    for key, part in origins.items():
        if isinstance(key, tuple) and key[0] != "formula":
            if f"{key[0]}: right answers come with {key[1]}" in check.spot:
                return f"change: {part}"
    plain = re.sub(r"-?\d[\d.e+-]*|\b[a-z]\w*\b(?= (is|and|exchanged))", "#", check.misconception)
    return f"relation: {plain}" if plain else ""


def _cpu():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def table(rows):
    """Print of each part how often it spoke and how often it was true, by corpus of independent
    files, of a lab's own list, and of mutants.
    """
    counts = defaultdict(lambda: defaultdict(lambda: [0, 0]))
    once = {(r["corpus"], r["title"], r["function"], r["part"]): r for r in rows if r["part"]}
    for row in once.values():
        kind = row["corpus"].split()[0] if row["corpus"].startswith("mutants") else row["corpus"]
        kind = "own list" if kind.startswith("lab") else "mutants" if kind == "mutants" else "files"
        count = counts[row["part"]][kind]
        count[0] += 1
        count[1] += row["true"]
    print("true of told in: independent files, mistakes of the labs' list, mutants")
    for part in sorted(counts):
        three = [counts[part][kind] for kind in ("files", "own list", "mutants")]
        print(*(f"{good:4}/{count:<4}" for count, good in three), part)
    for kind in ("files", "lab", "mutants"):
        own = [r for r in rows if (r["corpus"].split()[0].startswith(kind) or kind == "files")]
        own = [r for r in own if kind != "files" or not r["corpus"].startswith(("lab", "mutants"))]
        wrong = {(r["corpus"], r["title"], r["function"]) for r in own if r["wrong"]}
        named = {(r["corpus"], r["title"], r["function"]) for r in own if r["true"]}
        false = {(r["corpus"], r["title"], r["function"]) for r in own if r["part"]} - named
        lost = sum(r["lost"] for r in own if not r["wrong"])
        cpus = sorted({(r["corpus"], r["title"]): r["cpu"] for r in own}.values()) or [0]
        print(
            f"{kind}: {len(wrong)} wrong functions, {len(named)} named truly, {len(false)} not"
            f" truly, {lost:g} points lost beside, CPU of a file {cpus[len(cpus) // 2]:.1f} s"
            f" median, {cpus[-1]:.1f} s largest"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--corpora", nargs="*")
    parser.add_argument("--table", action="store_true", help="count what was graded before")
    options = parser.parse_args()
    if options.table:
        lines = options.path.read_text("utf-8").splitlines()
        return table([row for line in lines for row in json.loads(line)])
    names = options.corpora or [
        *FILES,
        *(f"mutants {base}" for base in MUTATED),
        *sorted(path.stem for path in SOLUTIONS.glob("lab*.py")),
    ]
    todo = [(name, k) for name in names for k in range(len([*cases(name)]))]
    random.Random(0).shuffle(todo)  # what is there early is a sample
    with ProcessPoolExecutor(options.jobs) as pool, options.path.open("a", encoding="utf-8") as out:
        for one in as_completed([pool.submit(told, *each) for each in todo]):
            print(json.dumps(one.result()), file=out, flush=True)


if __name__ == "__main__":
    main()
