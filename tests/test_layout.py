"""The packages listed for installation are those on disk."""

import ast
import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
NOT_INSTALLED = {"tests", "build", "dist"}
# docs/design.md says why each of them imports when it is called.
IMPORT_ON_CALL = {
    "api.py", "commands/effects.py", "fem/solvers/cholmod.py", "fem/solvers/pardiso.py", "model/rig_files.py",
    "notebook/curve.py", "notebook/outcomes.py", "notebook/resonance.py", "pictures/scene.py", "pipeline.py",
    "workflow/curve_jobs.py", "workflow/diagnose_run.py", "workflow/run.py", "workflow/run_outputs.py",
    "workflow/stage_functions.py",
}  # fmt: skip


def packages_on_disk() -> set[str]:
    folders = (path.parent.relative_to(ROOT).parts for path in ROOT.glob("[!.]*/**/__init__.py"))
    return {".".join(("updamp", *parts)) for parts in folders if parts[0] not in NOT_INSTALLED}


def test_listed_packages_are_those_on_disk() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    assert listed == sorted(listed)
    assert set(listed) == packages_on_disk() | {"updamp"}


def test_folders_with_code_are_packages() -> None:
    places = {path.parent for package in ("fem", "geometry", "hbm") for path in (ROOT / package).rglob("*.py")}
    assert [str(place) for place in places if not (place / "__init__.py").exists()] == []


def test_imports_inside_functions_are_those_that_have_a_reason() -> None:
    folders = [name.removeprefix("updamp.").replace(".", "/") for name in packages_on_disk()]
    files = [*ROOT.glob("*.py"), *(path for folder in folders for path in (ROOT / folder).glob("*.py"))]
    found = set()
    for path in files:
        functions = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.FunctionDef)]
        if any(isinstance(inside, ast.Import | ast.ImportFrom) for f in functions for inside in ast.walk(f)):
            found.add(path.relative_to(ROOT).as_posix())
    assert found == IMPORT_ON_CALL


def test_root_is_no_package_of_its_own() -> None:
    assert not (ROOT / "__init__.py").exists()


def test_the_command_line_says_how_many_threads_numpy_is_to_use_before_it_is_loaded() -> None:
    found = subprocess.run(
        [sys.executable, "-c", "import sys, updamp.pipeline; print('numpy' in sys.modules, 'jax' in sys.modules)"],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert found.stdout.split() == ["False", "False"]
