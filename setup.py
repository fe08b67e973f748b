"""Puts the labs into the package, so that an installed fivebar finds them without a clone."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class WithLabs(build_py):
    def run(self):
        super().run()
        if not self.editable_mode:
            inside = Path(self.build_lib) / "fivebar" / "_labs"
            shutil.rmtree(inside, ignore_errors=True)
            shutil.copytree("labs", inside, ignore=shutil.ignore_patterns("__pycache__", "*.pyc", ".*"))


setup(cmdclass={"build_py": WithLabs})
