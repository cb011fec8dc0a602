"""Counts what becomes of the broken inputs of tests/support/broken: clear, unclear, crash, accepted.

python tests/broken_inputs.py            # the counts
python tests/broken_inputs.py --list     # and every one that is not clear, with what was said
"""

import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

os.environ.setdefault("COLUMNS", "10000")

from support.broken.folders import FOLDERS
from support.broken.measurements import MEASUREMENTS
from support.broken.outcome import Outcome, outcome
from support.broken.rig_files import RIG_FILES


def main(listed: bool) -> None:
    started, found = time.process_time(), Counter[Outcome]()
    for case in (*RIG_FILES, *MEASUREMENTS, *FOLDERS):
        with tempfile.TemporaryDirectory() as folder:
            kind, said = outcome(case, Path(folder))
        found[kind] += 1
        if listed and kind is not Outcome.CLEAR:
            print(f"{kind.value:9} {case.name}\n          wanted {case.words}\n          said   {said[-400:]!r}")
    counts = ", ".join(f"{found[kind]} {kind.value}" for kind in Outcome)
    print(f"{found.total()} broken inputs: {counts}; {time.process_time() - started:.0f} s of processor time")


if __name__ == "__main__":
    main("--list" in sys.argv)
