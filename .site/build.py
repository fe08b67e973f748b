"""The site, from what stands in the repository: README, guides, notebooks, labs and docstrings.

python .site/build.py [FOLDER] writes it, to `site` if no other is named. A warning, such as a link
to nowhere, is an error. Nothing is written twice: the files keep their places, so that links
between them hold.
"""

import json
import re
import shutil
import sys
from operator import attrgetter
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from sphinx.cmd.build import main

import fivebar as fb

SITE = Path(__file__).parent
ROOT = SITE.parent
COPIED = (
    "fivebar/guide",
    "fivebar/grading/isolation.md",
    "fivebar/CHANGELOG.md",
    "notebooks",
    "labs",
    ".readme",
)
SUBJECTS = {
    "Models": ("models", "base"),
    "Singularities": ("singularities", "constraints"),
    "Simulation and control": ("simulation", "control"),
    "Planning": ("planning",),
    "Drawing": ("paths",),
    "Measured data": ("estimation",),
    "Design": ("optimal_design",),
    "Export": ("exporters",),
    "Pictures and pages": ("visualization",),
    "Linkages": ("linkages",),
    "Grading": ("grading",),
}
ANIMATION = re.compile(r'<img src="\.readme/play\.gif"[^>]*>')
LIVE = '<iframe class="live" src="play.html" title="The live page: drag the robot"></iframe>'


def public_names() -> dict[str, list[str]]:
    """Return the public names of each subject."""
    rooms = {room: subject for subject, rooms in SUBJECTS.items() for room in rooms}
    names: dict[str, list[str]] = {subject: [] for subject in SUBJECTS}
    for name, module in fb._MODULES.items():
        names[rooms[module.partition(".")[0]]].append(name)
    for part, module in fb._PARTS.items():
        for name in getattr(getattr(fb, part), "__all__", ()):
            names[rooms[module.partition(".")[0]]].append(f"{part}.{name}")
    return names


def _entry(name):
    """Return what shows a name with its docstring."""
    given = attrgetter(name)(fb)
    if isinstance(given, type):
        kind = "exception" if issubclass(given, Exception) else "class"
        return f".. auto{kind}:: fivebar.{name}\n"
    if callable(given):
        return f".. autofunction:: fivebar.{name}\n"
    known = f"By name: {', '.join(map(repr, given))}." if isinstance(given, dict) else f"{given!r}"
    return f".. py:data:: fivebar.{name}\n\n   {known}\n"


def _contents(caption, *pages):
    """Return a part of the table of contents that stands on each page."""
    return "\n".join((f"```{{toctree}}\n:caption: {caption}\n:hidden:\n", *pages, "```\n"))


def how_to_cite() -> str:
    """Return a text and BibTeX of what CITATION.cff says of the package."""
    about = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    authors = ", ".join(author["name"] for author in about["authors"])
    title, version = about["title"], about["version"]
    fields = {"author": f"{{{authors}}}", "title": title, "version": version}
    lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items())
    return (
        f"## How to cite\n\n{about['message']}\n\n{authors}: *{title}*, version {version}.\n\n"
        f"```bibtex\n@software{{fivebar,\n{lines}}}\n```\n"
    )


def assemble(source: Path) -> None:
    """Lay out the pages in a folder, as they stand in the repository."""
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copyfile
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        copy(ROOT / name, source / name)
    for name in ("CONTRIBUTING.md", "CITATION.cff", "LICENSE"):
        shutil.copyfile(ROOT / name, source / name)
    for path in (source / "notebooks").glob("*.ipynb"):
        notebook = json.loads(path.read_text("utf-8"))
        cells = notebook["cells"]
        notebook["cells"] = [
            cell for cell in cells if "install" not in cell["metadata"].get("tags", ())
        ]
        path.write_text(json.dumps(notebook), "utf-8")
    readme = (ROOT / "README.md").read_text("utf-8")
    guides = dict.fromkeys(re.findall(r"\]\((fivebar/guide/\w+)\.md\)", readme))
    reference = {f"reference/{subject.lower().replace(' ', '_')}": subject for subject in SUBJECTS}
    contents = (
        _contents("Words", "Glossary <fivebar/guide/glossary>"),
        _contents("Guide", *(guide for guide in guides if not guide.endswith("glossary"))),
        _contents(
            "Notebooks", *sorted(f"notebooks/{p.stem}" for p in ROOT.glob("notebooks/*.ipynb"))
        ),
        _contents(
            "Labs", *sorted(p.relative_to(ROOT).as_posix() for p in ROOT.glob("labs/**/*.md"))
        ),
        _contents("Reference", *reference),
        _contents("More", "fivebar/CHANGELOG", "CONTRIBUTING", "fivebar/grading/isolation"),
    )
    (source / "index.md").write_text(
        "\n".join((ANIMATION.sub(LIVE, readme), how_to_cite(), *contents)), "utf-8"
    )
    names = public_names()
    for page, subject in reference.items():
        text = f"{subject}\n{'=' * len(subject)}\n\n" + "\n".join(map(_entry, names[subject]))
        (source / f"{page}.rst").parent.mkdir(exist_ok=True)
        (source / f"{page}.rst").write_text(text, "utf-8")


def build(folder: Path) -> int:
    """Write the site to a folder; return Sphinx's exit status."""
    with TemporaryDirectory() as place:
        source, pages = Path(place, "source"), Path(place, "made", "html")
        assemble(source)
        status = main(["-q", "-W", "--keep-going", "-c", str(SITE), str(source), str(pages)])
        shutil.copytree(pages, folder, dirs_exist_ok=True)
    fb.play(fb.FiveBar()).save(folder / "play.html")
    return status


if __name__ == "__main__":
    sys.exit(build(Path(sys.argv[1]) if sys.argv[1:] else ROOT / "site"))
