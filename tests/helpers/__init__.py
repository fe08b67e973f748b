"""What several tests share; no file here holds a test."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA, LABS = ROOT / "tests" / "data", ROOT / "labs"
