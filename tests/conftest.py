"""Shared by all tests."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_reference() -> Path:
    """Published and solved problems beside the checkout; tests that need them are skipped where they are missing."""
    folder = Path(__file__).parents[2] / "shared" / "reference"
    if not folder.is_dir():
        pytest.skip(f"{folder} is missing: the solved problems of other codes are kept beside the checkout")
    return folder
