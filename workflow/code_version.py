"""Which version of the source made a result: a hash of its files. What other code made is not used again.

The stages of a run have a `version` instead that is raised by hand (`stages.py`): their products take an hour, and most
changes of the source do not change them. A search, branches and fits are pickled objects of the very classes that are
defined here, so that any change of these may make them wrong.
"""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import find_spec, module_from_spec

PACKAGE = "updamp"

# What a search for effects depends on, from the rig file to the decision; a test holds it against the imports.
SEARCH = (
    "rig", "geometry", "fem", "hbm", "effects", "model", "parallel", "measurement", "comparison", "diagnosis",
    "workflow/comparison_inputs.py", "workflow/diagnose_run.py", "workflow/stages.py",
    "workflow/built_rig.py",
)  # fmt: skip

# Their results enter the last digits, their arrays the pickles.
LIBRARIES = ("numpy", "scipy", "jax", "numba", "llvmlite")


@cache
def code_version(*parts: str) -> str:
    """SHA-256 of the source files of some parts of updamp and of the versions of the numerical libraries, hexadecimal.

    parts: folders or files, such as "fem" or "workflow/stages.py"; folders are taken with all below them

    The same in every process, from every folder, in a clone and installed from a wheel. Read once a process, when it is
    first asked for.
    raises: ValueError naming a part that is not there
    """
    sources = [source for part in sorted(parts) for source in source_files(part)]
    return hash_of(sources, [f"{name} {version(name)}" for name in LIBRARIES])


def hash_of(sources: Iterable[tuple[str, bytes]], versions: Sequence[str] = ()) -> str:
    """SHA-256 of names and contents, whatever their order and their ends of lines."""
    digest = hashlib.sha256("\n".join(versions).encode())
    for name, content in sorted(sources):
        digest.update(f"\n{name} ".encode())
        digest.update(hashlib.sha256(content.replace(b"\r\n", b"\n")).digest())
    return digest.hexdigest()


def source_files(part: str) -> Iterator[tuple[str, bytes]]:
    """Name, as "fem/solvers/amg.py", and content of each Python file of a part. raises: ValueError"""
    room, *below = part.split("/")
    spec = find_spec(f"{PACKAGE}.{room}")
    if spec is None:
        raise ValueError(f"{part}: not a part of {PACKAGE}")
    place: Traversable = files(module_from_spec(spec))  # not imported: that of hbm would load JAX
    for name in below:
        place = place / name
    if place.is_file():
        yield part, place.read_bytes()
    elif place.is_dir():
        yield from _below(place, part)
    else:
        raise ValueError(f"{part}: not a part of {PACKAGE}")


def _below(folder: Traversable, name: str) -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        if entry.is_dir() and entry.name != "__pycache__":
            yield from _below(entry, f"{name}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{name}/{entry.name}", entry.read_bytes()
