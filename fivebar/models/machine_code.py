"""CasADi functions as machine code: the system's C compiler, and a cache on disk that two processes
can share.
"""

import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

from ..base.errors import warn


def machine_code(function, jit=True):
    """Return a casadi.Function as machine code, from the cache folder or by the system's C
    compiler.

    jit=True: RuntimeError without a C compiler, OSError where the cache folder cannot be written.
    jit="auto": then a RuntimeWarning, and the function itself.
    """
    if jit not in (True, "auto"):
        raise ValueError(f'jit must be False, True or "auto", not {jit!r}')
    try:
        return _load(function)
    except (RuntimeError, OSError) as error:
        if jit is True:
            raise
        warn(f"{error}; going on in CasADi's virtual machine", RuntimeWarning)
        return function


FLAGS = ("-O3", "-fPIC", "-shared")


@lru_cache(maxsize=64)  # to write the C of a step takes longer than a motion of some seconds
def _load(function):
    import casadi

    generator = casadi.CodeGenerator("model.c")
    generator.add(function)
    return casadi.external(function.name(), str(library(generator.dump(), casadi.__version__)))


def library(source, made_by="", flags=(), compiler=None):
    """Return the shared library of a C text, compiled with FLAGS or from the cache; raises as
    `machine_code` with jit=True.

    made_by: what, beside the text, machine and compiler, makes it another one. flags: more of them;
    compiler: another than the system's for C.
    """
    compiler = compiler or c_compiler()
    if not compiler:
        raise RuntimeError(
            'no C compiler found (cc, gcc, clang, or the variable CC); jit="auto" does without'
        )
    recipe = "\n".join([source, compiler, *FLAGS, *flags, platform.machine(), made_by])
    model = cache_folder() / f"{hashlib.sha256(recipe.encode()).hexdigest()[:32]}.so"
    if not _intact(model):
        _build(source, [compiler, *FLAGS, *flags], model)
    return model


def c_compiler():
    """Return the system's C compiler, None if there is none."""
    return (
        os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    )


def cache_folder():
    """Return where compiled models and other files of fivebar are kept: the variable FIVEBAR_CACHE,
    or `fivebar` in the user's cache folder.
    """
    if chosen := os.environ.get("FIVEBAR_CACHE"):
        return Path(chosen)
    try:
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA") or Path.home()) / "fivebar"
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "fivebar"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fivebar"
    except RuntimeError:  # of a user without an account, as in many containers
        raise OSError(
            "this user has no home to keep files of fivebar in; set FIVEBAR_CACHE to a folder"
        ) from None


def _intact(model):
    """Return whether a finished library is there, to the last bit: loading a damaged one would end
    the process.
    """
    try:
        library = model.read_bytes()
        expected = model.with_suffix(".sha256").read_text()
    except OSError:
        return False
    return hashlib.sha256(library).hexdigest() == expected


def _build(source, command, model):
    """Compile in a folder beside `model` and move it there in one step, so that two processes at
    once do not meet.
    """
    try:
        model.parent.mkdir(parents=True, exist_ok=True)
        work = tempfile.TemporaryDirectory(prefix="part-", dir=model.parent)
    except OSError as error:
        problem = (
            f"compiled models cannot be kept in {model.parent}: {error}; set FIVEBAR_CACHE to"
            " another folder"
        )
        raise OSError(problem) from None
    with work as folder:
        part = Path(folder, model.name)
        code = part.with_suffix(".c")
        code.write_text(source, "utf-8")
        files = [str(code), "-o", str(part), "-lm"]
        done = subprocess.run([*command, *files], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{command[0]} failed: {' '.join(done.stderr.split())[:500]}")
        part.with_suffix(".sha256").write_text(hashlib.sha256(part.read_bytes()).hexdigest())
        try:
            for each in (part.with_suffix(".sha256"), part):
                each.replace(model.with_suffix(each.suffix))
        except OSError:
            if not _intact(model):  # else another process was first
                raise
