"""`fivebar chart`: speed against accuracy, measured here and drawn."""

from __future__ import annotations

from argparse import RawDescriptionHelpFormatter, _SubParsersAction
from pathlib import Path

from ..study.chart_names import CHARTS, PEERS


def add_parsers(commands: _SubParsersAction) -> None:
    """Add `chart` to the program's commands."""
    lines = [
        f"  {name:16} {words}{' (extra: peers)' if name in PEERS else ''}"
        for name, (_, words) in CHARTS.items()
    ]
    parser = commands.add_parser(
        "chart", formatter_class=RawDescriptionHelpFormatter, epilog="\n".join(["charts:", *lines])
    )
    parser.add_argument("name", metavar="NAME", help="a chart of those below, or all")
    parser.add_argument(
        "--out", type=Path, default=Path("charts"), metavar="DIR", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--quick", action="store_true", help="every other point, and less time for each"
    )
    parser.add_argument("--peers", action="store_true", help="with all: simulators too")
    parser.set_defaults(run=_chart)


def _chart(arguments):
    from ..study.speed_accuracy import chart_names, make

    names = chart_names(arguments.peers) if arguments.name == "all" else (arguments.name,)
    try:
        made = make(names, arguments.out, arguments.quick)
    except KeyboardInterrupt:
        raise RuntimeError(
            f"interrupted: what was measured is kept in {arguments.out}; the same command goes on"
            " there"
        ) from None
    for name in made:
        print(*(arguments.out / f"{name}{suffix}" for suffix in (".csv", ".png", ".svg")), sep="\n")
    print(arguments.out / "index.html")
