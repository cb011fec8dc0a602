"""The stated size is that of the mesh, and what does not fit is refused with what would."""

import re
from pathlib import Path

import pytest

from updamp.fem.quadratic_mesh import quadratic_mesh
from updamp.geometry.build_mesh import build_mesh
from updamp.model.rig_files import load_rig
from updamp.rig.questions import questions
from updamp.rig.size import finer_presets, size_of
from updamp.workflow.limits import check_size

RIGS = Path(__file__).parents[2] / "rigs"
FILES = ["pesaresi2017.toml", "virtual_rig.toml"]


@pytest.mark.parametrize("name", FILES)
def test_unknowns_are_those_of_the_mesh(name: str) -> None:
    rig = load_rig(RIGS / name)
    preset = next(iter(rig.mesh))
    mesh, size = build_mesh(rig, preset), size_of(rig, preset)
    assert size.unknowns == 3 * len(quadratic_mesh(mesh.blade).nodes)
    assert size.damper == 3 * len(quadratic_mesh(mesh.damper).nodes)
    assert size.contacts == len(mesh.contacts)


def test_memory_is_near_what_was_measured() -> None:
    """GB of the reference rig's runs (peak_memory_GB of summary.json, 2026-11-23)."""
    rig = load_rig(RIGS / "pesaresi2017.toml")
    for preset, measured in (("small", 0.52), ("medium", 1.74), ("full", 7.6)):
        assert size_of(rig, preset).elements_memory() / 1e9 == pytest.approx(measured, rel=0.25)


@pytest.mark.parametrize("name", FILES)
def test_a_rig_of_ours_fits_and_is_asked_nothing(name: str) -> None:
    rig = load_rig(RIGS / name)
    assert questions(rig) == []
    check_size(rig, next(iter(rig.mesh)), memory=4e9)


def test_what_fits_fits_and_one_more_does_not() -> None:
    rig = load_rig(RIGS / "pesaresi2017.toml")
    size = size_of(rig, "full")
    needed = size.elements_memory()
    assert size.most_unknowns(needed) == pytest.approx(size.unknowns, abs=1)
    check_size(rig, "full", memory=1.001 * needed)
    with pytest.raises(ValueError, match=r"mesh\.full: .* 7\.6 GB .* at most 3\.7"):
        check_size(rig, "full", memory=0.99 * needed)
    check_size(rig, "full", meshed=True, memory=0.5 * needed)


@pytest.mark.parametrize(
    ("name", "preset", "finer"),
    [
        ("pesaresi2017.toml", "small", ("medium",)),  # both finer
        ("pesaresi2017.toml", "medium", ("full",)),
        ("pesaresi2017.toml", "full", ()),
        ("virtual_rig.toml", "diagnosis", ("laboratory", "diagnosis_contacts")),  # mesh, contacts
        ("virtual_rig.toml", "diagnosis_146", ("laboratory", "diagnosis_contacts")),  # mesh, contacts
    ],
)
def test_the_numerical_error_is_told_by_the_next_finer_presets(name: str, preset: str, finer: tuple[str, ...]) -> None:
    assert finer_presets(load_rig(RIGS / name), preset) == finer


@pytest.mark.parametrize("preset", ["small", "medium", "full"])
def test_of_a_balance_that_does_not_fit_fewer_unknowns_or_samples_do_than_it_has(preset: str) -> None:
    rig = load_rig(RIGS / "pesaresi2017.toml")
    size = size_of(rig, preset)
    needed = size.curve_memory()
    check_size(rig, preset, meshed=True, memory=1.001 * needed)
    for share in (0.999, 0.9):
        with pytest.raises(ValueError, match=r"at most \d+ (fit|samples)") as refused:
            check_size(rig, preset, meshed=True, memory=share * needed)
        (fits,) = re.findall(r"at most (\d+)", str(refused.value))
        assert int(fits) < (size.balance if "unknowns" in str(refused.value) else size.samples)
