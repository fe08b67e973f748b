"""`fivebar chart`: speed against accuracy, measured here and drawn."""

from __future__ import annotations

from argparse import RawDescriptionHelpFormatter, _SubParsersAction
from pathlib import Path

from ..study.speed_accuracy.catalogue import CHARTS
from .options import add_options


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `chart` to the program's commands."""
    lines = [f"  {name:16} {words}" for name, (_, words) in CHARTS.items()]
    parser = commands.add_parser(
        "chart", formatter_class=RawDescriptionHelpFormatter, epilog="\n".join(["charts:", *lines])
    )
    parser.add_argument("name", metavar="NAME", help="a chart of those below, or all")
    options = {
        "--out DIR": (Path("charts"), "folder of the charts"),
        "--quick": "every other point, and less time for each",
    }
    add_options(parser, options)
    parser.set_defaults(run=_chart)


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
