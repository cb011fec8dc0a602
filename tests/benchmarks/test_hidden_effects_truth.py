"""What the laboratory hides is what the catalogue means by the same name and parameters.

Both solve the same mesh with the same harmonics and samples, each by its own code; compared is the change of the tips'
log(receptance) that an effect makes.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.both_codes import CHANGES, built, by_updamp, in_laboratory

from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import HIDDEN, hidden, with_hidden
from updamp.effects.catalogue import CATALOGUE
from updamp.effects.dimension_blend import varied_dimension
from updamp.effects.mode_alignment import ModesDifferError
from updamp.effects.rig_model import RigModel
from updamp.effects.varied_dimension import VariedDimension
from updamp.model.rig_files import load_rig
from updamp.rig.dimensions import DIMENSIONS
from updamp.rig.rig import Rig
from updamp.workflow.built_rig import STEPS

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
STRUCTURAL = (*DIMENSIONS, "clamp_flexibility", "blade_mistuning", "shaker_attachment", "wire_stiffness")
# Newton's method does not come from the motion without the effect to that with more of it.
WEAK = (*STRUCTURAL, "quadratic_damping")
# All that the catalogue has, by its own name or another.
KNOWN = [name for name, effect in HIDDEN.items() if effect.catalogue_values(effect.strengths["medium"]) is not None]

# Share of the change by which both may differ; 1e-3 where nothing is said.
APPROXIMATE = {
    # both are exact
    "shaker_attachment": 1e-6,
    "blade_mistuning": 1e-6,
    # no inertia of the modes that are left out
    "clamp_flexibility": 0.01,
    # averages over a patch: 144 equal parts here, 4000 random places there
    "edge_gap": 0.005,
    # six sliders here, ten there
    "sub_patch_microslip": 0.04,
    # the corner of |v| at rest is rounded
    "velocity_dependent_friction": 0.03,
    # loss of a blade by its amplitude there, by its motion at every instant here
    "material_damping": 0.02,
    # the bench is built with it, the catalogue goes there from a step of 2 %
    "face_length": 0.02,
    "platform_height": 0.08,
    "blade_thickness": 0.02,
    "face_angle": 0.02,
}


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(RIG, CHANGES)


@pytest.fixture(scope="module")
def bench(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench_of(rig, bodies_of(rig, "tiny", tmp_path_factory.mktemp("bodies")))


@pytest.fixture(scope="module", autouse=True)
def kept_elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """The laboratory's own store is left alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bodies_of, "__defaults__", (tmp_path_factory.mktemp("kept"),))
        yield


@pytest.fixture(scope="module")
def model(rig: Rig) -> RigModel:
    plain = built(rig)
    return replace(plain, dimensions={name: varied(plain, rig, name) for name in DIMENSIONS})


def varied(plain: RigModel, rig: Rig, name: str) -> VariedDimension:
    """By the first step that modes can be told after: on this mesh the last one that is kept changes on some ways."""
    for step in STEPS:
        with suppress(ModesDifferError):
            return varied_dimension(plain, built(DIMENSIONS[name].changed(rig, step)), step)
    raise AssertionError(name)


def places(bench: Bench, name: str) -> tuple[tuple[float, float], ...]:
    """Frequency [Hz] and force [N]: of each mode; what is structural is seen while all sticks."""
    ip, oop = assembled(bench).stuck_frequencies(2)
    forces = (0.01, 0.01) if name in STRUCTURAL else (5.0, 25.0)
    return (0.997 * ip, forces[0]), (0.997 * oop, forces[1])


@pytest.fixture(scope="module")
def plain(bench: Bench, model: RigModel) -> Callable[[float, float], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    known: dict[tuple[float, float], tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def both(frequency: float, force: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if (frequency, force) not in known:
            known[frequency, force] = (in_laboratory(bench, frequency, force), *by_updamp(model, frequency, force))
        return known[frequency, force]

    return both


def test_both_agree_where_nothing_is_hidden(bench, plain):
    for place in places(bench, "pressure_crown"):
        laboratory, updamp, _ = plain(*place)
        np.testing.assert_allclose(updamp, laboratory, rtol=1e-7)


def test_every_effect_of_the_catalogue_can_be_hidden():
    assert sorted(HIDDEN[name].catalogue_name for name in KNOWN) == sorted(CATALOGUE)


@pytest.mark.parametrize("name", KNOWN)
def test_hidden_parameters_are_those_of_the_catalogue(name):
    """By name, and within bounds at every strength."""
    effect = HIDDEN[name]
    parameters = {p.name: p for p in CATALOGUE[effect.catalogue_name].parameters}
    for strength in effect.strengths.values():
        values = effect.catalogue_values(strength)
        assert set(values) == set(parameters)
        for key, value in values.items():
            assert parameters[key].lower <= value <= parameters[key].upper
        apart = [value != parameters[key].null for key, value in values.items()]
        assert any(apart) if effect.renamed else all(apart)


@pytest.mark.parametrize("name", KNOWN)
def test_hidden_effect_changes_what_the_catalogue_s_changes(name, bench, model, plain, rig):
    one = hidden(name, "weak" if name in WEAK else "medium")
    changes = []
    for place in places(bench, name):
        laboratory, updamp, start = plain(*place)
        there = in_laboratory(with_hidden(bench, [one], rig).in_run(0.5), *place)
        effect = CATALOGUE[HIDDEN[name].catalogue_name]
        changed = effect.apply(model, HIDDEN[name].catalogue_values(one.values)).in_run(0.5)
        here, _ = by_updamp(changed, *place, start)
        changes.append((np.log(there / laboratory), np.log(here / updamp)))
    wanted, found = np.array(changes).swapaxes(0, 1)
    assert np.abs(wanted).max() > 0.02
    np.testing.assert_allclose(found, wanted, atol=APPROXIMATE.get(name, 1e-3) * np.abs(wanted).max())
