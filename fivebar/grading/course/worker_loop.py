"""The process that grades a cohort's submissions one after another: a JSON line in, a JSON line out."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

from ..grade import grade
from ..labs import Lab
from ..program import Job
from ..report.page import report_page
from ..worker.sandbox import IsolationError


def main() -> None:
    """Serve until stdin ends. Nothing else can write to the pipe: stdout is moved away first."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        answers.write(json.dumps(_graded(json.loads(line))) + "\n")
        answers.flush()


def _graded(request):
    lab = Lab(Path(request.pop("lab")))
    try:
        robot = replace(lab.robot(), **request.pop("robot"))
        report = grade(lab, Job(Path(os.fsdecode(bytes.fromhex(request.pop("path")))), robot=robot, **request))
        return {"report": report.as_json(), "page": report_page(report), "warnings": report.warnings}
    except IsolationError as error:  # of this machine: nobody can be graded
        return {"error": str(error)}
    except Exception as error:  # of this submission, as far as one can tell: the others are graded
        return {"failed": f"had {type(error).__name__}: {error}"[:300]}


if __name__ == "__main__":
    main()
