"""A machine without the system libraries: the sentence names them and the command, as the table in the repo does."""

from pathlib import Path

import pytest
from support.short_study import RIG, run_command

from updamp.parallel.system_libraries import lacking
from updamp.pictures import scene
from updamp.workflow import stage_functions

TABLE = Path(__file__).parents[2] / "system-packages.txt"
THERE, ABSENT = {"libc.so.6": "libc6"}, {"libnowhere.so.7": "libnowhere", "libnothere.so.1": "libnowhere"}


def test_what_is_missing_is_named_with_each_package_once() -> None:
    assert lacking(THERE) == ""
    wanted = "libnowhere.so.7, libnothere.so.1 missing; apt-get install libnowhere (Debian, Ubuntu)"
    assert lacking({**THERE, **ABSENT}) == wanted


@pytest.mark.parametrize(
    ("package", "libraries"), [("gmsh", stage_functions.GMSH_LIBRARIES), ("pyvista", scene.LIBRARIES)]
)
def test_libraries_are_those_of_the_table(package: str, libraries: dict[str, str]) -> None:
    rows = [line.split(maxsplit=2) for line in TABLE.read_text("utf-8").splitlines() if not line.startswith("#")]
    assert libraries == {file: debian for debian, file, needed_by in rows if package in needed_by}


def test_a_run_that_cannot_mesh_ends_with_that_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage_functions, "GMSH_LIBRARIES", {**THERE, **ABSENT})
    result = run_command("run", RIG, "--mesh", "small", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "error: no mesh can be made: libnowhere.so.7, libnothere.so.1 missing; apt-get install" in result.output
    assert "Traceback" not in result.output
