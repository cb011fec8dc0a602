"""Expected score and visibility: on covariances that can be done by hand, and on the laboratory's smallest mesh."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.plain_rig import TINY

from updamp.benchmarks.hidden_effects.detectability import (
    E_MODULUS,
    FACTORS,
    Background,
    as_real,
    background_of,
    bringing_back,
    covariances,
    difference,
    expected,
    like,
    log_receptance,
)
from updamp.benchmarks.hidden_effects.kinds_of_test import EASY
from updamp.benchmarks.virtual_rig.assembled import assembled
from updamp.benchmarks.virtual_rig.bench import Bench, bench_of
from updamp.benchmarks.virtual_rig.bodies import bodies_of
from updamp.benchmarks.virtual_rig.laboratory import hidden, with_hidden
from updamp.benchmarks.virtual_rig.periodic import SolverOptions
from updamp.benchmarks.virtual_rig.plan import PlannedRun, TestPlan
from updamp.model.calibration import OF_CONTACTS, OF_STRUCTURE
from updamp.model.rig_files import load_rig
from updamp.rig.rig import Rig

RIG = Path(__file__).parents[2] / "rigs" / "virtual_rig.toml"
PLAN, NOISE = EASY.plan, EASY.noise
QUICK = SolverOptions(3, 128, 1e-6)


@pytest.fixture(scope="module")
def rig() -> Rig:
    return load_rig(RIG, {"mesh.tiny": TINY, "reduction.modes": 10})


@pytest.fixture(scope="module")
def bench(rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return bench_of(rig, bodies_of(rig, "tiny", tmp_path_factory.mktemp("bodies")))


def test_score_is_length_in_standard_deviations() -> None:
    found = expected({"a": np.array([3.0, 0, 0, 4.0])}, 0.25 * np.eye(4), 0.25 * np.eye(4))["a"]
    assert (found.score, found.visibility) == pytest.approx((10, 1))


def test_what_nuisance_parameters_imitate_is_not_visible() -> None:
    noise, nuisance = np.eye(2), np.array([1.0, 0])
    allowed = noise + 1e8 * np.outer(nuisance, nuisance)
    angle = np.radians(30)
    found = expected({"a": 50 * np.array([np.cos(angle), np.sin(angle)])}, noise, allowed)["a"]
    assert found.score == pytest.approx(50 * np.sin(angle), rel=1e-5)
    assert found.visibility == pytest.approx(np.sin(angle), rel=1e-5)


def test_of_two_alike_neither_is_seen_and_of_two_apart_both() -> None:
    one, other = np.array([20.0, 0, 0]), np.array([0, 30.0, 0])
    apart = expected({"a": one, "b": other}, np.eye(3), np.eye(3))
    assert (apart["a"].score, apart["b"].score) == pytest.approx((20, 30))
    alike = expected({"a": one, "b": 2 * one}, np.eye(3), np.eye(3))
    assert alike["a"].score < 1
    assert alike["b"].visibility < 0.02


def test_covariance_is_that_of_noise_gains_and_drift_as_drawn() -> None:
    shape = (len(PLAN.runs), len(PLAN.channels), PLAN.points)
    plain = np.full(shape, np.log(1e-6) + 0.3j)
    columns = np.zeros((plain.size * 2, len(FACTORS)))
    columns[:, E_MODULUS] = 50.0
    noise, allowed = covariances(plain, columns)
    rng = np.random.default_rng(4)
    drawn = np.zeros((4000, *shape), dtype=complex)
    for _ in range(PLAN.assemblies):
        forces = np.array([run.force for run in PLAN.runs])[:, None, None]
        size = np.sqrt(NOISE.relative**2 + NOISE.force_reading**2 + (NOISE.floor / (forces * 1e-6)) ** 2)
        drawn += size * (rng.standard_normal(drawn.shape) + 1j * rng.standard_normal(drawn.shape))
        drawn += NOISE.gain * rng.standard_normal((4000, 1, shape[1], 1))
        both_parts = 1 + 1j
        drawn += both_parts * 2 * 50 * NOISE.drift * rng.standard_normal((4000, shape[0], 1, 1))
        drawn += both_parts * 50 * NOISE.youngs_modulus * rng.standard_normal((4000, 1, 1, 1))
    values = np.stack([as_real(d / PLAN.assemblies) for d in drawn[:, :, :, :2]])
    few = _first_two(shape)
    np.testing.assert_allclose(np.cov(values.T), noise[np.ix_(few, few)], atol=4 * noise.max() / np.sqrt(4000))
    assert np.trace(allowed) > np.trace(noise)


def _first_two(shape: tuple[int, ...]) -> np.ndarray:
    """Places of both parts of the first two points of every run and channel."""
    points = np.indices(shape)[2] < 2
    return np.flatnonzero(as_real(points * (1 + 1j)))


def test_nuisance_parameters_are_those_of_the_fit() -> None:
    """Friction, tangential and normal stiffness, preload, Young's modulus, loss factor, with the fit's deviations."""
    modulus, loss = OF_STRUCTURE
    assert [f.allowed for f in FACTORS] == [n.deviation for n in (*OF_CONTACTS, modulus, loss)]


def test_phase_differences_are_the_smaller_ones() -> None:
    found = difference(np.array([1 + 3.1j]), np.array([0.5 - 3.1j]))
    assert found == pytest.approx(np.array([0.5 + (6.2 - 2 * np.pi) * 1j]))


def test_signature_of_a_loose_sensor_is_in_its_own_channel(bench: Bench, rig: Rig) -> None:
    plan = TestPlan((PlannedRun("IP", 1.0), PlannedRun("OOP", 4.0)), 2, 8)
    ip, oop = assembled(bench).stuck_frequencies(2)
    frequencies = np.array([np.linspace(0.995, 1.005, 8)] * 2) * np.array([[ip], [oop]])
    plain = log_receptance(bench, frequencies, plan, QUICK)
    assert plain.shape == (2, 2, 8)
    assert np.isfinite(plain).all()
    changed = log_receptance(with_hidden(bench, [hidden("loose_sensor_gain", "strong")], rig), frequencies, plan, QUICK)
    left, right = difference(changed, plain).swapaxes(0, 1)
    assert np.abs(right).max() == 0
    assert np.abs(left.imag).max() < 1e-12
    assert (left.real < -0.01).all()


def test_a_calibrated_model_has_the_bench_s_stuck_resonance(bench: Bench) -> None:
    stiffer = bench.with_patches(kt=1.5 * bench.patches.kt, kn=1.5 * bench.patches.kn)
    found = assembled(like(stiffer, bench)).stuck_frequencies(1)
    assert assembled(stiffer).stuck_frequencies(1) > 1.001 * assembled(bench).stuck_frequencies(1)
    # the wires and the contacts do not get softer with Young's modulus
    assert found == pytest.approx(assembled(bench).stuck_frequencies(1), rel=2e-3)


def test_a_point_without_a_motion_changes_nothing() -> None:
    rng = np.random.default_rng(2)
    shape = (len(PLAN.runs), len(PLAN.channels), PLAN.points)
    plain = np.full(shape, np.log(1e-6) + 0.3j)
    columns, signature = rng.standard_normal((plain.size * 2, len(FACTORS))), rng.standard_normal(plain.size * 2)
    lost = np.zeros(shape, dtype=bool)
    lost[0, :, 3] = True
    nowhere = as_real(lost * (1 + 1j)) > 0
    columns[nowhere], signature[nowhere] = 0.0, 0.0
    found = []
    for one in (plain, np.where(lost, np.nan, plain)):
        noise, allowed = covariances(one, columns)
        found.append(expected({"a": signature}, noise, allowed)["a"])
    assert found[1].score == pytest.approx(found[0].score, rel=1e-3)


@pytest.fixture(scope="module")
def nothing_hidden(bench: Bench) -> Background:
    """Two runs, the model that is fitted being the laboratory's own."""
    plan = TestPlan((PlannedRun("IP", 1.0), PlannedRun("OOP", 4.0)), 2, 8)
    resonances = assembled(bench).stuck_frequencies(2)
    frequencies = np.linspace(0.995, 1.005, 8) * resonances[:, None]
    return background_of(bench, bench, replace(EASY, plan=plan), frequencies, QUICK)


def _stiffer(bench: Bench, percent: float) -> Bench:
    """Young's modulus of all bodies."""
    return FACTORS[E_MODULUS].apply(bench, 1 + percent / 100)


def test_a_bench_is_brought_back_by_what_moved_it(bench: Bench) -> None:
    logs = bringing_back(_stiffer(bench, 1.0), bench)
    assert logs[E_MODULUS] == pytest.approx(-np.log(1.01), rel=0.05)


def test_what_calibration_makes_up_for_is_not_seen_however_far_it_shifts_resonances(
    bench: Bench, nothing_hidden: Background
) -> None:
    """2 % of Young's modulus: two allowed deviations, and four half-widths, where first order has long failed."""
    b, stiffer = nothing_hidden, _stiffer(bench, 2.0)
    found = expected({"E": b.signature(stiffer)}, b.noise, b.allowed)["E"]
    assert found.score < 2.5
    unshifted = log_receptance(stiffer, b.frequencies, b.test.plan, QUICK)
    first_order = np.nan_to_num(as_real(difference(unshifted, b.plain)))
    assert expected({"E": first_order}, b.noise, b.allowed)["E"].score > 100
