"""Programs that look for the answers."""

READING = {
    "secrets from disk": (
        'def evil(x): return float(open("SECRETS").read()) * x',
        {"exception"},
        5,
    ),
    "package from disk": ('def evil(x): return open("PACKAGE").read()[:9]', {"exception"}, 5),
    "package by its file": (
        """
import importlib.util, sys
def evil(x):
    sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "Gate"]
    spec = importlib.util.spec_from_file_location("fivebar", "PACKAGE")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return 1.0
""",
        {"exception"},
        5,
    ),
    "package imported": (
        "def evil(x):\n    import fivebar\n    return fivebar.__file__",
        {"exception"},
        5,
    ),
    "package imported past the gate": (
        """
import sys
def evil(x):
    sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "Gate"]
    import fivebar
    return fivebar.__file__
""",
        {"exception"},
        5,
    ),
    "package through descriptors": (
        """
import os
def evil(x):
    found = 0
    for n in range(64):
        fd = f"/proc/self/fd/{n}/"
        for path in (fd, fd + "../" * 12, "/proc/GRADER/root/", "/proc/self/cwd/"):
            for name in ("PACKAGE", "fivebar/__init__.py", "SECRETS"):
                try:
                    found += len(open(path + name.lstrip("/")).read())
                except OSError:
                    pass
                try:
                    found += len(os.read(os.open(name.lstrip("/"), os.O_RDONLY, dir_fd=n), 100))
                except OSError:
                    pass
    assert found == 0, found
    raise OSError("nothing found")
""",
        {"exception"},
        5,
    ),
    "frames and gc": (
        """
import gc, inspect, sys
def evil(x):
    found = [v for frame in inspect.stack() for v in frame.frame.f_locals.values() if type(v) is float]
    for thing in gc.get_objects():
        if isinstance(thing, dict):
            found += [v for v in list(thing.values()) if type(v) is float]
        elif isinstance(thing, (list, tuple)):
            found += [v for v in thing if type(v) is float]
    return found[:5000]
""",
        {"value"},
        5,
    ),
    "modules": (
        """
import sys
def evil(x): return sorted(m for m in sys.modules if "fivebar" in m or "pytest" in m or "grading" in m)
""",
        {"value"},
        5,
    ),
    "grader's environment": (
        'def evil(x): return open("/proc/GRADER/environ", "rb").read()',
        {"exception"},
        5,
    ),
    "parent's environment": (
        'import os\ndef evil(x): return open(f"/proc/{os.getppid()}/environ", "rb").read()',
        {"exception"},
        5,
    ),
    "grader's memory": (
        'def evil(x): return open("/proc/GRADER/mem", "rb").read(1)',
        {"exception"},
        5,
    ),
    "grader's memory by a system call": (
        """
import ctypes
def evil(x):
    libc = ctypes.CDLL(None, use_errno=True)
    there, here = (ctypes.c_size_t * 2)(4096, 8), (ctypes.c_size_t * 2)(id(x), 8)
    if libc.process_vm_readv(GRADER, here, 1, there, 1, 0) < 0 and libc.ptrace(16, GRADER, 0, 0) < 0:
        raise OSError(ctypes.get_errno(), "no way in")
    return x
""",
        {"exception"},
        5,
    ),
    "own environment": (
        'import os\ndef evil(x): return sorted(os.environ) if "SECRET" in os.environ else []',
        {"value"},
        5,
    ),
    "grader's descriptors": (
        'import os\ndef evil(x): return os.listdir("/proc/GRADER/fd")',
        {"exception"},
        5,
    ),
    "inherited descriptors": (
        """
import os, stat
def evil(x):
    found = []
    for n in range(3, 64):
        try:
            mode = os.fstat(n).st_mode
            if stat.S_ISREG(mode) or stat.S_ISSOCK(mode):
                found.append(os.pread(n, 100, 0))
        except OSError:
            pass
    return len(found)
""",
        {"value"},
        5,
    ),
    "network": (
        """
import socket
def evil(x):
    with socket.create_connection(("127.0.0.1", 80), 1) as s:
        return float(s.recv(10))
""",
        {"exception"},
        5,
    ),
    "name server": (
        'import socket\ndef evil(x): return socket.getaddrinfo("example.org", 80)',
        {"exception"},
        5,
    ),
    "web page": (
        'import urllib.request\ndef evil(x): return urllib.request.urlopen("http://127.0.0.1:1/").read()',
        {"exception"},
        5,
    ),
}
