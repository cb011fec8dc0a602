"""The packages listed for installation are those on disk."""

import ast
import os
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
NOT_INSTALLED = {"tests", "build", "dist"}
# Modules that import inside a function, and why; docs/design.md says more.
IMPORT_ON_CALL = {
    "api.py": "reports and pictures, which effects' files that import it do not need",
    "commands/compare.py": "--help is there at once; threads are stated before numpy is loaded",
    "commands/design.py": "likewise",
    "commands/study.py": "likewise",
    "commands/effects.py": "likewise",
    "commands/predict.py": "likewise",
    "commands/shared.py": "likewise",
    "fem/solvers/cholmod.py": "optional library",
    "fem/solvers/pardiso.py": "library that loads MKL and may be missing",
    "hbm/contact/iwan.py": "numba, where something is solved",
    "hbm/contact/jenkins_box.py": "likewise",
    "hbm/contact/jenkins_box_sampled.py": "likewise",
    "hbm/contact/modified/pressure_stiffness.py": "likewise",
    "model/rig_files.py": "JAX, which most rig files do not need",
    "notebook/curve.py": "matplotlib, where a picture is asked for",
    "notebook/outcomes.py": "likewise",
    "notebook/resonance.py": "likewise",
    "parallel/processes.py": "Dask, optional",
    "pictures/scene.py": "pyvista, which needs system libraries",
    "workflow/stage_functions.py": "gmsh, which needs system libraries",
}
FOR_TYPES_ALONE = {
    "api.py", "commands/effects.py", "commands/predict.py", "notebook/curve.py", "notebook/outcomes.py",
    "notebook/resonance.py", "pictures/modes.py", "pictures/scene.py",
}  # fmt: skip  # of what the same modules, or for pyvista `scene.py`, import on call


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


@cache
def modules() -> dict[str, ast.Module]:
    folders = [name.removeprefix("updamp.").replace(".", "/") for name in packages_on_disk()]
    files = [*ROOT.glob("*.py"), *(path for folder in folders for path in (ROOT / folder).glob("*.py"))]
    return {path.relative_to(ROOT).as_posix(): ast.parse(path.read_text()) for path in files}


def imports_within(node: ast.AST) -> bool:
    return any(isinstance(inside, ast.Import | ast.ImportFrom) for inside in ast.walk(node))


def test_imports_inside_functions_are_those_that_have_a_reason() -> None:
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    found = {
        name
        for name, module in modules().items()
        if any(imports_within(node) for node in ast.walk(module) if isinstance(node, functions))
    }
    assert found == set(IMPORT_ON_CALL)


def test_no_other_import_is_hidden() -> None:
    """For types alone, or under another condition."""
    found = {
        name
        for name, module in modules().items()
        if any(imports_within(node) for node in module.body if isinstance(node, ast.If | ast.Try | ast.With))
    }
    assert found == FOR_TYPES_ALONE


def test_root_is_no_package_of_its_own() -> None:
    assert not (ROOT / "__init__.py").exists()


def test_the_command_line_says_how_many_threads_numpy_is_to_use_before_it_is_loaded() -> None:
    found = subprocess.run(
        [sys.executable, "-c", "import sys, updamp.pipeline; print('numpy' in sys.modules, 'jax' in sys.modules)"],
        capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    assert found.stdout.split() == ["False", "False"]
