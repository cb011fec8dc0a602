"""The benchmarks are scripts, not part of the package: their folder is put where they look for each other."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
