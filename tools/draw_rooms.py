"""The rooms of the code and the arrows between them, read from its imports, as a page: docs/rooms.md.

.venv/bin/python tools/draw_rooms.py

A room is a package of pyproject.toml; what lives there is the first line of its `__init__.py`. An arrow from one room
to another says that a module of the first imports one of the second, in a function or for types only included.
"""

import ast
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import grimp

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "rooms.md"
DOORS = ("pipeline", "api")  # modules at the root: the command line, and what scripts import
HEAD = """# The rooms

Made from the code by `.venv/bin/python tools/draw_rooms.py`; run it again after a change of rooms or imports.
`make test` checks that rooms and arrows are those of the code, and that every arrow goes down the list of layers in
`pyproject.toml`. Numbers of files and lines are of the day when the page was made.
"""


@dataclass(frozen=True)
class Row:
    """Of a table of rooms. room: as a path; imports: from which others of the table"""

    room: str
    purpose: str
    files: int
    lines: int
    imports: tuple[str, ...]


def project() -> Mapping[str, Any]:
    table: Mapping[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    return table


def packages() -> tuple[str, ...]:
    """All that are installed, dotted, without "updamp."."""
    listed = project()["setuptools"]["packages"]
    return tuple(name.removeprefix("updamp.") for name in listed if name != "updamp")


def layers() -> tuple[tuple[str, ...], ...]:
    """Rooms from the top down, as the contract of import-linter has them; those of one layer do not know each other."""
    contracts = project()["importlinter"]["contracts"]
    (rooms,) = (c["layers"] for c in contracts if c["type"] == "layers" and "containers" not in c)
    return tuple(tuple(name.strip().removeprefix("updamp.") for name in layer.split("|")) for layer in rooms)


def imports() -> dict[str, set[str]]:
    """Module -> modules that it imports, dotted, without "updamp."; tests, benchmarks and examples among them."""
    graph = grimp.build_graph("updamp", cache_dir=None)
    ours = {module for module in graph.modules if module.startswith("updamp.")}
    return {
        module.removeprefix("updamp."): {
            imported.removeprefix("updamp.") for imported in graph.find_modules_directly_imported_by(module) & ours
        }
        for module in ours
    }


def arrows(of: Mapping[str, set[str]], rooms: Iterable[str]) -> dict[str, set[str]]:
    """Room -> other rooms that it imports from; a module belongs to the innermost of the rooms that hold it."""
    rooms = tuple(rooms)
    found: dict[str, set[str]] = {room: set() for room in rooms}
    for module, imported in of.items():
        if home := _home(module, rooms):
            found[home] |= {there for name in imported if (there := _home(name, rooms)) and there != home}
    return found


def _home(module: str, rooms: Iterable[str]) -> str:
    """ "" for a module outside of all rooms"""
    return max((room for room in rooms if f"{module}.".startswith(f"{room}.")), key=len, default="")


def row(path: str, imported: Iterable[str]) -> Row:
    """path: of a folder, such as "hbm/", of the files of a folder alone, "hbm/*.py", or of one file"""
    place, _, pattern = path.rpartition("/")
    files = sorted((ROOT / place).glob(pattern) if pattern else (ROOT / place).rglob("*.py"))
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    described = ROOT / path if path.endswith(".py") and "*" not in path else ROOT / place / "__init__.py"
    purpose = (ast.get_docstring(ast.parse(described.read_text(encoding="utf-8"))) or "").split("\n")[0]
    return Row(path, "its own files" if "*" in path else purpose, len(files), lines, tuple(sorted(imported)))


def page() -> str:
    of = imports()
    order = [*DOORS, *(name for layer in layers() for name in layer)]
    between = arrows(of, order)
    rows = [row(f"{name}.py" if name in DOORS else f"{name}/", between[name]) for name in order]
    left_out = "Arrows that follow from others are left out of the picture; the table has all.\n"
    below = [part for name in order if (part := inside(of, name))]
    return "\n".join([HEAD, drawing(between), left_out, table(rows), *below])


def inside(of: Mapping[str, set[str]], outer: str) -> str:
    """The table of the rooms within a room; "" where there are none"""
    inner = [name for name in packages() if name.startswith(f"{outer}.")]
    if not inner:
        return ""
    paths = {name: f"{name.replace('.', '/')}/" for name in inner} | {outer: f"{outer}/*.py"}
    between = arrows(of, [outer, *inner])
    rows = [row(paths[name], (paths[to].removeprefix(f"{outer}/") for to in between[name])) for name in [outer, *inner]]
    return f"## Inside {outer}\n\n{table(rows)}"


def drawing(between: Mapping[str, set[str]]) -> str:
    """A graph in mermaid's language, with the fewest arrows that say the same."""
    edges = [f"    {a} --> {b}" for a in between for b in sorted(reduced(between)[a])]
    nodes = [f"    {name}[{name}{'.py' if name in DOORS else ''}]" for name in between]
    return "\n".join(["```mermaid", "flowchart TD", *nodes, *edges, "```", ""])


def reduced(between: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """Without arrows from a room to another that is also reached by way of a third; there are no circles."""

    def below(name: str) -> set[str]:
        return between[name].union(*(below(other) for other in between[name]))

    return {name: {b for b in to if not any(b in below(c) for c in to - {b})} for name, to in between.items()}


def table(rows: Iterable[Row]) -> str:
    head = "| room | what lives there | files | lines | imports from |\n|---|---|---|---|---|\n"
    lines = (
        f"| `{r.room}` | {r.purpose} | {r.files} | {r.lines} | {', '.join(r.imports) or 'none of these'} |"
        for r in rows
    )
    return head + "\n".join(lines) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
