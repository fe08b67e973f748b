"""README and the guide as a newcomer reads them: their Python blocks and commands work as printed."""

import re
import shlex
import shutil

import matplotlib
import pytest

import fivebar as fb
from fivebar.cli import _parser, main
from tests.helpers import DATA, LABS, ROOT
from tests.helpers.needs import need

README = ROOT / "README.md"
PAGES = {
    path.stem: path.read_text(encoding="utf-8")
    for path in (ROOT / "fivebar" / "guide").glob("*.md")
}
PAGES["README"] = README.read_text(encoding="utf-8")
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"^    (?:.*&& )?(?:\.venv/bin/)?(fivebar .+?)(?: +#.*)?$", re.MULTILINE)
INLINE = re.compile(r"`(?:\.venv/bin/)?(fivebar [^`]+)`")
SLOW = "fivebar chart all"  # takes minutes; tests/study tests each chart by itself
WRITTEN = {
    "README": {"tracking.png", "animation.html", "setpoints.csv"},
    "simulation": {
        "tracking.png",
        "animation.html",
        "animation.gif",
        "run.csv",
        "page.html",
        "poses.png",
    },
    "drawing": {"timed.png", "setpoints.csv", "proof.json"},
    "measured_data": {"calibration.png", "replay.png"},
    "design": {"front.png", "atlas.png", "swept"},
    "compiled": {"robot.xml", "play.html", "four-bar.html"},
}


def commands():
    """Return the fivebar commands with options that README and the guide print."""
    texts = []
    for page in PAGES.values():
        shell = BLOCK.sub("", page)
        texts += INDENTED.findall(shell) + [
            " ".join(text.split()) for text in INLINE.findall(shell)
        ]
    return [
        text
        for text in dict.fromkeys(texts)
        if " " in text and "..." not in text and "FILE" not in text
    ]


def test_readme_is_short():
    assert PAGES["README"].count("\n") <= 120


@pytest.mark.deep
@pytest.mark.parametrize("name", [name for name, text in PAGES.items() if BLOCK.search(text)])
def test_python_blocks_of_a_page_run_in_one_session(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    if "import jax" in PAGES[name]:
        need("JAX")
    session = {"__name__": "__main__"}
    for block in BLOCK.findall(PAGES[name]):
        exec(compile(block, name, "exec"), session)
    assert WRITTEN.get(name, set()) <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.deep
@pytest.mark.parametrize("command", commands())
def test_commands_do_what_they_say(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path)
    words = shlex.split(command)[1:]
    before = {path.name for path in tmp_path.iterdir()}
    if command.startswith(SLOW):
        assert _parser(words[0]).parse_args(words).run
        return
    try:
        code = main(words)
    except SystemExit as stop:  # `run` ends as its script did, --help with 0
        code = stop.code
    assert not code, capsys.readouterr().err
    files = re.findall(
        r"(?<![\w/])[\w-]+\.(?:png|html|csv)\b|results/|(?<=--out )compared", command
    )
    made = {path.name for path in tmp_path.iterdir()} - before
    assert {name.rstrip("/") for name in files} - before <= made


def write_inputs(folder):
    """Write the files that the commands read: a path, a log, lab scripts, a solution, a hand-in."""
    reference = fb.line((0.09, 0.068), (0.05, 0.0), 4.0)
    rows = ["t,x,y"]
    for k in range(41):
        x, y = reference(k / 10)[0].tolist()
        rows.append(f"{k / 10!r},{x!r},{y!r}")
    (folder / "path.csv").write_text("\n".join(rows), encoding="utf-8")
    controller = fb.ComputedTorque(fb.FiveBar(), 100.0, 20.0)
    circle = fb.circle((0.05, 0.09), 0.02, 1.0)
    log = fb.simulate(fb.FiveBar(), controller, circle, control_period=0.002, step=0.002)
    log.to_csv(folder / "log.csv")
    log.to_bag(folder / "bag")
    for script in (LABS / "amoro").glob("*.py"):
        shutil.copy(script, folder)
    shutil.copy(DATA / "solutions" / "lab1.py", folder / "my.py")
    shutil.copy(LABS / "lab8_calibration" / "measured.csv", folder)
    fb.FiveBar().save(folder / "robot.toml")
    lines = '<path fill="none" stroke="black" d="M0 0 L30 0 L15 20"/>'
    size = 'width="40mm" height="30mm" viewBox="0 0 40 30"'
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{lines}</svg>'
    (folder / "drawing.svg").write_text(svg, encoding="utf-8")
    (folder / "submissions").mkdir()
    shutil.copy(LABS / "lab1_geometry" / "student.py", folder / "submissions" / "anna.py")


def test_pages_have_commands_and_links_that_exist():
    assert len(commands()) >= 15
    for name, text in PAGES.items():
        folder = README.parent if name == "README" else README.parent / "fivebar" / "guide"
        for link in re.findall(r"\]\(([^)#:]+)\)|src=\"([^\"]+)\"", text):
            assert (folder / next(filter(None, link))).exists(), (name, link)
