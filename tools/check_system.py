"""Says which system libraries of system-packages.txt are missing, and the command that gets them.

Needs nothing but Python: it runs before the environment exists. With --packages it prints the missing
packages alone, the optional ones too, for a script to install.
"""

import ctypes
import sys
from importlib.util import find_spec
from pathlib import Path
from shutil import which
from typing import NamedTuple

TABLE = Path(__file__).parent.parent / "system-packages.txt"


class Library(NamedTuple):
    """One line of the table: Debian package, shared library, Python module or command it brings, what needs it."""

    package: str
    file: str
    needed_by: str

    @property
    def optional(self) -> bool:
        return self.needed_by.endswith("optional")


def read_table(text: str) -> list[Library]:
    """Columns are separated by white space; the last one may contain some."""
    lines = (line for line in text.splitlines() if line.strip() and not line.startswith("#"))
    return [Library(*line.split(maxsplit=2)) for line in lines]


def missing(libraries: list[Library]) -> list[Library]:
    """Those that neither the dynamic linker nor Python nor the shell finds."""
    return [library for library in libraries if not _found(library.file)]


def _found(file: str) -> bool:
    if ".so" not in file:
        return find_spec(file) is not None or which(file) is not None
    try:
        ctypes.CDLL(file)
    except OSError:
        return False
    return True


def main() -> int:
    """Exit status 1 if a library that is not optional is missing."""
    lacking = missing(read_table(TABLE.read_text(encoding="utf-8")))
    if "--packages" in sys.argv[1:]:
        print(*[library.package for library in lacking])
        return 0
    for library in lacking:
        print(f"missing system library: {library.file} ({library.needed_by})", file=sys.stderr)
    required = [library.package for library in lacking if not library.optional]
    if required:
        print(f"get it with: apt-get install {' '.join(required)}   (names as in Debian, Ubuntu)", file=sys.stderr)
    return 1 if required else 0


if __name__ == "__main__":
    sys.exit(main())
