"""Where the interpreter and the packages lie that a worker may use, and bubblewrap's command to
show only those.
"""

from __future__ import annotations

import os
import re
import shutil
import site
import subprocess
import sys
import sysconfig
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from importlib.util import find_spec
from pathlib import Path

_ROOT_FOLDERS = (
    "/lib",
    "/lib64",
)  # links to those in /usr, where they are not folders of their own
_SETTINGS = ("/etc/ld.so.cache", "/etc/alternatives")  # where the loader finds libraries
CELL = Path(__file__).parent / "cell"


@cache
def interpreter() -> Path:
    """Return the base interpreter, of which a virtual environment is only a view."""
    return Path(getattr(sys, "_base_executable", "") or sys.executable).resolve()


@cache
def import_folders(packages: tuple[str, ...]) -> tuple[Path, ...]:
    """Return the folders that hold the packages."""
    return tuple(dict.fromkeys(_place(name).parent for name in packages))


def _place(package):
    """Return a package's folder, or the file of a module that is one file."""
    spec = find_spec(package)
    if spec.origin is None:  # a package without an __init__.py
        return Path(next(iter(spec.submodule_search_locations))).resolve()
    origin = Path(spec.origin).resolve()
    return origin.parent if origin.name == "__init__.py" else origin


@cache
def with_dependencies(packages: tuple[str, ...]) -> tuple[str, ...]:
    """Return the packages and those that their distributions require, as they are imported."""
    modules = packages_distributions()
    waiting = [name for package in packages for name in modules.get(package, ())]
    names: set[str] = set()
    while waiting:
        if (name := _canonical(waiting.pop())) in names:
            continue
        names.add(name)
        try:
            needed = requires(name) or []
        except PackageNotFoundError:  # one that this system does not need
            continue
        waiting += [re.split(r"[^\w.-]", line)[0] for line in needed if "extra ==" not in line]
    found = {
        module
        for module, owners in modules.items()
        if names & set(map(_canonical, owners)) and module.isidentifier()
    }
    return tuple(dict.fromkeys((*packages, *filter(find_spec, sorted(found)))))


def _canonical(distribution):
    return re.sub("[-_.]+", "-", distribution).lower()


@cache
def unreachable(packages: tuple[str, ...]) -> bool:
    """Return whether a user without rights cannot reach the interpreter's library or the
    packages.
    """
    places = [Path(sysconfig.get_path("stdlib")), *import_folders(packages)]
    return any(
        not folder.stat().st_mode & 0o001 for place in places for folder in (place, *place.parents)
    )


@cache
def system_folders() -> list[Path]:
    """Return real folders of the libraries that an interpreter needs, none within another."""
    prefixes = {Path(p).resolve() for p in (sys.base_prefix, sys.base_exec_prefix)}
    wanted = [Path(p) for p in ("/usr/lib", "/usr/lib64", "/nix/store", *_ROOT_FOLDERS)]
    wanted += [prefix / name for prefix in sorted(prefixes) for name in ("lib", "lib64")]
    wanted = [
        folder for folder in dict.fromkeys(wanted) if folder.is_dir() and not folder.is_symlink()
    ]
    return [folder for folder in wanted if not set(folder.parents) & set(wanted)]


def _hidden():
    """Return folders of installed packages beneath the system's, which would show more than the
    packages allowed.
    """
    library = Path(sysconfig.get_path("stdlib")).resolve()
    variables = {"base": sys.base_prefix, "platbase": sys.base_exec_prefix}
    found = [*map(Path, site.getsitepackages()), *map(Path, sys.path)]
    found += [Path(sysconfig.get_path(name, vars=variables)) for name in ("purelib", "platlib")]
    found += [
        library / "site-packages",
        library / "dist-packages",
        *Path("/usr/lib/python3").glob("dist-packages"),
    ]
    kept = {library, library / "lib-dynload"}
    system = set(system_folders())
    folders = dict.fromkeys(place.resolve() for place in found)
    return [f for f in folders if f.is_dir() and f not in kept and system & set(f.parents)]


@cache
def readable(packages: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Return (files and folders that a worker may read, folders that it may list): Landlock has no
    exceptions to a rule.
    """
    more = (
        *_SETTINGS,
        "/sys/devices/system/cpu",
        "/usr/share/zoneinfo",
        "/dev/null",
        "/dev/urandom",
    )
    readable = [*_parts(packages), interpreter(), *(Path(p) for p in more if Path(p).exists())]
    listable, waiting, hidden = [*import_folders(packages)], [*system_folders()], _hidden()
    while waiting:
        folder = waiting.pop()
        if not any(folder in place.parents for place in hidden):
            readable.append(folder)
            continue
        listable.append(folder)
        waiting += [
            entry for entry in folder.iterdir() if entry not in hidden and not entry.is_symlink()
        ]
    return [str(place) for place in readable], [str(place) for place in listable]


def _parts(packages):
    """Yield the packages' folders and, beside them, those of their libraries."""
    for name in packages:
        place = _place(name)
        yield place
        beside = place.parent / f"{'pillow' if name == 'PIL' else name}.libs"
        if beside.is_dir():
            yield beside


@cache
def bwrap_command(packages: tuple[str, ...]) -> list[str]:
    """Return the words before the worker's command: it sees the interpreter, the packages, and
    nothing else.
    """
    system = system_folders()
    binds: list[tuple[str, ...]] = [("--ro-bind", str(place), str(place)) for place in system]
    binds += [("--tmpfs", str(place)) for place in _hidden()]
    shown = [*_parts(packages), interpreter(), *(Path(p) for p in _SETTINGS if os.path.exists(p))]
    binds += [("--ro-bind", str(place), str(place)) for place in shown]
    binds += [
        ("--symlink", os.readlink(place), place) for place in _ROOT_FOLDERS if os.path.islink(place)
    ]
    binds += [("--ro-bind", str(CELL), "/cell"), ("--dir", "/student"), ("--chdir", "/student")]
    above = {folder for place in [*system, *shown] for folder in place.parents}
    above = sorted(f for f in above if not {f, *f.parents} & set(system))
    folders = [("--perms", "0755", "--dir", str(folder)) for folder in above if str(folder) != "/"]
    # Before those above: the environment may lie in it, and what is there keeps its rights.
    folders = [("--perms", "0777", "--dir", "/tmp"), *folders]
    spaces = "--unshare-ipc --unshare-pid --unshare-net --unshare-uts --die-with-parent".split()
    spaces.append("--new-session")
    if os.getuid():
        spaces = ["--unshare-user", *spaces]
    return [_bwrap(), *spaces, *(word for words in [*folders, *binds] for word in words)]


def _bwrap():
    found = shutil.which("bwrap")
    if found is None:
        raise FileNotFoundError("bwrap (bubblewrap) is not installed")
    return found


@cache
def bwrap_trouble() -> str:
    """Return why a worker cannot be isolated by bubblewrap here, "" if it can."""
    try:
        command = [*bwrap_command(()), str(interpreter()), "-I", "-S", "-c", ""]
        run = subprocess.run(command, capture_output=True, text=True, timeout=20)
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    return (
        ""
        if run.returncode == 0
        else run.stderr.strip() or f"bwrap ended with status {run.returncode}"
    )
