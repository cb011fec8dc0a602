"""The example of the whole loop, in short: fewer runs and contacts, three effects to choose from."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from updamp.api import Criteria, SearchEffort
from updamp.effects.catalogue import CATALOGUE
from updamp.workflow import diagnose_run as diagnose
from updamp.workflow.history import read_history

pytestmark = pytest.mark.long

EXAMPLE = Path(__file__).parents[2] / "examples" / "hidden_effect.py"
CHOICE = ("blade_mistuning", "clamp_flexibility", "asymmetric_preload")


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("hidden_effect_example", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    monkeypatch.syspath_prepend(str(EXAMPLE.parents[1] / "benchmarks"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    from updamp.benchmarks.virtual_rig.bodies import bodies_of

    monkeypatch.setattr(bodies_of, "__defaults__", (tmp_path / "bodies",))
    monkeypatch.setattr(diagnose, "catalogue", lambda: {name: CATALOGUE[name] for name in CHOICE})
    monkeypatch.setattr(module, "MESH", module.MESH.replace("contact_elements = 16", "contact_elements = 8"))
    return module


def test_the_sealed_effect_is_found_and_added(example: ModuleType, tmp_path: Path) -> None:
    runs = tuple(example.PlannedRun(mode, force) for mode, force in (("IP", 2.0), ("OOP", 4.0)))
    plan, sealed = example.TestPlan(runs, 2, 16), example.hidden("blade_mistuning", "strong")
    few = Criteria(search=SearchEffort(short=2, full=1))
    result = example.loop(tmp_path, sealed, plan, quiet=True, report=False, criteria=few)
    assert (result.verdict.verdict, result.verdict.effects) == ("identified", ("blade_mistuning",))
    assert result.truth == {"blade_mistuning": dict(sealed.values)}
    assert result.found["blade_mistuning"]["difference"] == pytest.approx(0.015, rel=0.1)
    assert result.verdict.error.after < result.verdict.error.before / 3
    assert result.after < 0.7 * result.before, "a comparison learns its scatter from the misfit too"
    assert 0.5 < result.after < 1.2
    added, compared = read_history(tmp_path / "rig+blade_mistuning.toml").steps
    assert (added.kind, compared.kind) == ("added", "compared")
    assert compared.after.fit == pytest.approx(result.after)
