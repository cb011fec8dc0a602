"""A folder with a rig given by modes, for studies of it."""

from pathlib import Path

import pytest
from support.modal_study import modal_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return modal_folder(tmp_path)
