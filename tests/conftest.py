"""Shared by all tests: what is compiled once, by whichever process, is there for all of them."""

import os
from pathlib import Path

import pytest

# Before JAX is loaded, and for the processes that tests start too. What is compiled is kept beside the results, not in
# the user's own cache. Without the fusion emitters contact laws compile in two thirds of the time and run as fast.
os.environ["XDG_CACHE_HOME"] = str(Path(__file__).parents[1] / "results" / ".cache" / "tests")
_QUICK = "--xla_cpu_use_fusion_emitters=false"
if _QUICK not in os.environ.get("XLA_FLAGS", ""):
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {_QUICK}".strip()

from updamp.hbm import compilation_cache  # noqa: E402

compilation_cache.LEAST_SECONDS = 0.1  # many small laws, each in several processes


@pytest.fixture(scope="session", autouse=True)
def _compiled_laws_are_kept() -> None:
    compilation_cache.keep_compiled()


@pytest.fixture(scope="session")
def shared_reference() -> Path:
    """Published and solved problems beside the checkout; tests that need them are skipped where they are missing."""
    folder = Path(__file__).parents[2] / "shared" / "reference"
    if not folder.is_dir():
        pytest.skip(f"{folder} is missing: the solved problems of other codes are kept beside the checkout")
    return folder
