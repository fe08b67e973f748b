"""Charts with other simulators and more methods: `python -m tests.benchmarks.charts NAME|all [--quick] [--out DIR]`.

The charts of `fivebar chart`, of which `geometry` has more routes and `chip` the printed formulas and ARM, and
`simulators`: the same motions in heyoka, MuJoCo, Pinocchio, Drake, Exudyn and pylinkage (the extra `peers`); and
`least-time`: drawings timed by `time_path` and by toppra; and `plans`: plans between poses, and other searches.
"""

from argparse import ArgumentParser
from pathlib import Path

from fivebar.study.speed_accuracy.catalogue import CHARTS
from fivebar.study.speed_accuracy.making import make

ALL = CHARTS | {
    "geometry": ("tests.benchmarks.routes", CHARTS["geometry"][1]),
    "chip": ("tests.benchmarks.chip", CHARTS["chip"][1]),
    "least-time": ("tests.benchmarks.drawings", "timed drawings: gap against time, and toppra"),
    "plans": ("tests.benchmarks.plans", "plans between random poses: objective against time"),
    "simulators": ("tests.benchmarks.simulators.chart", "the same motion in five other programs"),
}


def main(arguments=None):
    """Make the charts."""
    parser = ArgumentParser(prog="python -m tests.benchmarks.charts", description=__doc__)
    parser.add_argument("name", choices=(*ALL, "all"))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("charts"))
    options = parser.parse_args(arguments)
    make(list(ALL) if options.name == "all" else [options.name], options.out, options.quick, ALL)


if __name__ == "__main__":
    main()
