"""The virtual laboratory's frequency-domain solver: its law's derivatives, and its motions against marching in time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.benchmarks.virtual_rig import bodies as bodies_module
from updamp.benchmarks.virtual_rig.assembled import Assembled, assembled
from updamp.benchmarks.virtual_rig.bench import Bench, Patches, bench_of
from updamp.benchmarks.virtual_rig.bodies import Bodies, bodies_of
from updamp.benchmarks.virtual_rig.laboratory import hidden, with_hidden
from updamp.benchmarks.virtual_rig.measurement import RIG
from updamp.benchmarks.virtual_rig.patch_forces import Basis, departures
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.stepped_sine import StepMotor
from updamp.benchmarks.virtual_rig.time_march import march
from updamp.fem.coupled_modes import coupled_frequencies_reduced
from updamp.fem.finite_element_model import finite_element_model, rig_springs
from updamp.fem.springs import ContactStiffness
from updamp.geometry.build_mesh import build_mesh
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

EIGHT = {**TINY, "contact_elements": 8}
TIP = "blade_right.tip.x"
MANY = SolverOptions(harmonics=15, n_time=1024, tolerance=1e-5)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(RIG, {"mesh.tiny": EIGHT, "reduction.modes": 10})


@pytest.fixture(scope="module")
def bodies(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Bodies:
    folder = tmp_path_factory.mktemp("bodies")
    first = bodies_of(rig, "tiny", folder)
    kept = bodies_of(rig, "tiny", folder)
    assert np.array_equal(first.blade_residual, kept.blade_residual)
    assert len(list(folder.iterdir())) == 1
    return kept


def test_bodies_of_other_code_and_damaged_ones_are_made_anew(
    rig: Rig, bodies: Bodies, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = []
    monkeypatch.setattr(bodies_module, "computed", lambda *_: made.append(1) or bodies)
    bodies_of(rig, "tiny", tmp_path)
    bodies_of(rig, "tiny", tmp_path)
    assert len(made) == 1
    monkeypatch.setattr(bodies_module, "code_version", lambda *_: "code of another day")
    bodies_of(rig, "tiny", tmp_path)
    assert len(made) == 2
    assert "made by another version of updamp" in capsys.readouterr().err
    (kept,) = tmp_path.iterdir()
    kept.write_bytes(kept.read_bytes()[:-100])
    assert np.array_equal(bodies_of(rig, "tiny", tmp_path).blade_residual, bodies.blade_residual)
    assert len(made) == 3
    bodies_of(rig, "tiny", tmp_path)
    assert len(made) == 3


@pytest.fixture(scope="module")
def bench(rig: Rig, bodies: Bodies) -> Bench:
    return bench_of(rig, bodies)


OWN = {"youngs_modulus": "197 GPa", "poissons_ratio": 0.3, "density": "15600 kg/m^3", "loss_factor": 0.02}


def test_a_material_of_the_damper_alone_changes_its_body_and_its_loss_alone(
    rig: Rig, bodies: Bodies, bench: Bench, tmp_path: Path
) -> None:
    own = load_rig(RIG, {"mesh.tiny": EIGHT, "reduction.modes": 10, "damper.material": OWN})
    other = bodies_of(own, "tiny", tmp_path)
    assert np.array_equal(other.blade_phi, bodies.blade_phi)
    elastic = bodies.damper_omega > 0
    assert other.damper_omega[elastic] == pytest.approx(bodies.damper_omega[elastic] / np.sqrt(2))
    bodies_of(rig, "tiny", tmp_path)
    assert len(list(tmp_path.iterdir())) == 2, "each has a file of its own"
    loss = rig.material.loss_factor
    assert bench.loss_factors == dict.fromkeys(("blade_left", "blade_right", "damper"), loss)
    assert bench_of(own, other).loss_factors == pytest.approx({"blade_left": loss, "blade_right": loss, "damper": 0.02})


LAWS = {
    "box": {},
    "speed": {"speed_drop": 0.5},
    "bundle": {"spread": 0.6},
    "film": {"viscosity": np.full(6, 1e3)},
    "pressure": {"exponent": 0.4, "stated_at": np.full(6, 30.0)},
    "all": {
        "exponent": 0.3, "stated_at": np.full(6, 30.0), "speed_drop": 0.4, "spread": 0.8,
        "viscosity": np.full(6, 500.0),
    },
}  # fmt: skip


def patches(**entries: object) -> Patches:
    plain = Patches(*(np.full(6, value) for value in (0.3, 1e7, 2e7, 20.0, 1e-7, 0.0)))
    return replace(plain, **entries)


@pytest.mark.parametrize("law", LAWS)
def test_derivatives_of_the_patches_forces(law: str) -> None:
    rng, basis, p, w = np.random.default_rng(0), Basis(3, True, 64), patches(**LAWS[law]), 2700.0
    x, dx, h = 1.5e-6 * rng.standard_normal((6, 3, 7)), rng.standard_normal((6, 3, 7)), 1e-13
    _, tangent = departures(x, w, basis, p)
    exact = (tangent @ dx.reshape(6, -1, 1)).reshape(x.shape)
    difference = (departures(x + h * dx, w, basis, p)[0] - departures(x - h * dx, w, basis, p)[0]) / (2 * h)
    assert np.abs(exact - difference).max() < 1e-7 * np.abs(exact).max()
    assert all(np.abs(exact[:, d]).max() > 0.1 * np.abs(exact).max() for d in range(3))


POINT_FORCES = (
    "blade_cubic_stiffness", "quadratic_damping", "second_damper_contact", "rubbing_cable", "platform_rub", "tip_stop",
    "cracked_blade",
    "saturating_spring", "quadratic_stiffness", "threshold_damping",
)  # fmt: skip


@pytest.mark.parametrize("name", POINT_FORCES)
def test_derivatives_of_point_forces(name: str, bench: Bench, rig: Rig) -> None:
    """By the displacement and by the velocity, away from where a force has a corner."""
    elements = with_hidden(bench, [hidden(name, "strong")], rig).elements
    assert elements
    rng, h = np.random.default_rng(1), 1e-6
    u, v = 1.5e-5 * rng.standard_normal(200), 2e-3 * rng.standard_normal(200)
    for element in elements:
        (ahead, *_), (_, by_u, _), (behind, *_) = (element.force(u * (1 + s), v) for s in (h, 0.0, -h))
        assert (ahead - behind) / (2 * h * u) == pytest.approx(by_u, rel=1e-5, abs=1e-6 * np.abs(by_u).max())
        (ahead, *_), (_, _, by_v), (behind, *_) = (element.force(u, v * (1 + s)) for s in (h, 0.0, -h))
        assert (ahead - behind) / (2 * h * v) == pytest.approx(by_v, rel=1e-5, abs=1e-6 * np.abs(by_v).max())


def test_patch_that_sticks_departs_from_nothing() -> None:
    value, tangent = departures(
        np.full((6, 3, 7), 1e-9), 2700.0, Basis(3, True, 64), replace(patches(), gap=np.zeros(6))
    )
    assert not value.any()
    assert not tangent.any()


def test_stuck_frequencies_are_those_of_updamps_reduced_model(rig: Rig, bench: Bench) -> None:
    reduced = finite_element_model(build_mesh(rig, "tiny"), rig).reduced
    springs = rig_springs(
        reduced, rig, ContactStiffness(rig.contact.tangential_stiffness, rig.contact.normal_stiffness)
    )
    assert assembled(bench).stuck_frequencies(3) == pytest.approx(
        coupled_frequencies_reduced(reduced, springs, 3), rel=1e-7
    )


def test_turning_clamp_lowers_both_blades_as_a_rigid_blade_on_a_spring_would(bench: Bench) -> None:
    """A soft clamp leaves a rigid body on a torsional spring: sqrt(1 / (compliance inertia))."""
    compliance = 1e3
    soft = assembled(replace(bench, clamp_compliance=compliance))
    lowest = np.linalg.eigvals(np.linalg.solve(soft.free.mass, soft.free.stiffness)).real
    lowest = np.sqrt(np.sort(lowest[lowest > 1e-6])[:2])
    inertia = float(bench.bodies.inertia)
    assert lowest == pytest.approx([1 / np.sqrt(compliance * inertia)] * 2, rel=1e-3)


def damped(bench: Bench, frequency: float) -> Bench:
    """Viscous damping of 2 % that forgets the start soon, and a free mean position."""
    return replace(bench, viscous_at=2 * np.pi * frequency, mean_share=1.0, loss_factor=0.02)


def checked(rig: Assembled, frequency: float, force: float, periods: int = 150):  # type: ignore[no-untyped-def]
    motion = StepMotor(rig, MANY).step(frequency, force)
    marched = march(rig, motion, TIP, periods, 512)
    return complex(motion.response(TIP)[0]), marched


UNEVEN = np.tile([0.03, 1.0, 1.0, 1.0], 2)  # on two patches the load is so small that they open


@pytest.mark.long
def test_slip_and_opening_against_marching_in_time(bench: Bench) -> None:
    ip, oop = assembled(bench).stuck_frequencies(2)
    uneven = bench.with_patches(n0=UNEVEN * bench.patches.n0)
    gap = uneven.with_patches(gap=np.tile([0, 0, 2e-8, 0], 2))
    for rest, resonance, place, force in ((uneven, ip, 0.997, 4.0), (gap, oop, 0.998, 30.0)):
        balanced, marched = checked(assembled(damped(rest, resonance)), place * resonance, force, 60)
        assert marched.open_share == pytest.approx(0.25)
        assert marched.slip_share >= 0.25
        assert abs(marched.first_harmonic[-1] / balanced - 1) < 3e-3


@pytest.mark.long
def test_bundle_speed_and_film_against_marching_in_time(bench: Bench) -> None:
    _, oop = assembled(bench).stuck_frequencies(2)
    plain = damped(bench, oop)
    hidden = plain.with_patches(spread=0.8, speed_drop=0.5, viscosity=5e8 * bench.bodies.area)
    balanced, marched = checked(assembled(hidden), oop * 0.998, 60.0, 60)
    without = StepMotor(assembled(plain), MANY).step(oop * 0.998, 60.0).response(TIP)[0]
    assert marched.slip_share >= 0.5
    assert abs(balanced / without - 1) > 0.02
    assert abs(marched.first_harmonic[-1] / balanced - 1) < 2e-3


@pytest.mark.long
def test_stuck_motion_against_marching_in_time(bench: Bench) -> None:
    ip, _ = assembled(bench).stuck_frequencies(2)
    balanced, marched = checked(assembled(damped(bench, ip)), ip, 0.05, 2)
    assert marched.slip_share == 0
    assert abs(marched.first_harmonic[-1] / balanced - 1) < 1e-8
