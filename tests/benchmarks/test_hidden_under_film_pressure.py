"""Where the load is not spread evenly at rest, the laboratory lays it on and changes it as the catalogue does."""

import numpy as np
import pytest
from support.both_codes import CHANGES, built, by_updamp, in_laboratory
from support.plain_rig import TINY

from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import hidden, with_hidden
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.contact_faces import entry
from updamp.effects.rig_model import RigModel
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig


@pytest.fixture(scope="module")
def rig() -> Rig:
    two_strips = {
        **TINY,
        "contact_elements": 48,
    }  # triangles up each face, without which no edge is told from the middle
    return load_rig(RIG.with_name("virtual_rig_jumping.toml"), {**CHANGES, "mesh.tiny": two_strips})


@pytest.fixture(scope="module")
def bench(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench_of(rig, bodies_of(rig, "tiny", tmp_path_factory.mktemp("bodies")))


@pytest.fixture(scope="module")
def model(rig: Rig) -> RigModel:
    return built(rig)


@pytest.fixture(scope="module")
def place(bench: Bench) -> tuple[float, float]:
    """Below OOP's resonance [Hz], and a force [N] at which contacts slip and open"""
    return 0.997 * float(assembled(bench).stuck_frequencies(2)[1]), 25.0


def test_the_load_at_rest_is_that_of_updamp(bench: Bench, model: RigModel) -> None:
    np.testing.assert_allclose(bench.patches.n0, entry(model, "n0"), rtol=1e-10)
    assert bench.patches.n0.max() > 5 * bench.patches.n0.min()


@pytest.mark.parametrize(
    "name", ["pressure_crown", "pressure_slope", "asymmetric_preload", "pressure_dependent_stiffness", "edge_gap"]
)
def test_what_is_hidden_changes_the_response_as_the_catalogues(name, bench, model, rig, place) -> None:
    one = hidden(name, "medium")
    before, (model_before, start) = in_laboratory(bench, *place), by_updamp(model, *place)
    np.testing.assert_allclose(model_before, before, rtol=1e-7)
    after = in_laboratory(with_hidden(bench, [one], rig), *place)
    model_after, _ = by_updamp(CATALOGUE[name].apply(model, one.values), *place, start)
    wanted, found = np.log(after / before), np.log(model_after / model_before)
    assert np.abs(wanted).max() > 5e-3
    # 4000 random places a patch there, 144 equal parts here
    share = 0.01 if name == "edge_gap" else 1e-3
    np.testing.assert_allclose(found, wanted, atol=share * np.abs(wanted).max())
