"""The process that grades a cohort's submissions one after another: a JSON line in, a JSON line
out.
"""

from __future__ import annotations

import json
import os
import sys
from dataclasses import fields, replace
from pathlib import Path

from ..grade import grade
from ..intake.hand_in import ProgramFile
from ..labs import Lab
from ..program import Job
from ..report.page import report_page
from ..results import withheld
from ..worker.sandbox import IsolationError, KilledError


def main() -> None:
    """Serve until stdin ends. Nothing else can write to the pipe: stdout is moved away first."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        try:
            answers.write(json.dumps(_graded(json.loads(line))) + "\n")
            answers.flush()
        except BrokenPipeError:
            os._exit(0)  # who asked was killed: there is nobody to answer


def request_line(job: Job, lab: Lab) -> str:
    """A job as the line that `main` reads."""
    request = {f.name: getattr(job, f.name) for f in fields(job)} | {
        "lab": _hex(lab.folder),
        "path": _hex(job.path),
    }
    request["robot"] = job.robot.parameters
    request["siblings"] = [(_hex(file.path), file.member, file.name) for file in job.siblings]
    return json.dumps(request) + "\n"


def _graded(request):
    lab = Lab(_path(request.pop("lab")))
    try:
        request["siblings"] = tuple(
            ProgramFile(_path(path), *rest) for path, *rest in request["siblings"]
        )
        robot = replace(lab.robot(), **request.pop("robot"))
        report = grade(lab, Job(_path(request.pop("path")), robot=robot, **request))
        return {
            "report": report.as_json(),
            "page": report_page(withheld(report)),
            "warnings": report.warnings,
        }
    except IsolationError as error:  # of this machine: nobody can be graded
        return {"error": str(error)}
    except KilledError as error:
        return {"failed": str(error)}
    except Exception as error:  # of this submission, as far as one can tell: the others are graded
        return {"failed": f"the grader itself failed with {type(error).__name__}: {error}"[:300]}


def _hex(path):
    """A path's bytes, which need be no text."""
    return os.fsencode(path).hex()


def _path(text):
    return Path(os.fsdecode(bytes.fromhex(text)))


if __name__ == "__main__":
    main()
