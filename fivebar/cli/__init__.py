"""The command line: data on stdout, messages on stderr; exit 0 done, 1 the work failed, 2 wrong usage."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ..errors import UsageError
from . import chart, grade, linkage, map, script, track


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; gives its exit code."""
    arguments = _parser().parse_args(argv)
    try:
        arguments.run(arguments)
    except UsageError as error:
        return _complain(error, 2)
    except BrokenPipeError:  # whoever read the output has read enough
        return 1
    except (ValueError, ArithmeticError, OSError, MemoryError, RuntimeError) as error:
        return _complain(error, 1)
    except KeyboardInterrupt:
        return _complain("interrupted", 1)
    return 0


def _complain(error, code):
    from ..grading.report.text import printable  # the error may quote a file's hostile name

    print("fivebar: " + printable(" ".join(str(error).split())), file=sys.stderr)
    return code


def _parser():
    parser = argparse.ArgumentParser(
        prog="fivebar", description="The five-bar parallel robot: models, control, singularities."
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in (track, map, linkage, chart, script, grade):
        module.add_parsers(commands)
    return parser
