"""Benchmarks are run by hand, and seldom: what they import is to be there."""

import os
from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
MODULES = sorted(".".join(path.relative_to(BENCHMARKS).with_suffix("").parts) for path in BENCHMARKS.glob("**/*.py"))


@pytest.mark.parametrize("name", MODULES)
def test_a_benchmark_can_be_imported(name, monkeypatch):
    monkeypatch.setattr(os, "environ", os.environ.copy())  # scripts set their numbers of threads
    assert import_module(f"updamp.benchmarks.{name}")
