"""Shared by all tests: what is compiled once, by whichever process, is there for all of them."""

import os
import sys
from pathlib import Path

import pytest

# Before JAX is loaded, and for the processes that tests start too. What is compiled is kept beside the results, not in
# the user's own cache. Without the fusion emitters contact laws compile in two thirds of the time and run as fast.
os.environ["XDG_CACHE_HOME"] = str(Path(__file__).parents[1] / "results" / ".cache" / "tests")
os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = str(Path(os.environ["XDG_CACHE_HOME"]) / "hypothesis")
# Bytecode too: in a copied environment that of the libraries is out of date, and where PYTHONDONTWRITEBYTECODE is set
# none is written. Either costs each of the many processes that tests start 5 s.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = str(Path(os.environ["XDG_CACHE_HOME"]) / "bytecode")
sys.dont_write_bytecode = False
_QUICK = "--xla_cpu_use_fusion_emitters=false"
if _QUICK not in os.environ.get("XLA_FLAGS", ""):
    os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {_QUICK}".strip()

from updamp.parallel.resources import thread_limits  # noqa: E402

# As the processes that updamp starts: what one of them has compiled, the others find.
os.environ.update(thread_limits(1))

from updamp.hbm import compilation_cache  # noqa: E402

compilation_cache.LEAST_SECONDS = 0.1  # many small laws, each in several processes


@pytest.fixture(scope="session", autouse=True)
def _compiled_laws_are_kept() -> None:
    """By this process and by those that tests start, whether these ask for it or not."""
    folder = compilation_cache.keep_compiled()
    if folder is not None:
        os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
        os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = str(compilation_cache.LEAST_SECONDS)


# Each file goes to one process (--dist loadfile), so that what its tests share is made once. These are begun with, or
# one process would be busy with them alone in the end; by processor time, longest first.
LONGEST = (
    "benchmarks/test_reproducibility.py",
    "diagnosis/selection/test_search.py",
    "hbm/contact/test_compiled_modified_laws.py",
    "hbm/contact/test_compiled_laws.py",
    "workflow/test_diagnose.py",
    "workflow/test_diagnose_brake_reuss.py",
    "commands/test_pipeline.py",
    "diagnosis/candidate_models/test_refit.py",
    "commands/test_quick_look.py",
    "examples/test_hidden_effect.py",
    "effects/test_faults.py",
    "hbm/stability/test_stability.py",
    "hbm/test_rig_time_integration.py",
    "hbm/contact/test_modified_laws.py",
    "comparison/test_modal_comparison.py",
    "parameter_study/test_run_study.py",
    "comparison/fit/test_fit_from_far.py",
    "comparison/fit/test_fit.py",
    "diagnosis/selection/test_calibration_first.py",
    "diagnosis/candidate_models/test_other_sizes.py",
    "workflow/test_diagnose_stated.py",
    "hbm/analysis/test_accuracy.py",
    "hbm/analysis/test_sensitivity.py",
    "hbm/contact/test_jenkins_box.py",
    "report/test_in_browser.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    place = {Path(__file__).parent / name: i for i, name in enumerate(LONGEST)}
    if missing := [path for path in place if not path.is_file()]:
        raise pytest.UsageError(f"tests/conftest.py: LONGEST has files that are not there: {missing}")
    items.sort(key=lambda item: place.get(item.path, len(LONGEST)))


@pytest.fixture(scope="session")
def shared_reference() -> Path:
    """Published and solved problems beside the checkout; tests that need them are skipped where they are missing."""
    folder = Path(__file__).parents[2] / "shared" / "reference"
    if not folder.is_dir():
        pytest.skip(f"{folder} is missing: the solved problems of other codes are kept beside the checkout")
    return folder
