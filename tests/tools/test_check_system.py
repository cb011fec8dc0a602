"""The check of system libraries: it finds what is there and names what is not."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parent.parent.parent
TABLE = """\
# package  file  needed by
libc6      libc.so.6      everything
libabsent  libabsent.so.7 gmsh, pyvista
libextra   libextra.so.1  CHOLMOD, optional
python3    ensurepip      the environment
python9    no_such_module the future
"""


@pytest.fixture
def check_system() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_system", ROOT / "tools" / "check_system.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(check_system: ModuleType, table: str, folder: Path, *arguments: str) -> int:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check_system, "TABLE", folder / "table.txt")
        patch.setattr(check_system.sys, "argv", ["check_system.py", *arguments])
        (folder / "table.txt").write_text(table)
        return check_system.main()


def test_missing_libraries_are_named_with_the_command(check_system, tmp_path, capsys) -> None:
    assert run(check_system, TABLE, tmp_path) == 1
    said = capsys.readouterr().err
    assert "missing system library: libabsent.so.7 (gmsh, pyvista)" in said
    assert "apt-get install libabsent python9 " in said
    assert "libc.so.6" not in said


def test_optional_libraries_do_not_stop_the_set_up(check_system, tmp_path, capsys) -> None:
    table = "".join(line + "\n" for line in TABLE.splitlines() if "absent" not in line and "python9" not in line)
    assert run(check_system, table, tmp_path) == 0
    assert "libextra.so.1 (CHOLMOD, optional)" in capsys.readouterr().err


def test_missing_packages_alone_for_scripts(check_system, tmp_path, capsys) -> None:
    assert run(check_system, TABLE, tmp_path, "--packages") == 0
    assert capsys.readouterr().out == "libabsent libextra python9\n"


def test_the_table_can_be_read(check_system) -> None:
    libraries = check_system.read_table((ROOT / "system-packages.txt").read_text())
    assert {"libgl1", "libglu1-mesa", "libsuitesparse-dev"} <= {library.package for library in libraries}
    optional = {library.package for library in libraries if library.optional}
    assert optional == {"libsuitesparse-dev", "chromium", "chromium-driver"}
