"""Benchmarks are run by hand, and seldom: what they import is to be there, and they say how they are used."""

import ast
import os
from importlib import import_module
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
SOURCES = sorted(BENCHMARKS.glob("**/*.py"))
SHORTEST = 40  # lines; what is shorter belongs to another file


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(BENCHMARKS).with_suffix("").parts)


def is_script(path: Path) -> bool:
    return '__name__ == "__main__"' in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [name_of(path) for path in SOURCES])
def test_a_benchmark_can_be_imported(name, monkeypatch):
    monkeypatch.setattr(os, "environ", os.environ.copy())  # scripts set their numbers of threads
    assert import_module(f"updamp.benchmarks.{name}")


@pytest.mark.parametrize("name", [name_of(path) for path in SOURCES if is_script(path)])
def test_a_script_says_how_it_is_used(name, monkeypatch):
    monkeypatch.setattr(os, "environ", os.environ.copy())
    script = typer.Typer()
    script.command()(import_module(f"updamp.benchmarks.{name}").main)
    found = CliRunner().invoke(script, ["--help"])
    assert found.exit_code == 0
    assert "Usage" in found.output


def test_benchmarks_are_imported_by_their_names_alone():
    """A script's own folder is the first that Python looks in, so that any other way would work by chance."""
    beside = {path.stem for path in SOURCES}
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not beside & {name.split(".")[0] for name in names}, path
            assert not (isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.path"), path


def test_no_benchmark_is_a_scrap():
    assert not [str(path) for path in SOURCES if len(path.read_text(encoding="utf-8").splitlines()) < SHORTEST]
