"""The reference that `make docs` writes has every key and every command there is."""

import re
import sys
from pathlib import Path

import pytest

from updamp.pipeline import app
from updamp.rig.rig import Rig

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from write_reference import write_reference


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("reference")
    write_reference(folder)
    return {path.stem: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def test_every_key_of_a_rig_file_is_there_with_its_unit(pages: dict[str, str]) -> None:
    page = pages["rig_file"]
    for name, field in Rig.model_fields.items():
        assert re.search(rf"^\| `{name}` \| .* \| {'yes' if field.is_required() else 'no'} \|$", page, re.MULTILINE)
    for table in ("[material]", "[mesh.NAME]", "[study.modes.NAME]", "[contact.pressure]"):
        assert f"## `{table}`" in page
    assert '| `thickness` | text with a unit, such as `"5 mm"`, at least 0.001 mm' in page
    assert '| `coupling` | one of `"patch"`, `"nearest_node"` | no |' in page
    assert "| `harmonics` | a list, such as `[0, 1, 2, 3]` | yes |" in page
    assert "| `tolerance` | a number, such as `0.01`, above 0 and at most 0.5 | no |" in page
    assert '| `held` | one of `"force"`, `"response"`, `"nothing"` | yes |' in pages["measurement_file"]


def test_every_command_is_there_with_its_options(pages: dict[str, str]) -> None:
    for command in app.registered_commands:
        assert command.callback is not None
        assert f"## updamp {command.callback.__name__.replace('_', '-')}" in pages["command_line"]
    assert "--next-measurement / --no-next-measurement" in pages["command_line"]
    assert set(pages) == {"command_line", "rig_file", "modal_rig_file", "measurement_file"}
