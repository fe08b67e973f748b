"""The package as its users get it: what is in it, what it needs, and under which licences."""

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib.metadata import PackageNotFoundError, distribution

import pytest

from tests.helpers import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NEEDED = PROJECT["dependencies"]
EXTRAS = PROJECT["optional-dependencies"]
PINS = (
    line.split("#")[0].strip() for line in (ROOT / ".ci/oldest.txt").read_text("utf-8").splitlines()
)
OLDEST = dict(pin.split("==") for pin in PINS if pin)
# What the guide calls a licence, and what of it is in a package's own metadata.
LICENCES = {
    "BSD": "BSD",
    "MIT": "MIT",
    "PSF": "Python Software Foundation",
    "MPL": "MPL",
    "Apache": "Apache",
    "LGPL": "LGPL|Lesser",
    "Own terms": "Various|EXUDYN",
}


def name_of(requirement):
    return re.match(r"[\w.-]+", requirement)[0].lower()


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """(names and bytes of the wheel of the tree, of the wheel of the sdist, and the sdist's names)."""
    place = tmp_path_factory.mktemp("built")
    source = place / "source"
    for name in subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT, text=True).split("\0")[
        :-1
    ]:
        if not name.startswith(("tests/", "notebooks/", ".")) and (ROOT / name).exists():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, source / name, follow_symlinks=False)
    run(source, "build_sdist", place)
    with tarfile.open(next(place.glob("*.tar.gz"))) as sdist:
        listed = {name.partition("/")[2] for name in sdist.getnames()}
        sdist.extractall(place / "unpacked", filter="data")
    wheels = []
    for k, tree in enumerate((source, next((place / "unpacked").iterdir()))):
        run(tree, "build_wheel", place / str(k))
        with zipfile.ZipFile(next((place / str(k)).glob("*.whl"))) as wheel:
            wheels.append(
                {
                    name: wheel.read(name)
                    for name in wheel.namelist()
                    if not name.endswith("/RECORD")
                }
            )
    return *wheels, listed, source


def run(source, step, out):
    code = f"import sys, setuptools.build_meta as b; b.{step}(sys.argv[1])"
    made = subprocess.run(
        [sys.executable, "-c", code, out], cwd=source, capture_output=True, text=True, timeout=120
    )
    assert made.returncode == 0, made.stderr


@pytest.mark.deep
def test_a_wheel_holds_what_is_tracked_and_the_sdists_is_the_same(built):
    wheel, again, listed, source = built
    assert wheel == again
    wanted = {
        str(path.relative_to(source)) for path in (source / "fivebar").rglob("*") if path.is_file()
    }
    wanted |= {
        f"fivebar/_labs/{path.relative_to(source / 'labs')}"
        for path in (source / "labs").rglob("*")
        if path.is_file() and not path.name.startswith(".")
    }
    own = {name for name in wheel if not name.startswith("fivebar-")}
    assert own == wanted
    assert {name.rpartition(".")[2] for name in own} >= {"py", "html", "css", "js", "md"}
    assert {"LICENSE", "README.md", "pyproject.toml"} <= listed


def test_lower_bounds_are_those_that_are_tested_and_there_are_no_upper_ones():
    for requirement in [*NEEDED, *(one for extra in EXTRAS.values() for one in extra)]:
        assert not re.search(r"<|==|~=|!=", requirement.partition(";")[0]), requirement
    for requirement in NEEDED:
        name, bound = requirement.split(">=")
        assert f"{OLDEST[name]}.0".startswith(f"{bound}."), requirement
    versions = [
        line.rpartition(" ")[2] for line in PROJECT["classifiers"] if re.search(r"3\.\d+$", line)
    ]
    assert versions[0] == PROJECT["requires-python"].removeprefix(">=")
    script = (ROOT / ".ci/run").read_text("utf-8")
    tried = re.search(r"^for version in (.*); do", script, re.MULTILINE)[1].split()
    assert set(versions[1:]) <= set(tried)


def licence(name):
    """What a package says of its licence; None where it is not installed."""
    try:
        about = distribution(name).metadata
    except PackageNotFoundError:
        return None
    classes = [line for line in about.get_all("Classifier", []) if line.startswith("License")]
    return " ".join(
        filter(
            None, [about.get("License-Expression"), (about.get("License") or "")[:200], *classes]
        )
    )


def test_the_guide_has_the_oldest_versions_of_what_is_needed():
    text = (ROOT / "fivebar/guide/versions.md").read_text(encoding="utf-8")
    table = dict(re.findall(r"^\| ([\w-]+)[^|]*\| ([\d.]+) \|", text, flags=re.MULTILINE))
    oldest = {name.lower(): version for name, version in table.items()}
    needed = [*NEEDED, *EXTRAS["jax"], *EXTRAS["torch"]]
    wanted = {name_of(each): re.search(r">=([\d.]+)", each)[1] for each in needed}
    wanted["python"] = PROJECT["requires-python"].removeprefix(">=")
    assert {"torch" if name == "pytorch" else name: v for name, v in oldest.items()} == wanted


def test_citations_are_articles_with_an_author_and_a_year():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    references = text.partition("\nreferences:\n")[2].split("\n  - type: ")[1:]
    assert len(references) >= 10
    for reference in references:
        for key in ("title: ", "authors:", "year: ", "notes: "):
            assert f"\n    {key}" in reference, reference


def test_every_dependency_has_the_licence_that_the_guide_names():
    text = (ROOT / "fivebar/guide/security.md").read_text(encoding="utf-8")
    sentences = text.partition("meshcat and Bokeh. ")[2].partition("\nThe tests use")[0]
    named = {}
    for sentence in re.sub(r"\(.*?\)", "", sentences.replace("\n", " "), flags=re.DOTALL).split(
        "."
    ):
        kind, _, names = sentence.partition(":")
        named |= dict.fromkeys(filter(None, names.replace(" ", "").split(",")), kind)
    extras = (one for key, extra in EXTRAS.items() if key not in ("test", "ci") for one in extra)
    assert set(named) == set(map(name_of, [*NEEDED, *extras]))
    assert {kind.strip() for kind in named.values()} == set(LICENCES)
    for name, kind in named.items():
        found = licence(name)
        assert found is None or re.search(LICENCES[kind.strip()], found), f"{name}: {found}"
    assert all(licence(name_of(requirement)) for requirement in NEEDED)


def test_the_changelog_is_of_this_version():
    text = (ROOT / "fivebar/CHANGELOG.md").read_text("utf-8")
    assert f"## {PROJECT['version']}" in text and "(fivebar/CHANGELOG.md)" in README
