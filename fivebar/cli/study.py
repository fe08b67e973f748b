"""`fivebar study`: what is worth its cost, measured here."""

from __future__ import annotations

import csv
from functools import partial

from .options import JSON, add_command, print_json, print_message, write_files

OPTIONS = JSON | {
    "--robots lab|vertical|haptic ...": "(default: all)",
    "--out DIR": "also ladder.csv and ladder.png",
}


def add_parsers(commands):
    """Add `study` to the program's commands."""
    parser = commands.add_parser("study")
    studies = parser.add_subparsers(dest="study", required=True, metavar="STUDY")
    words = "tracking error and time of a step, with each rung of physics added"
    add_command(studies, "ladder", _ladder, (OPTIONS,), help=words)


def _ladder(arguments):
    from ..base.progress import progress
    from ..base.representation import aligned
    from ..base.tables import saved, written
    from ..study.ladder import CASES, RUNGS, climb, figure, table

    names = arguments.robots or list(CASES)
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
    with progress(total=len(names) * len(RUNGS), unit=" rungs", leave=False) as bar:
        rungs = {name: climb(CASES[name], bar.update) for name in names}
    header, rows = table(rungs)

    def to_csv(path):
        with written(path) as file:
            csv.writer(file).writerows([header, *rows])

    if arguments.out:
        writers = {"ladder.csv": to_csv, "ladder.png": partial(saved, figure(rungs))}
        for path in write_files(arguments.out, writers):
            print_message(path)
    if arguments.json:
        print_json([dict(zip(header, row)) for row in rows])
        return
    lines = ([*row[:2], *(f"{value:.4g}" for value in row[2:])] for row in rows)
    print(*aligned([header, *lines], 2), sep="\n")
