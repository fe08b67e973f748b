"""README as a newcomer reads it: its Python blocks in one session, top to bottom, and its commands, work as printed."""

import re
import shlex
import shutil

import matplotlib
import pytest

import fivebar as fb
from fivebar.cli import _parser, main
from tests.helpers import DATA, LABS, ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", README, re.DOTALL | re.MULTILINE)
SHELL = re.sub(r"^```.*?^```", "", README, flags=re.DOTALL | re.MULTILINE)
INDENTED = re.findall(
    r"^    (?:.*&& )?(?:\.venv/bin/)?(fivebar .+?)(?: +#.*)?$", SHELL, re.MULTILINE
)
INLINE = [" ".join(text.split()) for text in re.findall(r"`(fivebar [^`]+)`", SHELL)]
COMMANDS = [text for text in dict.fromkeys(INDENTED + INLINE) if " " in text and "..." not in text]
SLOW = "fivebar chart all"  # minutes: what they do is tested, each chart by itself, in tests/study


def test_the_blocks_run_in_one_session(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    session = {"__name__": "__main__"}
    assert len(BLOCKS) >= 7
    for block in BLOCKS:
        exec(compile(block, "README.md", "exec"), session)
    assert {
        "tracking.png",
        "animation.html",
        "animation.gif",
        "run.csv",
        "page.html",
        "poses.png",
    } <= {path.name for path in tmp_path.iterdir()}
    assert "mpc" in capsys.readouterr().out and session["run"].events is not None


@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_do_what_they_say(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    reference = fb.line((0.09, 0.068), (0.05, 0.0), 4.0)
    rows = [
        f"{t / 10!r},{x!r},{y!r}" for t in range(41) for x, y in [reference(t / 10)[0].tolist()]
    ]
    (tmp_path / "path.csv").write_text("\n".join(["t,x,y", *rows]))
    circle = fb.circle((0.05, 0.09), 0.02, 1.0)
    log = fb.simulate(
        fb.FiveBar(),
        fb.ComputedTorque(fb.FiveBar(), 100.0, 20.0),
        circle,
        control_period=0.002,
        step=0.002,
    )
    log.to_csv(tmp_path / "log.csv")
    for script in (LABS / "amoro").glob("*.py"):
        shutil.copy(script, tmp_path)
    shutil.copy(DATA / "solutions" / "lab1.py", tmp_path / "my.py")
    shutil.copy(LABS / "lab8_calibration" / "measured.csv", tmp_path)
    (tmp_path / "submissions").mkdir()
    shutil.copy(LABS / "lab1_geometry" / "student.py", tmp_path / "submissions" / "anna.py")
    words = shlex.split(command)[1:]
    before = set(tmp_path.iterdir())
    try:
        arguments = _parser(words[0]).parse_args(words)
    except SystemExit as stop:  # --help
        assert stop.code == 0 and "usage" in capsys.readouterr().out
        return
    if command.startswith(SLOW):
        assert arguments.run
        return
    try:
        code = main(words)
    except SystemExit as stop:  # `run` ends as its script did
        code = stop.code
    assert not code, capsys.readouterr().err
    files = re.findall(
        r"(?<![\w/])[\w-]+\.(?:png|html|csv)\b|results/|(?<=--out )compared", command
    )
    made = {path.name for path in set(tmp_path.iterdir()) - before}
    assert {name.rstrip("/") for name in files} - {path.name for path in before} <= made


def test_there_are_commands():
    assert len(COMMANDS) >= 10 and any(command.startswith(SLOW) for command in COMMANDS)
