"""`fivebar chart`: speed against accuracy, measured here and drawn."""

from __future__ import annotations

from argparse import RawDescriptionHelpFormatter
from pathlib import Path

from ..study.speed_accuracy.catalogue import CHARTS
from .options import add_command

OPTIONS = {
    "NAME": "a chart of those below, or all",
    "--out DIR": (Path("charts"), "folder of the charts"),
    "--quick": "every other point, and less time for each",
}


def add_parsers(commands):
    """Add `chart` to the program's commands."""
    lines = [f"  {name:16} {words}" for name, (_, words) in CHARTS.items()]
    text = "\n".join(["charts:", *lines])
    add_command(
        commands,
        "chart",
        _chart,
        (OPTIONS,),
        formatter_class=RawDescriptionHelpFormatter,
        epilog=text,
    )


def _chart(arguments):
    from ..study.speed_accuracy.making import make

    out, name = arguments.out, arguments.name
    try:
        results = make(list(CHARTS) if name == "all" else [name], out, arguments.quick)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted: what was measured is kept in {out}; the same command goes on there"
        ) from None
    for chart in results:
        print(*(out / f"{chart}{suffix}" for suffix in (".csv", ".png", ".svg")), sep="\n")
    print(out / "index.html")
