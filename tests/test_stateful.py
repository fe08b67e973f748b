"""Long stories, made up by Hypothesis: options of `simulate` that come and go, charts that are interrupted and resumed,
folders of grades in which files change, results are damaged and graders go on."""

import json
import os
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

import fivebar as fb
from fivebar.cli import main
from fivebar.study.speed_accuracy.store import Partial
from tests.helpers.grading_lab import RIGHT, SHIFTED, write_lab, written

NIGHTLY = 50 if os.environ.get("FIVEBAR_NIGHTLY") else 1


def story(machine, examples, steps):
    test = machine.TestCase
    test.settings = settings(
        max_examples=examples * NIGHTLY,
        stateful_step_count=steps,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        derandomize=NIGHTLY == 1,
    )
    return test


ROBOT, BIGLIDE = fb.FiveBar(), fb.Biglide()
LINES = {
    ROBOT: fb.line((0.09, 0.068), (0.08, 0.075), 0.05),
    BIGLIDE: fb.line((0.0, 0.2), (0.01, 0.21), 0.05),
}
LAWS = {
    robot: [
        fb.ComputedTorque(robot, 100, 20),
        fb.PD(robot, 10.0, 1.0),
        fb.FeedForward(robot, 10.0, 1.0),
    ]
    for robot in LINES
}
OPTIONS = {
    "control_period": [0.01, 0.005, 0.02, 0.0, -1.0, 0.0101, np.nan],
    "step": [0.001, 0.0005, 0.01, 0.0, 1.0],
    "torque_limit": [0.01, (0.02, 0.01), 1e3, 0.0, -1.0, np.inf],
    "delay": [0, 1, 3, -1, 0.5],
    "encoder_resolution": [1e-4, (1e-3, 1e-4), 0.0, "x"],
    "chart": ["auto", "joint", "task", "bars", "other"],
    "method": ["rk4", "dop853", None, "euler"],
    "tolerance": [1e-9, 1e-6, 0.0, None],
    "duration": [0.02, 0.05, 0.0, -1.0],
}


GROUPS = {
    "measurement": (fb.Measurement, {"delay", "encoder_resolution"}),
    "integrator": (fb.Integrator, {"method", "chart", "tolerance"}),
}


class Simulating(RuleBasedStateMachine):
    """Whatever was asked before, a run depends on its own options alone, and keeps to them."""

    def __init__(self):
        super().__init__()
        self.options, self.robot, self.law, self.seen = {}, ROBOT, 0, {}

    @rule(name=st.sampled_from(list(OPTIONS)), k=st.integers(0, 6))
    def choose(self, name, k):
        values = OPTIONS[name]
        self.options[name] = values[k % len(values)]

    @rule(name=st.sampled_from(list(OPTIONS)))
    def forget(self, name):
        self.options.pop(name, None)

    @rule(robot=st.sampled_from(list(LINES)), law=st.integers(0, 2))
    def take(self, robot, law):
        self.robot, self.law = robot, law

    @rule()
    def run(self):
        key = repr((self.robot, self.law, sorted(self.options.items(), key=str)))
        try:
            options = dict(self.options)
            for name, (kind, parts) in GROUPS.items():
                options[name] = kind(**{part: options.pop(part) for part in parts & set(options)})
            run = fb.simulate(self.robot, LAWS[self.robot][self.law], LINES[self.robot], **options)
            found = run.q.tobytes(), run.tau.tobytes()
        except (ValueError, TypeError, ArithmeticError) as error:
            found = f"{type(error).__name__}: {error}"
            assert str(error)
        else:
            self.keeps_to_its_options(run)
        assert self.seen.setdefault(key, found) == found, "the same call gave something else"

    def keeps_to_its_options(self, run):
        assert all(
            np.isfinite(getattr(run, name)).all()
            for name in ("t", "q", "q_dot", "xi", "tau", "energy")
        )
        assert run.t[0] == 0 and np.all(np.diff(run.t) > 0)
        assert run.t[-1] >= self.options.get("duration", 0.05) - 1e-9
        limit = self.options.get("torque_limit")
        assert limit is None or np.all(np.abs(run.tau) <= np.asarray(limit))


class Resuming(RuleBasedStateMachine):
    """A chart's half-way file: what was added and not cut off is there again; another machine's is begun anew."""

    @initialize()
    def begin(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path, self.about, self.rows = Path(self.folder.name) / "it.jsonl", {"cpu": "a"}, []
        self.partial = Partial(self.path, self.about)

    @rule(knob=st.floats(0, 1e6), word=st.text(max_size=5))
    def add(self, knob, word):
        row = {"problem": "p", "method": "m", "knob": knob, "word": word}
        self.partial.add(row)
        self.rows.append(row)

    @rule(part=st.floats(0, 1))
    def cut(self, part):
        """The disk was full, or the machine switched off."""
        data = self.path.read_bytes()
        data = data[: int(part * len(data))]
        self.path.write_bytes(data)
        whole = data.count(b"\n") if not data.endswith(b"}") else data.count(b"\n") + 1
        self.rows = self.rows[: max(0, whole - 1)]
        self.open_again()

    @rule(junk=st.binary(max_size=20))
    def damage(self, junk):
        with self.path.open("ab") as file:
            file.write(b"\n" + junk.replace(b"{", b"(") + b"\n")
        self.open_again()

    @rule()
    def open_again(self):
        self.partial = Partial(self.path, self.about)

    @rule(cpu=st.sampled_from(["a", "b"]))
    def another_machine(self, cpu):
        if cpu != self.about["cpu"]:
            self.about, self.rows = {"cpu": cpu}, []
        self.open_again()

    @invariant()
    def nothing_is_lost_or_made_up(self):
        if hasattr(self, "partial"):
            assert [row for row in self.partial.rows if isinstance(row, dict)] == self.rows
            assert all(self.partial.has("p", "m", row["knob"]) for row in self.rows)

    def teardown(self):
        if hasattr(self, "folder"):
            self.folder.cleanup()


POINTS = {RIGHT: 4, SHIFTED: 1}


class Grading(RuleBasedStateMachine):
    """A folder of results: every grade is of the file that is there now, whatever happened to results in between."""

    @initialize()
    def begin(self):
        self.folder = tempfile.TemporaryDirectory()
        place = Path(self.folder.name)
        self.labs, self.files, self.out, self.now = (
            write_lab(place / "mylabs"),
            place / "files",
            place / "out",
            {},
        )
        self.hand_in("a", RIGHT)

    @rule(student=st.sampled_from("ab"), text=st.sampled_from(list(POINTS)))
    def hand_in(self, student, text):
        written(self.files / f"{student}.py", text)
        self.now[student] = POINTS[text]

    @rule(
        student=st.sampled_from("ab"), junk=st.one_of(st.binary(max_size=30), st.just(b"[" * 9999))
    )
    def damage_a_result(self, student, junk):
        path = self.out / "students" / f"{student}.json"
        if path.exists():
            path.write_bytes(junk)

    @rule(student=st.sampled_from("ab"))
    def cut_a_result(self, student):
        path = self.out / "students" / f"{student}.json"
        if path.exists():
            path.write_bytes(path.read_bytes()[:-40])

    @rule()
    def grade(self):
        command = [
            "grade",
            "elbow",
            self.files,
            "--labs",
            self.labs,
            "--out",
            self.out,
            "--isolate",
            "process",
        ]
        assert main([str(word) for word in command]) == 0
        found = {
            path.stem: json.loads(path.read_text("utf-8"))["points"]
            for path in (self.out / "students").glob("*.json")
        }
        assert found == self.now

    def teardown(self):
        if hasattr(self, "now"):
            self.grade()
            self.folder.cleanup()


TestSimulating = story(Simulating, 12, 12)
TestResuming = story(Resuming, 15, 12)
TestGrading = story(Grading, 2, 5)
