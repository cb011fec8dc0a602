"""The noise of each sensor by the amplitude, from what a model leaves."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.jumping_beam import Joint, Mode, measured

from updamp.comparison.fit.fit_from_far import fit_from_far
from updamp.comparison.fit.noise_by_amplitude import noise_of_each_sensor, with_noise_of_sensors
from updamp.comparison.fit.observations import Plan, plan_of
from updamp.comparison.prediction.parameters import Parametrisation
from updamp.model.build import modal_before_effects
from updamp.model.calibration import OF_MODES
from updamp.model.rig_files import load_modal

MODEL = modal_before_effects(load_modal(Path(__file__).parents[3] / "rigs" / "brake_reuss.toml"))
BEAM, WINDOW = Mode(80.38, 0.0031, 2.0), (79.9, 80.9)
SHARE, FLOOR = 0.004, 2e-7
SENSOR = ("beam.drive.x", 1)


def runs_with_a_floor(floor: float) -> Plan:
    """Four levels of one beam, of which the lowest are all floor. floor: [m]"""
    exact = measured((BEAM,), Joint(), WINDOW, (0.05, 0.2, 0.8, 3.2), True, 60, 1e-12, 3)
    rng, runs = np.random.default_rng(5), []
    for run in exact.runs:
        x = run.response
        one, other = (rng.standard_normal(x.shape) + 1j * rng.standard_normal(x.shape) for _ in range(2))
        runs.append(replace(run, response=x * (1 + SHARE * one) + floor * other))
    return plan_of(replace(exact, runs=tuple(runs), repeatability=0.0))


def read_off(plan: Plan):
    p = Parametrisation(MODEL, OF_MODES)
    return noise_of_each_sensor(fit_from_far(p, plan, np.zeros(len(p))).compared.matched, plan)


def test_a_share_of_the_amplitude_and_a_floor_are_told_apart():
    plan = runs_with_a_floor(FLOOR)
    noise = read_off(plan)[SENSOR]
    assert noise.share == pytest.approx(SHARE, rel=0.2)
    assert noise.floor["first"] == pytest.approx(FLOOR, rel=0.2)
    known = with_noise_of_sensors(plan, {SENSOR: noise})
    for o in known.observations:
        wanted = np.hypot(SHARE, FLOOR / np.exp(o.observed[:, 1]))
        np.testing.assert_allclose(o.noise[:, 1], wanted, rtol=0.25)
        np.testing.assert_array_equal(o.noise[:, 1], o.noise[:, 2])
    assert known.conditions[0].noise[1] > 3 * known.conditions[-1].noise[1]


def test_without_a_floor_all_amplitudes_are_as_noisy():
    plan = runs_with_a_floor(0.0)
    noise = read_off(plan)[SENSOR]
    smallest = min(np.exp(o.observed[:, 1]).min() for o in plan.observations)
    assert noise.share == pytest.approx(SHARE, rel=0.2)
    assert noise.floor["first"] < 0.5 * SHARE * smallest * 10


def test_a_floor_that_is_a_share_of_each_run_s_range_is_read_too():
    """Fourteen half-widths to both sides, where the flanks are a fourteenth of the peak. One floor for all levels
    cannot be a thousandth of the largest amplitude of each."""
    exact = measured((BEAM,), Joint(), (78.6, 82.2), (0.05, 0.2, 0.8, 3.2), True, 60, 1e-12, 3)
    rng, runs = np.random.default_rng(6), []
    for run in exact.runs:
        x = run.response
        one, other = (rng.standard_normal(x.shape) + 1j * rng.standard_normal(x.shape) for _ in range(2))
        runs.append(replace(run, response=x * (1 + SHARE * one) + 0.001 * np.abs(x).max() * other))
    plan = plan_of(replace(exact, runs=tuple(runs), repeatability=0.0))
    noise = read_off(plan)[SENSOR]
    assert noise.share == pytest.approx(SHARE, rel=0.25)
    assert noise.of_range == pytest.approx(0.001, rel=0.25)
    for o in with_noise_of_sensors(plan, {SENSOR: noise}).observations:
        amplitude = np.exp(o.observed[:, 1])
        np.testing.assert_allclose(o.noise[:, 1], np.hypot(SHARE, 0.001 * amplitude.max() / amplitude), rtol=0.3)


def test_stated_noise_stays_and_none_gets_larger():
    plan = runs_with_a_floor(FLOOR)
    assert noise_of_each_sensor((), replace(plan, noise_read=False)) == {}
    noise = read_off(plan)[SENSOR]
    worse = replace(noise, share=10.0)
    for before, after in zip(plan.observations, with_noise_of_sensors(plan, {SENSOR: worse}).observations, strict=True):
        assert np.median(after.noise[:, 1]) <= 1.001 * max(np.median(o.noise[:, 1]) for o in plan.observations)
        assert len(after) == len(before)
