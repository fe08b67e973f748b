"""What some tests need beside Python: without it they are skipped, and the summary says so; in CI they fail."""

import os
import shutil
import sys
from importlib.util import find_spec

import pytest

from fivebar.grading.worker.places import bwrap_trouble
from fivebar.models.machine_code import c_compiler
from tests.benchmarks.arm import PACKAGES, lacks_arm
from tests.benchmarks.simulators.native import lacks_cxx_compiler

PEERS = "heyoka", "mujoco", "pinocchio", "pydrake", "exudyn", "pylinkage", "numba"
BROWSERS = "chromium", "chromium-browser", "google-chrome"


def browser():
    """A Chromium's path, None if there is none."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def firefox():
    """A Firefox's path, None if there is none."""
    return shutil.which("firefox-esr") or shutil.which("firefox")


# What a test may need -> (() -> whether it is here, what brings it).
NEEDED = {
    "chromium": (browser, "apt-get install chromium"),
    "firefox": (firefox, "apt-get install firefox-esr"),
    "ffmpeg": (
        lambda: shutil.which("ffmpeg") and shutil.which("ffprobe"),
        "apt-get install ffmpeg",
    ),
    "bubblewrap": (
        lambda: not bwrap_trouble(),
        "apt-get install bubblewrap; it needs user namespaces, or root with CAP_SYS_ADMIN (a container: more rights)",
    ),
    "a C compiler": (c_compiler, "apt-get install gcc libc6-dev"),
    "a C++ compiler": (lambda: not lacks_cxx_compiler(), "apt-get install g++"),
    "ARM compilers": (lambda: not lacks_arm(), f"apt-get install {PACKAGES}"),
    "JAX": (lambda: find_spec("jax"), "pip install 'fivebar[jax]'"),
    "PyTorch": (lambda: find_spec("torch"), "pip install 'fivebar[torch]'"),
    "toppra": (lambda: find_spec("toppra"), "pip install 'fivebar[peers]'"),
    "axe": (lambda: find_spec("axe_playwright_python"), "pip install axe-playwright-python"),
    "mypy": (lambda: find_spec("mypy"), "pip install mypy"),
    "Sphinx": (lambda: find_spec("sphinx"), "pip install 'fivebar[docs]'"),
    "Dask": (lambda: find_spec("distributed"), "pip install 'fivebar[scale]'"),
    "Pinocchio": (lambda: find_spec("pinocchio"), "pip install 'fivebar[peers]'"),
    "locales": (
        lambda: shutil.which("localedef") and os.path.exists("/usr/share/i18n/locales/de_DE"),
        "apt-get install locales",
    ),
    "UTF-8 in file names": (
        lambda: sys.getfilesystemencoding() == "utf-8",
        "set LC_ALL=C.UTF-8 or PYTHONUTF8=1",
    ),
    "other simulators": (
        # Drake cannot be imported where file names are ASCII.
        lambda: all(map(find_spec, PEERS)) and sys.getfilesystemencoding() == "utf-8",
        "pip install 'fivebar[peers]', where there are wheels of all, and set a UTF-8 locale",
    ),
}
MARK = "this test needs {}: "


def need(thing):
    """Skip the test that asks, and fail it in CI (the variable CI), where a thing of NEEDED is not here.

    The variable FIVEBAR_WITHOUT names what CI has in another environment.
    """
    here, remedy = NEEDED[thing]
    if not here():
        is_wanted = os.environ.get("CI") and thing not in os.environ.get("FIVEBAR_WITHOUT", "")
        (pytest.fail if is_wanted else pytest.skip)(MARK.format(thing) + remedy)


def lacking(reports):
    """A line for each thing that tests lacked: what it is, how many, what brings it."""
    texts = [report.longreprtext for report in reports]
    for thing, (_, remedy) in NEEDED.items():
        if count := sum(MARK.format(thing) in text for text in texts):
            yield f"{thing}: {count} test{'s' * (count > 1)} did not run; {remedy}"
