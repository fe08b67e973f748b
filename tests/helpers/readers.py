"""Every reader of files that others may have written, what is right to read, and how a wrong file is refused.

`reading_functions` finds in the source who reads files: each of them is in
COVERS, by the reader that tries it, or in OWN.
"""

import ast
import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import nbformat
import numpy as np

import fivebar as fb
from fivebar.base import columns
from fivebar.base.errors import UsageError
from fivebar.base.shards import MANIFEST, read_chunk, read_manifest
from fivebar.base.units import METRES, SECONDS
from fivebar.estimation.calibration.rows import rows_of
from fivebar.grading.course import marks, settings
from fivebar.grading.course.cohort import Cohort, begin
from fivebar.grading.course.gradebook import Gradebook
from fivebar.grading.intake.hand_in import look_into
from fivebar.grading.judging.results import Check, Report
from fivebar.grading.labs import find_lab
from fivebar.grading.worker.submission import read_submission
from fivebar.linkages import FourBar, Study, study
from fivebar.optimal_design.designs import designs_of
from fivebar.optimal_design.results import Front
from fivebar.optimal_design.sweeps import Sweep
from fivebar.paths.certificates.checker import check, digest
from fivebar.paths.setpoints import setpoints
from fivebar.singularities.maps import Map, singularity_map
from fivebar.study.speed_accuracy.store import Partial
from tests.helpers import DATA, functions_with

ROBOT = fb.FiveBar()
POINTS = "t,x,y\n" + "".join(f"{k / 9!r},{0.09 - k * 0.001!r},0.068\n" for k in range(10))
SETPOINTS = b'# fivebar setpoints, SI units: {"working": [-1, -1], "frame": {"turn": 0.1}}\n'
SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="20mm" viewBox="0 0 20 20">
<path d="M 2 2 L 18 2 A 5 5 0 0 1 18 12 C 10 18 6 14 2 12 Z" fill="none" transform="rotate(10)"/>
<circle cx="9" cy="9" r="3"/></svg>"""
GCODE = (
    "%\nG21 G90\nM3\nG0 X10 Y10\nG1 X20 Y10 F600\nG2 X20 Y20 I0 J5\nG3 X10 Y10 R8 (back)\nM5\nM30\n"
)
TOML = "# by hand\nl11 = 0.1\nl12 = 0.11\nl21 = 0.1\nl22 = 0.11\nd = 0.12\nm = 0.5\nzz1 = 0.002\nzz2 = 0.002\n"
MACHINE = (
    TOML
    + """[readings]
offset = [0.01, -0.02]
ratio = [1.001, -1]
[frame]
shift = [0.1, 0.2]
turn = 0.1
[constraints]
torque = 0.1
joints = [[-1, 1.5], []]
half_planes = [[0, 1, 0.01]]
collisions = {widths = 0.01, layers = [1, 1, 2, 2]}
"""
)
SHEET = "Identifier,Full name,Maximum grade,Grade\nParticipant 1,A,20,\nParticipant 2,B,20,3\n"


@dataclass(frozen=True)
class Reader:
    """read(path); the name of a file, texts that are right; errors: what a wrong one is refused with, by its name."""

    read: Callable
    file: str
    right: tuple[bytes, ...]
    errors: tuple = (ValueError,)
    named: bool = True


def _text(write):
    file = StringIO(newline="")
    write(file)
    return file.getvalue().encode()


def _map():
    file = BytesIO()
    singularity_map(ROBOT, shape=(4, 4)).to_npz(file)
    return file.getvalue()


def _partial(path):
    partial = Partial(path, {"robot": 1})
    partial.add({"problem": "p", "method": "m", "knob": 2.0})
    return Partial(path, {"robot": 1}).row("p", "m", 2.0)


def _gradebook(path):
    mark = SimpleNamespace(student="A", number="1", points=3.0, most=4.0)
    book = Gradebook(path, find_lab("lab1"))
    return book.fill([mark]), book.handed_in("A", "1")


def _marks(path):
    """A table of marks, whatever a spreadsheet made of it: read, and written again."""
    table = marks.Table(path.parent, ["lab1"])
    names = table.without_hand_in(set())
    return table.text([table.mark(name, "", {}, {"lab1": 4.0}, (0.0, 0.1)) for name in names])


def _settings(path):
    return settings.read_settings(path.parent)


def _kept(path):
    """A folder of results goes on, whatever stands in its state, and in what is kept of a student."""
    lab, out = find_lab("lab1"), path.parent / "out"
    (out / "students").mkdir(parents=True, exist_ok=True)
    entry = SimpleNamespace(student="s", path=path, trouble="", member="", siblings=(), attempt=1)
    (out / "students" / "s.json").write_bytes(path.read_bytes())
    cohort = begin(Cohort(lab, out, "seed", None, "process", None))
    return cohort.done(entry)


def _state(path):
    return begin(Cohort(find_lab("lab1"), path.parent, None, None, "process", None)).seed


def _certificate(path):
    """Signed anew: what stands behind the sum is looked at."""
    try:
        claim = json.loads(path.read_bytes())
        path.write_text(json.dumps(claim | {"sha256": digest(claim)}), encoding="utf-8")
    except (ValueError, TypeError, AttributeError, RecursionError):
        pass
    if reason := check(path):
        raise ValueError(f"{path}: {reason}")


def _submission(path):
    programs, left = look_into(path)
    return [program.name for program in programs], len(left), read_submission(path).source


def readers():
    """{name: Reader}, made when asked for: plans take a second."""
    line = fb.line((0.09, 0.068), (0.08, 0.075), 0.2)
    run = fb.simulate(ROBOT, fb.ComputedTorque(ROBOT, 100, 20), line, duration=0.02)
    plan = fb.plan(ROBOT, (0.09, 0.068), (0.08, 0.075), 0.5)
    found = study(FourBar(0.2, 0.06, 0.16, 0.14), samples=5)
    points = POINTS.encode()
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("x = 1\n%pip list")])
    solution = (DATA / "solutions" / "lab1.py").read_bytes()
    wanted = {"t": columns.Quantity(("time",), SECONDS), "x": columns.Quantity((), METRES)}
    numbers = json.dumps(
        {
            name: getattr(ROBOT, name)
            for name in ("l11", "l12", "l21", "l22", "d", "zz1", "zz2", "m")
        }
    )
    proof = fb.certify(ROBOT, fb.path([(0.05, 0.09), (0.04, 0.09)]))
    one = Check("dgm", "Task 1", 2.0, 1.0, 0.5, "failed")
    kept = json.dumps(Report("lab1", "s.py", (one,), "s", "seed").as_json()).encode()
    state = json.dumps({"lab": find_lab("lab1").name, "seed": "a"}).encode()
    toml_links = (
        TOML.partition("m = ")[0] + "[links]\n11 = { mass = 0.1 }\n12 = { mass = 0.1, x = 0.05 }\n"
    )
    manifest, chunk = _shards()
    designs = BytesIO()
    np.savez(designs, l11=np.array([0.1, 0.2]), d=np.array([0.1, 0.1]))
    best = fb.design("workspace_area", {"l1": (0.05, 0.3), "l2": (0.05, 0.3)})
    poses = fb.measurement_poses(ROBOT, 6)
    points_measured = dict(zip(("q1", "q2", "x", "y"), (*poses.q.T, *poses.xi.T)))
    calibrated = fb.calibrate(ROBOT, points_measured)
    measured = _csv(points_measured)
    far = _csv(
        {"q1": poses.q[:, 0], "q2": poses.q[:, 1], "distance": [0.01] * 6, "to": [2, 3, 4, 5, 6, 1]}
    )
    motion = fb.simulate(
        ROBOT, fb.ComputedTorque(ROBOT, 100, 20), fb.circle((0.06, 0.09), 0.02, 0.5), step=2e-3
    )
    log = dict(zip(("t", "q1", "q2", "tau1", "tau2"), (motion.t, *motion.q.T, *motion.tau.T)))
    identified, log = (
        fb.identify(ROBOT, motion),
        _csv({name: column[:120] for name, column in log.items()}),
    )
    return {
        "from_csv": Reader(
            fb.from_csv, "it.csv", (points, points.replace(b",", b";").replace(b".", b","))
        ),
        "path.csv": Reader(
            fb.path, "it.csv", (points, b"x (mm);y (mm);pen\n90;60;1\n80;70;1\n70;70;0\n60;60;1\n")
        ),
        "path.svg": Reader(fb.path, "it.svg", (SVG.encode(),)),
        "path.gcode": Reader(fb.path, "it.gcode", (GCODE.encode(),)),
        "columns": Reader(
            lambda path: columns.read(path, wanted),
            "it.csv",
            (points, b"t (ms)\tx_mm\n1\t2\n2\t3\n", SETPOINTS + points),
        ),
        "Run": Reader(fb.Run.from_csv, "it.csv", (_text(run.to_csv),)),
        "Plan": Reader(fb.Plan.from_csv, "it.csv", (_text(plan.to_csv),)),
        "setpoints": Reader(
            fb.TimedPath.from_csv, "it.csv", (_text(setpoints(ROBOT, line, 100.0).to_csv),)
        ),
        "Study": Reader(Study.from_csv, "it.csv", (_text(found.to_csv),)),
        "Map": Reader(Map.from_npz, "it.npz", (_map(),)),
        "partial": Reader(
            _partial, "it.jsonl", (b'{"robot": 1}\n{"problem": "p", "method": "m", "knob": 1.0}\n',)
        ),
        "robot.toml": Reader(
            fb.load_machine, "it.toml", (TOML.encode(), toml_links.encode(), MACHINE.encode())
        ),
        "robot.json": Reader(fb.load_machine, "it.json", (numbers.encode(),)),
        "hand-in.py": Reader(
            _submission, "it.py", (solution[:3000], "# é\nl = 0.09\n".encode("latin-1"))
        ),
        "hand-in.ipynb": Reader(_submission, "it.ipynb", (nbformat.writes(notebook).encode(),)),
        "hand-in.zip": Reader(look_into, "it.zip", (_zipped(solution[:2000]),)),
        "gradebook": Reader(
            _gradebook,
            "it.csv",
            (SHEET.encode(), SHEET.replace(",", ";").encode("utf-8-sig")),
            (UsageError,),
            False,
        ),
        "marks": Reader(
            _marks,
            marks.FILE,
            (MARKS.encode(), MARKS.replace(",", ";").encode("cp1252")),
            (UsageError,),
            False,
        ),
        "settings": Reader(_settings, settings.FILE, (SETTINGS.encode(),), (UsageError,), False),
        "kept result": Reader(_kept, "it.json", (kept,)),
        "designs.csv": Reader(
            _designs, "it.csv", (b"l11,d\n0.1,0.1\n0.2,0.1\n0.2,0.2\n0.2,0.3\n",)
        ),
        "designs.npz": Reader(_designs, "it.npz", (designs.getvalue(),)),
        "Design": Reader(type(best).load, "it.json", (_text(best.save),)),
        "manifest": Reader(lambda path: read_manifest(path.parent, "sweep"), MANIFEST, (manifest,)),
        "chunk": Reader(lambda path: read_chunk(path, "sweep"), "chunk-000000.npz", (chunk,)),
        "Sweep.json": Reader(lambda path: _sweep(path, chunk), MANIFEST, (manifest,), named=False),
        "Sweep.npz": Reader(
            lambda path: _sweep(path, manifest), "chunk-000000.npz", (chunk,), named=False
        ),
        "Front": Reader(
            lambda path: repr(Front.load(path.parent)),
            "front.json",
            (_text(best.save),),
            named=False,
        ),
        "measured rows": Reader(lambda path: rows_of(str(path)), "it.csv", (measured, far)),
        "calibrate": Reader(
            lambda path: str(fb.calibrate(ROBOT, path, unknown=("l11", "d"))),
            "it.csv",
            (measured, measured.replace(b"q1", b"theta1 (rad)")),
            named=False,
        ),
        "Calibration": Reader(
            lambda path: str(fb.Calibration.from_json(path)),
            "it.json",
            (_text(calibrated.to_json),),
        ),
        "Identification": Reader(
            lambda path: str(fb.Identification.from_json(path)),
            "it.json",
            (_text(identified.to_json),),
        ),
        "from_log": Reader(fb.from_log, "it.csv", (log, log.replace(b"q1,", b"q1 (deg),"))),
        "identify": Reader(
            lambda path: str(fb.identify(ROBOT, path, unknown=["zz1", "m"])),
            "it.csv",
            (log,),
            named=False,
        ),
        "certificate": Reader(_certificate, "it.json", (_text(proof.to_json),)),
        "state": Reader(_state, "grading.json", (state,), (UsageError,), False),
    }


def _designs(path):
    """All rows, which are read as they are asked for."""
    return [row for chunk in designs_of(path, ROBOT).chunks(3) for row in chunk]


def _csv(table):
    rows = [",".join(table), *(",".join(f"{x:.9g}" for x in row) for row in zip(*table.values()))]
    return "\n".join(rows).encode() + b"\n"


def _sweep(path, other):
    """Loaded with what stands beside it, and all that is in it."""
    beside = path.with_name("chunk-000000.npz" if path.name == MANIFEST else MANIFEST)
    beside.write_bytes(other)
    sweep = Sweep.load(path.parent)
    return (
        repr(sweep),
        sweep.errors,
        sweep.to_csv(StringIO()),
        *map(sweep.__getitem__, sweep.figures),
    )


def _shards():
    """A sweep's manifest and a chunk of it, as they are written."""
    with TemporaryDirectory() as folder:
        place = Path(folder)
        fb.sweep(["bars", "workspace_area"], {"l1": [0.1, 0.2, 0.01]}, out=place, robot=ROBOT)
        return (place / MANIFEST).read_bytes(), next(place.glob("*.npz")).read_bytes()


MARKS = "student,lab1,mark,of,state,adjust,comment,days late,report /10\nanna,3,4,4,graded,-1.5,é,2,7\nben,,,4,no program,,,,\n"
SETTINGS = (
    'due = 2027-01-31 18:00:00\nlate_percent = 10\nlabs = ["lab1"]\n[points.lab1]\n"test_*" = 2.5\n'
)


def _zipped(content):
    file = BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("lab/solution.py", content)
        archive.writestr("lab/notes.txt", "é")
    return file.getvalue()


# Who reads, and the reader above through which it is fuzzed.
COVERS = {
    "base.columns:_numbers": "columns",
    "base.columns:_origin": "columns",
    "base.tables:whole_text": "columns",
    "base.tables:arrays_in": "Map",
    "grading.course.cohort:begin": "state",
    "grading.course.cohort:done": "kept result",
    "grading.course.sheet:read_sheet": "gradebook",
    "grading.course.settings:read_settings": "settings",
    "grading.course.course:_table": "marks",
    "grading.worker.submission:_bytes": "hand-in.py",
    "grading.worker.submission:_code": "hand-in.ipynb",
    "grading.worker.submission:_member": "hand-in.zip",
    "grading.worker.submission:opened": "hand-in.py",
    "grading.worker.submission:opened_archive": "hand-in.zip",
    "grading.worker.submission:inner_archive": "hand-in.zip",
    "grading.plugin:_from_options": "hand-in.py",
    "linkages.study:from_csv": "Study",
    "paths.certificates.checker:check": "certificate",
    "planning.plans:from_csv": "Plan",
    "paths.recorded_path:recorded_path": "setpoints",
    "simulation.run:from_csv": "Run",
    "singularities.maps:from_npz": "Map",
    "study.speed_accuracy.store:__init__": "partial",
    "study.speed_accuracy.store:_parsed": "partial",
    "base.tables:about": "Run",
    "optimal_design.results:_load": "Design",
    "base.shards:read_chunk": "chunk",
    "base.shards:read_manifest": "manifest",
    "base.shards:compute": "manifest",
    "simulation.summaries:load": "manifest",
    "estimation.saving:read_json": "Calibration",
    "estimation.identification.samples:_is_a_run": "identify",
}
# No reader of what others wrote.
OWN = {
    "writers": """base.tables:written grading.report.outputs:write_whole study.speed_accuracy.store:add
        study.speed_accuracy.making:make study.speed_accuracy.page:write_page cli.draw_gcode:written_gcode
        grading.course.feedback:write_feedback
        base.folders:locked_folder cli.__init__:main cli.__init__:_flush""",
    "files of the package and its dependencies": """visualization.document:document visualization.document:report visualization.document:script
        visualization.plot.panels:_styles visualization.view.page:_packed_viewer visualization.view.page:page
        grading.labs:template base.robot_uses:uses amoro.ros_free.marking:confined_program
        grading.labs:_loaded grading.labs:hash
        grading.course.settings:offer_settings""",
    "pipes between our own processes; tests/grading/test_wire.py": """amoro.ros_free.child:_report
        amoro.ros_free.child:main
        grading.worker.cell.__main__:main
        grading.worker.cell.__main__:receive grading.worker.live:_reply grading.worker.wire:message
        grading.worker.launch:launch simulation.summaries:_summarizer study.speed_accuracy.runner:_prepare study.speed_accuracy.runner:run""",
    "the system": """grading.worker.cell.confine:_descriptor grading.worker.cell.landlock:restrict
        grading.worker.launch:_spare_user grading.worker.sandbox:_kill_orphan
        study.speed_accuracy.machine:_processor""",
    "bytes that are not taken apart": """grading.grade:file_hash cli.grade:_secret
        grading.grade:grade""",
    "the cache of compiled code, checked by its sum; tests/models/test_compiled.py": """models.machine_code:_build
        models.machine_code:_intact""",
    "its own count, which begins anew where it is damaged; tests/grading/test_tries.py": "grading.report.tries:_read",
    "its own words": "optimal_design.task:about optimal_design.results:plain_parameters",
    "a script that its user runs; tests/amoro": "amoro.ros_free.child:_code",
    "what paths.certificates.checker:check has proved": "cli.certify:_check",
}


READING = {
    "open",
    "read_text",
    "read_bytes",
    "load",
    "loads",
    "loadtxt",
    "genfromtxt",
    "ZipFile",
    "Table",
    "opened",
    "fdopen",
}


def reading_functions():
    """module:function of every function of the package that opens or takes apart a file; writers among them."""
    return functions_with(
        lambda call: (
            (call.func.id if isinstance(call.func, ast.Name) else getattr(call.func, "attr", ""))
            in READING
        )
    )
